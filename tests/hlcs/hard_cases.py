"""Experiments that a diagnosis has failed on, made by closed forms and a fine Runge-Kutta, never by the code under test."""

from pathlib import Path

import numpy as np
from throws import G, csv

TUMBLING = Path(__file__).resolve().parent / "tumbling"
AIR = 1.2  # kg/m3
TENNIS = {"radius": 0.0335, "mass": 0.0577}
CELLULOID = {"radius": 0.02, "mass": 0.0027}
RUBBER = {"radius": 0.02, "mass": 0.0115}
MAGNET = np.array([2.0, 0.0, 1.0])  # m
MAGNET_EFFECT = '''from dataclasses import dataclass
import numpy as np
import minibullet as mb


@dataclass(frozen=True)
class MagnetPull(mb.Effect):
    """A pull towards (2, 0, 1), force = mass * k / distance^2."""

    k: float = mb.parameter(0.0, unit="m3/s2", low=-10, high=10, null=0.0)
    isotropic = False

    def forces(self, bodies, time):
        away = np.array([2.0, 0.0, 1.0]) - bodies.position
        wrench = np.zeros((len(bodies.mass), 6))
        wrench[:, :3] = self.k * bodies.mass[:, None] * away / np.linalg.norm(away, axis=1)[:, None] ** 3
        return wrench
'''


def per_metre(coefficient, radius, mass, fluid=AIR):
    """k of the deceleration k v^2 of a sphere in a fluid."""
    return 0.5 * fluid * coefficient * np.pi * radius**2 / mass


def path_of(acceleration, place, velocity, times, step=1e-3):
    """Positions (n, 3) under acceleration(place, velocity), Runge-Kutta of fourth order from time 0."""

    def rate(y):
        return np.concatenate([y[3:], acceleration(y[:3], y[3:])])

    y, now, found = np.concatenate([place, velocity]).astype(float), 0.0, []
    for time in times:
        count = max(int(np.ceil((time - now) / step - 1e-9)), 1)
        h = (time - now) / count
        for _ in range(count if time > now else 0):
            a = rate(y)
            b = rate(y + h / 2 * a)
            c = rate(y + h / 2 * b)
            d = rate(y + h * c)
            y = y + h / 6 * (a + 2 * b + 2 * c + d)
        now = time
        found.append(y[:3].copy())
    return np.array(found)


def write(folder, recordings, settings, columns=("x_m", "y_m", "z_m"), trial="", backwards=False):
    """An experiment folder: recordings as (times, rows); settings as TOML text; the path of its experiment file."""
    entries = []
    for k, (times, rows) in enumerate(recordings):
        (folder / f"r{k}.csv").write_text(csv(times, rows, columns))
        entries.append(f'[[trial]]\nfile = "r{k}.csv"\ngroup = "day {k % 2 + 1}"\n{trial}')
    path = folder / "e.toml"
    path.write_text('kind = "trajectory"\n' + settings + "".join(entries[:: -1 if backwards else 1]))
    return path


def ball(radius, mass, surroundings=f"fluid_density = {AIR}\n", measurement="", model=""):
    """TOML text of a thrown ball."""
    body = f'[body]\nshape = "sphere"\nradius = {radius}\nmass = {mass}\n[surroundings]\ngravity = {G}\n{surroundings}'
    return body + (f"[model]\neffects = [{model}]\n" if model else "") + f"[measurement]\n{measurement}\n"


