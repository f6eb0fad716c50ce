"""Layer tables as a kind of measurement: read, compared with simulated placement tests, searched for what these are missing."""

from functools import partial

import numpy as np

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.candidates import library, named
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.experiment_design import next_experiment
from hlcs.kinds.layers.findings import findings, intervals
from hlcs.kinds.layers.model import Simulator, model_of
from hlcs.kinds.layers.notes import campaign_notes, floor_of, left_out, samples, search_notes, set_notes
from hlcs.kinds.layers.search import SEEDS, LayerSearch
from hlcs.kinds.protocol import Observation
from hlcs.placement import statistics
from hlcs.records import Pictures, Reason
from hlcs.selection.verdict import Selection

ADEQUATE = 0.02  # smallest bootstrap p of a model that may pass, under the form of the campaign term that is kinder to it


class Layers:
    """An Experiment (`kinds.protocol`) of layer coefficients of repeated placement tests.

    simulator: runs the tests that are not yet in its store; seeds: tests of each model on each measured set.
    """

    kind, measure, unit = "layers", "mean relative error", "1"
    unjudged = Reason.NOT_TRIED(why="the number of tests, or their scatter, is unknown")
    advice = (
        "state in the columns cv and tests how many tests each mean stands for (two at least) and how they scatter between tests "
        "(above zero: no tests agree to the last digit in every layer)"
    )

    def __init__(self, file, options, simulator=None, seeds=SEEDS):
        measurement = read_layers(file)
        self.options, self.title = options, measurement.title
        self.model, self.sets = model_of(measurement), tuple(one for one in measurement.sets if one.judgeable)
        self.measurement, self.judgeable = measurement, bool(self.sets)
        self.notes = (*measurement.notes, *left_out(measurement, self.sets))
        simulator = simulator or Simulator(workers=options.workers, progress=options.progress)
        self._searching = partial(LayerSearch, measurement, self.sets, simulator, options.seed, seeds)

    @property
    def noise(self):
        if not self.judgeable:
            return {"position": None, "source": "unknown"}
        return {
            "position": None,
            "rho": 0.0,
            "source": "scatter between tests, over the number of tests",
            "campaign": least_squares.CAMPAIGN,
            "hold_out": self.measurement.hold_out,
        }

    def observe(self):
        search = self._searching()
        stage = search.stage(self.model)
        adequate, statistic, p, _ = _adequate(search, stage)
        inside = search.data.layer > 0
        error = {
            "measure": self.measure,
            "rms": search.error(stage.residual),
            "unit": self.unit,
            "noise": floor_of(search, stage),
            "bias": float(np.mean(-stage.residual[inside] / search.data.value[inside])),
        }
        notes = (*self.notes, *set_notes(search, stage), *campaign_notes(self.sets))
        table = _table(search, stage)
        table["trial"] = np.array([one.name for one in self.sets])[table["trial"]]
        shown = {"against": ("layer", "input")}
        return Observation(adequate, statistic, p, error, where_it_fails(search, stage), table, notes, shown)

    def _candidates(self, names):
        test, sets = self.model.placement, self.sets or self.measurement.sets
        if names is None:
            entries = library(test, sets)
        else:
            entries = [entry for name in dict.fromkeys(names) for entry in named(name, test, sets)]
        return tuple(entry for entry in entries if entry.name not in self.model.effects)

    def names(self, candidates):
        return tuple(sorted({entry.name for entry in self._candidates(candidates)}))

    def search(self, candidates):
        search, entries = self._searching(), self._candidates(candidates)
        first = search.stage(self.model)
        stages, rounds = search.run(first, entries)
        final = stages[-1]
        before, after, accepted = _adequate(search, first), _adequate(search, final), final.accepted
        rivals = [search.rivals(stage, winner, tried) for stage, winner, tried in zip(stages, accepted, rounds, strict=False)]
        alternatives = [
            (one.name, *sorted({other.name for other, _ in others})) for one, others in zip(accepted, rivals, strict=True)
        ]
        where, notes = where_it_fails(search, final), list(self.notes)
        notes += set_notes(search, final) + campaign_notes(self.sets) + search_notes(search, final, rounds)
        if self.options.user_effects:
            notes.append("effects of your own take part in recordings and tables of outcomes, not in layers")
        names = tuple(one.name for one in self.sets)
        return Selection(
            effects=tuple(one.name for one in accepted),
            ambiguous=tuple(members for members in alternatives if len(members) > 1),
            parameters=intervals(accepted),
            error=self._errors(search, first, final),
            steps=tuple(self._step(search, stage) for stage in stages),
            adequate={
                "before": before[0],
                "after": after[0],
                "statistic": after[1],
                "p": after[2],
                "by_form": after[3],
                "before_p": before[2],
            },
            candidates=findings(entries, accepted, rounds, rivals),
            where=where,
            model=final.model,
            pictures=Pictures(_table(search, first), _table(search, final), names, "input", "row: the layers, set after set"),
            notes=tuple(notes),
            next_experiment=partial(next_experiment, search, final, rivals, where),
        )

    def _errors(self, search, first, final):
        """Mean relative errors before and after, beside that of a perfect model."""
        floor, held = floor_of(search, final), None
        if search.can_hold_out:
            held = {"before": search.held_out_error(first), "after": search.held_out_error(final), "noise": floor}
        fitted = {"before": search.error(first.residual), "after": search.error(final.residual), "noise": floor}
        return {"measure": self.measure, "unit": self.unit, "held_out": held, "fitted": fitted}

    def _step(self, search, stage):
        """The errors after one more effect."""
        by_set = {one.name: search.error(stage.residual, search.data.set == index) for index, one in enumerate(self.sets)}
        return {
            "effects": list(stage.model.effects[len(self.model.effects) :]),
            "fitted": search.error(stage.residual),
            "held_out": search.held_out_error(stage),
            "by_set": by_set,
        }


def _adequate(search, stage):
    """(adequate, chi-squared, p, {form: p}): under the form of the campaign term that is kinder to the model."""
    slopes = [one.slope for one in stage.accepted if not one.candidate.switch]
    found = least_squares.adequacy(search.data, stage.numbers, stage.residual, slopes)
    form = max(found, key=lambda name: found[name][1])
    return found[form][1] >= ADEQUATE, found[form][0], found[form][1], {name: p for name, (_, p) in found.items()}


def where_it_fails(search, stage):
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


def _table(search, stage):
    """One entry a layer, for pictures and data frames."""
    data, layers = search.data, search.data.layer > 0
    error = np.sqrt((data.variance + stage.numbers.variance + (least_squares.CAMPAIGN * data.mean) ** 2)[layers])
    residual = stage.residual[layers]
    trial = data.set[layers]
    return {
        "trial": trial,
        "channel": np.zeros(len(trial), dtype=int),
        "layer": data.layer[layers],
        "input": np.arange(1.0, len(trial) + 1),
        "measured": data.value[layers],
        "model": stage.numbers.value[layers],
        "residual": residual,
        "sigmas": residual / error,
    }
