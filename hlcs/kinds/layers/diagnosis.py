"""Compare and diagnose layer coefficients: how far a placement model misses the tables, and which effect it is missing."""

import numpy as np

from hlcs.compare import Comparison
from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.candidates import library, named
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.experiment_design import next_experiment
from hlcs.kinds.layers.findings import findings, intervals
from hlcs.kinds.layers.model import Simulator, model_of
from hlcs.kinds.layers.notes import campaign_notes, floor_of, left_out, samples, search_notes, set_notes
from hlcs.kinds.layers.search import SEEDS, LayerSearch
from hlcs.placement import statistics
from hlcs.selection.diagnosis import Diagnosis, Finding
from hlcs.selection.experiment_design import NextExperiment

ADEQUATE = 0.02  # smallest bootstrap p of a model that may pass, under the form of the campaign term that is kinder to it
MEASURE, UNIT = "mean relative error", "1"
NO_TESTS = (
    "state in the columns cv and tests how many tests each mean stands for (two at least) and how they scatter between tests "
    "(above zero: no tests agree to the last digit in every layer)"
)


def compare_layer_file(file, seed=0, workers=None, progress=False, simulator=None, seeds=SEEDS):
    """The Comparison of an experiment file of layers: the model under test, simulated `seeds` times, beside every set."""
    measurement = read_layers(file)
    model, sets = model_of(measurement), tuple(one for one in measurement.sets if one.judgeable)
    notes = list(measurement.notes) + left_out(measurement, sets)
    if not sets:
        return Comparison(
            "layers",
            measurement.title,
            None,
            None,
            None,
            {"rms": None, "noise": None, "unit": UNIT},
            (),
            {"source": "unknown"},
            tuple([*notes, NO_TESTS]),
        )
    search = LayerSearch(measurement, sets, simulator or Simulator(workers=workers, progress=progress), seed, seeds)
    stage = search.stage(model)
    adequate, statistic, p, _ = _adequate(search, stage)
    inside = search.data.layer > 0
    error = {
        "measure": MEASURE,
        "rms": search.error(stage.residual),
        "unit": UNIT,
        "noise": floor_of(search, stage),
        "bias": float(np.mean(-stage.residual[inside] / search.data.value[inside])),
    }
    return Comparison(
        "layers",
        measurement.title,
        adequate,
        statistic,
        p,
        error,
        where_layers(search, stage),
        _noise(search),
        tuple(notes + set_notes(search, stage) + campaign_notes(sets)),
        _table(search, stage, names=True),
        against=("layer", "input"),
    )


def diagnose_layers(file, candidates=None, own=(), seed=0, workers=None, progress=False, simulator=None, seeds=SEEDS):
    """The Diagnosis of an experiment file of layers: `seeds` simulated tests of each model on each set."""
    measurement = read_layers(file)
    model, sets = model_of(measurement), tuple(one for one in measurement.sets if one.judgeable)
    notes = list(measurement.notes) + left_out(measurement, sets)
    if not sets:
        return _unknown(measurement, notes)
    search = LayerSearch(measurement, sets, simulator or Simulator(workers=workers, progress=progress), seed, seeds)
    placement = model.placement
    entries = (
        library(placement, sets)
        if candidates is None
        else tuple(entry for name in dict.fromkeys(candidates) for entry in named(name, placement, sets))
    )
    entries = tuple(entry for entry in entries if entry.name not in model.effects)
    first = search.stage(model)
    stages, rounds = search.run(first, entries)
    final = stages[-1]
    before, after = _adequate(search, first), _adequate(search, final)
    rivals = [search.rivals(stage, winner, tried) for stage, winner, tried in zip(stages, final.accepted, rounds, strict=False)]
    effects = tuple(one.name for one in final.accepted)
    ambiguous = tuple(
        (one.name, *sorted({other.name for other, _ in others}))
        for one, others in zip(final.accepted, rivals, strict=True)
        if others
    )
    verdict = "unexplained" if not after[0] else "ambiguous" if ambiguous else "effect" if effects else "complete"
    floor = floor_of(search, final)
    error = {
        "measure": MEASURE,
        "unit": UNIT,
        "held_out": None,
        "fitted": {"before": search.error(first.residual), "after": search.error(final.residual), "noise": floor},
    }
    if search.can_hold_out:
        error["held_out"] = {"before": search.held_out_error(first), "after": search.held_out_error(final), "noise": floor}
    steps = tuple(
        {
            "effects": list(stage.model.effects[len(model.effects) :]),
            "fitted": search.error(stage.residual),
            "held_out": search.held_out_error(stage),
            "by_set": {one.name: search.error(stage.residual, search.data.set == index) for index, one in enumerate(sets)},
        }
        for stage in stages
    )
    adequate = {
        "before": before[0],
        "after": after[0],
        "statistic": after[1],
        "p": after[2],
        "by_form": after[3],
        "before_p": before[2],
    }
    following = None
    if verdict in ("ambiguous", "unexplained"):
        following = next_experiment(search, final, final.accepted, rivals, verdict, where_layers(search, final))
    notes += set_notes(search, final) + campaign_notes(sets) + search_notes(search, final, rounds)
    if own:
        notes.append("effects of your own take part in recordings and tables of outcomes, not in layers")
    return Diagnosis(
        kind="layers",
        title=measurement.title,
        verdict=verdict,
        effects=effects,
        parameters=intervals(final.accepted),
        ambiguous=ambiguous,
        error=error,
        steps=steps,
        adequate=adequate,
        candidates=findings(entries, final.accepted, rounds, rivals),
        where=where_layers(search, final),
        next_experiment=following,
        notes=tuple(notes),
        noise=_noise(search),
        model=final.model,
        pictures={
            "before": _table(search, first),
            "after": _table(search, final),
            "trials": [one.name for one in sets],
            "groups": [measurement.group(one) for one in sets],
            "kind": "layers",
        },
    )