def throws(acceleration, sigma, generator, speeds, rate=60, seconds=0.9, spin=0.0):
    """[(times, rows)] of throws in four headings, noise white; with a spin [rad/s] about +z and -z in turn, quaternions too."""
    recordings = []
    for k, speed in enumerate(speeds):
        times = np.arange(0, seconds, 1 / rate)
        heading, turning = np.pi / 2 * (k % 4) + 0.5, spin * (-1) ** (k // 2)
        velocity = speed * np.array([0.8 * np.cos(heading), 0.8 * np.sin(heading), 0.6])
        law = acceleration(np.array([0, 0, turning])) if spin else acceleration
        rows = path_of(law, [0.0, 0.0, 1.5], velocity, times) + sigma * generator.standard_normal((len(times), 3))
        if spin:
            half = turning * times / 2 + 0.005 * generator.standard_normal(len(times))  # half of 0.01 rad
            lean = 0.005 * generator.standard_normal((len(times), 2))
            rows = np.column_stack([rows, np.cos(half), lean, np.sin(half)])
        recordings.append((times, rows))
    return recordings


def dragged(k, tilt=0.0):
    """Acceleration of a ball in still air, drag k v^2, gravity turned by `tilt` about x."""
    gravity = G * np.array([0.0, np.sin(tilt), -np.cos(tilt)])
    return lambda place, v: gravity - k * np.linalg.norm(v) * v


def write_in_air(folder, radius, mass, seconds, seed=5, drops=4, rate=60, noise=0.003, stated=True):
    """Drops in air, stated or not, let go at rest: weight, drag (C = 0.47), lift and half of the displaced air set in motion."""
    generator, times = np.random.default_rng(seed), np.arange(0, seconds, 1 / rate)
    displaced = AIR * 4 / 3 * np.pi * radius**3
    inertia, drag = mass + 0.5 * displaced, per_metre(0.47, radius, mass) * mass

    def law(place, v):
        return (np.array([0.0, 0.0, -G * (mass - displaced)]) - drag * np.linalg.norm(v) * v) / inertia

    rows = path_of(law, [0.0, 0.0, 3.0], np.zeros(3), times)[:, 2:]
    recordings = [(times, rows + noise * generator.standard_normal(rows.shape)) for _ in range(drops)]
    settings = ball(radius, mass, f"fluid_density = {AIR}\n" * stated, f"noise = {{ position = {noise} }}")
    return write(folder, recordings, settings, ("z_m",), "start = { velocity = [0.0, 0.0, 0.0] }\n")


def write_crisis(folder, subcritical=0.45, supercritical=0.10, critical=1.5e5):
    """Throws of a light ball at Reynolds numbers of 0.6 to 2.6e5, whose drag coefficient falls at a critical one; noise 3 mm."""
    radius, mass, viscosity = 0.11, 0.12, 1.8e-5
    k, generator = per_metre(1.0, radius, mass), np.random.default_rng(71)

    def law(place, v):
        speed = np.linalg.norm(v)
        ratio = 2 * radius * AIR * speed / viscosity / critical
        coefficient = supercritical + (subcritical - supercritical) / (1 + ratio**4)
        return np.array([0.0, 0.0, -G]) - coefficient * k * speed * v

    recordings = throws(law, 0.003, generator, np.linspace(4.0, 18.0, 8))
    settings = ball(radius, mass, surroundings=f"fluid_density = {AIR}\n", measurement="noise = { position = 0.003 }")
    return write(folder, recordings, settings)


def write_sinking(folder, drag):
    """A sphere that sinks in water from rest, noise 0.5 mm; the model has buoyancy and added mass, no drag."""
    radius, mass, generator, recordings = 0.0125, 0.01145, np.random.default_rng(81), []
    displaced = 998.0 * 4 / 3 * np.pi * radius**3
    moved = mass + 0.5 * displaced
    k = 0.5 * 998.0 * drag * np.pi * radius**2 / moved

    def law(place, v):
        return np.array([0.0, 0.0, -G * (mass - displaced) / moved]) - k * np.linalg.norm(v) * v

    for seconds in (0.7, 0.8, 0.9, 1.0, 1.1, 1.2):
        times = np.arange(0, seconds, 1 / 120)
        place = path_of(law, [0.0, 0.0, 1.0], np.zeros(3), times)
        recordings.append((times, place + 5e-4 * generator.standard_normal(place.shape)))
    laws = '{ name = "buoyancy", fluid_density = 998.0 }, { name = "added_mass", coefficient = 0.5 }'
    water = "fluid_density = 998.0\nfluid_viscosity = 0.001\n"
    settings = ball(radius, mass, water, "noise = { position = 0.0005 }", laws)
    return write(folder, recordings, settings, trial="start = { velocity = [0.0, 0.0, 0.0] }\n")


def write_magnet(folder, strength):
    """Eight throws past a magnet in a vacuum, 50 Hz, sigma 3 mm; the nearest passes it by more than 0.15 m (asserted)."""
    generator, recordings = np.random.default_rng(21), []

    def law(place, v):
        away = MAGNET - place
        return np.array([0, 0, -G]) + strength * away / np.linalg.norm(away) ** 3

    for speed, heading in zip(np.linspace(2.5, 4.5, 8), (0.05, -0.1, 0.2, -0.2, 0.3, -0.3, 0.15, -0.25), strict=True):
        times = np.arange(0, 1.2, 1 / 50)
        velocity = speed * np.array([0.8 * np.cos(heading), 0.8 * np.sin(heading), 0.6])
        place = path_of(law, [0.0, 0.0, 1.0], velocity, times)
        assert np.linalg.norm(place - MAGNET, axis=1).min() > 0.15
        recordings.append((times, place + 0.003 * generator.standard_normal(place.shape)))
    (folder / "magnet.py").write_text(MAGNET_EFFECT)
    return write(
        folder, recordings, ball(**TENNIS, surroundings="fluid_density = 0.0\n", measurement="noise = { position = 0.003 }")
    )


def write_quadratic(folder, sigma, number):
    """Throws with quadratic drag alone: body, coefficient and speeds by number, Reynolds numbers below 5e4."""
    generator = np.random.default_rng([15, number])
    radius, density = generator.uniform(0.015, 0.045), generator.uniform(80.0, 500.0)
    mass = float(f"{density * 4 / 3 * np.pi * radius**3:.4g}")
    fastest = min(5e4 * 1.5e-5 / (2 * radius), 12.0)
    law = dragged(per_metre(generator.uniform(0.3, 0.6), radius, mass))
    recordings = throws(law, sigma, generator, np.linspace(0.25, 1.0, 8) * fastest)
    return write(folder, recordings, ball(radius, mass, measurement=f"noise = {{ position = {sigma} }}"))


def write_hallway(folder, friction, stated):
    """A block pushed along a floor, filmed from above and from the side: it slows by friction g until it stops (closed form).
    No fluid is stated."""
    generator, recordings = np.random.default_rng(11), []
    for speed, heading in ((1.0, 0.0), (1.8, 1.6), (2.4, 3.1), (1.4, 4.5), (2.0, 0.7), (1.2, 2.2)):
        stop = speed / (friction * G)
        times = np.arange(0, stop + 0.2, 1 / 60)
        t = np.minimum(times, stop)
        way = speed * t - friction * G * t**2 / 2
        place = np.column_stack([way * np.cos(heading), way * np.sin(heading), np.full(len(t), 0.02)])
        recordings.append((times, place + 1e-3 * generator.standard_normal(place.shape)))
    return write(
        folder,
        recordings,
        f'[body]\nshape = "box"\nsize = [0.12, 0.08, 0.04]\nmass = 1.67\n[surroundings]\ngravity = {G}\nfriction = {stated}\n'
        "floor = { height = 0.0, normal = [0.0, 0.0, 1.0] }\n[measurement]\nnoise = { position = 0.001 }\n",
    )


def write_rounded(folder, pixels, seed):
    """Throws in a vacuum, noise 1 mm, rounded to a step of so many mm; the static recording likewise, of a body that rests at
    the middle of a pixel, where rounding hides noise instead of adding to it."""
    generator, step = np.random.default_rng(seed), pixels * 1e-3

    def rounded(rows):
        return np.round(rows / step) * step

    recordings = throws(dragged(0.0), 1e-3, generator, np.linspace(2, 6, 8))
    recordings = [(times, rounded(rows)) for times, rows in recordings]
    still = rounded(step * np.array([40, 80, 350]) + 1e-3 * generator.standard_normal((600, 3)))
    (folder / "rest.csv").write_text(csv(np.arange(600) / 60, still))
    return write(folder, recordings, ball(**TENNIS, surroundings="fluid_density = 0.0\n", measurement='static = "rest.csv"'))


def write_spun(folder, coefficient):
    """Throws with spin: lift = coefficient pi rho r^3 spin x v; drag of 0.47 acts and is in the model."""
    generator = np.random.default_rng(31)
    k, lift = per_metre(0.47, **TENNIS), coefficient * np.pi * AIR * TENNIS["radius"] ** 3 / TENNIS["mass"]
    still = dragged(k)
    recordings = throws(
        lambda spin: lambda place, v: still(place, v) + lift * np.cross(spin, v),
        0.003,
        generator,
        np.linspace(3, 7, 8),
        spin=20.0,
    )
    return write(
        folder,
        recordings,
        ball(
            **TENNIS,
            measurement="noise = { position = 0.003, orientation = 0.01 }",
            model='{ name = "quadratic_drag", drag_coefficient = 0.47 }',
        ),
        ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"),
    )


def write_plain_throws(folder, k=0.0, tilt=0.0, outliers=0.0, seed=41, body=TENNIS, vacuum=False, backwards=False):
    """Throws with drag k v^2 [1/m] and tilted gravity, sigma 3 mm stated, a share of readings off by 5 to 15 sigma."""
    generator = np.random.default_rng(seed)
    recordings = throws(dragged(k, tilt), 0.003, generator, np.linspace(2, 7, 8))
    for _, rows in recordings:
        wild = generator.random(rows.shape) < outliers
        rows += wild * 0.003 * generator.uniform(5, 15, rows.shape) * generator.choice([-1.0, 1.0], rows.shape)
    air = 0.0 if vacuum else AIR
    settings = ball(**body, surroundings=f"fluid_density = {air}\n", measurement="noise = { position = 0.003 }")
    return write(folder, recordings, settings, backwards=backwards)


def bouncing(height, times, k, restitution):
    """Heights of the lowest point of a ball let fall: quadratic drag k v^2 [1/m] and bounces, closed form."""
    root = np.sqrt(G * k)
    heights, moment = np.zeros(len(times)), np.arccosh(np.exp(k * height)) / root
    fall = times < moment
    heights[fall] = height - np.log(np.cosh(root * times[fall])) / k
    speed = restitution * np.sqrt(G / k) * np.tanh(root * moment)
    while moment < times[-1]:
        angle = np.arctan(speed * np.sqrt(k / G))
        top, rise = -np.log(np.cos(angle)) / k, angle / root
        down = np.arccosh(np.exp(k * top)) / root
        up = (times >= moment) & (times < moment + rise)
        heights[up] = np.log(np.cos(angle - root * (times[up] - moment)) / np.cos(angle)) / k
        back = (times >= moment + rise) & (times < moment + rise + down)
        heights[back] = top - np.log(np.cosh(root * (times[back] - moment - rise))) / k
        speed = restitution * np.sqrt(G / k) * np.tanh(root * down)
        moment += rise + down
    return heights


def write_dragged_bounces(folder, restitution, stated, drag=0.47):
    """A ball let fall on a floor from about 0.75 m, drag coefficient 0.47 if not another, noise 1 mm."""
    generator, recordings = np.random.default_rng(51), []
    k, radius = per_metre(drag, **RUBBER), RUBBER["radius"]
    for height in (0.70, 0.75, 0.80, 0.72, 0.78, 0.74):
        times = np.arange(0, 1.1, 1 / 120)
        z = radius + bouncing(height, times, k, restitution)
        place = np.column_stack([0 * times, 0 * times, z])
        recordings.append((times, place + 0.001 * generator.standard_normal(place.shape)))
    surroundings = f"fluid_density = {AIR}\nrestitution = {stated}\nfriction = 0.3\nfloor = {{ height = 0.0 }}\n"
    settings = ball(**RUBBER, surroundings=surroundings, measurement="noise = { position = 0.001 }")
    return write(
        folder, recordings, settings, trial="start = { velocity = [0.0, 0.0, 0.0], angular_velocity = [0.0, 0.0, 0.0] }\n"
    )


def write_tumbles(folder, case):
    """One experiment of tossed cubes from another engine (tumbling/make_tumbles.py), the friction stated wrong by 0.1; (path,
    true friction)."""
    rows = np.loadtxt(TUMBLING / "tumbles.csv", delimiter=",", skiprows=1)
    true = np.loadtxt(TUMBLING / "truths.csv", delimiter=",", skiprows=1)[case, 2]
    stated = true + (0.1 if case % 2 else -0.1)
    return write_cubes(folder, rows[rows[:, 0] == case, 1:], 60, np.random.default_rng([61, case]), stated), true


def write_tosses(folder):
    """Twenty tosses of a cube by springs (tumbling/make_tosses.py), friction stated as 0.5 and restitution as 0; (path,
    {"friction" and "restitution": (middle, low, high) of what acted})."""
    rows = np.loadtxt(TUMBLING / "tosses.csv", delimiter=",", skiprows=1)
    truths = np.loadtxt(TUMBLING / "tosses_truths.csv", delimiter=",", skiprows=1, usecols=(1, 2, 3))
    path = write_cubes(folder, rows, 120, np.random.default_rng(62), 0.5)
    return path, dict(zip(("friction", "restitution"), truths.tolist(), strict=True))


def write_cubes(folder, rows, rate, generator, friction):
    """An experiment of tossed cubes from rows (toss, frame, pose), noise 1 mm and 0.01 rad added; the path of its file."""
    recordings = []
    for toss in np.unique(rows[:, 0]):
        one = rows[rows[:, 0] == toss]
        place = one[:, 2:5] + 0.001 * generator.standard_normal((len(one), 3))
        turn = one[:, 5:] + 0.005 * generator.standard_normal((len(one), 4))  # half of 0.01 rad; its length is no information
        recordings.append((one[:, 1] / rate, np.hstack([place, turn / np.linalg.norm(turn, axis=1, keepdims=True)])))
    settings = (
        f'[body]\nshape = "box"\nsize = [0.1, 0.1, 0.1]\nmass = 0.37\n[surroundings]\ngravity = {G}\nfluid_density = 0.0\n'
        f"friction = {friction:.4f}\nrestitution = 0.0\nfloor = {{ height = 0.0 }}\n[measurement]\n"
        "noise = { position = 0.001, orientation = 0.01 }\n"
    )
    return write(folder, recordings, settings, ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"))
