"""Layer tables as a kind of measurement: read, compared with simulated placement tests, searched for what these are missing."""

from functools import partial

import numpy as np

from hlcs.data.experiment_file import LAYOUTS
from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.candidates import library, named
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.experiment_design import next_experiment
from hlcs.kinds.layers.findings import ambiguous_sets, intervals, layer_findings
from hlcs.kinds.layers.model import PlacementSimulator, model_of
from hlcs.kinds.layers.notes import campaign_notes, left_out, noise_floor, samples, search_notes, set_notes
from hlcs.kinds.layers.search import SEEDS, LayerSearch
from hlcs.kinds.protocol import Observation
from hlcs.placement import statistics
from hlcs.records import Pictures, Reason
from hlcs.selection.findings import error_record
from hlcs.selection.verdict import Selection, left_over
from minibullet.errors import InputError

ADEQUATE = 0.02  # smallest bootstrap p of a model that may pass, under the form of the campaign term that is kinder to it


class Layers:
    """An Experiment (`kinds.protocol`) of layer coefficients of repeated placement tests.

    simulator: runs the tests that are not yet in its store; seeds: tests of each model on each measured set.
    """

    kind, measure, unit = "layers", "mean relative error", "1"
    layout = LAYOUTS[kind]
    unjudged = Reason.NOT_TRIED(why="the number of tests, or their scatter, is unknown")
    advice = (
        "state in the columns cv and tests how many tests each mean stands for (two at least) and how they scatter between tests "
        "(above zero: no tests agree to the last digit in every layer)"
    )

    def __init__(self, file, options, simulator=None, seeds=SEEDS):
        measurement = read_layers(file)
        self.options, self.title, self.tolerance = options, file.title, file.tolerance
        self.model = model_of(measurement)
        self.sets = tuple(measured_set for measured_set in measurement.sets if measured_set.judgeable)
        self.measurement, self.judgeable = measurement, bool(self.sets)
        self.notes = (*measurement.notes, *left_out(measurement, self.sets))
        simulator = simulator or PlacementSimulator(workers=options.workers, progress=options.progress)
        self._searching = partial(LayerSearch, measurement, self.sets, simulator, options.seed, seeds)

    @property
    def noise(self):
        known = {
            "rho": 0.0,
            "source": "scatter between tests, over the number of tests",
            "campaign": least_squares.CAMPAIGN,
            "hold_out": self.measurement.hold_out,
        }
        return {"position": None} | (known if self.judgeable else {"source": "unknown"})

    def observe(self):
        search = self._searching()
        fit = search.fit(self.model)
        adequate = _adequacy(search, fit)
        error = {
            "measure": self.measure,
            "rms": search.error(fit.residual),
            "unit": self.unit,
            "noise": noise_floor(search, fit),
            "bias": float(np.mean(-fit.residual[search.layers] / search.data.value[search.layers])),
        }
        notes = (*self.notes, *set_notes(search, fit), *campaign_notes(self.sets))
        table = _table(search, fit)
        table["trial"] = np.array([measured_set.name for measured_set in self.sets])[table["trial"]]
        return Observation(
            adequate["after"],
            adequate["statistic"],
            adequate["p"],
            error,
            where_it_fails(search, fit),
            table,
            notes,
            {"against": ("layer", "input")},
        )

    def _candidates(self, names):
        test, sets = self.model.placement, self.sets or self.measurement.sets
        chosen = [library(test, sets)] if names is None else [named(name, test, sets) for name in dict.fromkeys(names)]
        return tuple(candidate for members in chosen for candidate in members if candidate.name not in self.model.effects)

    def names(self, candidates):
        return tuple(sorted({candidate.name for candidate in self._candidates(candidates)}))

    def pilot(self, effect):
        raise InputError(f"{self.title}: plans are made for recordings and outcome tables, not yet for layers")

    def search(self, candidates):
        search, candidates = self._searching(), self._candidates(candidates)
        first = search.fit(self.model)
        fits, rounds = search.run(first, candidates)
        final, accepted = fits[-1], fits[-1].accepted
        rivals = [search.rivals(fit, winner, trials) for fit, winner, trials in zip(fits, accepted, rounds, strict=False)]
        alternatives = {
            winner.name: {rival.name: cosine for rival, cosine in others} for winner, others in zip(accepted, rivals, strict=True)
        }
        fitted = [search.error(fit.residual) for fit in (first, final)]
        held_out = [search.held_out_error(fit) for fit in (first, final)] if search.can_hold_out else None
        before, adequate, where = _adequacy(search, first), _adequacy(search, final), where_it_fails(search, final)
        notes = [*self.notes, *set_notes(search, final), *campaign_notes(self.sets), *search_notes(search, final, rounds)]
        if self.options.user_effects:
            notes.append("effects of your own take part in recordings and tables of outcomes, not in layers")
        names = tuple(measured_set.name for measured_set in self.sets)
        return Selection(
            effects=tuple(alternatives),
            ambiguous=ambiguous_sets(alternatives),
            parameters=intervals(accepted),
            error=error_record(self.measure, self.unit, noise_floor(search, final), fitted, held_out),
            steps=tuple(self._step(search, fit) for fit in fits),
            adequate={"before": before["after"], **adequate, "before_p": before["p"]},
            candidates=layer_findings(candidates, accepted, rounds, alternatives),
            where=where,
            model=final.model,
            pictures=Pictures(_table(search, first), _table(search, final), names, "input", "row: the layers, set after set"),
            notes=tuple(notes),
            next_experiment=partial(next_experiment, search, final, rivals, where),
            tolerance=left_over(self.tolerance, self.unit, fitted[1], noise_floor(search, final)),
        )

    def _step(self, search, fit):
        """The errors after one more effect."""
        return {
            "effects": list(fit.model.effects[len(self.model.effects) :]),
            "fitted": search.error(fit.residual),
            "held_out": search.held_out_error(fit),
            "by_set": {
                measured_set.name: search.error(fit.residual, search.data.set == index)
                for index, measured_set in enumerate(self.sets)
            },
        }


