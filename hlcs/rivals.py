"""What else would explain as much: terms exchanged for better ones, and rivals that the data cannot rule out."""

from functools import partial

import numpy as np

from . import inference
from .candidates import carries
from .linear import Try
from .model import Term
from .search import EXPLAINED, MOST_TERMS, RIVAL_MARGIN, explained
from .solids import solid

DENSE = 0.05  # of the density of a body: what a fluid then does is no small matter
SAME = 0.99  # cosine above which two candidates are one entry
ALIKE = 0.95  # local cosine above which a candidate is refitted in place of a term


def reformed(search, fits, rounds):
    """(fits, rounds) of the search taken up again with another form of a law, where the form found first explains too little.

    The first term is chosen while others still hide in the residual, so it may have the wrong form, with which no second
    term then holds out. Another form is kept only if its route ends where all but noise is explained.
    """
    first = fits[-1]
    if search.problem.shots.contact or first.chi2 < EXPLAINED * first.freedom:
        return fits, rounds
    best, least = None, first.chi2 + sum(search.fee(term.candidate) for term in first.model.terms) - RIVAL_MARGIN
    for index, term in enumerate(first.model.terms):
        for entry in search.candidates:
            if entry.name == term.name or not search.same_form(entry.name, (term,)):
                continue
            search.progress(f"{entry.name} in place of {term.name}")
            rest = first.model.without(index)
            start = min((search.problem.fit(rest.with_term(Term(entry, values)), first.starts) for values in entry.starts),
                        key=lambda found: found.chi2)
            if search.out_of_bounds(Try(entry, fit=start)) or search.contradicts(start):
                continue
            found, more = search.run(start)
            last = found[-1]
            cost = last.chi2 + sum(search.fee(term.candidate) for term in last.model.terms)
            if last.chi2 < EXPLAINED * last.freedom and cost < least:
                best, least = (fits + found, rounds + more), cost
    return best or (fits, rounds)


def submerged(search, fits, rounds):
    """(fits, rounds) of a search begun with what a dense fluid does for certain, where something is missing and that is not in.

    A model that states a liquid and lacks buoyancy, added mass and drag misses three effects at once, and behind the first of
    them an imposter explains more than the second. Kept where all but noise is explained, about as cheaply as without.
    """
    base, last, around = fits[0], fits[-1], search.problem.trials[0].surroundings
    bodies = [solid(trial.body) for trial in search.problem.trials]
    known = {"buoyancy": {"fluid_density": around.fluid_density}, "added_mass": {}}
    entries = [entry for entry in search.candidates if entry.name in known and entry.name not in last.model.names]
    dense = any(around.fluid_density * body.volume > DENSE * body.mass for body in bodies)
    explains = last.chi2 < EXPLAINED * last.freedom
    if not dense or not entries or len(last.model.terms) < 1 + explains or search.problem.shots.contact:
        return fits, rounds  # one effect that explains everything is not doubted
    search.progress("in its fluid")
    model = base.model
    for entry in entries:
        numbers = {free.name: free.start for free in entry.free} | known[entry.name]
        model = model.with_term(Term(entry, tuple((free.name, numbers[free.name]) for free in entry.free)))
    found, more = search.run(search.problem.fit(model, base.starts))
    while (smaller := search.prune(found[-1], newest=0)) is not None:
        found = [*found, smaller]
    before, after = (one.chi2 + sum(search.fee(term.candidate) for term in one.model.terms) for one in (last, found[-1]))
    spare = RIVAL_MARGIN * len(entries) if explains else np.inf
    kept = found[-1].chi2 < EXPLAINED * found[-1].freedom and after < before + spare and any(
        entry.name in found[-1].model.names for entry in entries)
    return ([base, *found], rounds + more) if kept else (fits, rounds)


def exchanged(search, fits, rounds):
    """(fits, rounds) of the search taken up again from wherever a better term replaces one that stood for it.

    While an imposter stands in the model, what else is missing may not hold out.
    """
    for _ in range(MOST_TERMS):
        if search.budget.rivals_over("exchanges of an accepted effect for a better one"):
            break
        final = swapped(search, fits[-1])
        if final is fits[-1]:
            break
        if final.chi2 < final.freedom + 3 * np.sqrt(2 * final.freedom):  # nothing is left to look for
            fits = [*fits, final]
            break
        found, more = search.run(final)
        fits, rounds = fits + found, rounds + more
        if len(found) == 1:
            break
    return fits, rounds


def swapped(search, fit):
    """The fit with terms replaced by others that explain as much with fewer numbers, or more with as many; at most three."""
    for _ in range(MOST_TERMS):
        better = None
        for index, term in enumerate(fit.model.terms):
            if carries(fit.model, index):
                continue
            without, replaced = replacements(search, fit, index, 0.7, 0.0)
            for entry, other in replaced:
                if term.name in search.read and entry.name not in search.read and not explained(search.problem, other):
                    continue  # what the impacts show directly gives way only to what explains the data
                gain = (fit.chi2 - other.chi2) + search.fee(term.candidate) - search.fee(entry)
                if gain > 2.0 and not search.out_of_bounds(Try(entry, fit=other)) and not search.contradicts(other) and (
                        not search.same_form(entry.name, (term,))) and holds_out(search, without, other) and (
                        better is None or gain > better[0]):
                    better = gain, other
        if better is None:
            break
        fit = better[1]
        while (smaller := search.prune(fit, newest=0)) is not None:  # the better term may do what another was there for
            fit = smaller
    return fit


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
        if gains or alike or search.same_form(entry.name, (term,)):
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
