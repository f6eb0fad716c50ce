"""What is told of every candidate of a search: its likeness to others, its errors, and what became of it."""

import numpy as np

from hlcs.estimation.least_squares import basis, largest_cosine, project_out
from hlcs.records import Finding, Reason, untested
from hlcs.selection.eligibility import lacks_drag
from hlcs.selection.held_out import fitted_error, held_out_error
from hlcs.selection.prediction import AMPLITUDE
from hlcs.selection.preview import misfit
from hlcs.selection.thresholds import FALL

LAWS = ("fluid", "contact", "own")  # beginnings of groups whose members a model lacks; others are wrong numbers and readings


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
    groups = ({effect, *others} for effect, others in cosines.items())
    same = tuple(sorted(set().union(*(group for group in groups if name in group)) - {name}))
    like = cosines.get(name) or {effect: others[name] for effect, others in cosines.items() if name in others}
    alone = frozenset({name})
    known = (known for known in search.fits if name in known)
    holding = best if name in best else _beside(sets, name) or min(known, key=sets.cost, default=None)
    fit = search.fits.get(holding)
    if name in best:
        evidence = sets.worth(best, name)
    elif holding is not None:
        evidence = search.cost(frozenset()) - search.cost(holding)
    else:
        evidence = search.cost(frozenset()) - _foreseen(search, alone).cost if alone in search.foreseen else None
    left = remains(sets, name, holding)
    why = _explained(sets, name, same, holding, evidence, left)
    entry, fluid = search.candidates[name], getattr(getattr(problem.trials[0], "surroundings", None), "fluid", "air")
    return Finding(
        effect=name,
        fitted=fit and fitted_error(problem, fit),
        held_out=fit and held_out_error(problem, sets.cross_validation, fit),
        evidence=evidence,
        accepted=name in best,
        same_as=same,
        cosines=like,
        visible_from=_visible(search, name),
        called=entry.called(fluid),
        lacking=entry.group.startswith(LAWS),
        remains=left,
        **why._asdict(),
    )


def _beside(sets, name):
    """The best set with a candidate beside it, where no set explains the data and that one costs less; None if it does not."""
    beside = sets.best | {name}
    helps = beside in sets.search.fits and sets.cost(beside) < sets.cost(sets.best)
    return beside if helps and sets.overdispersion > 1 else None


def remains(sets, name, holding):
    """What is left with a candidate: {effects, numbers (how many), chi2_per_freedom, error, foreseen}, {} where nothing is known.

    Of the best set that it is in, or of another that does as well; else with the candidate alone, fitted or foreseen; else of
    `holding`, the cheapest set that it was fitted in.
    """
    search, alone = sets.search, frozenset({name})
    members = next((members for members in sets.tied if name in members), _beside(sets, name))
    if members is None:
        members = alone if alone in search.fits or alone in search.foreseen else holding
    if members is None:
        return {}
    count = sum(len(search.candidates[member].free) for member in members)
    if fit := search.fits.get(members):
        chi2, error, freedom = fit.chi2, fitted_error(search.problem, fit), fit.freedom
    else:
        fit = (proposal := _foreseen(search, members)).parent
        chi2, error, freedom = max(misfit(fit) - proposal.fall, 0.0), None, max(fit.freedom + len(fit.estimate) - count, 1)
    left = {"effects": sorted(members), "numbers": count, "chi2_per_freedom": chi2 / freedom, "error": error}
    return left | {"foreseen": members not in search.fits} if np.isfinite(chi2) else {}


def _foreseen(search, members):
    """The Proposal of a set that was not fitted: by the model under test where that foresees it, since from a fit of other
    effects the way back to where these are not is long, and slopes promise what no fit would find."""
    there = search.models.get(frozenset())
    if there and there.foresees(members):
        return there.proposal(members)
    return search.foreseen[members]


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
        own = np.concatenate(fit.linearization.without_states(whole))[:, None]
    return project_out(rest, own)