def _adequate(search, stage):
    """(adequate, chi-squared, p, {form: p}): under the form of the campaign term that is kinder to the model."""
    slopes = [one.slope for one in stage.accepted if not one.candidate.switch]
    found = least_squares.adequacy(search.data, stage.numbers, stage.residual, slopes)
    form = max(found, key=lambda name: found[name][1])
    return found[form][1] >= ADEQUATE, found[form][0], found[form][1], {name: p for name, (_, p) in found.items()}


def where_layers(search, stage):
    """Rows, one a layer, the worst first.

    bias %: model - measured, positive = too thick; z: that over its standard error; holm p: within its table; rms: absolute
    error over measured; sigma: z with what another campaign would change.
    """
    rows = []
    for index, one in enumerate(search.sets):
        measured, model = samples(search, stage, index)
        welch = statistics.welch(measured, model)
        campaign = np.sqrt(
            statistics.standard_error(measured) ** 2
            + statistics.standard_error(model) ** 2
            + (least_squares.CAMPAIGN * measured.mean) ** 2
        )
        adjusted = statistics.holm(welch.p)
        for j in range(one.layers):
            bias = model.mean[j] / measured.mean[j] - 1.0
            rows.append(
                {
                    "trial": one.name,
                    "phase": f"layer {j + 1}",
                    "layer": j + 1,
                    "measured": float(measured.mean[j]),
                    "model": float(model.mean[j]),
                    "bias %": float(100 * bias),
                    "z": float(welch.t[j]),
                    "holm p": float(adjusted[j]),
                    "rms": float(abs(bias)),
                    "sigma": float((model.mean[j] - measured.mean[j]) / campaign[j]),
                }
            )
    return tuple(sorted(rows, key=lambda row: (-abs(row["sigma"]), row["trial"], row["layer"])))


def _noise(search):
    return {
        "position": None,
        "rho": 0.0,
        "source": "scatter between tests, over the number of tests",
        "campaign": least_squares.CAMPAIGN,
        "hold_out": search.measurement.hold_out,
    }


def _table(search, stage, names=False):
    """One entry a layer, for pictures and data frames."""
    data, layers = search.data, search.data.layer > 0
    error = np.sqrt((data.variance + stage.numbers.variance + (least_squares.CAMPAIGN * data.mean) ** 2)[layers])
    residual = stage.residual[layers]
    trial = data.set[layers]
    return {
        "trial": np.array([one.name for one in search.sets])[trial] if names else trial,
        "channel": np.zeros(len(trial), dtype=int),
        "layer": data.layer[layers],
        "input": np.arange(1.0, len(trial) + 1),
        "measured": data.value[layers],
        "model": stage.numbers.value[layers],
        "residual": residual,
        "sigmas": residual / error,
    }


def _unknown(measurement, notes):
    """The verdict cannot_judge."""
    entries = library(measurement.test, measurement.sets)
    return Diagnosis(
        kind="layers",
        title=measurement.title,
        verdict="cannot_judge",
        effects=(),
        parameters={},
        ambiguous=(),
        error={"measure": MEASURE, "unit": UNIT, "fitted": None, "held_out": None},
        steps=(),
        adequate={"before": None, "after": None, "statistic": None, "p": None},
        candidates=tuple(
            Finding(name, None, None, None, False, (), "not tried: the number of tests, or their scatter, is unknown")
            for name in sorted({entry.name for entry in entries})
        ),
        where=(),
        next_experiment=NextExperiment(NO_TESTS, (), None, {}),
        notes=tuple(notes),
        noise={"position": None, "source": "unknown"},
    )
