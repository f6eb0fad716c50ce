"""What a diagnosis of layer coefficients says of each candidate."""

from hlcs.kinds.layers.candidates import set_of
from hlcs.kinds.layers.judge import QUANTILE
from hlcs.records import Finding, Reason, untested
from hlcs.selection.reasons import sentences

NOTHING_PAYS = "the misfit is too small, or the numbers too few, to pay for any"


def intervals(accepted):
    """{effect: {number: {value, low, high, unit}}} of the accepted candidates; 90 % intervals inside their bounds."""
    found = {}
    for one in accepted:
        error = 0.0 if one.candidate.switch else QUANTILE * one.deviation
        found[one.name] = {
            one.candidate.number: {
                "value": float(one.value),
                "low": float(max(one.value - error, min(one.candidate.low, one.value))),
                "high": float(min(one.value + error, max(one.candidate.high, one.value))),
                "unit": one.candidate.unit,
            }
        }
        if one.candidate.needs:
            found[one.name][one.candidate.number]["campaign"] = one.candidate.needs
    return found


def findings(entries, accepted, rounds, rivals):
    """One Finding a name: accepted ones first, then by evidence."""
    winners = {one.name: (one, others) for one, others in zip(accepted, rivals, strict=True)}
    partners = {other.name: (one.name, angle) for one, others in winners.values() for other, angle in others}
    sets = [{name, *(other.name for other, _ in others)} for name, (_, others) in winners.items()]
    found = []
    for name in sorted({entry.name for entry in entries}):
        tried = [one for round_ in rounds for one in round_ if one.name == name]
        best = winners[name][0] if name in winners else (tried[-1] if tried else None)
        same = tuple(sorted(set().union(*(members for members in sets if name in members)) - {name}))
        cosines = {other.name: round(angle, 4) for other, angle in winners[name][1]} if name in winners else {}
        if name in partners:
            cosines = {partners[name][0]: round(partners[name][1], 4)}
        if best is None:
            found.append(untested(name, Reason.NOT_SIMULATED() if rounds else Reason.NOT_TRIED(why=NOTHING_PAYS), same))
            continue
        explanation = _why(best, name in winners, same, winners)
        found.append(
            Finding(
                name,
                best.error,
                best.held_error,
                float(best.evidence),
                name in winners,
                same,
                explanation.why,
                cosines,
                _visible(best),
                reason=explanation.reason,
            )
        )
    return tuple(
        sorted(found, key=lambda one: (not one.accepted, -(one.evidence if one.evidence is not None else -1e9), one.effect))
    )


def _why(one, accepted, same, winners):
    """The Explanation of what became of a candidate."""
    form = set_of(one.name)
    label = f" ({form})" if form and any(set_of(other) == form for other in same) else ""
    at = f" ({one.candidate.family}, {one.candidate.number} = {one.value:.3g}"
    at += f" of {one.candidate.needs})" if one.candidate.needs else ")"
    if accepted:
        falls = " and ".join(f"{100 * fall:.0f} %" for fall in one.directions.values())
        return Reason.ACCEPTED(
            at=at,
            gain=one.gain,
            price=one.price,
            held_out=f"; held-out misfit falls by {falls}" if falls else "",
            same=f"; cannot be told from {', '.join(same)}{label}" if same else "",
        )
    if same:
        return Reason.NOT_TOLD_APART(others=", ".join(other for other in same if other in winners), at=at, label=label)
    if one.gain > 3.84 and one.fails:
        promise = "" if one.gain <= one.price else f"chi2 would fall by {one.gain:.1f}, but "
        return Reason.SUSPECTED(why=f"{at[1:]} {promise}{sentences(one.fails)}")
    if not one.fails:
        return Reason.EXPLAINED_TOO(at=at)
    return Reason.NOT_SEEN(at=at, why=one.fails[0].why)


def _visible(one):
    """The smallest value that would have moved a layer by what these data show."""
    if one.candidate.switch or one.size <= 0 or one.amount == 0:
        return ""
    unit = "" if one.candidate.unit == "1" else f" {one.candidate.unit}"
    return f"{one.candidate.number} {abs(one.amount) / one.size:.2g}{unit} from {one.candidate.null:g}"
