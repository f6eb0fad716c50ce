"""What else would explain as much: candidates put in the place of a term, and rivals that the data cannot rule out."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import stats

from hlcs.estimation import inference
from hlcs.estimation.linearization import Fit, Try
from hlcs.selection.eligibility import carries
from hlcs.selection.search import EXPLAINED, RIVAL_MARGIN
from hlcs.simulation.model import Term

SAME = 0.99  # cosine above which two candidates are one entry
ALIKE = 0.95  # local cosine above which a candidate is refitted in place of a term


@dataclass
class Place:
    """The place of one term of a fit: the fit without it, how candidates look there, and the fits with them in it."""

    without: Fit
    looks: dict  # candidate -> (signature on top of the fit without the term, (cosine with the term, numbers) or None)
    fits: dict  # candidate -> Fit


def place_of(search, fit, index):
    """The Place of a term; made once."""
    key = fit.model.terms, index
    if key not in search.places:
        search.places[key] = Place(search.problem.fit(fit.model.without(index), fit.starts), {}, {})
    return search.places[key]


def replacements(search, fit, index, share, margin):
    """(fit without term `index`, [(candidate, fit with it in place of the term)]).

    Candidates whose linear gain from the null value comes near that of the term (`share` of it less `margin`), whose law
    looks like the term's where the data are, and other forms of the same law.
    """
    place = place_of(search, fit, index)
    needed = share * (place.without.chi2 - fit.chi2 - search.fee(fit.model.terms[index].candidate) - margin)
    likely = promising(search, fit, index, place, needed)
    done = sum(entry.name in place.fits for entry, _ in likely)
    most = search.budget.refits(search.problem, max(len(likely) - done, 1))
    if most < len(likely) - done:
        search.budget.note(f"refits of rivals but the {most} most likely")
    likely = likely[: done + most]
    search.progress("rivals " + ", ".join(entry.name for entry, _ in likely))
    search.problem.at_once([partial(put_in, search, fit, index, place, *one) for one in likely if one[0].name not in place.fits])
    found = [(entry, place.fits[entry.name]) for entry, _ in likely]
    return place.without, [(entry, other) for entry, other in found if np.isfinite(other.chi2)]


def promising(search, fit, index, place, needed):
    """[(candidate, its numbers that imitate the term or None)] worth a refit in the place of a term; fitted ones first."""
    term, without = fit.model.terms[index], place.without
    r = np.concatenate(without.linear.projected[0])
    q_now = inference.basis(np.concatenate(without.linear.projected[1]))
    r = inference.project_out(q_now, r)
    entries = [
        entry
        for entry in search.candidates
        if entry.name not in fit.model.names and not search.same_form(entry, without.model.terms)
    ]
    if search.budget.rivals_over("rivals that are not another form of an accepted law"):
        entries = [entry for entry in entries if search.same_form(entry, (term,)) or entry.name in place.fits]
    unseen = [entry for entry in entries if entry.name not in place.looks]
    work = [partial(search.screen, without, entry) for entry in unseen]
    if search.problem.shots.contact:
        work += [partial(search.local, fit, index, entry) for entry in unseen]
    seen = search.problem.at_once(work)
    near = seen[len(unseen) :] or [None] * len(unseen)
    place.looks |= {entry.name: both for entry, *both in zip(unseen, seen[: len(unseen)], near, strict=True)}
    found = []
    for entry in entries:
        signature, here = place.looks[entry.name]
        if signature is None:
            continue
        s = inference.project_out(q_now, np.concatenate(signature))
        known = search.refitted.get((without.model.terms, entry.name))
        gain = max(inference.least_squares(s, r).gain, without.chi2 - known.chi2 if known is not None else 0.0)
        gain -= search.fee(entry)
        alike = here is not None and here[0] > ALIKE
        if gain >= needed or alike or search.same_form(entry, (term,)) or entry.name in place.fits:
            found.append((entry.name not in place.fits, -gain, entry, here[1] if alike else None))
    return [(entry, numbers) for _, _, entry, numbers in sorted(found, key=lambda one: one[:2])]


def put_in(search, fit, index, place, entry, numbers):
    """Fit a candidate in the place of a term and keep it there: from numbers that imitate the term, or on top of what is left."""

    def beside(numbers):  # with the numbers and starts that the others have beside the term: an equal law needs no others
        return search.problem.fit(fit.model.without(index).with_term(Term(entry, tuple(numbers.items()))), fit.starts)

    fits = [beside(numbers)] if numbers is not None else []
    if numbers is None or fits[0].chi2 - fit.chi2 > 12.0:
        fits.append(search.refit(place.without, entry))
    if search.problem.shots.contact and min(one.chi2 for one in fits) - fit.chi2 > 12.0:
        fits.append(beside(entry.absent or dict(entry.starts[0])))
    place.fits[entry.name] = min(fits, key=lambda found: found.chi2)


def rivals(search, fit, inflation):
    """For every term of the final fit: [(name, fit with it in place of the term)] that these data cannot rule out.

    inflation: chi2 per degree of freedom where the final model is not adequate (else 1); differences smaller than
    what stays unexplained decide nothing.
    """
    found = []
    for index, term in enumerate(fit.model.terms):
        if carries(fit.model, index):
            found.append(other_forms(search, fit, index, inflation))
            continue
        share = 0.5  # through contacts linear gains fall short too: derivatives are taken over wide steps there
        without, replaced = replacements(search, fit, index, share, RIVAL_MARGIN * inflation)
        mine = without.chi2 - fit.chi2 - search.fee(term.candidate)
        keep = []
        for entry, other in replaced:
            gain = without.chi2 - other.chi2 - search.fee(entry)
            if search.out_of_bounds(other) or search.contradicts(other):
                continue
            close = mine - gain <= RIVAL_MARGIN * inflation and gain > 0
            cosine = inference.cosine(own_columns(fit, index), own_columns(other, -1))
            if search.same_form(entry, (term,)) and inflation > 1 and cosine > 0.9 and gain > 0.5 * mine:
                close = True  # a form is not decided by differences smaller than what stays unexplained
            if inflation > 1 and not holds_out(search, without, other):
                continue
            # alike, and it explains the data too: what differs between them is smaller than what their laws leave out
            same = cosine > SAME and gain > 0 and other.chi2 < EXPLAINED * max(other.freedom, fit.chi2)
            if same or close and not beaten(search, fit, other, inflation):
                keep.append((entry.name, other, cosine))
        found.append(keep)
    return found


def other_forms(search, fit, index, inflation):
    """Rivals of a term that another one acts through: other forms of the same law, each put straight in its place."""
    term, keep = fit.model.terms[index], []
    for entry in search.candidates:
        if entry.name in fit.model.names or not search.same_form(entry, (term,)):
            continue
        search.progress(f"rival {entry.name}")
        rest = fit.model.without(index)
        fits = search.problem.at_once(
            [partial(search.problem.fit, rest.with_term(Term(entry, values)), fit.starts) for values in entry.starts]
        )
        other = min(fits, key=lambda found: found.chi2)
        behind = other.chi2 + search.fee(entry) - fit.chi2 - search.fee(term.candidate)
        if search.out_of_bounds(other) or search.contradicts(other) or behind > RIVAL_MARGIN * inflation:
            continue
        if not beaten(search, fit, other, inflation):
            keep.append((entry.name, other, inference.cosine(own_columns(fit, index), own_columns(other, -1))))
    return keep


def holds_out(search, before, other):
    """Does the newest term of `other` lower the held-out error, in each direction where recordings are few?"""
    if not search.folds.possible:
        return True
    trial = Try(other.model.terms[-1].candidate)
    search.judge(before, None, other, trial)
    return (min(trial.directions) if search.folds.few else trial.falls) > 0.02


def beaten(search, fit, other, inflation):
    """Does `other` predict recordings that it was not fitted to worse than `fit`, at p < 0.01?

    The difference of the two sums of squares is set beside its own spread, so that neither law need be the true one (Q. H. Vuong,
    Econometrica 57 (1989) 307). Never where the unexplained rest is more than noise.
    """
    if not search.folds.possible or inflation > 1:
        return False
    a, b = (np.concatenate(search.folds.residuals(one)) for one in (other, fit))
    spread = 2 * np.linalg.norm(a - b)
    return bool(spread > 0 and (a @ a - b @ b) / spread > stats.norm.isf(0.01) and other.chi2 - fit.chi2 > 1.0)


def own_columns(fit, index):
    """Projected signature of one term of a fit, all recordings in one column (n, p)."""
    counts = [len(term.candidate.free) for term in fit.model.terms]
    index = index % len(counts)
    start = sum(counts[:index])
    columns = np.concatenate(fit.linear.projected[1])
    others = np.delete(columns, np.arange(start, start + counts[index]), axis=1)
    return inference.project_out(inference.basis(others), columns[:, start : start + counts[index]])
