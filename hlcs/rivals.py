"""What else would explain as much: candidates put in the place of a term, and rivals that the data cannot rule out."""

from functools import partial

import numpy as np

from . import inference
from .candidates import carries
from .linear import Try
from .model import Term
from .search import EXPLAINED, RIVAL_MARGIN

SAME = 0.99  # cosine above which two candidates are one entry
ALIKE = 0.95  # local cosine above which a candidate is refitted in place of a term


def replacements(search, fit, index, share, margin):
    """(fit without term `index`, [(candidate, fit with it in place of the term)]).

    Candidates whose linear gain from the null value comes near that of the term (`share` of it less `margin`), whose law
    looks like the term's where the data are, and other forms of the same law.
    """
    term, key = fit.model.terms[index], (fit.model.terms, index)
    if key not in search.stripped:
        search.stripped[key] = search.problem.fit(fit.model.without(index), fit.starts), {}
    without, looks = search.stripped[key]
    r = np.concatenate(without.linear.projected[0])
    q_now = inference.basis(np.concatenate(without.linear.projected[1]))
    r = inference.project_out(q_now, r)
    needed = share * (without.chi2 - fit.chi2 - search.fee(term.candidate) - margin)
    entries = [entry for entry in search.candidates
               if entry.name not in fit.model.names and not search.same_form(entry.name, without.model.terms)]
    if search.budget.rivals_over("rivals that are not another form of an accepted law"):
        entries = [entry for entry in entries if search.same_form(entry.name, (term,)) or (*key, entry.name) in search.replaced]
    unseen = [entry for entry in entries if entry.name not in looks]
    work = [partial(search.screen, without, entry) for entry in unseen]
    if search.problem.shots.contact:
        work += [partial(search.local, fit, index, entry) for entry in unseen]
    seen = search.problem.at_once(work)
    near = seen[len(unseen):] or [None] * len(unseen)
    looks |= {entry.name: both for entry, *both in zip(unseen, seen[:len(unseen)], near, strict=True)}
    promising = []
    for entry in entries:
        signature, here = looks[entry.name]
        if signature is None:
            continue
        s = inference.project_out(q_now, np.concatenate(signature))
        known = search.refitted.get((without.model.terms, entry.name))
        gain = max(inference.least_squares(s, r).gain, without.chi2 - known.chi2 if known is not None else 0.0)
        gains = gain - search.fee(entry) >= needed
        alike = here is not None and here[0] > ALIKE
        if gains or alike or search.same_form(entry.name, (term,)) or (*key, entry.name) in search.replaced:
            promising.append((entry, here if alike else None, gain - search.fee(entry)))
    promising.sort(key=lambda one: ((*key, one[0].name) not in search.replaced, -one[2]))  # those fitted already cost nothing
    done = sum((*key, entry.name) in search.replaced for entry, _, _ in promising)
    most = search.budget.refits(search.problem, max(len(promising) - done, 1))
    if most < len(promising) - done:
        search.budget.note(f"refits of rivals but the {most} most likely")
    promising = [(entry, here) for entry, here, _ in promising[:done + most]]

    def in_place(entry, here):
        if (*key, entry.name) not in search.replaced:
            def beside(numbers):  # with the numbers and starts that the others have beside the term: an equal law needs no others
                return search.problem.fit(fit.model.without(index).with_term(Term(entry, tuple(numbers.items()))), fit.starts)

            fits = [beside(here[1])] if here is not None else []
            if here is None or fits[0].chi2 - fit.chi2 > 12.0:
                fits.append(search.refit(without, entry))
            if search.problem.shots.contact and min(one.chi2 for one in fits) - fit.chi2 > 12.0:
                fits.append(beside(entry.absent or dict(entry.starts[0])))
            search.replaced[*key, entry.name] = min(fits, key=lambda found: found.chi2)
        return entry, search.replaced[*key, entry.name]

    search.progress("rivals " + ", ".join(entry.name for entry, _ in promising))
    found = search.problem.at_once([partial(in_place, entry, here) for entry, here in promising])
    return without, [(entry, other) for entry, other in found if np.isfinite(other.chi2)]


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
            if search.out_of_bounds(Try(entry, fit=other)) or search.contradicts(other):
                continue
            close = mine - gain <= RIVAL_MARGIN * inflation and gain > 0
            cosine = inference.cosine(own_columns(fit, index), own_columns(other, -1))
            if search.same_form(entry.name, (term,)) and inflation > 1 and cosine > 0.9 and gain > 0.5 * mine:
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
        if entry.name in fit.model.names or not search.same_form(entry.name, (term,)):
            continue
        search.progress(f"rival {entry.name}")
        rest = fit.model.without(index)
        fits = search.problem.at_once([partial(search.problem.fit, rest.with_term(Term(entry, values)), fit.starts)
                                       for values in entry.starts])
        other = min(fits, key=lambda found: found.chi2)
        behind = other.chi2 + search.fee(entry) - fit.chi2 - search.fee(term.candidate)
        if search.out_of_bounds(Try(entry, fit=other)) or search.contradicts(other) or behind > RIVAL_MARGIN * inflation:
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
