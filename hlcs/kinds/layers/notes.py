"""What a report on layers says beside its tables: the paper's errors and their floor, campaigns, scatter, resolution."""

import numpy as np

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.search import SCREEN
from hlcs.placement import statistics
from hlcs.placement.comparison import repeated
from hlcs.placement.statistics import Sample


def samples(search, stage, index):
    """(measured, model) Samples of one set; the measured scatter is at least what rounding to three decimals hides."""
    runs, (mean, cv, tests) = stage.rows[index], search.sets[index].sample
    measured = Sample(mean, np.hypot(cv, least_squares.ROUNDING * np.sqrt(tests) / mean), tests)
    return measured, repeated(runs[np.isfinite(runs).all(axis=1)])


def perfect_models(search, stage):
    return [statistics.perfect_model_error(*samples(search, stage, index), draws=20_000) for index in range(len(search.sets))]


def floor_of(search, stage):
    """Mean relative error that a perfect model would show on these data [-]."""
    return float(np.average([one.mean for one in perfect_models(search, stage)], weights=[one.layers for one in search.sets]))


def left_out(measurement, sets):
    return [
        f"{one.name}: not judged, its number of tests or its scatter is not stated, or zero in every layer"
        for one in measurement.sets
        if sets and one not in sets
    ]


def set_notes(search, stage):
    """One line a set: the paper's error, its sign, the height, and what a perfect model would show; then the scatter."""
    notes = []
    for index, (one, perfect) in enumerate(zip(search.sets, perfect_models(search, stage), strict=True)):
        measured, model = samples(search, stage, index)
        ratio = ""
        if one.layers > 1 and np.any(measured.cv[1:] > 0) and np.any(model.cv[1:] > 0):
            upper = (Sample(*(part[1:] for part in sample)) for sample in (measured, model))
            value, p = statistics.scatter_ratio(*upper)
            ratio = f"; scatter between tests {value:.1f} times the model's (p = {p:.2g})"
        notes.append(
            f"{one.name}: eps_R {100 * statistics.mean_relative_error(measured.mean, model.mean):.2f} % (a perfect model "
            f"{100 * perfect.mean:.2f} %, below {100 * perfect.quantile:.2f} % in 95 of 100), bias "
            f"{100 * statistics.signed_bias(measured.mean, model.mean):+.2f} %, height "
            f"{100 * statistics.height_error(measured.mean, model.mean):+.2f} %{ratio}"
        )
    return notes


def campaign_notes(sets):
    """First layers of several sets, which measure the same thing: a unit on a bottom."""
    notes = []
    if len(sets) > 1:
        first = [(one.sample.mean[0], one.name) for one in sets]
        low, high = min(first), max(first)
        error = np.hypot(
            *(
                one.sample.mean[0] * one.sample.cv[0] / np.sqrt(one.sample.tests[0])
                for one in sets
                if one.name in (low[1], high[1])
            )
        )
        gap = high[0] / low[0] - 1.0
        sigmas = f", {(high[0] - low[0]) / error:.1f} sigma" if error > 0 else ""
        notes.append(
            f"first layers, which measure one thing (a unit on the bottom): {high[0]:.3f} ({high[1]}) against {low[0]:.3f} "
            f"({low[1]}), {100 * gap:.1f} % apart{sigmas}: what another campaign alone may change"
        )
    notes.append(
        f"campaign term {100 * least_squares.CAMPAIGN:g} %, common to all layers or individual to each: what is accepted "
        "survives both; sigma under 'where' includes it, z does not"
    )
    return notes


def search_notes(search, final, rounds):
    shown = [
        statistics.detectable_shift(
            np.sqrt((search.data.variance + final.numbers.variance)[(search.data.set == index) & (search.data.layer > 0)]),
            one.layers,
        )
        / one.sample.mean
        for index, one in enumerate(search.sets)
    ]
    text = "; ".join(
        f"{one.name} " + ", ".join(f"{100 * part:.1f}" for part in row) for one, row in zip(search.sets, shown, strict=True)
    )
    notes = [
        f"smallest shift of a layer that single sets show (80 % power) [%]: {text}; "
        "an effect must move one by what all sets show together, differences between campaigns included"
    ]
    if rounds:
        moved = {one.name: one for one in rounds[0] if one.name in ("time_step", "iterations")}
        notes += [
            f"numerics first: {name} x {one.candidate.trial:g} moves the layers by {one.size:.1f} times what these data can show"
            for name, one in sorted(moved.items())
        ]
    notes.append(
        f"{len(search.seeds)} simulated tests a set, {SCREEN} pairs a candidate, {search.pairs} for the most promising, "
        f"step {search.measurement.test.time_step:.4g} s; "
        f"{getattr(search.simulator, 'ran', 0)} simulated now, the others read from the store"
    )
    return notes
