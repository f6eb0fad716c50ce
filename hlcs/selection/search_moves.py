"""Other moves of the search: another form of a law, another first effect, what a stated fluid does for certain, better terms."""

from functools import partial

import numpy as np

from hlcs.data.rigid_body import rigid_body
from hlcs.estimation.least_squares import least_squares, project_out
from hlcs.selection.competing_models import holds_out, replacement_of, replacements
from hlcs.selection.eligibility import carries
from hlcs.selection.pairs import passes
from hlcs.selection.search import COMPETITOR_MARGIN, EXPLAINED, MOST_TERMS, explained
from hlcs.simulation.model import Term

DENSE = 0.05  # of the density of a body: what a fluid then does is no small matter
MANY = 12.0  # by which a pair must be cheaper: 2 log of the several hundred pairs among which it was chosen
PART = 0.4  # of the best gain that a first effect must have: two of equal strength have half each
FIRSTS, PAIRS = 8, 8  # first effects that are tried, pairs that are refitted


def cost(search, fit):
    """chi2 of a fit and p log n of its terms: what fits with other terms are compared by."""
    return fit.chi2 + sum(search.complexity_penalty(term.candidate) for term in fit.model.terms)


def try_other_forms(search, fits, rounds):
    """(fits, rounds) of the search taken up again with another form of a law, where the form found first explains too little.

    The first term is chosen while others still hide in the residual, so it may have the wrong form, with which no second
    term then holds out. Another form is kept only if the search from it ends where all but noise is explained.
    """
    first = fits[-1]
    if search.problem.simulator.contact or first.chi2 < EXPLAINED * first.freedom:
        return fits, rounds
    best, least = None, cost(search, first) - COMPETITOR_MARGIN
    for index, term in enumerate(first.model.terms):
        for entry in search.candidates:
            if entry.name == term.name or not search.same_form(entry, (term,)):
                continue
            search.progress(f"{entry.name} in place of {term.name}")
            other = search.best_fit(first.model.without(index), entry, entry.starts, first.initial_states)
            if search.out_of_bounds(other) or search.contradicts(other):
                continue
            following, more = search.run(other)
            last = following[-1]
            if last.chi2 < EXPLAINED * last.freedom and cost(search, last) < least:
                best, least = (fits + following, rounds + more), cost(search, last)
    return best or (fits, rounds)


def try_other_first_effects(search, fits, rounds):
    """(fits, rounds) of the search taken up again from another first effect, where two explain everything, and more cheaply.

    What explains most by itself may be an imposter that does the work of two: clock and drag together look like another scale
    of time. First effects are those that explain a good part alone, second ones are ranked by their signatures on top of them.
    """
    base, last = fits[0], fits[-1]
    if not last.model.terms or search.budget.ends_search("pairs that begin with another effect than was accepted first"):
        return fits, rounds
    least = cost(search, last) - MANY
    firsts = other_firsts(search, base, rounds[0].values(), last)
    promising = [
        (first, entry)
        for first, entry in pairs_below(search, firsts, least)
        if {first.model.names[-1], entry.name} != set(last.model.names)
    ]
    promising = promising[: search.budget.affordable(PAIRS)]
    search.progress(f"refitting {len(promising)} pairs that begin with another effect")
    both = search.problem.batched([partial(search.refit, *pair) for pair in promising])
    better = [
        fit
        for (first, entry), fit in zip(promising, both, strict=True)
        if fit.chi2 < EXPLAINED * fit.freedom
        and cost(search, fit) < least
        and not any(fit.at_bound)
        and passes(search, search.judged(first, entry, fit), len(search.candidates))
        and search.prune(fit, newest=0) is None
    ]
    if not better:
        return fits, rounds
    better.sort(key=lambda fit: cost(search, fit))
    for other in better[1:]:
        remember(search, better[0], other)
    more, again = search.run(better[0])
    return fits + more, rounds + again


def pairs_below(search, firsts, least):
    """[(fit with a first effect, second candidate)] that by their signatures would cost less than `least`; the cheapest first."""
    ranked = {}  # names of both -> (what the pair would cost, the first, the second)
    for first in firsts:
        r, q = first.linearization.residual
        entries = [
            entry
            for entry in search.candidates
            if entry.name not in first.model.names and not search.same_form(entry, first.model.terms)
        ]
        signatures = search.problem.batched([partial(search.screen, first, entry) for entry in entries])
        for entry, signature in zip(entries, signatures, strict=True):
            if signature is None:
                continue
            gain = least_squares(project_out(q, np.concatenate(signature)), r).gain
            costs, names = (
                cost(search, first) - gain + search.complexity_penalty(entry),
                frozenset((first.model.names[-1], entry.name)),
            )
            if costs < least and (names not in ranked or costs < ranked[names][0]):
                ranked[names] = costs, first, entry
    return [(first, entry) for _, first, entry in sorted(ranked.values(), key=lambda each: each[0])]


