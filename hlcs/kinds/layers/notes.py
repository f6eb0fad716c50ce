"""What a report on layers says beside its tables: the paper's errors and their floor, campaigns, scatter, resolution."""

import numpy as np

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.search import SCREEN
from hlcs.placement import statistics
from hlcs.placement.comparison import repeated
from hlcs.placement.statistics import Sample


def samples(search, fit, index):
    """(measured, model) Samples of one set; the measured scatter is at least what rounding to three decimals hides."""
    runs, (mean, cv, tests) = fit.runs[index], search.sets[index].sample
    measured = Sample(mean, np.hypot(cv, least_squares.ROUNDING * np.sqrt(tests) / mean), tests)
    return measured, repeated(runs[np.isfinite(runs).all(axis=1)])


def perfect_models(search, fit):
    """The error that a perfect model would show on each set."""
    return [statistics.perfect_model_error(*samples(search, fit, index), draws=20_000) for index in range(len(search.sets))]


def noise_floor(search, fit):
    """Mean relative error that a perfect model would show on these data [-]."""
    layers = [measured_set.layers for measured_set in search.sets]
    return float(np.average([perfect.mean for perfect in perfect_models(search, fit)], weights=layers))


def left_out(measurement, sets):
    return [
        f"{measured_set.name}: not judged, its number of tests or its scatter is not stated, or zero in every layer"
        for measured_set in measurement.sets
        if sets and measured_set not in sets
    ]


def set_notes(search, fit):
    """One line a set: the paper's error, its sign, the height, and what a perfect model would show; then the scatter."""
    notes = []
    for index, (measured_set, perfect) in enumerate(zip(search.sets, perfect_models(search, fit), strict=True)):
        measured, model = samples(search, fit, index)
        ratio = ""
        if measured_set.layers > 1 and np.any(measured.cv[1:] > 0) and np.any(model.cv[1:] > 0):
            upper = (Sample(*(part[1:] for part in sample)) for sample in (measured, model))
            ratio = "; scatter between tests {:.1f} times the model's (p = {:.2g})".format(*statistics.scatter_ratio(*upper))
        notes.append(
            f"{measured_set.name}: eps_R {100 * statistics.mean_relative_error(measured.mean, model.mean):.2f} % (a perfect "
            f"model {100 * perfect.mean:.2f} %, below {100 * perfect.quantile:.2f} % in 95 of 100), bias "
            f"{100 * statistics.signed_bias(measured.mean, model.mean):+.2f} %, height "
            f"{100 * statistics.height_error(measured.mean, model.mean):+.2f} %{ratio}"
        )
    return notes


def campaign_notes(sets):
    """First layers of several sets, which measure the same thing: a unit on a bottom."""
    notes = []
    if len(sets) > 1:
        first = [(measured_set.sample.mean[0], measured_set.name) for measured_set in sets]
        (low, low_name), (high, high_name) = min(first), max(first)
        extremes = [measured_set.sample for measured_set in sets if measured_set.name in (low_name, high_name)]
        error = np.hypot(*(sample.mean[0] * sample.cv[0] / np.sqrt(sample.tests[0]) for sample in extremes))
        sigmas = f", {(high - low) / error:.1f} sigma" if error > 0 else ""
        notes.append(
            f"first layers, which measure one thing (a unit on the bottom): {high:.3f} ({high_name}) against {low:.3f} "
            f"({low_name}), {100 * (high / low - 1.0):.1f} % apart{sigmas}: what another campaign alone may change"
        )
    notes.append(
        f"campaign term {100 * least_squares.CAMPAIGN:g} %, common to all layers or individual to each: what is accepted "
        "survives both; sigma under 'where' includes it, z does not"
    )
    return notes


def search_notes(search, fit, rounds):
    """What the data could show, what the numerics change, and how many tests were simulated."""
    shifts = []
    for index, measured_set in enumerate(search.sets):
        error = np.sqrt((search.data.variance + fit.simulated.variance)[(search.data.set == index) & search.layers])
        parts = statistics.detectable_shift(error, measured_set.layers) / measured_set.sample.mean
        shifts.append(f"{measured_set.name} " + ", ".join(f"{100 * part:.1f}" for part in parts))
    numerics = {trial.name: trial for trial in (rounds[0] if rounds else ()) if trial.name in ("time_step", "iterations")}
    return [
        f"smallest shift of a layer that single sets show (80 % power) [%]: {'; '.join(shifts)}; "
        "an effect must move one by what all sets show together, differences between campaigns included",
        *(
            f"numerics first: {name} x {trial.candidate.number.start:g} moves the layers by {trial.relative_shift:.1f} times "
            "what these data can show"
            for name, trial in sorted(numerics.items())
        ),
        f"{len(search.seeds)} simulated tests a set, {SCREEN} pairs a candidate, {search.pairs} for the most promising, "
        f"step {search.measurement.test.time_step:.4g} s; "
        f"{search.simulator.ran} simulated now, the others read from the store",
    ]
