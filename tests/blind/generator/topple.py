"""Topple: a block held on its edge at a measured angle and let go; filmed until the edge is about to slip or the face to land."""

import numpy as np

from . import tilting
from .case import Setup, Trial
from .dials import Dial, camera_drift, camera_shake, groups, one, own_moments, tilt
from .fluid import around
from .fluid import rivals as missing

STYLES = ("falls",)
FRICTION = 0.9
OF_FRICTION = 0.6, 0.95  # the part of it that the edge may need: as the file has it, and with what is hidden
HIDDEN = {
    "centre_of_mass_offset": Dial(lambda rng: _centre(rng), 1e-4, 0.045, STYLES),
    "tilted_gravity": tilt("tilted_gravity", STYLES),
    "tilted_frame": tilt("tilted_frame", STYLES),
    "length_scale": one("length_scale", "factor", 5e-4, 0.06, STYLES, null=1.0, sign=0),
    "time_scale": one("time_scale", "factor", 3e-4, 0.04, STYLES, null=1.0, sign=0),
    "clock_offset": one("clock_offset", "offset", 3e-4, 0.1, STYLES, sign=0),
    "margin_offset": one("margin_offset", "offset", 5e-4, 0.018, STYLES),
    "size_error": one("size_error", "relative", 5e-4, 0.018, STYLES, sign=0),
}
OUTSIDE = {
    "camera_shake": camera_shake(STYLES, low=1e-4),
    "camera_drift": camera_drift(STYLES, high=2.0),
    "shaken_floor": Dial(lambda rng: _shaken(rng), 0.01, 6.0, STYLES),
    "kick": Dial(lambda rng: lambda amplitude: {"kick": {"kick": amplitude}}, 0.02, 60.0, STYLES),
}
DEGENERATE, JOINT = (), (("clock_offset", "time_scale", "falls"),)
DOUBLES = (
    ("centre_of_mass_offset", "tilted_gravity", "falls"),
    ("clock_offset", "tilted_frame", "falls"),
    ("centre_of_mass_offset", "time_scale", "falls"),
)


def _centre(rng):
    angle = rng.uniform(0, 2 * np.pi)
    return lambda amplitude: {"centre_of_mass_offset": {"x": amplitude * np.cos(angle), "z": amplitude * np.sin(angle)}}


def _shaken(rng):
    frequency, phase = float(rng.uniform(15, 30)), float(rng.uniform(0, 2 * np.pi))
    return lambda amplitude: {"shaken_floor": {"shake": amplitude, "frequency": frequency, "phase": phase}}


def holds(trial, inputs, effects, times):
    """Does the block turn about its edge at all these true times, as the file says?"""
    return tilting.valid(inputs, effects, trial.start, times, 1e-3, OF_FRICTION[1] * FRICTION, np.pi / 2) == len(times)


def setup(rng, stamps, style, hidden=()):
    """A toppling experiment: start pose and rest stated, leaning angles on both sides of the balance, four headings."""
    width, depth, height = ((0.10, 0.10, 0.25), (0.06, 0.12, 0.20), (0.15, 0.10, 0.30))[rng.integers(3)]
    mass = float(f"{rng.uniform(600, 2400) * width * depth * height:.3g}")
    air = around(rng, hidden, "box")
    inputs = {
        "mass": mass,
        "gravity": 9.81,
        "width": width,
        "block_height": height,
        "fluid_density": air.density,
        "volume": width * depth * height,
        "area": (width * depth + depth * height + width * height) / 2,
        "nominal_diameter": (width * depth * height) ** (1 / 3),
    }
    balance = np.arctan2(width, height)
    count = int(rng.integers(6, 11))
    trials = []
    for i, group in enumerate(groups(rng, count)):
        heading = np.pi / 2 * (i % 4) + rng.uniform(-0.3, 0.3)
        lean = np.deg2rad(float(np.linspace(2.5, 9.0, count)[(i * 3) % count]))
        angle = balance + lean if i % 3 else max(balance - lean, 0.1)
        pivot = np.array([*rng.uniform(-0.1, 0.1, 2), 0.0])
        start = {"heading": heading, "angle": angle, "pivot": pivot}
        times = stamps(1.2)
        times = times[: tilting.valid(inputs, {}, start, times, 1e-3, OF_FRICTION[0] * FRICTION, balance + np.deg2rad(40))]
        position, orientation = tilting.simulate(None, inputs, {}, start, np.zeros(1), 1e-3)
        start.update(position=position[0], orientation=orientation[0], velocity=np.zeros(3), angular_velocity=np.zeros(3))
        own = {key: value for name in hidden for key, value in own_moments(rng, name, times[-1]).items()}
        trials.append(Trial(group, start, ("position", "orientation", "velocity", "angular_velocity"), times, own=own))
    rivals = (
        "inertia_error",
        "centre_of_mass_offset",
        "tilted_gravity",
        "tilted_frame",
        "length_scale",
        "time_scale",
        "clock_offset",
        "margin_offset",
        "size_error",
    )
    surroundings = {
        "gravity": 9.81,
        **air.stated,
        "floor": {"height": 0.0, "normal": [0.0, 0.0, 1.0]},
        "friction": FRICTION,
        "restitution": 0.0,
    }
    return Setup(
        "topple",
        "block toppling about its edge",
        {"shape": "box", "size": [width, depth, height]},
        inputs,
        surroundings,
        air.model,
        tuple(trials),
        ("x_m", "y_m", "z_m", "q"),
        tilting.simulate,
        missing(rivals, air),
        holds=holds,
    )
