"""Scenes in which something can be hidden: what was dropped, thrown or slid where, and what is known about it.

A scene says all that a laboratory knows, and its model is complete: air and water at rest, with their drag, lift and added mass.
What is hidden is taken out of that model, or changes what it states, when the data set is made. Like `motion` this imports
nothing of the engine.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hlcs.mystery import motion

AIR, WATER = 1.2, 998.0  # kg/m3 at 20 degrees Celsius
VISCOSITY = {AIR: 1.8e-5, WATER: 1.0e-3}  # Pa s at 20 degrees Celsius
SPHERE = {"drag_coefficient": 0.47, "coefficient": 0.5}  # Hoerner (1965) ch. 3; Lamb (1932) art. 92
BLOCK = {"drag_coefficient": 1.05, "coefficient": 0.68}  # of a cube: Hoerner (1965) ch. 3; DNV-RP-C205 (2010) app. D
# radius [m] and mass [kg]: of foam, a beach ball, a tennis ball, a football, steel
BALLS = ((0.04, 0.011), (0.15, 0.11), (0.0335, 0.0577), (0.11, 0.43), (0.05, 4.08))
AT_REST = np.zeros(3)
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


class Trial(NamedTuple):
    """One recording to be made."""

    group: str
    start: motion.Start
    known: tuple[str, ...]  # what of the start the experiment file states
    duration: float  # s
    floor: motion.Floor | None = None


class Scene(NamedTuple):
    """An experiment before anything is hidden in it."""

    room: str
    title: str
    shape: dict  # [body]
    surroundings: dict  # [surroundings]
    model: tuple[dict, ...]  # [model] effects
    trials: tuple[Trial, ...]
    move: Callable  # (laws, trial, start, times) -> positions (n, 3), orientations (n, 4)
    turns: bool = False  # whether orientations are recorded
    rate: float = 60.0  # pictures a second


# --- in the air -------------------------------------------------------------------------------------------------------------


def tower(rng):
    """Balls let go at rest from several heights."""
    radius, mass = pick(rng, BALLS)
    trials = []
    for turn, height in enumerate(spread(rng, 1.5, 9.0, 9)):
        start = motion.Start(place(rng, 0.3, height), AT_REST, UPRIGHT, AT_REST)
        trials.append(Trial(session(turn, 9), start, ("velocity",), np.sqrt(2 * (height - 0.3) / motion.GRAVITY)))
    return in_air("Balls let go from several heights", radius, mass, trials, rate=30.0)


def gallery(rng):
    """Balls thrown to four sides."""
    radius, mass = pick(rng, BALLS)
    trials = []
    for turn, speed in enumerate(spread(rng, 3.0, 11.0, 8)):
        velocity = speed * heading(rng, turn, rise=rng.uniform(0.3, 1.0))
        start = motion.Start(place(rng, 0.2, 1.6), velocity, UPRIGHT, AT_REST)
        trials.append(Trial(session(turn, 8), start, (), flight_time(velocity[2], 1.4)))
    return in_air("Balls thrown to four sides", radius, mass, trials)


def spinning(rng):
    """Balls thrown with spin about an axis near the vertical, every second the other way."""
    radius, mass = pick(rng, ((0.11, 0.43), (0.105, 0.27)))
    trials = []
    for turn, speed in enumerate(spread(rng, 5.0, 12.0, 8)):
        velocity = speed * heading(rng, turn, rise=rng.uniform(0.4, 1.0))
        axis = np.array([*rng.uniform(-0.3, 0.3, 2), 1.0 if turn % 2 else -1.0])
        spin = axis / np.linalg.norm(axis) * rng.uniform(10.0, 30.0)
        start = motion.Start(place(rng, 0.2, 1.6), velocity, UPRIGHT, spin)
        trials.append(Trial(session(turn, 8), start, (), flight_time(velocity[2], 1.4)))
    return in_air("Balls thrown with spin, every second the other way", radius, mass, trials)._replace(turns=True)


def in_air(title, radius, mass, trials, rate=60.0):
    """A scene of balls that fly in air at rest."""
    body = motion.ball(radius, mass, AIR)
    return Scene(
        "air",
        title,
        {"shape": "sphere", "radius": radius, "mass": mass},
        around(AIR),
        fluid_model(AIR, SPHERE),
        tuple(trials),
        lambda laws, trial, start, times: motion.fly(body, laws, start, times),
        rate=rate,
    )


# --- on the floor -----------------------------------------------------------------------------------------------------------


def hallway(rng):
    """A block launched along a level floor, to four sides."""
    size, mass = pick(rng, (([0.12, 0.08, 0.04], 0.27), ([0.2, 0.15, 0.05], 1.05), ([0.12, 0.08, 0.04], 0.43)))
    body, floor = motion.block(size, mass, AIR), motion.Floor(np.array([0.0, 0.0, 1.0]), 0.3, 0.0)
    trials = []
    for turn, speed in enumerate(spread(rng, 0.8, 2.4, 7)):
        way = heading(rng, turn)
        lies = np.round(motion.quaternion(np.array([0.0, 0.0, np.arctan2(way[1], way[0])])), 8)
        start = motion.Start(place(rng, 0.05, size[2] / 2), speed * way, lies, AT_REST)
        seconds = speed / (0.3 * motion.GRAVITY) + 0.2
        trials.append(Trial(session(turn, 7), start, ("orientation", "angular_velocity"), seconds, floor))
    return Scene(
        "floor",
        "A block launched along a floor, to four sides",
        {"shape": "box", "size": size, "mass": mass},
        around(AIR) | resting_on(floor),
        fluid_model(AIR, BLOCK),
        tuple(trials),
        lambda laws, trial, start, times: motion.slide(body, laws, start, times, trial.floor, size[2] / 2),
    )


def gymnasium(rng):
    """Balls dropped without spin on a level floor, followed over two bounces."""
    radius, mass = pick(rng, ((0.0335, 0.0577), (0.11, 0.43), (0.03, 0.027)))
    body, floor = motion.ball(radius, mass, AIR), motion.Floor(np.array([0.0, 0.0, 1.0]), 0.5, 0.75)
    trials = []
    for turn, height in enumerate(spread(rng, 0.25, 1.4, 7)):
        start = motion.Start(place(rng, 0.2, height + radius), AT_REST, UPRIGHT, AT_REST)
        seconds = np.sqrt(2 * height / motion.GRAVITY) * (1 + 2 * 0.75 + 0.75**2)
        trials.append(Trial(session(turn, 7), start, ("velocity", "angular_velocity"), seconds, floor))
    return Scene(
        "floor",
        "Balls dropped on a floor, followed over their first bounces",
        {"shape": "sphere", "radius": radius, "mass": mass},
        around(AIR) | resting_on(floor),
        fluid_model(AIR, SPHERE),
        tuple(trials),
        lambda laws, trial, start, times: motion.fly(body, laws, start, times, trial.floor),
    )


def boards(rng):
    """A ball let go on gently inclined boards that fall to four sides."""
    radius, mass = pick(rng, ((0.02, 0.26), (0.03, 0.12), (0.06, 0.35)))
    body, trials = motion.ball(radius, mass, AIR), []
    for turn, slope in enumerate(spread(rng, 1.0, 6.0, 7)):
        slope, way = np.deg2rad(slope), heading(rng, turn)
        normal = np.round(np.sin(slope) * way + [0.0, 0.0, np.cos(slope)], 8)
        start = motion.Start(np.round(radius * normal, 6), AT_REST, UPRIGHT, AT_REST)
        seconds = min(np.sqrt(2 * rng.uniform(0.3, 0.6) / (5 / 7 * motion.GRAVITY * np.sin(slope))), 1.8)
        known = ("position", "orientation", "velocity", "angular_velocity")
        trials.append(Trial(session(turn, 7), start, known, seconds, motion.Floor(normal, 0.6, 0.0)))
    return Scene(
        "floor",
        "A ball let go on gently inclined boards",
        {"shape": "sphere", "radius": radius, "mass": mass},
        around(AIR) | resting_on(motion.Floor(np.array([0.0, 0.0, 1.0]), 0.6, 0.0)),
        fluid_model(AIR, SPHERE),
        tuple(trials),
        lambda laws, trial, start, times: motion.roll(body, laws, start, times, trial.floor),
    )


# --- in the water ------------------------------------------------------------------------------------------------------------


def tank(rng):
    """Balls in a tank of water, released at rest and pushed to four sides in turn."""
    radius, density = pick(rng, ((0.01, 1180.0), (0.0125, 1400.0), (0.02, 1180.0)))  # acrylic glass, PVC
    mass = float(f"{density * 4 / 3 * np.pi * radius**3:.4g}")
    body, trials = motion.ball(radius, mass, WATER), []
    for turn, speed in enumerate(spread(rng, 0.4, 1.2, 10)):
        pushed = turn % 2 == 1
        velocity = speed * (heading(rng, turn // 2) + [0.0, 0.0, -0.4]) if pushed else AT_REST
        start = motion.Start(place(rng, 0.05, -0.05), velocity, UPRIGHT, AT_REST)
        trials.append(Trial(session(turn, 10), start, () if pushed else ("velocity",), float(rng.uniform(0.8, 1.4))))
    return Scene(
        "water and layers",
        "Plastic balls in a tank of water, released or pushed",
        {"shape": "sphere", "radius": radius, "mass": mass},
        around(WATER),
        fluid_model(WATER, SPHERE),
        tuple(trials),
        lambda laws, trial, start, times: motion.fly(body, laws, start, times),
    )


# --- parts of scenes --------------------------------------------------------------------------------------------------------


def around(density):
    """What [surroundings] says of a fluid at rest."""
    return {"gravity": motion.GRAVITY, "fluid_density": density, "fluid_viscosity": VISCOSITY[density]}


def resting_on(floor):
    """What [surroundings] says of a floor."""
    plane = {"height": 0.0, "normal": [float(part) for part in floor.normal]}
    return {"floor": plane, "friction": floor.friction, "restitution": floor.restitution}


def fluid_model(density, shape):
    """Entries of [model] effects for a body of that shape in a fluid at rest."""
    return (
        {"name": "buoyancy", "fluid_density": density},
        {"name": "added_mass", "coefficient": shape["coefficient"], "fluid_density": density},
        {"name": "quadratic_drag", "drag_coefficient": shape["drag_coefficient"], "fluid_density": density},
    )


def pick(rng, choices):
    """One of the choices."""
    return choices[rng.integers(len(choices))]


def spread(rng, low, high, count):
    """(count,) values from low to high in an order in which neighbours differ, each a little off."""
    step = (high - low) / (count - 1)
    return [float(low + step * (3 * turn % count if count % 3 else turn) + rng.uniform(0, 0.1) * step) for turn in range(count)]


def place(rng, side, height):
    """A point (3,) [m] at a height, up to `side` off the middle."""
    return np.round(np.array([*rng.uniform(-side, side, 2), height]), 6)


def heading(rng, turn, rise=0.0):
    """A unit vector (3,): about one of four directions in turn, so many radians over the horizontal."""
    angle = np.pi / 2 * (turn % 4) + rng.uniform(-0.2, 0.2)
    return np.array([np.cos(rise) * np.cos(angle), np.cos(rise) * np.sin(angle), np.sin(rise)])


def session(turn, count):
    """The name of the group of a recording: three sessions, one after the other."""
    return f"session {1 + 3 * turn // count}"


def flight_time(upwards, drop):
    """Seconds of a throw until it is `drop` [m] under its start, at most 1.6."""
    return min((upwards + np.sqrt(upwards**2 + 2 * motion.GRAVITY * drop)) / motion.GRAVITY, 1.6)
