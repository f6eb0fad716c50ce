"""What is told of every candidate of a search: its likeness to others, its errors, and what became of it."""

import numpy as np

from hlcs.estimation.least_squares import basis, largest_cosine, project_out
from hlcs.records import Finding, Reason, untested
from hlcs.selection.held_out import fitted_error, held_out_error
from hlcs.selection.reasons import sentences


def candidate_findings(sets, places, absent):
    """One Finding a candidate of a search over sets, the accepted ones first, then by evidence; then those that were not tried.

    places: {effect of the best set: names that take its place}; absent: {name: why it was not tried}.
    """
    cosines = {name: {other: round(_cosine(sets, name, other), 4) for other in others} for name, others in places.items()}
    told = [_finding(sets, name, cosines) for name in sets.search.candidates]
    told.sort(key=lambda each: (not each.accepted, np.inf if each.evidence is None else -each.evidence, each.effect))
    return (*told, *(untested(name, Reason.NOT_TRIED(why=why)) for name, why in sorted(absent.items())))


def _finding(sets, name, cosines):
    """What became of one candidate; cosines: {effect of the best set: {name that takes its place: likeness}}."""
    search, best, problem = sets.search, sets.best, sets.search.problem
    same = set().union(*({name_of_set, *others} for name_of_set, others in cosines.items() if name in {name_of_set, *others}))
    like = cosines.get(name) or {effect: others[name] for effect, others in cosines.items() if name in others}
    alone, fitted, held = frozenset({name}), None, None
    holding = best if name in best else min((known for known in search.fits if name in known), key=search.cost, default=None)
    if holding is not None:
        fit = search.fits[holding]
        fitted, held = fitted_error(problem, fit), held_out_error(problem, sets.cross_validation, fit)
    if name in best:
        evidence = sets.worth(best, name)
    elif holding is not None:
        evidence = search.cost(frozenset()) - search.cost(holding)
    else:
        evidence = search.cost(frozenset()) - search.foreseen[alone][0].cost if alone in search.foreseen else None
    same = tuple(sorted(same - {name}))
    why = _explained(sets, name, same, holding, evidence)
    seen = _visible(search, name)
    return Finding(name, fitted, held, evidence, name in best, same, why.why, like, seen, reason=why.reason)


def set_label(candidate, others):
    """The set of look-alikes that a candidate and some of its rivals belong to, in brackets, or nothing."""
    return f" ({candidate.alike})" if candidate.alike and any(other.alike == candidate.alike for other in others) else ""


def _cosine(sets, name, other):
    """Likeness of an effect of the best set and of one that takes its place."""
    search, best = sets.search, sets.best
    holding = next(members for members in sets.tied[1:] if other in members and name not in members)
    both = (search.fits[best], name), (search.fits[holding], other)
    return largest_cosine(*(_own_columns(search.problem, *each) for each in both))


def _own_columns(problem, fit, name):
    """Projected signature of one effect of a fit, recordings in one column (n, p): of one without numbers, all that it does."""
    index, columns = fit.model.terms_named(name), np.concatenate(fit.linearization.projected[1])
    its = fit.numbers_of(index)
    own, rest = columns[:, its], basis(np.delete(columns, its, axis=1))
    if not own.shape[1]:
        whole = problem.signature(fit.model.without(index), fit.initial_states, fit.model)
        parts = zip(fit.linearization.state_bases, whole, strict=True)
        own = np.concatenate([project_out(q, part) for q, part in parts])[:, None]
    return project_out(rest, own)


def _explained(sets, name, same, holding, evidence):
    """The Explanation of what became of a candidate."""
    search, best, entry = sets.search, sets.best, sets.search.candidates[name]
    at = f" ({entry.family})" if entry.family else ""
    label = set_label(entry, [search.candidates[other] for other in same])
    if name in best:
        rest, fit, falls = sets.fit(sets.without(best, name)), search.fits[best], sets.held_out(best, name).directions
        gain = rest.chi2 - fit.chi2
        held_out = f"; held-out error falls by {' and '.join(f'{100 * fall:.0f} %' for fall in falls)}" if falls else ""
        others = f"; cannot be told from {', '.join(same)}{label}" if same else ""
        return Reason.ACCEPTED(at=at, gain=gain, price=gain - evidence, held_out=held_out, same=others)
    if same:
        return Reason.NOT_TOLD_APART(others=", ".join(other for other in same if other in best), at=at, label=label)
    if evidence is None:
        return Reason.INVISIBLE()
    better = [other for other in sorted(best) if entry.alike and search.candidates[other].alike == entry.alike]
    if better and evidence > 0:
        return Reason.OTHER_FORM(form=entry.alike, better=better[0])
    broken = sets.broken(holding, name) if holding is not None and evidence > 0 else []
    if broken:
        return Reason.SUSPECTED(why=sentences(broken))
    if evidence > 0:
        return Reason.EXPLAINED_TOO(at=at)
    return Reason.NOT_SEEN(at=at, why=f"it would cost {-evidence:.1f} more than it explains")


def _visible(search, name):
    """The smallest value of a one-number candidate that these data would have shown nine times in ten; empty where it is beyond
    what is plausible."""
    entry, linear = search.candidates[name], search.base_model
    if len(entry.free) != 1 or entry.absent is None or name not in linear.entries or not linear.visible(name):
        return ""
    (free,), information = entry.free, linear.information(name)
    required = search.price({name}) + np.log1p(information)
    size = (np.sqrt(required) + 1.28) * free.spread / np.sqrt(information)
    if size > max(free.high - free.null, free.null - free.low):
        return ""
    return f"{free.name} {size:.2g}{'' if free.unit == '1' else ' ' + free.unit} from {free.null:g}"
