"""What is told of the effects that were found, and of every candidate: numbers with their intervals, errors, reasons."""

import numpy as np

from hlcs.estimation.least_squares import basis, largest_cosine, project_out
from hlcs.records import Finding, Reason, untested
from hlcs.selection.held_out import fitted_error, held_out_error
from hlcs.selection.reasons import sentences

# --- for every kind of measurement --------------------------------------------------------------------------------------------


def error_record(measure, unit, noise, fitted, held_out):
    """The errors of a Diagnosis; fitted, held_out: (before, after), None where nothing can be held out."""
    fitted, held_out = (errors and {"before": errors[0], "after": errors[1], "noise": noise} for errors in (fitted, held_out))
    return {"measure": measure, "unit": unit, "held_out": held_out, "fitted": fitted}


def findings(names, alternatives, described):
    """One Finding a candidate, the accepted ones first, then by evidence.

    alternatives: {accepted effect: {rival: cosine of the signatures}}; described: function (name, names of what it cannot be told
    from) -> the fields of its Finding that a kind of measurement knows: fitted, held_out, evidence, why, reason, visible_from.
    """
    cosines = {effect: {rival: round(cosine, 4) for rival, cosine in rivals.items()} for effect, rivals in alternatives.items()}
    partners = {rival: {effect: cosine} for effect, rivals in cosines.items() for rival, cosine in rivals.items()}
    sets = [{effect, *rivals} for effect, rivals in alternatives.items()]
    unsorted = []
    for name in names:
        same = tuple(sorted(set().union(*(members for members in sets if name in members)) - {name}))
        known = {"accepted": name in alternatives, "same_as": same, "cosines": partners.get(name) or cosines.get(name, {})}
        unsorted.append(Finding(name, **known, **described(name, same)))

    def order(finding):
        return not finding.accepted, -(-1e9 if finding.evidence is None else finding.evidence), finding.effect

    return tuple(sorted(unsorted, key=order))


def accepted_reason(gain, price, falls, same, at="", label=""):
    """The Explanation of an accepted candidate; falls: of its held-out error, each relative; at: its number, in brackets."""
    return Reason.ACCEPTED(
        at=at,
        gain=gain,
        price=price,
        held_out=f"; held-out error falls by {' and '.join(f'{100 * fall:.0f} %' for fall in falls)}" if falls else "",
        same=f"; cannot be told from {', '.join(same)}{label}" if same else "",
    )


def rival_reason(same, effects, at="", label=""):
    """The Explanation of a candidate that does as well as accepted effects."""
    return Reason.NOT_TOLD_APART(others=", ".join(name for name in same if name in effects), at=at, label=label)


def set_label(candidate, others):
    """The set of look-alikes that a candidate and some of its rivals belong to, in brackets, or nothing."""
    return f" ({candidate.alike})" if candidate.alike and any(other.alike == candidate.alike for other in others) else ""


def smallest_visible(free, size):
    """The smallest value of a free number that these data would have shown, in words; size: how far it is from the null value."""
    return f"{free.name} {size:.2g}{'' if free.unit == '1' else ' ' + free.unit} from {free.null:g}"


# --- for fitted sets ------------------------------------------------------------------------------------------------------------


def candidate_findings(sets, places, absent):
    """One Finding a candidate of a search over sets, and one for each of those that were not tried.

    places: {effect of the best set: names that take its place}; absent: {name: why it was not tried}.
    """
    search, problem, best = sets.search, sets.search.problem, sets.best
    alternatives = {name: {other: _cosine(sets, name, other) for other in others} for name, others in places.items()}

    def described(name, same):
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
        return {
            "fitted": fitted,
            "held_out": held,
            "evidence": evidence,
            "visible_from": _visible(search, name),
            **_explained(sets, name, same, holding, evidence)._asdict(),
        }

    untried = (untested(name, Reason.NOT_TRIED(why=why)) for name, why in sorted(absent.items()))
    return (*findings(search.candidates, alternatives, described), *untried)


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
    others = [search.candidates[other] for other in same]
    at = f" ({entry.family})" if entry.family else ""
    if name in best:
        held = sets.held_out(best, name)
        rest, fit = sets.fit(sets.without(best, name)), search.fits[best]
        gain = rest.chi2 - fit.chi2
        return accepted_reason(gain, gain - evidence, held.directions, same, at, set_label(entry, others))
    if same:
        return rival_reason(same, best, at, set_label(entry, others))
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
    return smallest_visible(free, size) if size <= max(free.high - free.null, free.null - free.low) else ""
