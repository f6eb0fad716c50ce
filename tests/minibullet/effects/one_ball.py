"""One ball under effects: its acceleration, and its motion integrated far below the tolerance of the tests."""

import numpy as np
from scipy.integrate import solve_ivp

from minibullet import effects
from minibullet.bodies import Bodies

G = 9.81


def ball(position=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0), radius=0.1, density=2000.0, orientation=(1, 0, 0, 0)):
    """One sphere as Bodies."""
    volume = 4 / 3 * np.pi * radius**3
    mass = density * volume
    one = (position, orientation, (*velocity, *spin), mass, [0.4 * mass * radius**2] * 3, volume, np.pi * radius**2, radius)
    return Bodies(*(np.array([value], dtype=float) for value in one))


def acceleration(model, bodies, time=0.0):
    """Linear acceleration of one body under effects: (m + added mass)^-1 force, (3,)."""
    model = effects.compose(model)
    mass = bodies.mass[0] * np.eye(3)
    added = effects.added_mass(model, bodies)
    if added is not None:
        mass = mass + added[0, :3, :3]
    return np.linalg.solve(mass, sum(effects.wrench(effect, bodies, time)[0, :3] for effect in model))


def fall(model, duration, body=None, velocity=(0, 0, 0)):
    """Velocity after a free flight, integrated far below the tolerance of the tests, (3,)."""
    body = body or ball()

    def rate(time, state):
        bodies = body._replace(position=state[None, :3], twist=np.concatenate([state[3:], body.twist[0, 3:]])[None])
        return np.concatenate([state[3:], acceleration(model, bodies, time)])

    start = np.concatenate([body.position[0], velocity])
    return solve_ivp(rate, (0, duration), start, method="DOP853", rtol=1e-11, atol=1e-12).y[3:, -1]
