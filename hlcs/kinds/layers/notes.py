"""What a report on layers says beside its tables: the paper's errors and their floor, campaigns, scatter, resolution."""

import numpy as np

from hlcs.kinds.layers import observations
from hlcs.placement import statistics
from hlcs.placement.comparison import repeated
from hlcs.placement.statistics import Sample


def samples(problem, model):
    """[(measured, simulated) Samples] of all sets; the measured scatter is at least what rounding to three decimals hides."""
    pairs = []
    for measured_set, runs in zip(problem.responses.sets, problem.responses.runs_of(model), strict=True):
        mean, cv, tests = measured_set.sample
        measured = Sample(mean, np.hypot(cv, observations.ROUNDING * np.sqrt(tests) / mean), tests)
        pairs.append((measured, repeated(runs[np.isfinite(runs).all(axis=1)])))
    return pairs


def perfect_models(problem, model):
    """The error that a perfect model would show on each set."""
    return [statistics.perfect_model_error(*pair, draws=20_000) for pair in samples(problem, model)]


def noise_floor(problem, model):
    """Mean relative error that a perfect model would show on these data [-]."""
    layers = [measured_set.layers for measured_set in problem.responses.sets]
    return float(np.average([perfect.mean for perfect in perfect_models(problem, model)], weights=layers))


def stated_notes(file, model):
    """Sentences on numbers of [model] effects that a law allows but nobody expects."""
    stated = [(term.name, free, term.numbers[free.name]) for term in model.stated for free in term.candidate.free]
    said = filter(None, (free.doubt(name, value) for name, free, value in stated))
    return tuple(f"{file.place('model.effects')}: {sentence}" for sentence in said)


def left_out(measurement, sets):
    return [
        f"{measured_set.name}: not judged, its number of tests or its scatter is not stated, or zero in every layer"
        for measured_set in measurement.sets
        if sets and measured_set not in sets
    ]


def set_notes(problem, model):
    """One line a set: the paper's error, its sign, the height, and what a perfect model would show; then the scatter."""
    notes = []
    perfect_of_sets = zip(problem.responses.sets, samples(problem, model), perfect_models(problem, model), strict=True)
    for measured_set, (measured, simulated), perfect in perfect_of_sets:
        ratio = ""
        if measured_set.layers > 1 and np.any(measured.cv[1:] > 0) and np.any(simulated.cv[1:] > 0):
            upper = (Sample(*(part[1:] for part in sample)) for sample in (measured, simulated))
            times, p = statistics.scatter_ratio(*upper)
            chance = "p < 0.001" if p < 0.001 else f"p = {p:.2g}"  # beyond that it is the law of Fisher's F that speaks, not data
            ratio = f"; scatter between tests {times:.1f} times the model's ({chance})"
        notes.append(
            f"{measured_set.name}: eps_R {100 * statistics.mean_relative_error(measured.mean, simulated.mean):.2f} % (a perfect "
            f"model {100 * perfect.mean:.2f} %, below {100 * perfect.quantile:.2f} % in 95 of 100), bias "
            f"{100 * statistics.signed_bias(measured.mean, simulated.mean):+.2f} %, height "
            f"{100 * statistics.height_error(measured.mean, simulated.mean):+.2f} %{ratio}"
        )
    return notes


def campaign_notes(sets):
    """First layers of several sets, which measure the same thing: a unit on a bottom."""
    notes = []
    if len(sets) > 1:
        ends = [pick(sets, key=lambda each: (each.sample.mean[0], each.name)) for pick in (min, max)]
        (low, low_name), (high, high_name) = ((each.sample.mean[0], each.name) for each in ends)
        error = np.hypot(*(each.sample.mean[0] * each.sample.cv[0] / np.sqrt(each.sample.tests[0]) for each in ends))
        sigmas = f", {(high - low) / error:.1f} sigma" if error > 0 else ""
        notes.append(
            f"first layers, which measure one thing (a unit on the bottom): {high:.3f} ({high_name}) against {low:.3f} "
            f"({low_name}), {100 * (high / low - 1.0):.1f} % apart{sigmas}: what another campaign alone may change"
        )
    notes.append(
        f"campaign term {100 * observations.CAMPAIGN:g} %, half of its variance common to all layers, half individual to "
        "each; sigma under 'where' includes it, z does not"
    )
    return notes


def search_notes(problem):
    """What the data could show, what the numerics change, and how many tests were simulated."""
    responses, shifts = problem.responses, []
    data, numerics = responses.data, []
    error = np.sqrt(data.variance + responses.base.variance)
    for index, measured_set in enumerate(responses.sets):
        layers, _ = observations.rows_of(data, index)
        parts = statistics.detectable_shift(error[layers], measured_set.layers) / measured_set.sample.mean
        shifts.append(f"{measured_set.name} " + ", ".join(f"{100 * part:.1f}" for part in parts))
    for name, what in (("time_step", "half the time step"), ("iterations", "twice the iterations")):
        for known in responses.nodes.get(name, {}).values():
            if known is not None:
                moved = np.max(np.abs(known[0] / error)[data.layer > 0])
                numerics.append(f"{what} moves a layer by {moved:.1f} standard errors at most")
    return [
        f"smallest shift of a layer that single sets show (80 % power) [%]: {'; '.join(shifts)}; "
        "an effect must move one by what all sets show together, differences between campaigns included",
        *(["numerics first: " + ", ".join(numerics)] if numerics else ()),
        f"{len(responses.seeds)} simulated tests a set and effect, step {responses.model.placement.time_step:.4g} s; "
        f"{responses.simulator.ran} simulated now, the others read from the store",
    ]
