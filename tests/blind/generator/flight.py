"""Flight in air: balls thrown in four headings, dropped from heights, thrown with spin, and thrown in a narrow range of
speeds."""

import numpy as np

from . import motion
from .case import Setup, Trial
from .dials import camera_drift, camera_shake, crisis, groups, growing_lift, gust, magnet, one, own_moments, plane, swirl, tilt
from .fluid import AIR, AIR_VISCOSITY, SPHERES_MASS, around
from .fluid import rivals as missing

STYLES = ("throws", "drops", "spinning")
HIDDEN = {
    "linear_drag": one("linear_drag", "rate", 0.003, 1.5, ("throws", "drops"), form="form"),
    "quadratic_drag": one("quadratic_drag", "drag_coefficient", 0.02, 1.4, ("throws", "drops"), form="form"),
    "buoyancy": one("buoyancy", "fluid_density", AIR, AIR, STYLES),
    "added_mass": one("added_mass", "coefficient", 0.05, SPHERES_MASS, STYLES),
    "length_scale": one("length_scale", "factor", 5e-4, 0.04, STYLES, null=1.0, sign=0),
    "time_scale": one("time_scale", "factor", 3e-4, 0.03, STYLES, null=1.0, sign=0),
    "tilted_gravity": tilt("tilted_gravity", STYLES),
    "tilted_frame": tilt("tilted_frame", STYLES),
    "clock_offset": one("clock_offset", "offset", 2e-4, 0.1, ("drops",), sign=0),
    "magnus": one("magnus", "coefficient", 0.02, 1.5, ("spinning",)),
    "spin_decay": one("spin_decay", "rate", 0.002, 2.0, ("spinning",), form="form"),
    "uniform_flow": plane("uniform_flow", ("velocity_x", "velocity_y"), 0.02, 2.5, ("throws", "drops")),
    "mass_offset": one("mass_offset", "relative", 0.003, 0.045, ("throws",), sign=0),
}
EXTRA = {"drag_crisis": crisis(("throws",))}  # hidden where it is asked for
OUTSIDE = {
    "camera_shake": camera_shake(STYLES),
    "camera_drift": camera_drift(("throws", "spinning")),
    "gust": gust(STYLES),
    "growing_lift": growing_lift(("throws", "spinning")),
    "magnet": magnet(("throws",), (1.5, 0.0, 1.0), 3.0),
    "swirl": swirl(("throws",)),
}
DEGENERATE = (
    ("length_scale", "throws"),
    ("time_scale", "drops"),
    ("tilted_gravity", "throws"),
    ("tilted_frame", "spinning"),
    ("added_mass", "drops"),
    ("linear_drag", "narrow"),
    ("quadratic_drag", "narrow"),
)
NESTED = (("quadratic_drag", "throws"), ("quadratic_drag", "drops"), ("drag_crisis", "throws"))  # one law contains the other
JOINT = (
    ("quadratic_drag", "clock_offset", "drops"),
    ("quadratic_drag", "length_scale", "throws"),
    ("linear_drag", "clock_offset", "drops"),
    ("quadratic_drag", "time_scale", "throws"),
    ("linear_drag", "length_scale", "drops"),
    ("clock_offset", "time_scale", "drops"),
)  # each takes back what the other does, so neither alone announces itself
DOUBLES = (
    ("quadratic_drag", "tilted_gravity", "throws"),
    ("linear_drag", "tilted_frame", "drops"),
    ("quadratic_drag", "length_scale", "throws"),
    ("magnus", "spin_decay", "spinning"),
    ("magnus", "tilted_gravity", "spinning"),
    ("quadratic_drag", "clock_offset", "drops"),
    ("uniform_flow", "time_scale", "throws"),
)
BALLS = (
    (0.0335, 0.0577),
    (0.0213, 0.0459),
    (0.11, 0.43),
    (0.04, 0.011),
    (0.105, 0.06),
    (0.15, 0.11),
    (0.05, 4.08),
)  # radius [m], mass [kg]
BIG = ((0.11, 0.43), (0.105, 0.27), (0.15, 0.9))  # fast enough here for the drag crisis


def setup(rng, stamps, style, hidden=()):
    """A flight experiment; stamps(duration) gives the recorder's times, `hidden` names what is not in the model."""
    radius, mass = BIG[rng.integers(len(BIG))] if "drag_crisis" in hidden else BALLS[rng.integers(len(BALLS))]
    spin = style == "spinning"
    air = around(rng, hidden)
    count = int(rng.integers(6, 11))
    trials = []
    for i, group in enumerate(groups(rng, count)):
        heading = np.pi / 2 * (i % 4) + rng.uniform(-0.3, 0.3)
        start = {"angular_velocity": np.zeros(3)}
        if style == "drops":
            height = float(np.linspace(1.5, 9.0, count)[(i * 3) % count] + rng.uniform(0, 0.4))
            start.update(position=np.array([rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), height]), velocity=np.zeros(3))
            duration, known = np.sqrt(2 * (height - 0.3) / 9.81), ("velocity",)
        else:
            speed = 6.0 + rng.uniform(-0.2, 0.2) if style == "narrow" else float(np.linspace(3, 13, count)[(i * 3) % count])
            rise = rng.uniform(0.0, 0.15) if style == "narrow" else rng.uniform(0.3, 1.1)
            velocity = speed * np.array([np.cos(rise) * np.cos(heading), np.cos(rise) * np.sin(heading), np.sin(rise)])
            start.update(position=np.array([rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), 1.6]), velocity=velocity)
            duration = 0.35 if style == "narrow" else (velocity[2] + np.sqrt(velocity[2] ** 2 + 2 * 9.81 * 1.4)) / 9.81
            known = ()
        if spin:
            axis = np.array([rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), 1.0 if i % 2 else -1.0])
            start.update(
                orientation=np.array([1.0, 0.0, 0.0, 0.0]), angular_velocity=axis / np.linalg.norm(axis) * rng.uniform(10, 30)
            )
        own = {key: value for name in hidden for key, value in own_moments(rng, name, duration).items()}
        trials.append(Trial(group, start, known, stamps(min(duration, 1.6)), own=own))
    rivals = [
        "linear_drag",
        "quadratic_drag",
        "buoyancy",
        "added_mass",
        "tilted_gravity",
        "tilted_frame",
        "length_scale",
        "time_scale",
    ]
    rivals += ["clock_offset"] if style == "drops" else []
    rivals += ["magnus", "spin_decay"] if spin else []
    rivals += ["uniform_flow", "mass_offset", "size_error"] if "quadratic_drag" in {one["name"] for one in air.model} else []
    columns = ("x_m", "y_m", "z_m", "q") if spin else ("x_m", "y_m", "z_m")
    title = {"drops": "ball dropped from several heights"}.get(style, "ball thrown across a hall")
    return Setup(
        "flight",
        title,
        {"shape": "sphere", "radius": radius},
        {"mass": mass, "radius": radius, "gravity": 9.81, "fluid_density": air.density, "viscosity": AIR_VISCOSITY, "v_ref": 6.0},
        {"gravity": 9.81, **air.stated},
        air.model,
        tuple(trials),
        columns,
        motion.simulate,
        missing(rivals, air),
    )
