"""Bounce: balls dropped or thrown on a floor, one to three impacts before the film ends. (Rebound tables: `tables`.)"""

import numpy as np

from . import motion
from .case import Setup, Trial
from .dials import Dial, camera_drift, camera_shake, groups, growing_lift, gust, magnet, one, own_moments, swirl, tilt
from .fluid import AIR, AIR_VISCOSITY, SPHERES_MASS, around
from .fluid import rivals as missing

STYLES = ("drops", "throws")


def _restitution(rng):
    side = rng.choice([-1.0, 1.0])
    return lambda amplitude: {"restitution": {"coefficient": 0.75 + side * amplitude}}


def _friction(rng):
    side = rng.choice([-1.0, 1.0])
    return lambda amplitude: {"friction": {"coefficient": 0.09 + side * amplitude, "form": 0.0}}


HIDDEN = {
    "restitution": Dial(_restitution, 5e-4, 0.2, STYLES),
    "velocity_dependent_restitution": one("velocity_dependent_restitution", "exponent", 5e-4, 0.2, STYLES, form="form"),
    "friction": Dial(_friction, 5e-4, 0.085, ("throws",)),
    "linear_drag": one("linear_drag", "rate", 0.002, 1.0, STYLES, form="form"),
    "quadratic_drag": one("quadratic_drag", "drag_coefficient", 0.01, 1.4, STYLES, form="form"),
    "tilted_gravity": tilt("tilted_gravity", STYLES),
    "tilted_frame": tilt("tilted_frame", STYLES),
    "length_scale": one("length_scale", "factor", 5e-4, 0.05, STYLES, null=1.0, sign=0),
    "time_scale": one("time_scale", "factor", 3e-4, 0.04, STYLES, null=1.0, sign=0),
    "clock_offset": one("clock_offset", "offset", 2e-4, 0.1, ("drops",), sign=0),
    "buoyancy": one("buoyancy", "fluid_density", AIR, AIR, STYLES),
    "added_mass": one("added_mass", "coefficient", 0.02, SPHERES_MASS, STYLES),
    "bottom_slope": Dial(lambda rng: _slope(rng), 3e-4, 0.09, STYLES),
}
OUTSIDE = {
    "camera_shake": camera_shake(STYLES),
    "camera_drift": camera_drift(STYLES),
    "gust": gust(STYLES),
    "growing_lift": growing_lift(("throws",)),
    "magnet": magnet(STYLES, (0.4, 0.0, 0.5), 1.0),
    "swirl": swirl(("throws",)),
}
DEGENERATE = (
    ("time_scale", "drops"),
    ("tilted_gravity", "drops"),
    ("length_scale", "throws"),
    ("bottom_slope", "drops"),
    ("time_scale", "throws"),
    ("added_mass", "drops"),
)
NESTED = (("quadratic_drag", "throws"), ("quadratic_drag", "drops"))
JOINT = (
    ("restitution", "quadratic_drag", "drops"),
    ("restitution", "quadratic_drag", "throws"),
    ("restitution", "velocity_dependent_restitution", "drops"),
    ("restitution", "linear_drag", "throws"),
    ("restitution", "linear_drag", "drops"),
    ("velocity_dependent_restitution", "length_scale", "throws"),
    ("restitution", "time_scale", "drops"),
)
DOUBLES = (
    ("restitution", "tilted_gravity", "drops"),
    ("restitution", "quadratic_drag", "throws"),
    ("friction", "bottom_slope", "throws"),
    ("velocity_dependent_restitution", "tilted_gravity", "drops"),
    ("restitution", "length_scale", "throws"),
)


def _slope(rng):
    heading = rng.uniform(0, 2 * np.pi)
    return lambda amplitude: {"bottom_slope": {"grade_x": amplitude * np.cos(heading), "grade_y": amplitude * np.sin(heading)}}


def setup(rng, stamps, style, hidden=()):
    """A bounce experiment on a level floor, restitution 0.75 and friction 0.09 (waxed) nominal."""
    radius, mass = ((0.0335, 0.0577), (0.11, 0.43), (0.02, 0.0027), (0.03, 0.027))[rng.integers(4)]
    air = around(rng, hidden)
    count = int(rng.integers(6, 11))
    trials = []
    for i, group in enumerate(groups(rng, count)):
        heading = np.pi / 2 * (i % 4) + rng.uniform(-0.3, 0.3)
        height = float(np.linspace(0.25, 1.8, count)[(i * 3) % count] + rng.uniform(0, 0.05))
        forward = 0.0 if style == "drops" else float(rng.uniform(1.0, 4.0))
        start = {
            "position": np.array([rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), height + radius]),
            "velocity": forward * np.array([np.cos(heading), np.sin(heading), 0.0]),
            "angular_velocity": np.zeros(3),
        }
        fall = np.sqrt(2 * height / 9.81)
        duration = min(fall * (1 + 2 * 0.75 + rng.choice([0.0, 1.0])), 1.8)
        known = ("velocity", "angular_velocity") if style == "drops" else ("angular_velocity",)
        own = {key: value for name in hidden for key, value in own_moments(rng, name, duration).items()}
        trials.append(Trial(group, start, known, stamps(duration), own=own))
    rivals = [
        "restitution",
        "velocity_dependent_restitution",
        "linear_drag",
        "quadratic_drag",
        "buoyancy",
        "added_mass",
        "tilted_gravity",
        "tilted_frame",
        "length_scale",
        "time_scale",
        "bottom_slope",
        "size_error",
        "margin_offset",
    ]
    rivals += ["clock_offset"] if style == "drops" else ["friction"]
    inputs = {
        "mass": mass,
        "radius": radius,
        "gravity": 9.81,
        "fluid_density": air.density,
        "viscosity": AIR_VISCOSITY,
        "v_ref": 3.0,
        "floor_height": 0.0,
        "floor_normal": (0.0, 0.0, 1.0),
        "restitution": 0.75,
        "friction": 0.09,
    }
    surroundings = {
        "gravity": 9.81,
        **air.stated,
        "floor": {"height": 0.0, "normal": [0.0, 0.0, 1.0]},
        "friction": 0.09,
        "restitution": 0.75,
    }
    return Setup(
        "bounce",
        "ball bouncing on a waxed floor",
        {"shape": "sphere", "radius": radius},
        inputs,
        surroundings,
        air.model,
        tuple(trials),
        ("x_m", "y_m", "z_m"),
        motion.simulate,
        missing(rivals, air),
    )
