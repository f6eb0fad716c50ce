"""Sinking in water: spheres released below the surface, from rest or pushed, some spinning; the usual fluid forces already
in the model."""

import numpy as np

from . import motion
from .case import Setup, Trial
from .dials import camera_drift, camera_shake, groups, growing_lift, gust, magnet, one, own_moments, plane, swirl, tilt
from .fluid import SPHERES_MASS

WATER = 998.0  # fresh water at 20 degrees Celsius [kg/m3]
STYLES = ("released", "pushed", "spinning", "both")
HIDDEN = {
    "linear_drag": one("linear_drag", "rate", 0.003, 2.0, ("released", "pushed"), form="form"),
    "quadratic_drag": one("quadratic_drag", "drag_coefficient", 0.01, 1.2, ("both",), form="form"),
    "added_mass": one("added_mass", "coefficient", 0.01, SPHERES_MASS, ("both",)),
    "buoyancy": one("buoyancy", "fluid_density", WATER, WATER, ("heavy",)),
    "uniform_flow": plane("uniform_flow", ("velocity_x", "velocity_y"), 0.003, 1.0, ("released", "pushed")),
    "tilted_gravity": tilt("tilted_gravity", STYLES),
    "tilted_frame": tilt("tilted_frame", STYLES),
    "length_scale": one("length_scale", "factor", 5e-4, 0.06, ("released", "pushed"), null=1.0, sign=0),
    "time_scale": one("time_scale", "factor", 3e-4, 0.04, ("released", "pushed"), null=1.0, sign=0),
    "clock_offset": one("clock_offset", "offset", 3e-4, 0.15, ("released",), sign=0),
    "magnus": one("magnus", "coefficient", 0.01, 1.5, ("spinning",)),
    "spin_decay": one("spin_decay", "rate", 0.002, 2.5, ("spinning",), form="form"),
    "mass_offset": one("mass_offset", "relative", 1e-3, 0.045, ("released", "pushed"), sign=0),
    "size_error": one("size_error", "relative", 5e-4, 0.018, ("released", "pushed"), sign=0),
}
OUTSIDE = {
    "camera_shake": camera_shake(STYLES),
    "camera_drift": camera_drift(STYLES),
    "gust": gust(STYLES),
    "growing_lift": growing_lift(("pushed",)),
    "magnet": magnet(("released", "pushed"), (0.1, 0.0, -0.5), 0.6, low=0.005),
    "swirl": swirl(("released", "pushed")),
}
DEGENERATE = (
    ("tilted_frame", "both"),
    ("tilted_gravity", "both"),
    ("tilted_frame", "heavy"),
    ("tilted_gravity", "released"),
    ("tilted_frame", "pushed"),
)
NESTED = (("quadratic_drag", "both"),)
JOINT = (
    ("quadratic_drag", "clock_offset", "released"),
    ("linear_drag", "mass_offset", "released"),
    ("linear_drag", "length_scale", "pushed"),
    ("size_error", "time_scale", "released"),
)
DOUBLES = (
    ("linear_drag", "uniform_flow", "pushed"),
    ("quadratic_drag", "tilted_gravity", "both"),
    ("added_mass", "tilted_frame", "both"),
    ("magnus", "spin_decay", "spinning"),
    ("clock_offset", "tilted_gravity", "released"),
    ("uniform_flow", "length_scale", "released"),
)


def setup(rng, stamps, style, hidden=()):
    """A sinking experiment: released, pushed, or both in turn; `heavy`: of steel. What is hidden is not in the model."""
    radius = float(rng.choice([0.006, 0.01, 0.0125, 0.02]))
    density = 7800.0 if style == "heavy" else float(rng.choice([1180.0, 1400.0, 2500.0]))
    mass = float(f"{density * 4 / 3 * np.pi * radius**3:.4g}")
    parts = {
        "buoyancy": {"fluid_density": WATER},
        "added_mass": {"coefficient": 0.5},
        "quadratic_drag": {"drag_coefficient": 0.45},
    }
    model = tuple({"name": name, **law} for name, law in parts.items() if name not in hidden)
    count = int(rng.integers(6, 11))
    trials = []
    for i, group in enumerate(groups(rng, count)):
        heading = np.pi / 2 * (i % 4) + rng.uniform(-0.3, 0.3)
        start = {
            "position": np.array([rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05), -0.05]),
            "angular_velocity": np.zeros(3),
        }
        known = ()
        if style in ("released", "heavy", "both"):
            start["velocity"], known = np.zeros(3), ("velocity",)
            if style == "both" and i % 2:  # pushed downwards or sideways: drag and added mass part
                start["velocity"], known = 0.8 * np.array([np.cos(heading), np.sin(heading), -0.5]), ()
        else:
            speed = float(np.linspace(0.3, 1.6, count)[(i * 3) % count])
            start["velocity"] = speed * np.array([np.cos(heading), np.sin(heading), 0.4 - 0.4 * (i % 3)])
        duration = float(rng.uniform(0.7, 1.4)) * (0.5 if style == "heavy" else 1.0)
        if style == "spinning":
            axis = np.array([rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), 1.0 if i % 2 else -1.0])
            start.update(
                orientation=np.array([1.0, 0.0, 0.0, 0.0]), angular_velocity=axis / np.linalg.norm(axis) * rng.uniform(8, 20)
            )
        own = {key: value for name in hidden for key, value in own_moments(rng, name, duration).items()}
        trials.append(Trial(group, start, known, stamps(duration), own=own))
    rivals = ["linear_drag", "tilted_gravity", "tilted_frame", "length_scale", "time_scale", "mass_offset", "size_error"]
    rivals += [name for name in parts if name not in {entry["name"] for entry in model}]
    rivals += ["uniform_flow"] if "quadratic_drag" not in hidden else []
    rivals += ["clock_offset"] if trials[0].known else []
    rivals += ["magnus", "spin_decay"] if style == "spinning" else []
    columns = ("x_m", "y_m", "z_m", "q") if style == "spinning" else ("x_m", "y_m", "z_m")
    return Setup(
        "sinking",
        "sphere sinking in a water tank",
        {"shape": "sphere", "radius": radius},
        {"mass": mass, "radius": radius, "gravity": 9.81, "fluid_density": WATER, "viscosity": 1.0e-3, "v_ref": 0.7},
        {"gravity": 9.81, "fluid_density": WATER, "fluid_viscosity": 1.0e-3},
        model,
        tuple(trials),
        columns,
        motion.simulate,
        tuple(rivals),
    )
