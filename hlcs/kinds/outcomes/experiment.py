"""Outcome tables as a kind of measurement: read, compared with the model under test, searched for what it is missing."""

from dataclasses import replace
from functools import cache
from itertools import chain

import numpy as np

from hlcs.data.experiment_file import LAYOUTS
from hlcs.data.outcome_tables import read_outcomes
from hlcs.data.quantities import OUTCOMES
from hlcs.effects import check_names, class_named
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.kinds.noise_shown import Shown, noise_shown
from hlcs.kinds.outcomes.never import other_settings
from hlcs.kinds.outcomes.problem import fastest_rows, judge_table, posed, prepare_table, table_candidates, where_in_table
from hlcs.kinds.outcomes.rebounds_read import rebounds_read
from hlcs.kinds.outcomes.repeats import groups_told, without_misread
from hlcs.kinds.outcomes.rolling import rolled_told, rolling_told
from hlcs.kinds.outcomes.row_noise import about_a_curve, between_repeats, to_know_it
from hlcs.kinds.outcomes.zero_errors import zero_errors_told, zeros_of
from hlcs.kinds.protocol import Observation, Tabulated, misfit
from hlcs.learning.rebounds import learn_rebounds
from hlcs.records import Reason
from hlcs.rendering import Pictures
from hlcs.selection.planning import Pilot
from hlcs.selection.search import Search
from hlcs.selection.thresholds import ODDS, ODDS_ALONE
from hlcs.selection.verdict import select
from hlcs.simulation.model import Term
from hlcs.simulation.row_setups import row_setups

FEW = 12  # rows below which a table is small
BY_REPEATS = "leave measurement.noise out: rows of equal inputs then tell the noise"
AGAIN = 3  # searches at most, each with the errors of inputs as the best set of the last one propagates them


