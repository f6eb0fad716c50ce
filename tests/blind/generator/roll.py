"""Roll and spin: balls let go on gently inclined boards in four headings, and balls spun on the spot."""

from functools import partial

import numpy as np

from . import plane
from .case import Setup, Trial
from .dials import Dial, camera_drift, camera_shake, groups, one, own_moments, tilt
from .fluid import around
from .fluid import rivals as missing
from .slide import _patch, _shaken, _slope, _wave, floor_of

STYLES = ("boards", "spins")
HIDDEN = {
    "rolling_friction": one("rolling_friction", "arm", 1e-6, 0.0018, ("boards",), form="form"),
    "spinning_friction": one("spinning_friction", "arm", 1e-6, 0.008, ("spins",)),
    "spin_decay": one("spin_decay", "rate", 0.001, 2.0, ("spins",)),
    "linear_drag": one("linear_drag", "rate", 0.002, 1.0, ("boards",)),
    "quadratic_drag": one("quadratic_drag", "drag_coefficient", 0.01, 2.0, ("boards",)),
    "tilted_gravity": tilt("tilted_gravity", STYLES),
    "tilted_frame": tilt("tilted_frame", STYLES),
    "bottom_slope": Dial(_slope, 1e-4, 0.06, STYLES),
    "length_scale": one("length_scale", "factor", 5e-4, 0.06, ("boards",), null=1.0, sign=0),
    "time_scale": one("time_scale", "factor", 3e-4, 0.04, ("boards",), null=1.0, sign=0),
    "clock_offset": one("clock_offset", "offset", 5e-4, 0.15, ("boards",), sign=0),
    "size_error": one("size_error", "relative", 1e-3, 0.018, ("boards",), sign=0),
    "margin_offset": one("margin_offset", "offset", 1e-3, 0.0105, ("boards",)),
}
OUTSIDE = {
    "camera_shake": camera_shake(STYLES, low=1e-4),
    "camera_drift": camera_drift(STYLES),
    "sticky_patch": Dial(_patch, 2e-4, 0.05, ("boards",)),
    "wavy_floor": Dial(_wave, 2e-4, 0.05, ("boards",)),
    "shaken_board": Dial(_shaken, 0.005, 3.0, ("boards",)),
}
DEGENERATE = (("size_error", "boards"), ("margin_offset", "boards"), ("bottom_slope", "spins"), ("tilted_gravity", "spins"))
JOINT = (
    ("rolling_friction", "length_scale", "boards"),
    ("rolling_friction", "clock_offset", "boards"),
    ("rolling_friction", "time_scale", "boards"),
    ("clock_offset", "time_scale", "boards"),
)
DOUBLES = (
    ("rolling_friction", "tilted_gravity", "boards"),
    ("rolling_friction", "linear_drag", "boards"),
    ("spinning_friction", "tilted_gravity", "spins"),
    ("rolling_friction", "time_scale", "boards"),
    ("clock_offset", "bottom_slope", "boards"),
)
BALLS = ((0.02, 0.26), (0.03, 0.12), (0.05, 0.09), (0.06, 0.35))  # radius [m], mass [kg]


def setup(rng, stamps, style, hidden=()):
    """A rolling or spinning experiment; friction 0.6 is never used up, so the ball rolls without slipping."""
    radius, mass = BALLS[rng.integers(len(BALLS))]
    air = around(rng, hidden)
    count = int(rng.integers(6, 11))
    trials = []
    for i, group in enumerate(groups(rng, count)):
        heading = np.pi / 2 * (i % 4) + rng.uniform(-0.2, 0.2)
        slope = np.deg2rad(float(np.linspace(1.0, 6.0, count)[(i * 3) % count])) if style == "boards" else 0.0
        normal, tangents, turn = floor_of(slope, heading)
        start = {
            "position": np.round(radius * normal, 6),
            "orientation": np.array([1.0, 0.0, 0.0, 0.0]),
            "velocity": np.zeros(3),
            "angular_velocity": np.zeros(3),
        }
        known, overrides = ("position", "orientation", "velocity", "angular_velocity"), {}
        if style == "boards":
            duration = min(np.sqrt(2 * rng.uniform(0.4, 0.9) / (5 / 7 * 9.81 * np.sin(slope))), 2.0)
            overrides = {"floor": {"height": 0.0, "normal": [float(x) for x in normal]}}
        else:
            spin = float(np.linspace(4.0, 22.0, count)[(i * 3) % count]) * (1 if i % 2 else -1)
            start["angular_velocity"], known = np.array([0.0, 0.0, spin]), ("position", "velocity")
            duration = float(rng.uniform(0.9, 1.6))
        own = {key: value for name in hidden for key, value in own_moments(rng, name, duration).items()}
        trials.append(Trial(group, start, known, stamps(duration), overrides, own, tangents))
    rivals = ["bottom_slope", "tilted_gravity", "tilted_frame", "length_scale", "time_scale", "size_error", "margin_offset"]
    rivals += (
        ["rolling_friction", "linear_drag", "quadratic_drag", "clock_offset", "inertia_error"]
        if style == "boards"
        else ["spinning_friction", "spin_decay"]
    )
    inputs = {
        "mass": mass,
        "radius": radius,
        "gravity": 9.81,
        "fluid_density": air.density,
        "volume": 4 / 3 * np.pi * radius**3,
        "clearance": radius,
        "floor_height": 0.0,
        "floor_normal": (0.0, 0.0, 1.0),
        "nominal_diameter": radius * (4 * np.pi / 3) ** (1 / 3),
    }
    surroundings = {
        "gravity": 9.81,
        **air.stated,
        "floor": {"height": 0.0, "normal": [0.0, 0.0, 1.0]},
        "friction": 0.6,
        "restitution": 0.0,
    }
    title = "ball let go on gently inclined boards" if style == "boards" else "ball spun on the spot"
    columns = ("x_m", "y_m", "z_m") if style == "boards" else ("x_m", "y_m", "z_m", "q")
    return Setup(
        "roll",
        title,
        {"shape": "sphere", "radius": radius},
        inputs,
        surroundings,
        air.model,
        tuple(trials),
        columns,
        partial(plane.simulate, rolling=True),
        missing(rivals, air),
    )
