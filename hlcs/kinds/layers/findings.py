"""What a diagnosis of layer coefficients says of each candidate."""

from hlcs.kinds.layers.candidates import set_of
from hlcs.kinds.layers.judge import QUANTILE
from hlcs.records import Reason
from hlcs.selection.findings import accepted_reason, findings, rival_reason, set_label, smallest_visible
from hlcs.selection.reasons import sentences

NOTHING_PAYS = "the misfit is too small, or the numbers too few, to pay for any"


def interval(free, value, error):
    """A free number with its interval, inside the bounds that its value has not left."""
    low, high = min(free.low, value), max(free.high, value)
    return {
        "value": float(value),
        "low": float(max(value - error, low)),
        "high": float(min(value + error, high)),
        "unit": free.unit,
    }


def ambiguous_sets(alternatives):
    """Each accepted effect with its rivals, where it has any; alternatives: {accepted effect: {rival: cosine}}."""
    return tuple((effect, *sorted(rivals)) for effect, rivals in alternatives.items() if rivals)


def intervals(accepted):
    """{effect: {number: {value, low, high, unit}}} of the accepted trials; 90 % intervals inside their bounds."""
    effects = {}
    for trial in accepted:
        candidate, error = trial.candidate, 0.0 if trial.candidate.switch else QUANTILE * trial.deviation
        free, campaign = candidate.number, {"campaign": candidate.campaign} if candidate.campaign else {}
        effects[trial.name] = {free.name: interval(free, trial.value, error) | campaign}
    return effects


def layer_findings(candidates, accepted, rounds, alternatives):
    """One Finding a name; alternatives: {accepted effect: {rival: cosine of the signatures}}."""
    last = {trial.name: trial for trials in [*rounds, accepted] for trial in trials}

    def described(name, same):
        if name not in last:
            explanation = Reason.NOT_SIMULATED() if rounds else Reason.NOT_TRIED(why=NOTHING_PAYS)
            return {"fitted": None, "held_out": None, "evidence": None, **explanation._asdict()}
        trial = last[name]
        return {
            "fitted": trial.error,
            "held_out": trial.held_out_error,
            "evidence": float(trial.evidence),
            "visible_from": _visible(trial),
            **_explained(trial, same, alternatives)._asdict(),
        }

    return findings(sorted({candidate.name for candidate in candidates}), alternatives, described)


def _explained(trial, same, effects):
    """The Explanation of what became of a candidate."""
    candidate, label = trial.candidate, set_label(trial.name, same, set_of)
    of_campaign = f" of {candidate.campaign}" if candidate.campaign else ""
    at = f" ({candidate.family}, {candidate.number.name} = {trial.value:.3g}{of_campaign})"
    if trial.name in effects:
        falls = [held_out.fall for held_out in trial.held_out.values()]
        return accepted_reason(trial.gain, trial.required_gain, falls, same, "misfit", at, label)
    if same:
        return rival_reason(same, effects, at, label)
    if not trial.fails:
        return Reason.EXPLAINED_TOO(at=at)
    if trial.gain <= 3.84:
        return Reason.NOT_SEEN(at=at, why=trial.fails[0].why)
    promise = "" if trial.gain <= trial.required_gain else f"chi2 would fall by {trial.gain:.1f}, but "
    return Reason.SUSPECTED(why=f"{at[1:]} {promise}{sentences(trial.fails)}")


def _visible(trial):
    """The smallest value that would have moved a layer by what these data show."""
    candidate = trial.candidate
    if candidate.switch or trial.relative_shift <= 0 or trial.amount == 0:
        return ""
    return smallest_visible(candidate.number, abs(trial.amount) / trial.relative_shift)