def remember(search, fit, other):
    """Keep a pair that shares a term with a better one as competing for the other term: signatures may not show that it does."""
    of_other, of_fit = (
        [index for index, term in enumerate(one.model.terms) if term.name not in another.model.names]
        for one, another in ((other, fit), (fit, other))
    )
    if len(of_other) == 1:
        term = other.model.terms[of_other[0]]
        model = other.model.without(of_other[0]).with_term(term)
        replacement_of(search, fit, of_fit[0]).fits[term.name] = search.problem.fit(model, other.initial_states)


def other_firsts(search, base, trials, last):
    """Fits with one effect that explains a good part alone, other than the first one of the last fit; the best first.

    One that lies at a bound is among them: it may come off it when the other is in. In flight of equal ones the first;
    through contacts effects that look alike alone may differ beside another.
    """
    most = max(trial.gain for trial in trials if trial.fit is not None)
    accepted = last.model.terms[:1]
    strong = [
        trial
        for trial in trials
        if trial.fit is not None
        and trial.gain > PART * most
        and trial.candidate.name != accepted[0].name
        and not search.same_form(trial.candidate, accepted)
    ]
    strong.sort(key=lambda trial: (trial.required_gain - trial.gain, trial.candidate.name))
    firsts = [last] if len(last.model.terms) == 1 else []
    strong = strong[: search.budget.affordable(FIRSTS)]
    for fit in search.problem.batched([partial(search.refit, base, trial.candidate) for trial in strong]):
        if not search.contradicts(fit) and (
            search.problem.simulator.contact or all(abs(fit.chi2 - other.chi2) > 1.0 for other in firsts)
        ):
            firsts.append(fit)
    return [fit for fit in firsts if fit is not last]


def try_stated_fluid(search, fits, rounds):
    """(fits, rounds) of a search begun with what a dense fluid does for certain, where something is missing and that is not in.

    A model that states a liquid and lacks buoyancy, added mass and drag misses three effects at once, and behind the first of
    them an imposter explains more than the second. Kept where all but noise is explained, about as cheaply as without.
    """
    base, last, around = fits[0], fits[-1], search.problem.trials[0].surroundings
    bodies = [rigid_body(trial.body) for trial in search.problem.trials]
    known = {"buoyancy": {"fluid_density": around.fluid_density}, "added_mass": {}}
    entries = [entry for entry in search.candidates if entry.name in known and entry.name not in last.model.names]
    dense = any(around.fluid_density * body.volume > DENSE * body.mass for body in bodies)
    explains = last.chi2 < EXPLAINED * last.freedom
    if not dense or not entries or len(last.model.terms) < 1 + explains or search.problem.simulator.contact:
        return fits, rounds  # one effect that explains everything is not doubted
    search.progress("in its fluid")
    model = base.model
    for entry in entries:
        numbers = {free.name: free.start for free in entry.free} | known[entry.name]
        model = model.with_term(Term(entry, tuple((free.name, numbers[free.name]) for free in entry.free)))
    following, more = search.run(search.problem.fit(model, base.initial_states))
    while (smaller := search.prune(following[-1], newest=0)) is not None:
        following = [*following, smaller]
    before, after = cost(search, last), cost(search, following[-1])
    spare = COMPETITOR_MARGIN * len(entries) if explains else np.inf
    kept = (
        following[-1].chi2 < EXPLAINED * following[-1].freedom
        and after < before + spare
        and any(entry.name in following[-1].model.names for entry in entries)
    )
    return ([base, *following], rounds + more) if kept else (fits, rounds)


def exchange_terms(search, fits, rounds):
    """(fits, rounds) of the search taken up again from wherever a better term replaces one that stood for it.

    While an imposter stands in the model, what else is missing may not hold out.
    """
    for _ in range(MOST_TERMS):
        if search.budget.ends_comparison("exchanges of an accepted effect for a better one"):
            break
        final = exchange_best_terms(search, fits[-1])
        if final is fits[-1]:
            break
        if final.chi2 < final.freedom + 3 * np.sqrt(2 * final.freedom):  # nothing is left to look for
            fits = [*fits, final]
            break
        following, more = search.run(final)
        fits, rounds = fits + following, rounds + more
        if len(following) == 1:
            break
    return fits, rounds


def exchange_best_terms(search, fit):
    """The fit with terms replaced by others that explain as much with fewer numbers, or more with as many; at most three."""
    for _ in range(MOST_TERMS):
        better = None
        for index, term in enumerate(fit.model.terms):
            if carries(fit.model, index):
                continue
            without, replaced = replacements(search, fit, index, 0.7, 0.0)
            for entry, other in replaced:
                if term.name in search.readings and entry.name not in search.readings and not explained(search.problem, other):
                    continue  # what the impacts show directly gives way only to what explains the data
                gain = (fit.chi2 - other.chi2) + search.complexity_penalty(term.candidate) - search.complexity_penalty(entry)
                if (
                    gain > 2.0
                    and not search.out_of_bounds(other)
                    and not search.contradicts(other)
                    and (not search.same_form(entry, (term,)))
                    and holds_out(search, without, other)
                    and (better is None or gain > better[0])
                ):
                    better = gain, other
        if better is None:
            break
        fit = better[1]
        while (smaller := search.prune(fit, newest=0)) is not None:  # the better term may do what another was there for
            fit = smaller
    return fit
