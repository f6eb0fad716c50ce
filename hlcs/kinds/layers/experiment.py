"""Layer tables as a kind of measurement: read, compared with simulated placement tests, searched for what these are missing."""

from dataclasses import replace
from functools import partial

import numpy as np

from hlcs.data.experiment_file import LAYOUTS
from hlcs.estimation.adequacy import Adequacy
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.estimation.direct_problem import Rows
from hlcs.kinds.layers import observations
from hlcs.kinds.layers.candidates import library, named
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.model import PlacementSimulator, model_of
from hlcs.kinds.layers.notes import campaign_notes, left_out, samples, search_notes, set_notes, stated_notes
from hlcs.kinds.layers.problem import LayerProblem
from hlcs.kinds.layers.responses import Responses
from hlcs.kinds.protocol import Observation, Prepared, Tabulated
from hlcs.placement import statistics
from hlcs.records import Reason
from hlcs.rendering import Pictures
from hlcs.selection.search import Search
from hlcs.selection.sets import explained
from hlcs.selection.thresholds import HELPS, ODDS, ODDS_ALONE, REACH, TIED
from hlcs.selection.verdict import select
from minibullet.errors import InputError

SEEDS = 16  # tests of a model on each measured set: the same ones in a comparison and in a search, so that both judge alike
SCREEN = 4  # of them for a first look at every effect
ROUNDS = 4  # of a search and of simulations of what it found to be among the best
CHECKED = 3  # sets of effects that are simulated as a whole, at most
NOTHING_PAYS = "the misfit is too small, or the numbers too few, to pay for any"


def _check_candidates(file, test, sets):
    """InputError, by its line, where a file names a candidate that no layers know: a misspelt name is the user's to mend."""
    for name in file.candidates or ():
        try:
            named(name, test, sets)
        except InputError as problem:
            raise InputError(f"{file.place('diagnose.candidates')}: {problem}") from None


