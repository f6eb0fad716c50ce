"""Is it the noise that was stated too small, and not the model that lacks something?

A model that leaves more than the stated noise may lack an effect, or the noise may be larger than stated. Data tell the two apart
where they show a noise of their own, of which no model knows: what smooth curves leave, or rows that repeat each other. The model
is then judged once more with that noise. Nothing but the words of a report depends on it.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hlcs.data.quantities import CHANNELS
from hlcs.estimation.noise_model import Noise
from hlcs.report.leftover import spectra


class Shown(NamedTuple):
    """A noise that data show, larger than what was taken for it."""

    key: str  # of measurement.noise
    sigma: float  # of one reading [unit]
    unit: str
    seen: str  # how it shows, in words that end before its size
    noise: Noise
    next: str  # what to do, where a noise was stated, that tells it without any model


def noise_shown(problem, fit, shown, judge, file):
    """What a report says of a Shown noise where the model of a fit is adequate with it, a dictionary; else None.

    judge: (problem, fit) -> (Adequacy, table of observations). A swing is no noise, though no slow curve follows it and its
    blocks sum to nothing.
    """
    again = problem.with_noise(shown.noise)
    rewhitened = replace(fit, linearization=again.linearise(fit.model, fit.initial_states))
    adequacy, table = judge(again, rewhitened)
    if not adequacy.adequate or any(each.hides_a_period for each in spectra(table)):
        return None
    along = shown.noise.by_axis if shown.key == "position" else None
    value = f"{shown.sigma:.2g}" if along is None else f"[{', '.join(f'{size:.2g}' for size in along)}]"
    stated, remedy = shown.key in file.noise, f"{file.place('measurement.noise')}, {shown.key} = {value}"
    seen = sorted({int(channel) for recording in problem.recordings for channel in np.unique(recording.channel) if channel < 3})
    same = along is not None and shown.noise.along == problem.noise.along  # as unlike as was known: it is only too small
    of_axes = {"along": along, "known_along": problem.noise.by_axis if same else None}
    more = {
        name: {CHANNELS[axis]: float(sigmas[axis]) for axis in seen} for name, sigmas in of_axes.items() if sigmas is not None
    }
    return more | {
        "sigma": shown.sigma,
        "known": problem.noise.of_unit(shown.unit),
        "unit": shown.unit,
        "source": "stated" if stated else problem.noise.source,
        "seen": shown.seen,
        "remedy": remedy,
        "next": shown.next if stated else f"state it: {remedy}",
    }
