"""Slide: a block let go on inclines, or launched on a level floor, in four headings. (Stopping-distance tables: `tables`.)"""

import numpy as np

from . import plane
from .case import Setup, Trial
from .dials import Dial, camera_drift, camera_shake, groups, one, own_moments, tilt
from .fluid import around
from .fluid import rivals as missing
from .noise import product, small_turn

STYLES = ("incline", "launched")
MU = 0.30
SIZES = ((0.12, 0.08, 0.04), (0.20, 0.15, 0.05), (0.06, 0.06, 0.03))


def floor_of(slope, heading):
    """Unit normal of a plane that falls towards the heading at `slope` rad, two tangents, and the turn of a body that lies
    on it."""
    normal = np.array([np.sin(slope) * np.cos(heading), np.sin(slope) * np.sin(heading), np.cos(slope)])
    lean = small_turn(slope * np.array([-np.sin(heading), np.cos(heading), 0.0]))
    turn = product(lean, small_turn(np.array([0.0, 0.0, heading])))
    axes = plane.frame(normal)
    return normal, (tuple(axes[0]), tuple(axes[1])), turn


def _friction(rng):
    side = rng.choice([-1.0, 1.0])
    return lambda amplitude: {"friction": {"coefficient": MU + side * amplitude, "form": 0.4}}


def _stribeck(rng):
    speed = float(rng.uniform(0.12, 0.35))
    return lambda amplitude: {"stribeck_friction": {"ratio": 1 + amplitude, "speed": speed, "form": 0.5}}


def _anisotropic(rng):
    angle = float(rng.uniform(0.1, 1.4))
    return lambda amplitude: {"anisotropic_friction": {"ratio": 1 + amplitude, "angle": angle}}


def _slope(rng):
    heading = rng.uniform(0, 2 * np.pi)
    return lambda amplitude: {"bottom_slope": {"grade_x": amplitude * np.cos(heading), "grade_y": amplitude * np.sin(heading)}}


def _patch(rng):
    return lambda amplitude: {"sticky_patch": {"patch": amplitude, "patch_1": 0.25, "patch_2": 0.15, "patch_size": 0.12}}


def _wave(rng):
    number = float(rng.uniform(18, 30))
    return lambda amplitude: {"wavy_floor": {"wave": amplitude, "wave_number": number}}


def _shaken(rng):
    rate, heading = float(rng.uniform(15, 35)), float(rng.uniform(0, 2 * np.pi))
    return lambda amplitude: {"shaken_board": {"shake": amplitude, "shake_rate": rate, "shake_heading": heading}}


HIDDEN = {
    "friction": Dial(_friction, 1e-4, 0.15, STYLES),
    "stribeck_friction": Dial(_stribeck, 2e-3, 0.8, ("launched",)),
    "viscous_friction": one("viscous_friction", "slope", 5e-4, 0.3, STYLES, form="form"),
    "anisotropic_friction": Dial(_anisotropic, 2e-3, 0.6, STYLES),
    "tilted_gravity": tilt("tilted_gravity", STYLES),
    "tilted_frame": tilt("tilted_frame", STYLES),
    "bottom_slope": Dial(_slope, 3e-4, 0.08, STYLES),
    "length_scale": one("length_scale", "factor", 5e-4, 0.06, STYLES, null=1.0, sign=0),
    "time_scale": one("time_scale", "factor", 3e-4, 0.04, STYLES, null=1.0, sign=0),
    "clock_offset": one("clock_offset", "offset", 3e-4, 0.1, ("incline",), sign=0),
    "margin_offset": one("margin_offset", "offset", 1e-3, 0.018, STYLES),
    "size_error": one("size_error", "relative", 1e-3, 0.018, STYLES, sign=0),
}
OUTSIDE = {
    "camera_shake": camera_shake(STYLES),
    "camera_drift": camera_drift(STYLES),
    "sticky_patch": Dial(_patch, 2e-3, 0.5, ("incline",)),
    "wavy_floor": Dial(_wave, 1e-3, 0.4, STYLES),
    "shaken_board": Dial(_shaken, 0.01, 4.0, STYLES),
}
DEGENERATE = (("viscous_friction", "one_slope"), ("viscous_friction", "launched"))  # on one slope the load never changes
JOINT = (
    ("friction", "viscous_friction", "launched"),
    ("friction", "clock_offset", "incline"),
    ("friction", "length_scale", "launched"),
    ("friction", "time_scale", "incline"),
    ("friction", "stribeck_friction", "launched"),
)
DOUBLES = (
    ("friction", "tilted_gravity", "launched"),
    ("friction", "viscous_friction", "launched"),
    ("friction", "bottom_slope", "incline"),
    ("friction", "clock_offset", "incline"),
    ("stribeck_friction", "tilted_frame", "launched"),
)


