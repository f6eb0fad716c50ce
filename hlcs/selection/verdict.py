"""From a search to what it found: the best set, those that do as well, their numbers, and whether the best one is adequate."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial

import numpy as np

from hlcs.data.quantities import have_unit
from hlcs.records import Found, NextExperiment
from hlcs.selection import experiment_design
from hlcs.selection.findings import candidate_findings
from hlcs.selection.found_numbers import doubts_of, parameters_of, shows
from hlcs.selection.held_out import fitted_error, held_out_error
from hlcs.selection.reynolds import reached
from hlcs.selection.sets import FittedSets, explained
from hlcs.selection.thresholds import HELPS, TIED


@dataclass(frozen=True, kw_only=True)
class Selection(Found):
    """What a search found, and what follows from it."""

    next_experiment: Callable[[str], NextExperiment | None] = field(repr=False)  # of a verdict; None where it leaves nothing open

    @property
    def verdict(self):
        """One rule for all kinds of measurement."""
        if not self.adequate["after"]:
            return "unexplained"
        if self.ambiguous:
            return "ambiguous"
        return "effect" if self.effects else "complete"


def select(experiment, prepared, search, cross_validation, absent, otherwise=lambda: np.inf, on_all=lambda *judged: judged):
    """The Selection from a search that has run.

    experiment: has `measure` of the error, `judge` (problem, fit) -> (Adequacy, table of observations), `where` (problem,
    table) -> rows, `polisher` (problem, best fit, on_all) -> function fit -> the final ones, `polished_notes` (problem, final
    one) -> what that changed, `alone` (problem, fit) -> a fit that owes nothing to other sets, `with_step_error` (problem, fit)
    -> one whose numbers have that of the time step, `learn` (problem, fit, best fit) -> the law that explains the rest, or None,
    `noise_shown` (problem, fit) -> the noise with which all would be explained, or None, `starts_shown` (problem, fit) -> the
    starts with which it would be, or None, `moved` (problem) -> how fast bodies moved, `pictures`, and `shows_motion`; prepared:
    has the problem and the fit of the model under test; absent: {name: why it was not tried}; otherwise: function () -> what the
    model costs were a reading of the file off alike in all rows; on_all: function (problem, fit) -> the same on all rows, for
    the verdict and the numbers, where the search has fewer.
    """
    problem, base = prepared.problem, prepared.base
    finished = finals(experiment, search, experiment.polisher(problem, search.fits[search.ranked()[0]], on_all))
    _, _, before, table_before = finished(frozenset())
    fitted = partial(FittedSets, search, cross_validation, alone=experiment.alone)
    sets, learned = law_first(experiment, fitted, finished, best_set(fitted, finished)[0])
    sets = reading_first(fitted, finished, sets, otherwise)
    starts_shown = None if learned or search.budget.stopped or finished(sets.best)[2].adequate else experiment.starts_shown
    sets, (judged, best, after, table_after), starts = starts_first(fitted, finished, sets, starts_shown)
    effects = sets.best
    search.progress("comparing sets")
    ordered, places = sets.ordered(effects), sets.alternatives()
    final = search.fits[effects]
    final_fits = {members: experiment.with_step_error(problem, search.fits[members]) for members in sets.tied[1:]}
    final_fits |= {members: finished(members)[1] for members in (effects, *sets.absorbing)}
    errors = partial(held_out_error, problem, cross_validation)
    parameters = parameters_of(sets, final_fits, sets.tied)
    said = (*prepared.notes, *prepared.aside, *experiment.polished_notes(problem, judged))
    return Selection(
        effects=ordered,
        ambiguous=tuple((name, *others) for name, others in places.items() if others),
        parameters=parameters,
        absorbing=parameters_of(sets, final_fits, sets.absorbing),
        reynolds=reached(search.candidates, parameters, experiment.moved(judged), after.adequate),
        error={
            "measure": experiment.measure,
            "unit": problem.unit,
            "held_out": _record(problem, errors, base, final) if cross_validation.possible else None,
            "fitted": _record(problem, partial(fitted_error, problem), base, final) | {"starts": starts_share(problem, final)},
        },
        steps=_steps(sets, ordered, errors),
        adequate=_told_adequate(before, after, base, final),
        candidates=candidate_findings(sets, places, absent),
        where=experiment.where(judged, table_after),
        model=best.model,
        pictures=experiment.pictures(problem, table_before, table_after),
        notes=(*said, *doubts_of(best, parameters), *search.budget.notes()),
        sets=tuple(_described(sets, members, final_fits[members], errors, parameters) for members in sets.tied),
        inclusion=sets.inclusion,
        explained=explained(base, final),
        learned=learned,
        noise_shown=None if after.adequate or learned or starts else experiment.noise_shown(judged, best),
        starts_shown=starts,
        tolerance=left_over(experiment.tolerance, problem.unit, fitted_error(judged, best), problem.noise_level),
        next_experiment=partial(experiment_design.next_experiment, sets, absent),
    )


def no_effect(effects):
    """May a set stand where something else explains the data? The model under test alone."""
    return not effects


def law_first(experiment, fitted, finished, sets):
    """(FittedSets, the Learned law that explains what the best of them leaves, or None).

    Where a kind of data shows the end of a motion alone, all sets that explain it may do so by numbers beyond what is plausible
    (a drag of five times what air allows, for rebounds that grow lower with speed). There no effect stands if a law without them
    is cheaper, at the odds against any one effect, by more than what is tied. fitted, finished: as in `starts_first`.
    """
    search, bare = sets.search, frozenset()
    if search.budget.stopped:
        return sets, None
    try:
        if not finished(sets.best)[2].adequate:
            return sets, learned_law(experiment, sets)
        if experiment.shows_motion or not all(search.fits[effects].implausible for effects in sets.tied):
            return sets, None
        law = experiment.learn(search.problem, search.fits[bare], search.fits[bare])
    except KeyboardInterrupt:  # the verdict is known
        return sets, search.budget.stop(search.progress)
    if not (law and law.fit) or sets.cost_of(bare, law.fit) + search.odds >= sets.cost(sets.best) - TIED:
        return sets, None
    return fitted(finished(bare)[2].overdispersion, possible=no_effect), law


def reading_first(fitted, finished, sets, otherwise):
    """The FittedSets; where one reading that is off alike in all rows explains the data and costs less than effects, by more than
    what is tied, no effect stands. otherwise: as in `select`."""
    bare, search = finished(frozenset())[2], sets.search
    proved = sets.best and finished(sets.best)[2].adequate and not search.budget.stopped
    try:
        if not proved or bare.adequate or otherwise() >= sets.cost(sets.best) - TIED:
            return sets
    except KeyboardInterrupt:  # the verdict is known
        search.budget.stop(search.progress)
        return sets
    return fitted(bare.overdispersion, possible=no_effect)


def learned_law(experiment, sets):
    """The Learned law that explains what the best of the FittedSets leaves, or None: it takes HELPS of that, as an effect must.

    Effects that do not explain the data may hold a part of what is missing: a law without them stands where it does better than
    they do, not where it does as well. It is fitted as what leaves nothing but noise: each residual counts as one.
    """
    search, effects = sets.search, sets.best
    search.problem.overdispersion, tempered = 1.0, search.problem.overdispersion
    best, bare = search.fits[effects], search.implied if search.implied in search.fits else frozenset()
    try:
        found = experiment.learn(search.problem, best, best)
        alone = experiment.learn(search.problem, search.fits[bare], best) if bare != effects else None
    finally:
        search.problem.overdispersion = tempered
    found, alone = (law if law and (not law.fit or explained(best, law.fit) >= HELPS) else None for law in (found, alone))
    if not (alone and alone.fit):
        return found
    fit = found.fit if found and found.fit else best
    return alone if sets.cost_of(bare, alone.fit) < sets.cost_of(effects, fit) - TIED else found


def finals(experiment, search, polished):
    """Function set -> (all rows, the final fit of a set on them, its Adequacy, table of observations), made once of each fit.

    polished: Fit -> (all rows, final fit on them); the rest as in `select`.
    """

    @cache
    def finished(fit):
        judged, final = polished(fit)
        return judged, final, *experiment.judge(judged, final)

    return lambda effects: finished(search.fits[effects])


def starts_first(fitted, finished, sets, starts_shown):
    """(FittedSets, what `finished` gives of the best of them, the starts with which that one would explain the data, or None).

    Where it is the model under test that other starts let explain the data, no effect stands. starts_shown: as of the experiment
    in `select`; None = not to be asked.
    """
    bare, best = finished(frozenset()), finished(sets.best)
    if starts := starts_shown and starts_shown(*bare[:2]):
        return fitted(bare[2].overdispersion, possible=no_effect), bare, starts
    return sets, best, starts_shown and sets.best and starts_shown(*best[:2]) or None


def best_set(fitted, finished):
    """(FittedSets, what `finished` gives of the best of them); fitted: overdispersion -> FittedSets; finished: set -> (problem,
    final fit, its Adequacy, ..).

    Where the best set leaves more than noise the search goes farther, and what is then found is judged with as many readings as
    one as hang together in what is left; there an effect that only absorbs a part of the misfit does not stand. A set that costs
    less and leaves nothing but noise is proved by that: data left out of a short table are too few to prove an effect, but the
    data contradict the model without it.
    """
    sets = fitted(1.0)
    at_best = finished(sets.best)
    if not at_best[2].adequate and sets.search.wider(at_best[2].overdispersion):
        sets = fitted(1.0)
        at_best = finished(sets.best)
    if at_best[2].adequate:
        return best_of_adequate(sets, fitted, finished)
    if adequate := adequate_ones(sets, finished):
        return best_of_adequate(fitted(1.0, adequate=adequate), partial(fitted, adequate=adequate), finished)
    sets = fitted(max(at_best[2].overdispersion, 1.0)).tempered()
    return sets, finished(sets.best)


def best_of_adequate(sets, fitted, finished):
    """What `best_set` gives of adequate sets: of the best of them whose effects are all shown, by their own numbers and beside
    the others.

    What segments tell against each other is in the errors of their numbers, not in the costs of sets. So an effect does not stand
    of which the final numbers are withheld, or as they are where it is absent, if the set is adequate without it too. Nor does
    one beside others that do as well without it: that something is missing held-out data have proved, not that so much is.
    """
    left_out, outdone = set(), set()
    while True:
        at_best = finished(sets.best)
        without = {name: sets.without(sets.best, name) for name in sorted(sets.best)}
        hidden = [rest for name, rest in without.items() if not shows(at_best[1], name)]
        tied = [rest for rest in without.values() if rest in sets.tied and rest - sets.search.implied]
        fitted_ones = (rest for rest in (*hidden, *tied) if rest in sets.search.fits)
        adequate = next((rest for rest in fitted_ones if finished(rest)[2].adequate), None)
        if adequate is None:
            return sets, at_best
        (left_out if adequate in hidden else outdone).add(sets.best)
        sets = fitted(1.0, possible=lambda effects: effects not in left_out, outdone=frozenset(outdone))


def adequate_ones(sets, finished):
    """The sets that cost less than the best one that stands and are adequate: the cheapest of all, and what does as well; where
    that one is not adequate, none.

    None of more numbers than different things were measured: it might as well describe each by a number of its own.
    """
    found, most = [], sets.cost(sets.best)
    for effects in sets.ranked:
        if sets.cost(effects) >= most:
            break
        if len(sets.search.fits[effects].numbers) > sets.search.problem.measured:
            continue
        if finished(effects)[2].adequate:
            most = min(most, sets.cost(effects) + TIED)
            found.append(effects)
        elif not found:
            break
    return frozenset(found)


def _told_adequate(before, after, base, final):
    """The Adequacy of the model under test and of the final fit, as in the result file; base, final: their fits of the search."""
    return {
        "before": before.adequate,
        "after": after.adequate,
        "statistic": after.statistic,
        "p": after.p,
        "threshold": after.threshold,
        "speaks": after.worst,
        "draws": after.draws,
        "chi2_per_freedom": {"before": base.chi2_per_freedom, "after": final.chi2_per_freedom},
    }


def _record(problem, error, base, final):
    """An error before and after, beside the noise."""
    return {"before": error(base), "after": error(final), "noise": problem.noise_level}


def starts_share(problem, fit):
    """Share of the variance of the noise that the fitted initial states take up, in the channel that errors are told in [-]."""
    if not any(basis.shape[1] for basis in fit.linearization.state_bases):  # no starts, as in tables
        return 0.0
    known = zip(problem.recordings, fit.linearization.state_bases, strict=True)
    parts = [basis[have_unit(recording.channel, problem.unit)] for recording, basis in known]
    return sum(float(np.sum(part**2)) for part in parts) / max(sum(map(len, parts)), 1)


def left_over(tolerance, unit, error, noise):
    """What is left of an error beyond the noise beside the tolerance of the user; None where none is stated."""
    if tolerance is None:
        return None
    left = float(np.sqrt(max(error**2 - noise**2, 0.0)))
    return {"value": tolerance, "unit": unit, "left": left, "met": left <= tolerance}


def _described(sets, members, final, errors, parameters):
    """One of the fitted sets, as in the result file, with the numbers of its final fit; one that is withheld from
    the parameters is None here too."""
    fit = sets.search.fits[members]
    known = {(name, key): entry["value"] for name, numbers in parameters.items() for key, entry in numbers.items()}
    return {
        "effects": list(sets.ordered(members)),
        "weight": sets.weights[members],
        "chi2": fit.chi2,
        "held_out": errors(fit),
        "parameters": {
            name: {key: None if known.get((name, key), value) is None else value for key, value in numbers.items()}
            for name, numbers in final.model.numbers.items()
        },
    }


def _steps(sets, ordered, errors):
    """The error falling from the model under test to the best set, along the sets that were fitted."""
    first = [ordered[:count] for count in range(len(ordered) + 1)]
    fits = [(names, sets.search.fits.get(frozenset(names))) for names in first]
    return tuple(
        {
            "effects": list(names),
            "held_out": errors(fit),
            "fitted": fitted_error(sets.search.problem, fit),
            "chi2_per_freedom": fit.chi2_per_freedom,
        }
        for names, fit in fits
        if fit
    )
