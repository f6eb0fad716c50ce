"""The film of a motion: clock, camera and shaking support act on the true motion; a trial becomes rows of numbers."""

import numpy as np

from .noise import gone_round, product, small_turn, turn_between

FINE, COARSE = 1e-4, 2e-3  # steps [s]: of what is recorded, and of the sensitivities that set coefficients


# power of the size that an input goes with
LENGTHS = {"radius": 1, "width": 1, "block_height": 1, "clearance": 1, "nominal_diameter": 1, "area": 2, "volume": 3}


def with_errors(inputs, overrides, errors, effects):
    """Inputs of one trial: nominal ones, the trial's own, and the true deviations {mass, size: relative, tilt_x, tilt_y: rad}.

    A body that is larger than its file says (`size_error`, or by a little) displaces more fluid and meets more of it.
    """
    true = {**inputs, **{key: value for key, value in overrides.items() if key in ("mass", "radius", "friction", "restitution")}}
    if "floor" in overrides:
        true["floor_height"], true["floor_normal"] = overrides["floor"]["height"], overrides["floor"]["normal"]
    if "radius" in overrides and "clearance" in true:
        true["clearance"] = overrides["radius"]
        true["volume"] = 4 / 3 * np.pi * overrides["radius"] ** 3
        true["nominal_diameter"] = true["volume"] ** (1 / 3)
    true["mass"] = true["mass"] * (1 + errors.get("mass", 0.0))
    size = (1 + errors.get("size", 0.0)) * (1 + effects.get("size_error", {}).get("relative", 0.0))
    for key, power in LENGTHS.items():
        if key in true:
            true[key] = true[key] * size**power
    true["tilt_x"], true["tilt_y"] = errors.get("tilt_x", 0.0), errors.get("tilt_y", 0.0)
    return true


def truth(setup, trial, effects, errors=None):
    """(Inputs, effects, times) of one trial as they are. True time = factor * stamp - offset (`time_scale`, `clock_offset`: late
    release)."""
    own = {name: {**law, **trial.own.get(name, {})} for name, law in effects.items()}
    inputs = with_errors(setup.inputs, trial.overrides, errors or {}, own)
    times = trial.times * own.get("time_scale", {}).get("factor", 1.0) - own.get("clock_offset", {}).get("offset", 0.0)
    return inputs, own, times


def holds(setup, trial, effects, errors=None):
    """Is the film of a trial one of a motion as the file has it?"""
    return setup.holds is None or setup.holds(trial, *truth(setup, trial, effects, errors))


def film(setup, trial, effects, errors=None, start=None, step=COARSE):
    """Positions (n, 3) and orientations (n, 4) or None that a perfect tracker would report for one trial.

    Reported = factor * R(tilt) position (`length_scale`, `tilted_frame`); `camera_shake` and `camera_drift`
    add a motion of the support of the camera.
    """
    inputs, own, times = truth(setup, trial, effects, errors)
    position, orientation = setup.simulate(trial, inputs, own, start or trial.start, times, step)
    tilt = own.get("tilted_frame", {})
    if tilt:
        about_x, about_y = np.array([tilt["angle_x"], 0.0, 0.0]), np.array([0.0, tilt["angle_y"], 0.0])
        lean = product(small_turn(about_y), small_turn(about_x))
        position = turned(lean, position)
        orientation = None if orientation is None else product(lean, orientation)
    position = position * own.get("length_scale", {}).get("factor", 1.0)
    if "camera_shake" in own:
        law = own["camera_shake"]
        swing = law["amplitude"] * np.sin(2 * np.pi * law["frequency"] * trial.times + law.get("phase", 0.0))
        position = position + swing[:, None] * np.asarray(law["direction"])
    if "camera_drift" in own:
        law = own["camera_drift"]
        position = position + (law.get("side", 1.0) * law["amplitude"] * trial.times**3)[:, None] * np.asarray(law["direction"])
    return position, orientation


def turned(quaternion, vectors):
    """Vectors (n, 3) turned by one quaternion."""
    pure = np.concatenate([np.zeros((len(vectors), 1)), vectors], axis=1)
    return product(product(quaternion, pure), quaternion * [1, -1, -1, -1])[:, 1:]


def axes_seen(setup):
    """Indices of the position columns that are recorded."""
    return [i for i, name in enumerate(("x_m", "y_m", "z_m")) if name in setup.columns]


def difference(setup, new, old, sigma_position, sigma_orientation):
    """What separates two films of a trial, in sigmas: (n, c) with the recorded position columns, then three of rotation if
    recorded."""
    parts = [(new[0] - old[0])[:, axes_seen(setup)] / sigma_position]
    if "q" in setup.columns:
        parts.append(gone_round(turn_between(old[1], new[1])) / sigma_orientation)
    return np.concatenate(parts, axis=1)


def shifted(start, key, direction, amount):
    """A start with one unknown moved: position, velocity and angular_velocity add, orientation turns."""
    moved = dict(start)
    if key == "orientation":
        moved[key] = product(small_turn(amount * np.asarray(direction)), start[key])
    else:
        moved[key] = np.asarray(start[key], float) + amount * np.asarray(direction)
    return moved


def unknowns(setup, trial):
    """(key, direction, step) of everything of the start that has to be fitted."""
    full = np.eye(3)
    within = np.array(trial.tangents) if len(trial.tangents) else full
    found = []
    if "position" not in trial.known:
        found += [("position", d, 1e-4) for d in within]
    if "velocity" not in trial.known:
        found += [("velocity", d, 1e-4) for d in within]
    if "q" in setup.columns and "orientation" not in trial.known:
        found += [("orientation", d, 1e-4) for d in full]
    if "q" in setup.columns and "angular_velocity" not in trial.known:
        found += [("angular_velocity", d, 1e-3) for d in (np.eye(3)[2:] if len(trial.tangents) else full)]
    return found