class Outcomes(Tabulated):
    """An OpenExperiment (`kinds.protocol`) of an outcome table: one row, one experiment, one number."""

    kind, measure, carried_noise = "outcomes", "rms", True
    layout = LAYOUTS[kind]
    unjudged = Reason.NOT_JUDGED()
    judge, where = staticmethod(judge_table), staticmethod(where_in_table)

    def __init__(self, file, options):
        self.options, self.title, self.tolerance = options, file.title, file.tolerance
        table = read_outcomes(file)
        said = check_names(file, options.user_effects, row_setups(file, table))
        table, aside = without_misread(table)
        self.file, self.table = file, replace(table, notes=(*said, *table.notes, *aside, *groups_told(table)))
        self.notes = self.table.notes
        self.unit, self.advice = OUTCOMES[self.table.outcome], to_know_it(self.table)
        self._prepared = prepare_table(file, self.table, options.user_effects)
        self.judgeable = self._prepared.problem is not None
        self.noise = self._noise_of(self._prepared)

    def _noise_of(self, prepared):
        """The noise as it is told: that of the rows, what the errors of inputs make of it, and what settings scatter by, beside
        the model of a Prepared."""
        if not self.judgeable:
            return prepared.noise.to_dict()
        problem, scatter = prepared.problem, prepared.problem.errors.scatter
        inputs = float(np.sqrt(np.mean(problem.errors.of_inputs[problem.back] ** 2)))
        shared = {"inputs": inputs, "between_settings": scatter}
        return prepared.noise.to_dict() | {name: size for name, size in shared.items() if size}

    def observe(self):
        problem = self._prepared.problem
        adequacy, table = judge_table(problem, self._prepared.base)
        error = misfit(table["residual"], self.unit, problem.noise_level)
        if problem.never.any():
            error["bias"] = None  # an outcome that never comes is not less than was measured
        shown = {
            "trials": tuple(group.name for group in problem.trials),
            "channels": (self.table.outcome,),
            "against": tuple(self.table.inputs),
        }
        if not adequacy.adequate:
            shown["noise_shown"] = self.noise_shown(problem, self._prepared.base)
        where = where_in_table(problem, table)
        return Observation(adequacy.adequate, adequacy.statistic, adequacy.p, error, where, table, self._prepared.notes, shown)

    def noise_shown(self, problem, fit):
        """What rows show that repeat each other, else those about a smooth curve, where the model would be adequate with it."""
        scatter = repeats = between_repeats(self.table)
        if scatter is None and not problem.errors.deviation.any():
            scatter = about_a_curve(self.table, problem.by_row(fit))
        if scatter is None or scatter.sigma <= problem.noise.position:
            return None
        key = "outcome" if "outcome" in self.file.noise else self.table.outcome
        noise = scatter.noise(problem.noise.source)
        following = BY_REPEATS if repeats else f"repeat rows, and {BY_REPEATS}"
        shown = Shown(key, scatter.sigma, self.unit, scatter.seen, noise, following)
        return noise_shown(problem, fit, shown, judge_table, self.file)

    def learn(self, problem, fit, best):
        """The Learned law of rebounds that explains what a fit leaves, or None; best: Fit of the best effects."""
        readings = rebounds_read(problem, self._prepared.base.model)
        return learn_rebounds(problem, fit, best, readings, self.alone, self.file.hold_out)

    @staticmethod
    def moved(problem):
        """[(body, surroundings, highest speed)] of the rows, as `selection.reynolds.reached` asks for it."""
        speeds = fastest_rows(problem.file, problem.table)
        setups = [problem.setups[k] for k in problem.back]
        return [(setup.body, setup.surroundings, float(speed)) for setup, speed in zip(setups, speeds, strict=True)]

    def names(self, candidates):
        return tuple(candidate.name for candidate in self._candidates(candidates)[0])

    def _candidates(self, names):
        return table_candidates(self.file, self.table, names, self.options.user_effects)

    def search(self, candidates):
        chosen, absent = self._candidates(candidates)
        prepared = self._prepared
        for again in reversed(range(AGAIN)):
            cross_validation = CrossValidation(prepared.problem.trials, self.file.hold_out, len(self.table.values) < FEW)
            odds = ODDS if cross_validation.possible else ODDS_ALONE
            search = Search(prepared.problem, chosen, prepared.base, odds, self.options.log)
            search.first += other_settings(search)
            search.run()
            if not again or search.budget.stopped:
                break
            problem = prepared.problem.beside(search.fits[search.ranked()[0]].model)
            if problem is prepared.problem:
                break
            prepared = posed(problem, prepared.base.model)
        self.noise = self._noise_of(prepared)
        problem, model = prepared.problem, prepared.base.model
        as_it_is = cache(lambda: zeros_of(problem, model, judge_table))

        def with_zero():
            return odds + min((zero.cost for zero in as_it_is()), default=np.inf)

        found = select(self, prepared, search, cross_validation, absent, with_zero)
        if found.adequate["before"] or search.budget.stopped:
            return found
        best = search.fits[frozenset(found.effects)]
        doubted = [entry for entry in chosen if entry.setting and not found.adequate["after"]]  # a number of the file beside it
        models = (model.with_term(Term(entry, tuple(entry.start.items()))) for entry in doubted)
        zeros = chain([as_it_is()], (zeros_of(problem, each, judge_table) for each in models))
        rolls = (*rolling_told(problem, model, judge_table), *rolled_told(problem, best))
        return replace(found, notes=(*zero_errors_told(zeros, best.chi2), *rolls, *found.notes))

    def pilot(self, effect):
        class_named(effect, self.options.user_effects)
        names, prepared = self.file.candidates, self._prepared
        candidates, absent = self._candidates(None if names is None else [*names, effect])
        groups = prepared.problem.trials if prepared.problem else ()
        possible = CrossValidation(groups, self.file.hold_out).possible if groups else False
        return Pilot(candidates, absent, lambda: prepared, possible, FEW, len(self.table.values), "rows")

    @staticmethod
    def pictures(problem, before, after):
        """What the figure of a Diagnosis draws."""
        names = tuple(group.name for group in problem.trials)
        return Pictures(before, after, names, "input", problem.table.main or "row")
