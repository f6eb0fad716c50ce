"""From a search to what it found: the moves of the search in their order, the final fit, its competitors."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from hlcs.records import Finding, NextExperiment, Pictures
from hlcs.selection import experiment_design
from hlcs.selection.competing_models import competing_models
from hlcs.selection.findings import ambiguous_sets, errors, fitted_error, held_out_error, intervals, problem_findings
from hlcs.selection.search_moves import exchange_terms, try_other_first_effects, try_other_forms, try_stated_fluid


@dataclass(frozen=True)
class Selection:
    """What a search found, in any kind of measurement; fields as in `records.Diagnosis`."""

    effects: tuple[str, ...]
    ambiguous: tuple[tuple[str, ...], ...]
    parameters: dict
    error: dict
    steps: tuple[dict, ...]
    adequate: dict
    candidates: tuple[Finding, ...]
    where: tuple[dict, ...]
    model: Any
    pictures: Pictures
    notes: tuple[str, ...]
    next_experiment: Callable[[str], NextExperiment] = field(repr=False)  # of a verdict that leaves something open
    left_out: tuple[str, ...] = ()  # of the notes, what was left out to keep within the limit of time

    @property
    def verdict(self):
        """One rule for all kinds of measurement."""
        if not self.adequate["after"]:
            return "unexplained"
        if self.ambiguous:
            return "ambiguous"
        return "effect" if self.effects else "complete"


def select(experiment, prepared, search, absent, on_all=lambda problem, fit: (problem, fit)):
    """Run a search over candidates and return the Selection.

    experiment: has `judge` (problem, fit) -> (Adequacy, table of observations), `where` (problem, table) -> rows, `polished`
    (problem, fit) -> the final fit and `pictures`; prepared: has the problem and the fit of the model under test; absent: {name:
    why it was not tried}; on_all: function (problem, fit) -> the same on all rows, for the verdict and the numbers, where the
    search has fewer.
    """
    problem, base, unit = prepared.problem, prepared.base, prepared.problem.unit
    before, table_before = experiment.judge(*on_all(problem, base))
    fits, rounds = try_stated_fluid(search, *try_other_first_effects(search, *try_other_forms(search, *search.run(base))))
    settled = len(fits[-1].model.terms) < 2 and not problem.simulator.contact  # else a term may stand where another belongs
    if not settled:
        fits, rounds = exchange_terms(search, fits, rounds)
    final, exact = fits[-1], experiment.polished(problem, fits[-1])  # rivals were, and are, fitted at the step of the search
    judged, best = on_all(problem, exact)
    after, table_after = experiment.judge(judged, best)
    search.progress("rivals")
    others = competing_models(search, final, 1.0 if after.adequate else max(after.chi2, 1.0))
    alternatives = {
        term.name: {name: cosine for name, _, cosine in rest} for term, rest in zip(final.model.terms, others, strict=True)
    }
    steps = {}
    for fit in [*fits[:-1], exact]:
        names = tuple(term.name for term in fit.model.terms)
        if names not in steps:
            held, fitted = held_out_error(search, fit, unit), fitted_error(search, fit, unit)
            steps[names] = {"effects": list(names), "held_out": held, "fitted": fitted}
    return Selection(
        effects=tuple(alternatives),
        ambiguous=ambiguous_sets(alternatives),
        parameters=intervals(best, 1.0 if after.adequate else after.chi2),
        error=errors(search, base, exact, unit),
        steps=tuple(steps.values()),
        adequate={
            "before": before.adequate,
            "after": after.adequate,
            "statistic": after.statistic,
            "p": after.p,
            "threshold": after.threshold,
            "speaks": after.worst,
            "chi2_per_freedom": {"before": before.chi2, "after": after.chi2},
        },
        candidates=problem_findings(search, fits, rounds, alternatives, absent, unit),
        where=experiment.where(judged, table_after),
        model=best.model,
        pictures=experiment.pictures(problem, table_before, table_after),
        notes=(*prepared.notes, *search.budget.notes()),
        left_out=search.budget.notes(),
        next_experiment=partial(experiment_design.next_experiment, problem, final, others),
    )
