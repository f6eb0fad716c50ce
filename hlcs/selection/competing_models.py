"""What else would explain as much: candidates put in the place of a term, and competing models that the data cannot rule out."""

from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy import stats

from hlcs.estimation.least_squares import basis, largest_cosine, least_squares, project_out
from hlcs.estimation.linearization import Fit
from hlcs.selection.eligibility import carries
from hlcs.selection.search import COMPETITOR_MARGIN, EXPLAINED
from hlcs.simulation.model import Term

SAME = 0.99  # cosine above which two candidates are one entry
ALIKE = 0.95  # local cosine above which a candidate is refitted in place of a term
WORSE = 12.0  # of chi2 by which an imitation may be worse than the term before other values to begin with are tried


@dataclass
class Replacement:
    """What may stand in the place of one term of a fit."""

    without: Fit  # the fit without the term
    screened: dict = field(default_factory=dict)  # candidate -> (signature on top of that fit, likeness to the term or None)
    fits: dict = field(default_factory=dict)  # candidate -> Fit with it in the place of the term


def replacement_of(search, fit, index):
    """The Replacement of a term; made once."""
    key = fit.model.terms, index
    if key not in search.replacements:
        search.replacements[key] = Replacement(search.problem.fit(fit.model.without(index), fit.initial_states))
    return search.replacements[key]


def replacements(search, fit, index, share, margin):
    """(fit without term `index`, [(candidate, fit with it in place of the term)]).

    Candidates whose linear gain from the null value comes near that of the term (`share` of it less `margin`), whose law
    looks like the term's where the data are, and other forms of the same law.
    """
    place = replacement_of(search, fit, index)
    needed = share * (place.without.chi2 - fit.chi2 - search.complexity_penalty(fit.model.terms[index].candidate) - margin)
    likely = promising(search, fit, index, place, needed)
    done = sum(entry.name in place.fits for entry, _ in likely)
    most = search.budget.affordable(max(len(likely) - done, 1))
    if most < len(likely) - done:
        search.budget.leave_out(f"refits of rivals but the {most} most likely")
    likely = likely[: done + most]
    search.progress("rivals " + ", ".join(entry.name for entry, _ in likely))
    search.problem.batched(
        [partial(put_in, search, fit, index, place, *each) for each in likely if each[0].name not in place.fits]
    )
    fits = [(entry, place.fits[entry.name]) for entry, _ in likely]
    return place.without, [(entry, other) for entry, other in fits if np.isfinite(other.chi2)]


def promising(search, fit, index, place, needed):
    """[(candidate, its numbers that imitate the term or None)] worth a refit in the place of a term; fitted ones first."""
    term, without = fit.model.terms[index], place.without
    r, q = without.linearization.residual
    entries = [
        entry
        for entry in search.candidates
        if entry.name not in fit.model.names and not search.same_form(entry, without.model.terms)
    ]
    if search.budget.ends_comparison("rivals that are not another form of an accepted law"):
        entries = [entry for entry in entries if search.same_form(entry, (term,)) or entry.name in place.fits]
    unseen = [entry for entry in entries if entry.name not in place.screened]
    work = [partial(search.screen, without, entry) for entry in unseen]
    if search.problem.simulator.contact:
        work += [partial(search.likeness, fit, index, entry) for entry in unseen]
    signatures = search.problem.batched(work)
    near = signatures[len(unseen) :] or [None] * len(unseen)
    place.screened |= {entry.name: both for entry, *both in zip(unseen, signatures[: len(unseen)], near, strict=True)}
    ranked = []  # (not fitted yet, minus its gain, the candidate, the numbers that imitate the term)
    for entry in entries:
        signature, likeness = place.screened[entry.name]
        if signature is None:
            continue
        s = project_out(q, np.concatenate(signature))
        known = search.refitted.get((without.model.terms, entry.name))
        gain = max(least_squares(s, r).gain, without.chi2 - known.chi2 if known is not None else 0.0)
        gain -= search.complexity_penalty(entry)
        alike = likeness is not None and likeness[0] > ALIKE
        if gain >= needed or alike or search.same_form(entry, (term,)) or entry.name in place.fits:
            ranked.append((entry.name not in place.fits, -gain, entry, likeness[1] if alike else None))
    return [(entry, numbers) for _, _, entry, numbers in sorted(ranked, key=lambda each: each[:2])]


