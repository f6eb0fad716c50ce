"""Two effects that hide each other: found together where neither holds out alone."""

from functools import partial

import numpy as np

from hlcs.estimation import inference
from hlcs.estimation.linearization import Try
from hlcs.selection.eligibility import carries
from hlcs.simulation.model import Term

PAIRS_TRIED = 4  # pairs of candidates refitted together where no single one holds out
PER_PAIR = 4  # fits that a pair takes: the first, both, and each without the other
PAIRS_BESIDE = 12  # the same where all of them are simulated side by side, and linear ranks are poor


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
        and trial.gain > 2 * trial.price * max(trial.fit.chi2 / trial.fit.freedom, 1.0)
        and not search.out_of_bounds(trial.fit)
        and not search.contradicts(trial.fit)
        and not search.same_form(trial.candidate, fit.model.terms)
    ]
    if not pointing:
        return []
    most = search.budget.refits(search.problem, PAIRS_BESIDE, 1, PER_PAIR) if search.problem.shots.contact else PAIRS_TRIED
    tried = pairs(search, fit, trials)[:most]
    search.progress(f"refitting {len(tried)} pairs")

    def both_in(first, second):
        one = search.refit(fit, first.candidate)
        both = search.refit(one, second.candidate)
        good = all(stands(search, fit, both, trial, len(trials)) for trial in (first, second))
        return both.chi2 + first.price + second.price, good, [one, both]

    if search.problem.shots.contact:
        found = search.problem.at_once([partial(both_in, *pair) for pair in tried])
        found = sorted((entry for entry in found if entry[1]), key=lambda entry: entry[0])
    else:
        found = (entry for entry in (both_in(*pair) for pair in tried) if entry[1])
    for _, _, fits in found:
        return fits
    if search.problem.shots.contact:
        return []
    for first in sorted(pointing, key=lambda trial: (-(trial.gain - trial.price), trial.candidate.name))[:2]:
        if search.budget.search_over(f"what acts only through {first.candidate.name}"):
            break
        seconds = [
            trial
            for trial in search.round(first.fit).values()
            if trial.fit is not None and not trial.fails and not search.same_form(trial.candidate, first.fit.model.terms)
        ]
        if not seconds:
            continue
        second = max(seconds, key=lambda trial: (round(trial.gain - trial.price, 6), trial.candidate.name))
        if stands(search, fit, second.fit, first, len(trials)):
            return [first.fit, second.fit]
    return []


def pairs(search, fit, trials):
    """[(Try, Try)] of candidates that together point at the residual more than either alone, the best first."""
    q_now = inference.basis(np.concatenate(fit.linear.projected[1]))
    r = inference.project_out(q_now, np.concatenate(fit.linear.projected[0]))
    seen = [
        (trial, inference.project_out(q_now, np.concatenate(trial.signature)))
        for trial in trials.values()
        if trial.visible and trial.linear_gain > 0.5 * trial.price and not search.same_form(trial.candidate, fit.model.terms)
    ]
    found = []
    for place, (first, s) in enumerate(seen):
        for second, t in seen[:place]:
            if search.same_form(first.candidate, (Term(second.candidate, ()),)):
                continue
            gain = inference.least_squares(np.hstack([s, t]), r).gain
            extra = gain - max(first.linear_gain, second.linear_gain)
            if extra > max(first.price, second.price):
                ordered = sorted((first, second), key=lambda trial: -trial.linear_gain)
                found.append((gain - first.price - second.price, len(found), ordered))
    return [tuple(ordered) for _, _, ordered in sorted(found, key=lambda entry: -entry[0])]


def stands(search, before, both, one, count):
    """Is one of the last two terms of a fit worth its price beside the other, held-out data and bounds included?"""
    return passes(search, beside(search, before, both, both.model.names.index(one.candidate.name) - len(both.model.fixed)), count)


def beside(search, before, fit, index):
    """The Try of a term beside the others of a fit: against the fit without it, or against `before` where another term acts
    through it and the two are judged together."""
    entry, alone = fit.model.terms[index].candidate, before
    if not carries(fit.model, index):
        alone = search.problem.fit(fit.model.without(index), fit.starts)
    check = Try(entry, price=search.price(entry))
    search.judge(alone, entry, fit, check)
    return check


def passes(search, check, count):
    """Does a judged candidate keep every rule of acceptance, chosen among `count` of them?"""
    check.holm = min(1.0, count * check.p)
    return check.fit is not None and not search.broken(check)
