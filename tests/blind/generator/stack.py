"""Small stack: the top unit is set down from a few centimetres on a stack of known height and comes to rest; closed forms."""

import numpy as np

from .case import Setup, Trial
from .dials import Dial, camera_drift, camera_shake, groups, one, own_moments, tilt
from .fluid import around, displaced
from .fluid import rivals as missing
from .noise import lean

STYLES = ("set_down",)
HIDDEN = {
    "margin_offset": one("margin_offset", "offset", 5e-4, 0.0095, STYLES),
    "size_error": one("size_error", "relative", 5e-4, 0.018, STYLES, sign=0),
    "restitution": one("restitution", "coefficient", 5e-3, 0.5, STYLES),
    "tilted_gravity": tilt("tilted_gravity", STYLES),
    "tilted_frame": tilt("tilted_frame", STYLES),
    "length_scale": one("length_scale", "factor", 5e-4, 0.05, STYLES, null=1.0, sign=0),
    "time_scale": one("time_scale", "factor", 1e-3, 0.045, STYLES, null=1.0, sign=0),
    "clock_offset": one("clock_offset", "offset", 3e-4, 0.06, STYLES, sign=0),
}
OUTSIDE = {
    "camera_shake": camera_shake(STYLES, low=1e-4),
    "camera_drift": camera_drift(STYLES),
    "wobble": Dial(lambda rng: _wobble(rng), 1e-4, 0.05, STYLES),
}
DEGENERATE = (("margin_offset", "set_down"), ("size_error", "set_down"))
JOINT = (("clock_offset", "time_scale", "set_down"), ("clock_offset", "length_scale", "set_down"))
DOUBLES = (
    ("margin_offset", "tilted_frame", "set_down"),
    ("clock_offset", "tilted_frame", "set_down"),
    ("restitution", "margin_offset", "set_down"),
)


def _wobble(rng):
    heading, frequency = rng.uniform(0, 2 * np.pi), rng.uniform(3, 7)
    return lambda a: {"wobble": {"amplitude": a, "frequency": frequency, "direction": (np.cos(heading), np.sin(heading), 0.0)}}


def drop(height, speed_x, speed_y, g, restitution, times, drag=0.0):
    """Rise above the rest height and sideways way (n, 3) of a flat body let go at `height`: (g_x, g_y, g_z) constant,
    restitution e, drag k [1/m] of the fall (the low rebounds feel none).

    Closed form, impact by impact; the sideways motion is stopped by friction at the first impact.
    """
    out = np.empty((len(times), 3))
    landing = np.sqrt(-g[2] * (1 - np.exp(-2 * drag * height)) / drag) if drag else np.sqrt(2 * height * -g[2])
    fall = np.sqrt(2 * height / -g[2])
    if drag:  # h = ln cosh(sqrt(k g) t) / k, and arrives slower than it would without air
        fall = np.arccosh(np.exp(drag * height)) / np.sqrt(-g[2] * drag)
    for k, t in enumerate(np.maximum(times, 0.0)):
        side = min(t, fall)
        out[k, :2] = speed_x * side + 0.5 * g[0] * side**2, speed_y * side + 0.5 * g[1] * side**2
        if t <= fall:
            out[k, 2] = height - (np.log(np.cosh(np.sqrt(-g[2] * drag) * t)) / drag if drag else -0.5 * g[2] * t**2)
            continue
        t, speed = t - fall, restitution * landing
        while speed > 1e-3 and t > 2 * speed / -g[2]:
            t, speed = t - 2 * speed / -g[2], restitution * speed
        out[k, 2] = max(speed * t + 0.5 * g[2] * t**2, 0.0) if speed > 1e-3 else 0.0
    return out


def simulate(trial, inputs, effects, start, times, step):
    """Positions (n, 3) [m] and the constant orientation (n, 4) of the unit."""
    ax, ay = lean(inputs, effects)
    g = inputs["gravity"] * np.array([np.sin(ax), np.sin(ay), -np.sqrt(1 - np.sin(ax) ** 2 - np.sin(ay) ** 2)])
    lifted, moved_along = displaced(inputs, effects, inputs["mass"])
    g *= (1 - lifted) / (1 + moved_along)
    coefficient = effects.get("quadratic_drag", {}).get("drag_coefficient", 0.0)
    drag = 0.5 * inputs["fluid_density"] * coefficient * inputs["area"] / (inputs["mass"] * (1 + moved_along))
    rest = (
        inputs["floor_height"]
        + inputs["clearance"]
        + effects.get("margin_offset", {}).get("offset", 0.0) * inputs["nominal_diameter"]
    )
    first = np.asarray(start["position"], float)
    way = drop(
        max(first[2] - rest, 1e-9),
        start["velocity"][0],
        start["velocity"][1],
        g,
        effects.get("restitution", {}).get("coefficient", 0.0),
        times,
        drag,
    )
    position = way + [first[0], first[1], rest]
    if "wobble" in effects:
        law = effects["wobble"]
        since = np.maximum(times - 0.1, 0.0)
        swing = law["amplitude"] * np.exp(-since / 0.35) * np.sin(2 * np.pi * law["frequency"] * since)
        position = position + swing[:, None] * np.array(law["direction"])
    return position, np.repeat(np.asarray(start["orientation"], float)[None], len(times), axis=0)


def setup(rng, stamps, style, hidden=()):
    """Units set down on stacks of one to four; velocity zero and upright pose stated."""
    side = float(rng.choice([0.06, 0.10, 0.25]))
    air = around(rng, hidden, "box")
    count = int(rng.integers(6, 11))
    trials = []
    for i, group in enumerate(groups(rng, count)):
        below = 1 + i % 4
        level = round(side * below, 6)
        lift = float(np.linspace(0.02, 0.12, count)[(i * 3) % count])
        start = {
            "position": np.array([*rng.uniform(-0.02, 0.02, 2), level + side / 2 + lift]),
            "orientation": np.array([1.0, 0.0, 0.0, 0.0]),
            "velocity": np.zeros(3),
            "angular_velocity": np.zeros(3),
        }
        overrides = {"floor": {"height": level, "normal": [0.0, 0.0, 1.0]}}
        own = {key: value for name in hidden for key, value in own_moments(rng, name, 0.5).items()}
        trials.append(
            Trial(
                group,
                start,
                ("orientation", "velocity", "angular_velocity"),
                stamps(float(rng.uniform(0.5, 0.8))),
                overrides,
                own,
            )
        )
    mass = float(f"{2300 * side**3:.4g}")
    inputs = {
        "mass": mass,
        "gravity": 9.81,
        "clearance": side / 2,
        "floor_height": 0.0,
        "floor_normal": (0.0, 0.0, 1.0),
        "nominal_diameter": side,
        "fluid_density": air.density,
        "volume": side**3,
        "area": 1.5 * side**2,
    }
    surroundings = {
        "gravity": 9.81,
        **air.stated,
        "floor": {"height": 0.0, "normal": [0.0, 0.0, 1.0]},
        "friction": 0.6,
        "restitution": 0.0,
    }
    return Setup(
        "stack",
        "top unit set down on a small stack",
        {"shape": "box", "size": [side] * 3},
        inputs,
        surroundings,
        air.model,
        tuple(trials),
        ("x_m", "y_m", "z_m", "q"),
        simulate,
        missing(HIDDEN, air),
    )