def _explained(sets, name, same, holding, evidence, left):
    """The Explanation of what became of a candidate."""
    search, best, entry = sets.search, sets.best, sets.search.candidates[name]
    at = f" ({entry.family})" if entry.family else ""
    label = set_label(entry, [search.candidates[other] for other in same])
    if name in best:
        rest, fit, falls = sets.fit(sets.without(best, name)), search.fits[best], sets.held_out(best, name).directions
        gain = rest.chi2 - fit.chi2
        held_out = f"; held-out error falls by {' and '.join(f'{100 * fall:.0f} %' for fall in falls)}" if falls else ""
        others = f"; cannot be told from {', '.join(same)}{label}" if same else ""
        if name in search.implied and gain < search.odds:
            return Reason.IMPLIED(at=at, gain=gain, odds=search.odds, same=others)
        return Reason.ACCEPTED(at=at, gain=gain, price=_price(search, name, gain - evidence), held_out=held_out, same=others)
    if same:
        return Reason.NOT_TOLD_APART(others=", ".join(other for other in same if other in best), at=at, label=label)
    if evidence is None:
        if lacks_drag(entry, search.fits[best].model.kinds):
            return Reason.NO_DRAG()
        if not entry.through_drag and name not in search.models[frozenset()].entries:
            return Reason.NOT_TRIED(why="nothing can be simulated with it beside the model as it is")
        short = _short_beside(search, best, name)  # of what acts through a drag that was found
        return Reason.NOT_SEEN(at=at, why=short) if short else Reason.INVISIBLE()
    better = [other for other in sorted(best) if entry.alike and search.candidates[other].alike == entry.alike]
    if better and evidence > 0:
        return Reason.OTHER_FORM(form=entry.alike, better=better[0])
    if holding is not None and evidence > 0 and (broken := sets.broken(holding, name)):
        beside = f", beside {_names(holding - {name})}" if len(holding) > 1 else ""
        return Reason.SUSPECTED(why=broken.why + beside)
    if evidence > 0 and (why := _adds_nothing(sets, name, holding)):
        return Reason.NOT_SEEN(at=at, why=why)
    if evidence > 0:
        return Reason.EXPLAINED_TOO(at=at, why=_leaves(sets, name, left))
    if why := _outside(search, name):
        return Reason.BEYOND_ITS_LAW(at=at, why=why)
    base, alone = search.fits[frozenset()], frozenset({name})
    gain = misfit(base) - misfit(search.fits[holding]) if holding is not None else search.foreseen[alone].fall
    return Reason.NOT_SEEN(at=at, why=_too_little(gain, -evidence))


def _price(search, name, price):
    """What an accepted effect costs, in words."""
    if name in search.implied:
        return ", and what the file states implies it"
    if not np.isfinite(price):
        return ", and the others alone would need numbers that cannot be"
    without = f", and what is improbable without it (numbers, starts that must be tuned) costs {-price:.0f} more than it does"
    return f" for a price of {price:.0f}" if price > -0.5 else without


def _names(effects):
    return " and ".join(sorted(effects))


def _too_little(gain, short):
    """What is said where the misfit would fall by `gain`, and by `short` too little for its price."""
    return f"the misfit would fall by {max(gain, 0.0):.1f}, which is {short:.1f} less than the price of it"


def _short_beside(search, best, name):
    """Why a candidate that is foreseen beside the best set alone is not seen; "" where it is not foreseen, or of use there."""
    if (beside := best | {name}) not in search.foreseen:
        return ""
    proposal = search.foreseen[beside]
    gain, short = misfit(search.fits[best]) - misfit(proposal.parent) + proposal.fall, proposal.cost - search.cost(best)
    return f"beside {_names(best)} " + _too_little(gain, short) if short > 0 else ""