class Layers(Tabulated):
    """An OpenExperiment (`kinds.protocol`) of layer coefficients of repeated placement tests.

    simulator: runs the tests that are not yet in its store; seeds: tests of each model on each measured set.
    """

    kind, measure, unit, carried_noise = "layers", "mean relative error", "1", False
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
        _check_candidates(file, self.model.base, measurement.sets)  # what stands in the model may have been one
        self.sets = tuple(measured_set for measured_set in measurement.sets if measured_set.judgeable)
        self.measurement, self.judgeable = measurement, bool(self.sets)
        self.notes = (*measurement.notes, *stated_notes(file, self.model), *left_out(measurement, self.sets))
        self.simulator = simulator or PlacementSimulator(workers=options.workers, progress=options.progress)
        self.seeds = [options.seed + 1 + k for k in range(seeds)]

    @property
    def noise(self):
        known = {
            "rho": 0.0,
            "source": "scatter between tests, over the number of tests",
            "campaign": observations.CAMPAIGN,
            "hold_out": self.measurement.hold_out,
        }
        return {"position": None} | (known if self.judgeable else {"source": "unknown"})

    def _problem(self):
        """The LayerProblem of the model under test, simulated on every set."""
        data = observations.observed(self.sets, self.measurement.group)
        responses = Responses(self.simulator, self.model, self.sets, data, self.seeds)
        names = tuple(dict.fromkeys(map(self.measurement.group, self.sets)))
        groups = tuple(Rows(name, np.flatnonzero(data.group == index)) for index, name in enumerate(names))
        return LayerProblem(responses, groups, data.variance + responses.base.variance)

    def observe(self):
        problem = self._problem()
        fit = problem.fit(self.model)
        adequacy, table = self.judge(problem, fit)
        error = {
            "measure": self.measure,
            "rms": problem.error(fit.linearization.white),
            "unit": self.unit,
            "noise": problem.noise_level,
            "bias": float(np.mean(-table["residual"] / table["measured"])),
        }
        notes = (*self.notes, *set_notes(problem, self.model), *campaign_notes(self.sets))
        where, shown = self.where(problem, table), {"against": ("layer", "input")}
        table["trial"] = np.array([measured_set.name for measured_set in self.sets])[table["trial"]]
        return Observation(adequacy.adequate, adequacy.statistic, adequacy.p, error, where, table, notes, shown)

    # --- search -----------------------------------------------------------------------------------------------------------------

    def _candidates(self, names):
        test, sets = self.model.placement, self.sets or self.measurement.sets
        chosen = library(test, sets) if names is None else [named(name, test, sets) for name in dict.fromkeys(names)]
        return tuple(candidate for candidate in chosen if candidate.name not in self.model.effects)

    def names(self, candidates):
        return tuple(sorted(candidate.name for candidate in self._candidates(candidates)))

    def pilot(self, effect):
        raise InputError(f"{self.title}: plans are made for recordings and outcome tables, not yet for layers")

    def search(self, candidates):
        problem = self._problem()
        responses, base = problem.responses, problem.fit(self.model)
        cross_validation = CrossValidation(problem.trials, self.measurement.hold_out)
        odds = ODDS if cross_validation.possible else ODDS_ALONE
        chosen, absent = self._candidates(candidates), {}
        if base.chi2 <= odds:  # no fall of chi2 could outweigh the odds against an effect
            chosen, absent = (), {candidate.name: NOTHING_PAYS for candidate in chosen}
        responses.take([(candidate, candidate.step) for candidate in chosen if candidate.simulated], SCREEN)
        fallen = [entry.name for entry in chosen if entry.simulated and responses.nodes[entry.name][entry.step] is None]
        absent |= dict.fromkeys(fallen, "no such placement stands")
        chosen = [candidate for candidate in chosen if candidate.name not in fallen]
        if switch := self._switched(problem, base, chosen):
            others = [entry for entry in chosen if entry.simulated and entry is not switch]
            responses.take_beside(switch, others, SCREEN)
        first = {entry.name: {free.name: free.null + entry.step for free in entry.free} for entry in chosen if entry.simulated}
        searched, checked = partial(Search, problem, chosen, base, odds, self.options.log, first), set()
        search = searched().run()
        for _ in range(ROUNDS):
            if search.budget.stopped or not self._check(search, checked):
                break
            search = searched().run()
        notes = [*self.notes, *campaign_notes(self.sets), *search_notes(problem)]
        if self.options.user_effects:
            notes.append("effects of your own take part in recordings and tables of outcomes, not in layers")
        prepared = Prepared(None, problem, base, tuple(notes))
        selection = select(self, prepared, search, cross_validation, absent)
        return replace(selection, notes=(*set_notes(problem, selection.model), *selection.notes))

    def _switched(self, problem, base, candidates):
        """The switch that explains most of the misfit, where that is HELPS of it or more; else None. What the others do is then
        measured beside it: it makes another model."""
        fits = {
            entry: problem.fit(self.model.with_effect(entry, entry.step))
            for entry in candidates
            if entry.simulated and not entry.free
        }
        helpful = [entry for entry in fits if explained(base, fits[entry]) >= HELPS]
        return min(helpful, key=lambda entry: fits[entry].cost, default=None)

    @staticmethod
    def _check(search, checked):
        """Simulate what the best sets of a search rest on and what has not been simulated yet; is anything new known now?

        First the effects of all sets within reach, near to the numbers that were found; then the best set as a whole, and others
        that do as well, whose effects are more than one."""
        responses, (best, *others) = search.problem.responses, search.ranked()
        reach = [effects for effects in (best, *others) if search.cost(effects) <= search.cost(best) + REACH]
        if responses.complete([search.fits[effects].model for effects in reach]):
            return True
        together = [other for other in others if len(other) > 1 and search.cost(other) <= search.cost(best) + TIED]
        simulated = {effects for effects in (best, *together) if any(search.candidates[name].simulated for name in effects)}
        whole = [effects for effects in (best, *together) if effects in simulated - checked][: CHECKED - len(checked)]
        for effects in whole:
            responses.mend(search.fits[effects].model)
        checked.update(whole)
        return bool(whole)

    # --- verdict: as `selection.verdict.select` asks for it ---------------------------------------------------------------------

    @staticmethod
    def judge(problem, fit):
        """(Adequacy by bootstrap, table of one entry a layer for pictures and data frames)."""
        data, layers = problem.data, problem.data.layer > 0
        residual = problem.coloured(fit.linearization.white)
        columns = [problem.coloured(problem.split(column)) for column in np.concatenate(fit.linearization.parameter_columns).T]
        columns = np.array(columns).reshape(-1, len(residual)).T
        of_model = problem.responses.base, residual, columns, problem.doubt(fit.model)
        statistic, p, threshold, draws = observations.adequacy(data, *of_model)
        error = np.sqrt(data.variance + problem.responses.base.variance + (observations.CAMPAIGN * data.mean) ** 2)
        compared = [statistics.welch(*pair) for pair in samples(problem, fit.model)]
        count, left = int(layers.sum()), fit.chi2_per_freedom
        return Adequacy(statistic <= threshold, statistic, p, threshold, "chi2", left, left, draws), {
            "trial": data.set[layers],
            "channel": np.zeros(count, dtype=int),
            "layer": data.layer[layers],
            "input": np.arange(1.0, count + 1),
            "measured": data.value[layers],
            "model": data.value[layers] - residual[layers],
            "residual": residual[layers],
            "sigmas": residual[layers] / error[layers],
            "welch_t": np.concatenate([welch.t for welch in compared]),
            "holm_p": np.concatenate([statistics.holm(welch.p) for welch in compared]),
        }

    @staticmethod
    def where(problem, table):
        """Rows, one a layer, the worst first.

        bias %: model - measured, positive = too thick; z: that over its standard error; holm p: within its table; rms: absolute
        error over measured; sigma: z with what another campaign would change.
        """
        names, rows = [measured_set.name for measured_set in problem.responses.sets], []
        for k, layer in enumerate(table["layer"]):
            measured, model = float(table["measured"][k]), float(table["model"][k])
            row = {
                "trial": names[table["trial"][k]],
                "phase": f"layer {layer}",
                "layer": int(layer),
                "measured": measured,
                "model": model,
                "bias %": 100 * (model / measured - 1.0),
                "z": float(table["welch_t"][k]),
                "holm p": float(table["holm_p"][k]),
                "rms": abs(model / measured - 1.0),
                "sigma": -float(table["sigmas"][k]),
            }
            rows.append(row)
        return tuple(sorted(rows, key=lambda row: (-abs(row["sigma"]), row["trial"], row["layer"])))

    @staticmethod
    def pictures(problem, before, after):
        names = tuple(measured_set.name for measured_set in problem.responses.sets)
        return Pictures(before, after, names, "input", "row: the layers, set after set")