def _adequacy(search, fit):
    """Is the model adequate, chi-squared and its p: under the form of the campaign term that is kinder to the model."""
    slopes = [trial.slope for trial in fit.accepted if not trial.candidate.switch]
    by_form = least_squares.adequacy(search.data, fit.simulated, fit.residual, slopes)
    statistic, p = max(by_form.values(), key=lambda judged: judged[1])
    return {"after": p >= ADEQUATE, "statistic": statistic, "p": p, "by_form": {form: p for form, (_, p) in by_form.items()}}


def where_it_fails(search, fit):
    """Rows, one a layer, the worst first.

    bias %: model - measured, positive = too thick; z: that over its standard error; holm p: within its table; rms: absolute
    error over measured; sigma: z with what another campaign would change.
    """
    rows = []
    for index, measured_set in enumerate(search.sets):
        measured, model = samples(search, fit, index)
        welch, bias = statistics.welch(measured, model), model.mean / measured.mean - 1.0
        errors = [statistics.standard_error(sample) ** 2 for sample in (measured, model)]
        sigma = (model.mean - measured.mean) / np.sqrt(errors[0] + errors[1] + (least_squares.CAMPAIGN * measured.mean) ** 2)
        columns = {
            "measured": measured.mean,
            "model": model.mean,
            "bias %": 100 * bias,
            "z": welch.t,
            "holm p": statistics.holm(welch.p),
            "rms": abs(bias),
            "sigma": sigma,
        }
        for j in range(measured_set.layers):
            numbers = {name: float(column[j]) for name, column in columns.items()}
            rows.append({"trial": measured_set.name, "phase": f"layer {j + 1}", "layer": j + 1, **numbers})
    return tuple(sorted(rows, key=lambda row: (-abs(row["sigma"]), row["trial"], row["layer"])))


def _table(search, fit):
    """One entry a layer, for pictures and data frames."""
    data, layers = search.data, search.layers
    error = np.sqrt(data.variance + fit.simulated.variance + (least_squares.CAMPAIGN * data.mean) ** 2)
    count = int(layers.sum())
    return {
        "trial": data.set[layers],
        "channel": np.zeros(count, dtype=int),
        "layer": data.layer[layers],
        "input": np.arange(1.0, count + 1),
        "measured": data.value[layers],
        "model": fit.simulated.value[layers],
        "residual": fit.residual[layers],
        "sigmas": fit.residual[layers] / error[layers],
    }