def _adds_nothing(sets, name, holding):
    """Why a candidate that was fitted beside others alone is not seen, though they explain much; "" where it does explain."""
    search, alone, empty = sets.search, frozenset({name}), frozenset()
    if holding is None or len(holding) == 1:
        return ""
    foreseen = search.foreseen[alone].cost if alone in search.foreseen else np.inf
    if min(search.cost(alone) if alone in search.fits else np.inf, foreseen) < search.cost(empty):
        return ""
    rest = sets.without(holding, name)
    if rest not in search.fits or search.cost(rest) - search.cost(holding) > 0:
        return ""
    gain, short = misfit(search.fits[rest]) - misfit(search.fits[holding]), search.cost(holding) - search.cost(rest)
    return f"beside {_names(rest)} " + _too_little(gain, short)


def _leaves(sets, name, left):
    """What a candidate that explains a part leaves, beside what the best set leaves."""
    fit, best = sets.search.fits[sets.best], _names(sets.best) or "the model as it is"
    beside = _names(set(left["effects"]) - {name})
    mine, theirs = left["chi2_per_freedom"], fit.chi2_per_freedom
    how = "is foreseen to leave" if left["foreseen"] else "leaves"
    told = f"{f'with {beside} ' if beside else ''}it {how} a chi-square of {mine:.3g} per degree of freedom, {best} {theirs:.3g}"
    if mine > theirs:
        return told
    if left["foreseen"]:
        return f"{told}; it was not fitted, since other sets promised more"
    numbers = sets.search.fits[frozenset(left["effects"])].numbers
    if doubts := [doubt for effect, free, value in numbers if (doubt := free.doubt(effect, value))]:
        return "; ".join([told, *doubts])
    if sets.cost(frozenset(left["effects"])) > sets.cost(sets.best):
        if sets.overdispersion > 1:
            return f"{told}: the difference is small beside what both leave, and may be chance"
        return f"{told}, which is more probable: it needs fewer numbers, or more usual ones"
    members = frozenset(left["effects"])
    if sets.absorbs(members, name):
        percent = 100 * sets.share(members, name)
        return f"{told}: {percent:.0f} % of what is more than noise, too little to be told from what absorbs another effect"
    return f"{told}, but {'the others of that set do' if beside else 'it does'} not hold on recordings that were not fitted"


def _outside(search, name):
    """Why a law of one number cannot explain what it would explain beyond its end; "" where that is not so. To first order."""
    linear = search.models[frozenset()]
    places = linear.places.get(name, ())
    if len(places) != 1 or linear.columns[places[0]].free is AMPLITUDE or not linear.visible(name):
        return ""
    (place,) = places
    column, dot, information = linear.columns[place], linear.dots[place], linear.gram[place, place]
    (low, high), step, gain = column.ends, dot / information, dot**2 / information
    part = gain / max(misfit(search.fits[frozenset()]), 1e-300)
    if low <= step <= high or gain <= search.price({name}) + np.log1p(information) or part < FALL:
        return ""
    side, end = ("below", column.free.least) if step < low else ("above", column.free.most)
    told = f"the data would have {column.free.name} {side} {end:g}, where the law ends"
    return f"{told}; then {100 * part:.0f} % of the misfit would go"


def _visible(search, name):
    """The smallest value of a one-number candidate that these data would have shown nine times in ten; empty where it is beyond
    what is plausible."""
    entry, linear = search.candidates[name], search.models[frozenset()]
    if len(entry.free) != 1 or entry.absent is None or name not in linear.entries or not linear.visible(name):
        return ""
    (free,), information = entry.free, linear.information(name)
    required = search.price({name}) + np.log1p(information)
    size = (np.sqrt(required) + 1.28) * free.spread / np.sqrt(information)
    if size > max(free.high - free.null, free.null - free.low):
        return ""
    return change_told(free, size)


def change_told(free, size):
    """A number that is off its null value by a size, in words: "rate 0.02 1/s", "relative +-0.0025", "friction 0.05 more or less
    than 0.5"."""
    both, unit = free.least < free.null, "" if free.unit == "1" else f" {free.unit}"
    if free.null == 0.0:
        return f"{free.name} {'+-' * both}{size:.2g}{unit}"
    return f"{free.name} {size:.2g}{unit} {'more or less' if both else 'more'} than {free.null:g}"
