"""The experiment that a verdict recommends, done on the same hidden motion: a recording already made is changed and made anew."""

from dataclasses import replace

import numpy as np

from .noise import product, small_turn
from .observe import turned

GROUP = "recommended"
UP = np.array([0.0, 0.0, 1.0])


def turns(design, count):
    """[{input: value}] of each of `count` tests of a design: a list of values takes turns."""
    return [
        {key: value[k % len(value)] if isinstance(value, list) else value for key, value in design.items()} for k in range(count)
    ]


def trials(setup, design, count, stamps):
    """`count` trials of the recommended design, from the recording that is named, else the longest; stamps(duration) gives the
    recorder's times. Raises KeyError for a design that no trial of this laboratory can follow.
    """
    longest = max(
        range(len(setup.trials)), key=lambda k: (np.ptp(setup.trials[k].times), k)
    )  # of equals the last, as the analyst
    named = {recording_name(k): k for k in range(len(setup.trials))}
    made = []
    for test in turns(design, count):
        ((key, value),) = test.items()
        made.append(_changed(setup, setup.trials[named[value] if key == "repeat" else longest], key, value, stamps))
    return made


def recording_name(index):
    """File of the recording with this index, from 0."""
    return f"recording_{index + 1:02d}.csv"


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
