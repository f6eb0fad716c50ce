"""What else would explain as much: terms exchanged for better ones, and rivals that the data cannot rule out."""

import numpy as np

from . import inference
from .search import MOST_TERMS, RIVAL_MARGIN, Try


def swapped(search, fit):
    """The fit with terms replaced by others that explain as much with fewer numbers, or more with as many; at most three."""
    for _ in range(MOST_TERMS):
        better = None
        for index, term in enumerate(fit.model.terms):
            without = search.problem.fit(fit.model.without(index), fit.starts)
            for entry, other in replacements(search, without, fit, term):
                gain = (fit.chi2 - other.chi2) + search.fee(term.candidate) - search.fee(entry)
                if gain > 2.0 and not search.out_of_bounds(Try(entry, fit=other)) and not search.contradicts(other) and (
                        holds_out(search, without, other)) and (better is None or gain > better[0]):
                    better = gain, other
        if better is None:
            return fit
        fit = better[1]
    return fit


def replacements(search, without, fit, term):
    """[(candidate, fit with it in place of the term)] for candidates whose linear gain comes near the term's."""
    r = np.concatenate(without.linear.projected[0])
    q_now = inference.basis(np.concatenate(without.linear.projected[1]))
    r = inference.project_out(q_now, r)
    needed = 0.7 * (without.chi2 - fit.chi2 - search.fee(term.candidate))
    found = []
    for entry in search.candidates:
        if entry.name in fit.model.names or search.same_form(entry.name, fit.model.terms):
            continue
        signature = search.screen(without, entry)
        if signature is None:
            continue
        s = inference.project_out(q_now, np.concatenate(signature))
        if inference.least_squares(s, r).gain - search.fee(entry) > needed:
            found.append((entry, search.refit(without, entry)))
    return found


def rivals(search, fit, inflation):
    """For every term of the final fit: [(name, fit with it in place of the term)] that these data cannot rule out.

    inflation: chi2 per degree of freedom where the final model is not adequate (else 1); differences smaller than
    what stays unexplained decide nothing.
    """
    found = []
    for index, term in enumerate(fit.model.terms):
        without = search.problem.fit(fit.model.without(index), fit.starts)
        r = np.concatenate(without.linear.projected[0])
        q_now = inference.basis(np.concatenate(without.linear.projected[1]))
        r = inference.project_out(q_now, r)
        mine = without.chi2 - fit.chi2 - search.fee(term.candidate)
        keep = []
        for entry in search.candidates:
            if entry.name in fit.model.names:
                continue
            signature = search.screen(without, entry)
            if signature is None:
                continue
            s = inference.project_out(q_now, np.concatenate(signature))
            same_form = search.same_form(entry.name, (term,))
            linear = inference.least_squares(s, r).gain
            if linear < (0.8 if search.problem.shots.contact else 0.5) * (mine - RIVAL_MARGIN * inflation) and not same_form:
                continue
            search.progress(f"rival {entry.name}")
            other = search.refit(without, entry)
            gain = without.chi2 - other.chi2 - search.fee(entry)
            trial = Try(entry, fit=other)
            if search.out_of_bounds(trial) or search.contradicts(other):
                continue
            close = mine - gain <= RIVAL_MARGIN * inflation and gain > 0
            cosine = inference.cosine(own_columns(fit, index), own_columns(other, -1))
            if same_form and inflation > 1 and cosine > 0.9 and gain > 0.5 * mine:
                close = True  # a form is not decided by differences smaller than what stays unexplained
            if inflation > 1 and not holds_out(search, without, other):
                continue
            if close and not beaten(search, fit, other, inflation):
                keep.append((entry.name, other, cosine))
        found.append(keep)
    return found


def holds_out(search, before, other):
    """Does the newest term of `other` lower the held-out error, in each direction where recordings are few?"""
    if not search.folds.possible:
        return True
    trial = Try(other.model.terms[-1].candidate)
    search.judge(before, None, other, trial)
    return (min(trial.directions) if search.folds.few else trial.falls) > 0.02


def beaten(search, fit, other, inflation):
    """Is `other` worse than `fit` on held-out data at p < 0.01, with the unexplained rest counted as noise?"""
    if not search.folds.possible or inflation > 1:
        return False
    trial = Try(fit.model.terms[-1].candidate)
    search.judge(other, None, fit, trial)
    return trial.p < 0.01 and other.chi2 - fit.chi2 > 1.0


def own_columns(fit, index):
    """Projected signature of one term of a fit, all recordings in one column (n, p)."""
    counts = [len(term.candidate.free) for term in fit.model.terms]
    index = index % len(counts)
    start = sum(counts[:index])
    columns = np.concatenate(fit.linear.projected[1])
    others = np.delete(columns, np.arange(start, start + counts[index]), axis=1)
    return inference.project_out(inference.basis(others), columns[:, start:start + counts[index]])
