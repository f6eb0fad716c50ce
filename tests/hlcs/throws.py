"""Makes recordings for the tests: closed forms and a fine Runge-Kutta, never the code under test."""

import numpy as np
from scipy.optimize import brentq

G = 9.81


def flight(start, velocity, times, drag_per_metre=0.0, rate=0.0, tilt=(0.0, 0.0), step=1e-3):
    """Positions (n, 3) of a thrown ball, acceleration = gravity - (rate + k |v|) v, by fourth-order Runge-Kutta."""
    gravity = G * np.array([-np.sin(tilt[1]), np.sin(tilt[0]), -1.0])

    def slope(y):
        v = y[3:]
        return np.concatenate([v, gravity - (rate + drag_per_metre * np.linalg.norm(v)) * v])

    y, now, found = np.concatenate([start, velocity]).astype(float), 0.0, []
    for time in times:
        count = max(int(np.ceil((time - now) / step)), 1)
        h = (time - now) / count
        for _ in range(count if time > now else 0):
            a = slope(y)
            b = slope(y + h / 2 * a)
            c = slope(y + h / 2 * b)
            d = slope(y + h * c)
            y = y + h / 6 * (a + 2 * b + 2 * c + d)
        now = time
        found.append(y[:3].copy())
    return np.array(found)


def correlated(generator, shape, sigma, rho):
    """AR(1) noise along the first axis, stationary from the first sample."""
    noise = generator.standard_normal(shape) * sigma
    for k in range(1, shape[0]):
        noise[k] = rho * noise[k - 1] + np.sqrt(1 - rho**2) * noise[k]
    return noise


def csv(times, position, columns=("x_m", "y_m", "z_m")):
    """A recording as CSV text."""
    rows = [",".join(["t_s", *columns])]
    rows += [",".join(f"{value:.6f}" for value in (time, *row)) for time, row in zip(times, position, strict=True)]
    return "\n".join(rows) + "\n"


def write_throws(folder, sigma=0.004, rho=0.0, seed=1, count=8, static=True, noise="", order=1, **law):
    """An experiment folder of throws in four headings with 2 m/s to 9 m/s; returns the path of its TOML."""
    generator = np.random.default_rng(seed)
    trials = []
    for k in range(count):
        heading, speed = np.pi / 2 * (k % 4) + 0.2, 2.0 + k
        velocity = speed * np.array([0.8 * np.cos(heading), 0.8 * np.sin(heading), 0.6])
        times = np.arange(0, 1.0, 1 / 60)
        seen = flight(np.array([0.0, 0.0, 1.5]), velocity, times, **law) + correlated(generator, (len(times), 3), sigma, rho)
        (folder / f"throw_{k}.csv").write_text(csv(times, seen))
        trials.append(f'[[trial]]\nfile = "throw_{k}.csv"\ngroup = "day {k % 2 + 1}"\n')
    if static:
        times = np.arange(600) / 60
        (folder / "rest.csv").write_text(csv(times, 1.0 + correlated(generator, (600, 3), sigma, rho)))
    text = (
        'kind = "trajectory"\ntitle = "throws"\n[body]\nshape = "sphere"\nradius = 0.0335\nmass = 0.0577\n[surroundings]\n'
        "fluid_density = 1.2\nfluid_viscosity = 1.8e-5\n[measurement]\n"
        + ('static = "rest.csv"\n' if static else "")
        + noise
        + "\n"
        + "\n".join(trials[::order])
    )
    path = folder / "throws.toml"
    path.write_text(text)
    return path


def drag_per_metre(coefficient, density=1.2, radius=0.0335, mass=0.0577):
    """k of acceleration = -k |v| v for a sphere."""
    return density * coefficient * np.pi * radius**2 / (2 * mass)


def write_drops(folder, noise):
    """A ball let fall from 3 to 13 cm that bounces with e = 0.5, where the model says 0 (closed form); its experiment."""
    generator, text = (
        np.random.default_rng(2),
        (
            'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.1\n[surroundings]\nfriction = 0.3\n'
            "restitution = 0.0\nfloor = { height = 0.0, normal = [0.0, 0.0, 1.0] }\n"
            f"[measurement]\nnoise = {{ position = {noise} }}\n"
        ),
    )
    for k, height in enumerate((0.03, 0.05, 0.07, 0.09, 0.11, 0.13)):
        times, rise = np.arange(0, 0.6, 1 / 60), np.zeros(36)
        moment, speed = np.sqrt(2 * height / G), 0.5 * np.sqrt(2 * height * G)
        fall = times < moment
        rise[fall] = height - G / 2 * times[fall] ** 2
        while speed > 1e-3:
            up = (times >= moment) & (times < moment + 2 * speed / G)
            rise[up] = speed * (times[up] - moment) - G / 2 * (times[up] - moment) ** 2
            moment, speed = moment + 2 * speed / G, 0.5 * speed
        seen = np.column_stack([0 * times, 0 * times, 0.03 + rise]) + noise * generator.standard_normal((36, 3))
        (folder / f"drop_{k}.csv").write_text(csv(times, seen))
        text += f'[[trial]]\nfile = "drop_{k}.csv"\ngroup = "day {k % 2}"\nstart = {{ velocity = [0.0, 0.0, 0.0] }}\n'
    path = folder / "drops.toml"
    path.write_text(text)
    return path


def write_damped_drops(folder, rate, noise=0.0008):
    """A ball let fall from 0.5 to 0.7 m through a linear drag [1/s] that bounces with e = 0.75, as the model says that knows no
    drag (closed form between impacts); its experiment."""
    generator, times = np.random.default_rng(3), np.arange(0, 1.2, 1 / 60)
    text = (
        'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.1\n[surroundings]\nfriction = 0.3\n'
        "restitution = 0.75\nfloor = { height = 0.0, normal = [0.0, 0.0, 1.0] }\n"
        f"[measurement]\nnoise = {{ position = {noise} }}\n"
    )

    def rise(start, speed, time):
        return start + (speed + G / rate) * -np.expm1(-rate * time) / rate - G / rate * time

    for k, height in enumerate((0.5, 0.55, 0.6, 0.7)):
        heights, moment, start, speed = np.zeros_like(times), 0.0, height, 0.0
        while moment < times[-1] and (start > 0 or speed > 1e-3):
            top = np.log1p(max(speed, 0.0) * rate / G) / rate
            lasts = brentq(lambda time, start=start, speed=speed: rise(start, speed, time), top + 1e-9, top + 10.0)
            there = (times >= moment) & (times < moment + lasts)
            heights[there] = rise(start, speed, times[there] - moment)
            fall = (speed + G / rate) * np.exp(-rate * lasts) - G / rate
            moment, start, speed = moment + lasts, 0.0, -0.75 * fall
        seen = np.column_stack([0 * times, 0 * times, 0.03 + heights]) + noise * generator.standard_normal((len(times), 3))
        (folder / f"drop_{k}.csv").write_text(csv(times, seen))
        text += f'[[trial]]\nfile = "drop_{k}.csv"\ngroup = "day {k % 2}"\nstart = {{ velocity = [0.0, 0.0, 0.0] }}\n'
    path = folder / "drops.toml"
    path.write_text(text)
    return path
