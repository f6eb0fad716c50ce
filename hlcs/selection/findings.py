"""What is told of the effects that were found, and of every candidate: numbers with their intervals, errors, reasons."""

import numpy as np
from scipy import stats

from hlcs.effects import set_of
from hlcs.records import Finding, Reason, untested
from hlcs.selection.pairs import beside
from hlcs.selection.reasons import sentences

INTERVAL = 0.90  # of coefficients


# --- for every kind of measurement --------------------------------------------------------------------------------------------


def interval(free, value, error):
    """A free number with its interval, inside the bounds that its value has not left; an angle has no bounds."""
    low, high = (-np.inf, np.inf) if free.period is not None else (min(free.low, value), max(free.high, value))
    return {
        "value": float(value),
        "low": float(max(value - error, low)),
        "high": float(min(value + error, high)),
        "unit": free.unit,
    }


def error_record(measure, unit, noise, fitted, held_out):
    """The errors of a Diagnosis; fitted, held_out: (before, after), None where nothing can be held out."""
    fitted, held_out = (errors and {"before": errors[0], "after": errors[1], "noise": noise} for errors in (fitted, held_out))
    return {"measure": measure, "unit": unit, "held_out": held_out, "fitted": fitted}


def ambiguous_sets(alternatives):
    """Each accepted effect with its rivals, where it has any; alternatives: {accepted effect: {rival: cosine}}."""
    return tuple((effect, *sorted(rivals)) for effect, rivals in alternatives.items() if rivals)


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


def accepted_reason(gain, price, falls, same, error="error", at="", label=""):
    """The Explanation of an accepted candidate; falls: of its held-out error, each relative; at: its number, in brackets."""
    return Reason.ACCEPTED(
        at=at,
        gain=gain,
        price=price,
        held_out=f"; held-out {error} falls by {' and '.join(f'{100 * fall:.0f} %' for fall in falls)}" if falls else "",
        same=f"; cannot be told from {', '.join(same)}{label}" if same else "",
    )


def rival_reason(same, effects, at="", label=""):
    """The Explanation of a candidate that does as well as accepted effects."""
    return Reason.NOT_TOLD_APART(others=", ".join(name for name in same if name in effects), at=at, label=label)


def set_label(name, same, set_of=set_of):
    """The set of look-alikes that a candidate and some of its rivals belong to, in brackets, or nothing."""
    form = set_of(name)
    return f" ({form})" if form and any(set_of(other) == form for other in same) else ""


def smallest_visible(free, size):
    """The smallest value of a free number that these data would have shown, in words; size: how far it is from the null value."""
    return f"{free.name} {size:.2g}{'' if free.unit == '1' else ' ' + free.unit} from {free.null:g}"


# --- for fits of problems -----------------------------------------------------------------------------------------------------


def intervals(fit, inflation):
    """{effect: {name: value, low, high, unit}} at 90 %, widened where the model is not adequate, inside the bounds."""
    found, place = {}, 0
    quantile = stats.t.ppf(0.5 + INTERVAL / 2, fit.freedom)
    for term in fit.model.terms:
        numbers = {}
        for free in term.candidate.free:
            error = quantile * np.sqrt(max(inflation, 1.0) * max(fit.covariance[place, place], 0.0))
            numbers[free.name] = interval(free, fit.estimate[place], error)
            place += 1
        found[term.name] = numbers
    return found


def _rms(problem, residuals, unit):
    """RMS over positions [m] or rotations [rad] of residuals in units of sigma."""
    total, count = 0.0, 0
    for recording, part in zip(problem.recordings, residuals, strict=True):
        inside = recording.channel < 3 if unit != "rad" else recording.channel >= 3
        total += float(np.sum(part[inside] ** 2))
        count += int(inside.sum())
    sigma = problem.noise.orientation if unit == "rad" else problem.noise.position
    return float(sigma * np.sqrt(total / max(count, 1)))


def fitted_error(search, fit, unit):
    """RMS residual of a fit on the data it was fitted to."""
    r, s = fit.linearization.projected
    return _rms(search.problem, search.coloured(r), unit)


def held_out_error(search, fit, unit):
    """RMS residual on recordings the numbers were not fitted to; None where nothing can be held out."""
    if not search.cross_validation.possible:
        return None
    return _rms(search.problem, search.coloured(search.cross_validation.residuals(fit)), unit)


def errors(search, base, final, unit):
    """RMS before and after, on the data that were fitted and on those held out, beside the noise."""
    noise = search.problem.noise.orientation if unit == "rad" else search.problem.noise.position
    fitted = [fitted_error(search, fit, unit) for fit in (base, final)]
    held_out = [held_out_error(search, fit, unit) for fit in (base, final)] if search.cross_validation.possible else None
    return error_record("rms", unit, noise, fitted, held_out)


def problem_findings(search, fits, rounds, alternatives, absent, unit):
    """One Finding a candidate of a search over fits, and one for each of those that were not tried.

    alternatives: as for `findings`; absent: {name: why it was not tried}.
    """
    effects = list(alternatives)
    candidates = {candidate.name: candidate for candidate in search.candidates}

    def described(name, same):
        trials = [trials[name] for trials in rounds if name in trials]
        refitted = [trial for trial in trials if trial.fit is not None]
        best = max(refitted, key=lambda trial: trial.gain, default=None)
        last = trials[-1] if trials else None
        if name in effects and best is None:  # brought in with another one, not in a round of its own
            best = beside(search, fits[0], fits[-1], effects.index(name))
        fitted, held_out, gain = None, None, last.linear_gain if last is not None and last.visible else None
        if best is not None:
            fitted, held_out, gain = fitted_error(search, best.fit, unit), held_out_error(search, best.fit, unit), best.gain
        return {
            "fitted": fitted,
            "held_out": held_out,
            "evidence": None if gain is None else float(gain - search.complexity_penalty(candidates[name])),
            "visible_from": _visible(last),
            **_explained(name, same, best, last, effects)._asdict(),
        }

    untried = (untested(name, Reason.NOT_TRIED(why=why)) for name, why in sorted(absent.items()))
    return (*findings(candidates, alternatives, described), *untried)


def _explained(name, same, best, last, effects):
    """The Explanation of what became of a candidate."""
    if name in effects:
        return accepted_reason(best.gain, best.required_gain, best.directions, same)
    if same:
        return rival_reason(same, effects, label=set_label(name, same))
    form = set_of(name)
    better = [other for other in effects if form and set_of(other) == form]
    if best is not None and better:
        return Reason.OTHER_FORM(form=form, better=better[0])
    if last is not None and last.fit is not None and last.gain > last.required_gain and last.fails:
        return Reason.SUSPECTED(why=sentences(last.fails))
    if last is None or not last.visible:
        return Reason.INVISIBLE()
    if best is not None and best.gain > best.required_gain:
        if not best.fails:
            return Reason.EXPLAINED_TOO(at="")
        return Reason.EXPLAINED_BEFORE(why=sentences(best.fails))
    why = f"chi2 would fall by {max(last.linear_gain, 0.0):.1f}, less than the price of {last.required_gain:.1f}"
    return Reason.NOT_SEEN(at="", why=why)


def _visible(last):
    """The smallest value of a one-number candidate these data would have shown nine times in ten."""
    if last is None or not last.visible or len(last.candidate.free) != 1 or last.candidate.absent is None:
        return ""
    free = last.candidate.free[0]
    return smallest_visible(free, (np.sqrt(last.required_gain) + 1.28) / last.visible)