def put_in(search, fit, index, place, entry, numbers):
    """Fit a candidate in the place of a term and keep it there: from numbers that imitate the term, or on top of what is left."""

    def beside(numbers):  # with the numbers and states that the others have beside the term: an equal law needs no others
        return search.problem.fit(fit.model.without(index).with_term(Term(entry, tuple(numbers.items()))), fit.initial_states)

    fits = [beside(numbers)] if numbers is not None else []
    if numbers is None or fits[0].chi2 - fit.chi2 > WORSE:
        fits.append(search.refit(place.without, entry))
    if search.problem.simulator.contact and min(other.chi2 for other in fits) - fit.chi2 > WORSE:
        fits.append(beside(entry.absent or dict(entry.starts[0])))
    place.fits[entry.name] = min(fits, key=lambda other: other.chi2)


def competing_models(search, fit, inflation):
    """For every term of the final fit: [(name, fit with it in place of the term, cosine)] that these data cannot rule out.

    inflation: chi2 per degree of freedom where the final model is not adequate (else 1); differences smaller than
    what stays unexplained decide nothing.
    """
    return [
        (other_forms if carries(fit.model, index) else competitors)(search, fit, index, inflation)
        for index in range(len(fit.model.terms))
    ]


def competitors(search, fit, index, inflation):
    """[(name, fit with it in place of the term, cosine)] of the candidates that compete with a term."""
    term, kept = fit.model.terms[index], []
    share = 0.5  # through contacts linear gains fall short too: derivatives are taken over wide steps there
    without, replaced = replacements(search, fit, index, share, COMPETITOR_MARGIN * inflation)
    gain_of_term = without.chi2 - fit.chi2 - search.complexity_penalty(term.candidate)
    for entry, other in replaced:
        gain = without.chi2 - other.chi2 - search.complexity_penalty(entry)
        if search.out_of_bounds(other) or search.contradicts(other):
            continue
        close = gain_of_term - gain <= COMPETITOR_MARGIN * inflation and gain > 0
        cosine = largest_cosine(own_columns(fit, index), own_columns(other, -1))
        if search.same_form(entry, (term,)) and inflation > 1 and cosine > 0.9 and gain > 0.5 * gain_of_term:
            close = True  # a form is not decided by differences smaller than what stays unexplained
        if inflation > 1 and not holds_out(search, without, other):
            continue
        # alike, and it explains the data too: what differs between them is smaller than what their laws leave out
        same = cosine > SAME and gain > 0 and other.chi2 < EXPLAINED * max(other.freedom, fit.chi2)
        if same or close and not beaten(search, fit, other, inflation):
            kept.append((entry.name, other, cosine))
    return kept


def other_forms(search, fit, index, inflation):
    """The same for a term that another one acts through: other forms of the same law, each put straight in its place."""
    term, kept = fit.model.terms[index], []
    for entry in search.candidates:
        if entry.name in fit.model.names or not search.same_form(entry, (term,)):
            continue
        search.progress(f"rival {entry.name}")
        other = search.best_fit(fit.model.without(index), entry, entry.starts, fit.initial_states)
        behind = other.chi2 + search.complexity_penalty(entry) - fit.chi2 - search.complexity_penalty(term.candidate)
        if search.out_of_bounds(other) or search.contradicts(other) or behind > COMPETITOR_MARGIN * inflation:
            continue
        if not beaten(search, fit, other, inflation):
            kept.append((entry.name, other, largest_cosine(own_columns(fit, index), own_columns(other, -1))))
    return kept


def holds_out(search, before, other):
    """Does the newest term of `other` lower the held-out error, in each direction where recordings are few?"""
    if not search.cross_validation.possible:
        return True
    trial = search.judged(before, other.model.terms[-1].candidate, other)
    return (min(trial.directions) if search.cross_validation.few else trial.falls) > 0.02


def beaten(search, fit, other, inflation):
    """Does `other` predict recordings that it was not fitted to worse than `fit`, at p < 0.01?

    The difference of the two sums of squares is set beside its own spread, so that neither law need be the true one (Q. H. Vuong,
    Econometrica 57 (1989) 307). Never where the unexplained rest is more than noise.
    """
    if not search.cross_validation.possible or inflation > 1:
        return False
    a, b = (np.concatenate(search.cross_validation.residuals(each)) for each in (other, fit))
    spread = 2 * np.linalg.norm(a - b)
    return bool(spread > 0 and (a @ a - b @ b) / spread > stats.norm.isf(0.01) and other.chi2 - fit.chi2 > 1.0)


def own_columns(fit, index):
    """Projected signature of one term of a fit, all recordings in one column (n, p)."""
    columns, its = np.concatenate(fit.linearization.projected[1]), fit.numbers_of(index)
    return project_out(basis(np.delete(columns, its, axis=1)), columns[:, its])
