"""The experiment that a verdict recommends, done on the same hidden motion: a recording already made is changed and made anew."""

from dataclasses import replace

import numpy as np

from .noise import product, small_turn
from .observe import turned

GROUP = "recommended"
UP = np.array([0.0, 0.0, 1.0])


def trials(setup, design, count, stamps):
    """`count` trials of the recommended design, from the longest recording; stamps(duration) gives the recorder's times.

    A list of values takes turns. Raises KeyError for a design that no trial of this laboratory can follow.
    """
    trial = max(setup.trials, key=lambda one: one.times[-1] - one.times[0])
    ((key, values),) = design.items()
    values = values if isinstance(values, list) else [values]
    return [_changed(setup, trial, key, values[k % len(values)], stamps) for k in range(count)]


def _changed(setup, trial, key, value, stamps):
    start, overrides, duration = dict(trial.start), dict(trial.overrides), float(trial.times[-1])
    if key == "speed_m_s":
        start["velocity"] = np.asarray(start["velocity"]) * value / np.linalg.norm(start["velocity"])
    elif key == "heading_deg":
        quarter = small_turn(np.deg2rad(value) * UP)
        start["velocity"] = turned(quarter, np.asarray(start["velocity"])[None])[0]
        if "angular_velocity" in start:
            start["angular_velocity"] = turned(quarter, np.asarray(start["angular_velocity"])[None])[0]
        if setup.family == "slide":  # its long side lies along the way
            start["orientation"] = product(quarter, start["orientation"])
    elif key == "raise_m":
        start["position"] = np.asarray(start["position"]) + value * UP
    elif key == "spin":
        start["angular_velocity"] = -np.asarray(start["angular_velocity"])
    elif key == "duration":
        duration *= 2
    elif key == "mass_kg":
        overrides["mass"] = value
    elif key != "repeat":
        raise KeyError(key)
    return replace(trial, group=GROUP, start=start, overrides=overrides, times=stamps(duration))
