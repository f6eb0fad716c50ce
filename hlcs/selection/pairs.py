"""Two effects that hide each other: found together where neither holds out alone."""

from functools import partial

import numpy as np

from hlcs.estimation.least_squares import least_squares, project_out
from hlcs.selection.eligibility import carries
from hlcs.simulation.model import Term

PAIRS_TRIED = 4  # pairs of candidates refitted together where no single one holds out
PER_PAIR = 4  # fits that a pair takes: the first, both, and each without the other
PAIRS_IN_A_BATCH = 12  # the same where all of them are simulated in one batch, and linear ranks are poor


def hidden_pair(search, fit, trials):
    """Fits with two more terms, each worthless on held-out data until the other is in, or [].

    Only where a candidate points at the residual strongly and fails for its held-out error alone: two effects at once
    spoil each other's numbers in one half of the recordings. Pairs are ranked by their linear signatures together; where
    simulations are cheap, a second effect that acts only through the first is looked for too.
    """
    pointing = [
        trial
        for trial in trials.values()
        if trial.fit is not None
        and trial.fails
        and trial.gain > 2 * trial.required_gain * max(trial.fit.chi2 / trial.fit.freedom, 1.0)
        and not search.out_of_bounds(trial.fit)
        and not search.contradicts(trial.fit)
        and not search.same_form(trial.candidate, fit.model.terms)
    ]
    if not pointing:
        return []
    most = search.budget.affordable(PAIRS_IN_A_BATCH, 1, PER_PAIR) if search.problem.simulator.contact else PAIRS_TRIED
    tried = pairs(search, fit, trials)[:most]
    search.progress(f"refitting {len(tried)} pairs")

    def both_in(first, second):
        alone = search.refit(fit, first.candidate)
        both = search.refit(alone, second.candidate)
        good = all(stands(search, fit, both, trial, len(trials)) for trial in (first, second))
        return both.chi2 + first.required_gain + second.required_gain, good, [alone, both]

    if search.problem.simulator.contact:
        fitted = search.problem.batched([partial(both_in, *pair) for pair in tried])
        good = [(cost, fits) for cost, stand, fits in fitted if stand]
        return min(good, key=lambda each: each[0])[1] if good else []
    for first, second in tried:
        _, good, fits = both_in(first, second)
        if good:
            return fits
    for first in sorted(pointing, key=lambda trial: (-(trial.gain - trial.required_gain), trial.candidate.name))[:2]:
        if search.budget.ends_search(f"what acts only through {first.candidate.name}"):
            break
        seconds = [
            trial
            for trial in search.round(first.fit).values()
            if trial.fit is not None and not trial.fails and not search.same_form(trial.candidate, first.fit.model.terms)
        ]
        if not seconds:
            continue
        second = max(seconds, key=lambda trial: (round(trial.gain - trial.required_gain, 6), trial.candidate.name))
        if stands(search, fit, second.fit, first, len(trials)):
            return [first.fit, second.fit]
    return []


def pairs(search, fit, trials):
    """[(CandidateTrial, CandidateTrial)] of candidates that together point at the residual more than either, best first."""
    r, q = fit.linearization.residual
    signatures = [
        (trial, project_out(q, np.concatenate(trial.signature)))
        for trial in trials.values()
        if trial.visible
        and trial.linear_gain > 0.5 * trial.required_gain
        and not search.same_form(trial.candidate, fit.model.terms)
    ]
    found = []  # (gain less what it requires, its number, the pair)
    for place, (first, s) in enumerate(signatures):
        for second, t in signatures[:place]:
            if search.same_form(first.candidate, (Term(second.candidate, ()),)):
                continue
            gain = least_squares(np.hstack([s, t]), r).gain
            extra = gain - max(first.linear_gain, second.linear_gain)
            if extra > max(first.required_gain, second.required_gain):
                ordered = sorted((first, second), key=lambda trial: -trial.linear_gain)
                found.append((gain - first.required_gain - second.required_gain, len(found), ordered))
    return [tuple(ordered) for _, _, ordered in sorted(found, key=lambda each: -each[0])]


def stands(search, before, both, trial, count):
    """Is one of the last two terms of a fit worth its complexity beside the other, held-out data and bounds included?"""
    index = both.model.names.index(trial.candidate.name) - len(both.model.fixed)
    return passes(search, beside(search, before, both, index), count)


def beside(search, before, fit, index):
    """The CandidateTrial of a term beside the others of a fit: against the fit without it, or against `before` where another
    term acts through it and the two are judged together."""
    entry, alone = fit.model.terms[index].candidate, before
    if not carries(fit.model, index):
        alone = search.problem.fit(fit.model.without(index), fit.initial_states)
    return search.judged(alone, entry, fit)


def passes(search, trial, count):
    """Does a judged candidate keep every rule of acceptance, chosen among `count` of them?"""
    trial.holm = min(1.0, count * trial.p)
    return trial.fit is not None and not search.broken_rules(trial)
