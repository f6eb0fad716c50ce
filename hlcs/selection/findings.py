"""What is told of the effects that were found, and of every candidate: numbers with their intervals, errors, reasons."""

import numpy as np
from scipy import stats

from hlcs.effects import set_of
from hlcs.records import Finding, Reason, untested
from hlcs.selection.pairs import beside
from hlcs.selection.reasons import sentences

INTERVAL = 0.90  # of coefficients


def intervals(fit, inflation):
    """{effect: {name: value, low, high, unit}} at 90 %, widened where the model is not adequate, inside the bounds."""
    found, place = {}, 0
    quantile = stats.t.ppf(0.5 + INTERVAL / 2, fit.freedom)
    for term in fit.model.terms:
        numbers = {}
        for free in term.candidate.free:
            error = quantile * np.sqrt(max(inflation, 1.0) * max(fit.covariance[place, place], 0.0))
            value = fit.estimate[place]
            low, high = (-np.inf, np.inf) if free.period is not None else (min(free.low, value), max(free.high, value))
            numbers[free.name] = {
                "value": float(value),
                "low": float(max(value - error, low)),
                "high": float(min(value + error, high)),
                "unit": free.unit,
            }
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
    held = None
    if search.cross_validation.possible:
        held = {"before": held_out_error(search, base, unit), "after": held_out_error(search, final, unit), "noise": noise}
    return {
        "measure": "rms",
        "unit": unit,
        "held_out": held,
        "fitted": {"before": fitted_error(search, base, unit), "after": fitted_error(search, final, unit), "noise": noise},
    }


def findings(search, fits, rounds, rivals, effects, absent, unit):
    """One Finding a candidate: accepted ones first, then by evidence."""
    told = []
    partners = {name: (effect, cosine) for effect, others in zip(effects, rivals, strict=True) for name, _, cosine in others}
    for entry in search.candidates:
        name = entry.name
        trials = [trials[name] for trials in rounds if name in trials]
        refitted = [trial for trial in trials if trial.fit is not None]
        best = max(refitted, key=lambda trial: trial.gain, default=None)
        last = trials[-1] if trials else None
        accepted = name in effects
        if accepted and best is None:  # brought in with another one, not in a round of its own
            best = beside(search, fits[0], fits[-1], effects.index(name))
        same = tuple(sorted({other for members in _sets(effects, rivals) if name in members for other in members} - {name}))
        cosines = {}
        if name in partners:
            cosines = {partners[name][0]: round(partners[name][1], 4)}
        elif accepted:
            cosines = {other: round(cosine, 4) for other, _, cosine in rivals[effects.index(name)]}
        explanation = _why(name, accepted, same, best, last, effects)
        if best is not None:
            fitted, held, gain = fitted_error(search, best.fit, unit), held_out_error(search, best.fit, unit), best.gain
        else:
            fitted, held, gain = None, None, last.linear_gain if last is not None and last.visible else None
        evidence = None if gain is None else float(gain - search.complexity_penalty(entry))
        told.append(
            Finding(
                name, fitted, held, evidence, accepted, same, explanation.why, cosines, _visible(last), reason=explanation.reason
            )
        )
    told.sort(key=lambda entry: (not entry.accepted, -(entry.evidence if entry.evidence is not None else -1e9), entry.effect))
    return (*told, *(untested(name, Reason.NOT_TRIED(why=why)) for name, why in sorted(absent.items())))


def _sets(effects, rivals):
    return [[effect] + [name for name, _, _ in others] for effect, others in zip(effects, rivals, strict=True)]


def _why(name, accepted, same, best, last, effects):
    """The Explanation of what became of a candidate."""
    form = set_of(name)
    if accepted:
        falls = " and ".join(f"{100 * fall:.0f} %" for fall in best.directions)
        return Reason.ACCEPTED(
            at="",
            gain=best.gain,
            price=best.required_gain,
            held_out=f"; held-out error falls by {falls}" if falls else "",
            same=f"; cannot be told from {', '.join(same)}" if same else "",
        )
    if same:
        label = f" ({form})" if form and any(set_of(other) == form for other in same) else ""
        return Reason.NOT_TOLD_APART(others=", ".join(other for other in same if other in effects), at="", label=label)
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
    size = (np.sqrt(last.required_gain) + 1.28) / last.visible
    return f"{free.name} {size:.2g}{'' if free.unit == '1' else ' ' + free.unit} from {free.null:g}"
