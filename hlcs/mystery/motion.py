"""How nature moves a ball or a block in a mystery: equations of motion, solved by SciPy to nine digits.

Nothing here comes from the engine: no module of `minibullet` or `hlcs` is imported, an import contract sees to that, so a data
set made here is an outside test of the diagnosis. Laws are a dictionary {effect: {parameter: value}}, numbers in SI, under the
names of `hlcs effects`; what is not in it does not act. Vectors stand in the world frame, z up; quaternions are w, x, y, z.
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.81  # m/s2
ACCURACY = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-10}
STANDS = 1e-4  # m/s: a sliding block this slow has 2 nanometres to go at a friction of 0.3
MOST_BOUNCES = 50


class Body(NamedTuple):
    """What moves, and in which fluid."""

    mass: float  # kg
    volume: float  # m3
    area: float  # m2, the mean area that it shows to the flow: a quarter of its surface
    radius: float  # m, of a ball; of a block that of the ball of equal volume
    fluid_density: float  # kg/m3


class Start(NamedTuple):
    """The state at the release."""

    position: np.ndarray  # (3,) m
    velocity: np.ndarray  # (3,) m/s
    orientation: np.ndarray  # (4,)
    angular_velocity: np.ndarray  # (3,) rad/s


class Floor(NamedTuple):
    """A plane through the origin, and what it does by itself."""

    normal: np.ndarray  # (3,) unit vector, upwards
    friction: float  # -
    restitution: float  # -


def ball(radius, mass, fluid_density):
    """The Body of a ball: radius [m], mass [kg], density of the fluid [kg/m3]."""
    return Body(mass, 4 / 3 * np.pi * radius**3, np.pi * radius**2, radius, fluid_density)


def block(size, mass, fluid_density):
    """The Body of a block with edges `size` (3,) [m]."""
    a, b, c = size
    volume = a * b * c
    return Body(mass, volume, (a * b + b * c + c * a) / 2, (3 * volume / (4 * np.pi)) ** (1 / 3), fluid_density)


# --- forces of the fluid ----------------------------------------------------------------------------------------------------


def number(laws, effect, parameter, absent=0.0):
    """A parameter of a law, or what holds where the law does not act."""
    return laws.get(effect, {}).get(parameter, absent)


def carried_along(body, laws):
    """Mass of the fluid that is accelerated with the body, over the mass of the body: C rho V / m (Lamb 1932, art. 92)."""
    return number(laws, "added_mass", "coefficient") * body.fluid_density * body.volume / body.mass


def weight(body, laws):
    """Gravity less the lift of the displaced fluid (Archimedes), over the mass of the body [m/s2]."""
    return GRAVITY * (1 - number(laws, "buoyancy", "fluid_density") * body.volume / body.mass)


def drag(body, laws, velocity):
    """Resistance of the fluid over the mass of the body (3,) [m/s2], at a velocity (3,) relative to the fluid.

    rho C A |w| w / 2 (Newton, Principia II).
    """
    square = 0.5 * body.fluid_density * number(laws, "quadratic_drag", "drag_coefficient") * body.area
    return -square * np.sqrt(velocity @ velocity) / body.mass * velocity


def side_force(body, laws, velocity, spin):
    """Magnus force over the mass of the body (3,) [m/s2]: C pi rho r3 omega x w (Rubinow and Keller 1961)."""
    strength = number(laws, "magnus", "coefficient") * np.pi * body.fluid_density * body.radius**3 / body.mass
    return strength * np.cross(spin, velocity)


def flow_of(laws):
    """Velocity of the fluid (3,) [m/s]."""
    return np.array([number(laws, "uniform_flow", f"velocity_{axis}") for axis in "xyz"])


# --- a ball that flies, sinks or bounces ------------------------------------------------------------------------------------


def fly(body, laws, start, times, floor=None):
    """Positions (n, 3) [m] and orientations (n, 4) of a ball at rising times (n,) [s]; before 0 it waits at its start.

    With a floor it bounces: restitution e, or e v^-exponent of the speed v of the impact in m/s (Johnson 1985, ch. 11).
    The floor gives no spin and takes no speed along itself, so only balls dropped without spin may meet it.
    """
    times = np.asarray(times, float)
    flow, down = flow_of(laws), np.array([0.0, 0.0, -weight(body, laws)])
    inertia = 1 + carried_along(body, laws)
    decay = number(laws, "spin_decay", "rate")

    def rate(t, state):
        spin = start.angular_velocity * np.exp(-decay * t)
        through = state[3:] - flow
        push = down + drag(body, laws, through) + side_force(body, laws, through, spin)
        return np.concatenate([state[3:], push / inertia])

    state = np.concatenate([start.position, start.velocity])
    if floor is None:
        states = solved(rate, state, times)
    else:
        restitution = number(laws, "restitution", "coefficient", floor.restitution)
        exponent = number(laws, "velocity_dependent_restitution", "exponent")
        states = bouncing(rate, state, times, floor.normal, body.radius, lambda speed: min(restitution * speed**-exponent, 1.0))
    return states[:, :3], turned(start, decay, times)


def solved(rate, state, times):
    """States (n, k) of d(state)/dt = rate(t, state) from t = 0; the first state at times that are not later."""
    later = times > 0
    out = np.repeat(state[None], len(times), axis=0)
    if later.any():
        out[later] = solve_ivp(rate, (0.0, times[-1]), state, t_eval=times[later], **ACCURACY).y.T
    return out


def bouncing(rate, state, times, normal, radius, restitution):
    """The same for a ball of that radius [m] on a floor through the origin; restitution(speed [m/s]) of each impact."""

    def gap(_, state):
        return normal @ state[:3] - radius

    gap.terminal, gap.direction = True, -1.0
    out, now = np.repeat(state[None], len(times), axis=0), 0.0
    for _ in range(MOST_BOUNCES):
        found = solve_ivp(rate, (now, times[-1]), state, events=gap, dense_output=True, **ACCURACY)
        inside = (times > now) & (times <= found.t[-1])
        if inside.any():
            out[inside] = found.sol(times[inside]).T
        if not found.t_events[0].size:
            return out
        now, state = found.t[-1], found.y[:, -1].copy()
        speed = -normal @ state[3:]
        state[3:] += (1 + restitution(speed)) * speed * normal
    raise ValueError(f"more than {MOST_BOUNCES} bounces: the recording is too long")


def turned(start, decay, times):
    """Orientations (n, 4) of a body whose spin dies away as exp(-decay t) about a fixed axis; decay [1/s]."""
    late = np.maximum(times, 0.0)
    lasted = -np.expm1(-decay * late) / decay if decay else late
    return product(quaternion(lasted[:, None] * start.angular_velocity), start.orientation)


# --- a block that slides, a ball that rolls ---------------------------------------------------------------------------------


def level(laws, floor):
    """The normal of the floor as it really lies (3,): it rises by the grades of `bottom_slope` beside what is stated."""
    grades = np.array([number(laws, "bottom_slope", f"grade_{axis}") for axis in "xy"] + [0.0])
    normal = floor.normal - floor.normal[2] * grades
    return normal / np.linalg.norm(normal)


def slide(body, laws, start, times, floor, clearance):
    """Positions (n, 3) [m] and orientations (n, 4) of a block launched along a floor; it stays where it stops.

    clearance: height of its centre over the floor [m]. Coulomb's friction, with `viscous_friction` mu + slope v. The floor must
    be too gentle to set a block at rest in motion.
    """
    normal = level(laws, floor)
    down = np.array([0.0, 0.0, -weight(body, laws)])
    load, along = -(down @ normal), down - (down @ normal) * normal
    inertia = 1 + carried_along(body, laws)
    mu, slope = number(laws, "friction", "coefficient", floor.friction), number(laws, "viscous_friction", "slope")

    def rate(_, state):
        speed = max(np.sqrt(state[3:] @ state[3:]), STANDS)
        grip = max(mu + slope * speed, 0.0) * load
        return np.concatenate([state[3:], (along - grip * state[3:] / speed + drag(body, laws, state[3:])) / inertia])

    def stops(_, state):
        return np.sqrt(state[3:] @ state[3:]) - STANDS

    stops.terminal = True
    position = start.position + (clearance - start.position @ normal) * normal
    velocity = start.velocity - (start.velocity @ normal) * normal
    times = np.asarray(times, float)
    found = solve_ivp(
        rate, (0.0, times[-1] + 1e-9), np.concatenate([position, velocity]), events=stops, dense_output=True, **ACCURACY
    )
    states = found.sol(np.clip(times, 0.0, found.t[-1])).T
    return states[:, :3], np.repeat(start.orientation[None], len(times), axis=0)


def roll(body, laws, start, times, floor):
    """Positions (n, 3) [m] and orientations (n, 4) of a solid ball let go on an inclined board, rolling without slip.

    (m + I/r2) dv/dt = drive - drag - N arm/r, I = 2/5 m r2 (Reynolds 1876): straight down the board.
    """
    normal = level(laws, floor)
    down = np.array([0.0, 0.0, -weight(body, laws)])
    load, along = -(down @ normal), down - (down @ normal) * normal
    drive = np.linalg.norm(along)
    heading, inertia = along / drive, 1 + 2 / 5 + carried_along(body, laws)
    resistance = load * number(laws, "rolling_friction", "arm") / body.radius

    def rate(_, state):
        air = drag(body, laws, state[1] * heading) @ heading
        return np.array([state[1], (drive - resistance + air) / inertia])

    times = np.asarray(times, float)
    way = solved(rate, np.zeros(2), times)[:, 0] if drive > resistance else np.zeros(len(times))
    axis = np.cross(normal, heading) / body.radius
    position = start.position + (body.radius - start.position @ normal) * normal + way[:, None] * heading
    return position, product(quaternion(way[:, None] * axis), start.orientation)


# --- rotations --------------------------------------------------------------------------------------------------------------


def quaternion(turn):
    """Quaternions (..., 4) of rotation vectors (..., 3) [rad]."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * turn], axis=-1)


def product(a, b):
    """Hamilton's product of quaternions (..., 4)."""
    a, b = np.broadcast_arrays(np.asarray(a, float), np.asarray(b, float))
    w = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    return np.concatenate([w, a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])], axis=-1)


def turn_between(a, b):
    """Rotation vectors (..., 3) [rad], world frame, that take orientations a into b."""
    change = product(b, np.asarray(a) * [1, -1, -1, -1])
    change = np.where(change[..., :1] < 0, -change, change)
    sine = np.linalg.norm(change[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, change[..., :1])
    return change[..., 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 2.0)