def setup(rng, stamps, style, hidden=()):
    """A sliding experiment, friction 0.30 nominal. The block lies flat, its long side along the way."""
    size = SIZES[rng.integers(len(SIZES))]
    mass = float(f"{rng.choice([rng.uniform(700, 2500), 7800.0]) * np.prod(size):.3g}")
    clearance = size[2] / 2
    air = around(rng, hidden, "box")
    count = int(rng.integers(6, 11))
    trials = []
    for i, group in enumerate(groups(rng, count)):
        heading = np.pi / 2 * (i % 4) + rng.uniform(-0.2, 0.2)
        slope = 0.0 if style == "launched" else float(np.linspace(21, 36, count)[(i * 3) % count])
        slope = np.deg2rad(28.0 if style == "one_slope" else slope)
        normal, tangents, turn = floor_of(slope, heading)
        along = np.cross(normal, np.cross([np.cos(heading), np.sin(heading), 0.0], normal))
        along /= np.linalg.norm(along)
        place = rng.uniform(-0.05, 0.05) * np.array(tangents[0]) + rng.uniform(-0.05, 0.05) * np.array(tangents[1])
        start = {
            "position": np.round(place + clearance * normal, 6),
            "orientation": turn,
            "velocity": np.zeros(3),
            "angular_velocity": np.zeros(3),
        }
        known, overrides = ("position", "orientation", "velocity", "angular_velocity"), {}
        if style != "launched":
            duration = np.sqrt(2 * rng.uniform(0.6, 1.2) / (9.81 * (np.sin(slope) - MU * np.cos(slope))))
            overrides = {"floor": {"height": 0.0, "normal": [float(x) for x in normal]}}
        else:
            speed = float(np.linspace(0.7, 2.8, count)[(i * 3) % count])
            start["velocity"], known = speed * along, ("orientation", "angular_velocity")
            duration = speed / (MU * 9.81) + 0.15
        own = {key: value for name in hidden for key, value in own_moments(rng, name, duration).items()}
        trials.append(Trial(group, start, known, stamps(min(duration, 1.8)), overrides, own, tangents))
    rivals = [
        "friction",
        "stribeck_friction",
        "viscous_friction",
        "anisotropic_friction",
        "tilted_gravity",
        "tilted_frame",
        "bottom_slope",
        "length_scale",
        "time_scale",
        "margin_offset",
        "size_error",
    ]
    rivals += ["clock_offset"] if style != "launched" else []
    volume = float(np.prod(size))
    inputs = {
        "mass": mass,
        "gravity": 9.81,
        "friction": MU,
        "clearance": clearance,
        "floor_height": 0.0,
        "floor_normal": (0.0, 0.0, 1.0),
        "nominal_diameter": volume ** (1 / 3),
        "fluid_density": air.density,
        "volume": volume,
        "area": (size[0] * size[1] + size[1] * size[2] + size[0] * size[2]) / 2,
    }
    surroundings = {
        "gravity": 9.81,
        **air.stated,
        "floor": {"height": 0.0, "normal": [0.0, 0.0, 1.0]},
        "friction": MU,
        "restitution": 0.0,
    }
    title = "block let go on inclined boards" if style != "launched" else "block launched on a level floor"
    return Setup(
        "slide",
        title,
        {"shape": "box", "size": list(size)},
        inputs,
        surroundings,
        air.model,
        tuple(trials),
        ("x_m", "y_m", "z_m"),
        plane.simulate,
        missing(rivals, air),
    )
