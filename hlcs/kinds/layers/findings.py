"""What a diagnosis of layer coefficients says of each candidate."""

from hlcs.kinds.layers.judge import QUANTILE
from hlcs.selection.findings import accepted_reason, findings, interval, rival_reason, set_label, smallest_visible


def intervals(accepted):
    """{effect: {number: {value, low, high, unit}}} of the accepted trials; 90 % intervals inside their bounds."""
    found = {}
    for trial in accepted:
        candidate, error = trial.candidate, 0.0 if trial.candidate.switch else QUANTILE * trial.deviation
        number = interval(trial.value, error, candidate.low, candidate.high, candidate.unit)
        found[trial.name] = {candidate.number: number | ({"campaign": candidate.campaign} if candidate.campaign else {})}
    return found


def layer_findings(candidates, accepted, rounds, alternatives):
    """One Finding a name; alternatives: {accepted effect: {rival: cosine of the signatures}}."""
    last = {trial.name: trial for trials in [*rounds, accepted] for trial in trials}

    def described(name, same):
        if name not in last:
            why = (
                "could not be simulated: no such placement stands, or it takes too long"
                if rounds
                else "not tried: the misfit is too small, or the numbers too few, to pay for any"
            )
            return {"fitted": None, "held_out": None, "evidence": None, "why": why}
        trial = last[name]
        return {
            "fitted": trial.error,
            "held_out": trial.held_out_error,
            "evidence": float(trial.evidence),
            "why": _why(trial, same, alternatives),
            "visible_from": _visible(trial),
        }

    return findings(sorted({candidate.name for candidate in candidates}), alternatives, described)


def _why(trial, same, effects):
    """One sentence on a trial."""
    candidate, label = trial.candidate, set_label(trial.name, same)
    of_campaign = f" of {candidate.campaign}" if candidate.campaign else ""
    at = f" ({candidate.family}, {candidate.number} = {trial.value:.3g}{of_campaign})"
    if trial.name in effects:
        falls = [held_out.fall for held_out in trial.held_out.values()]
        return accepted_reason(trial.gain, trial.required_gain, falls, same, "misfit", at, label)
    if same:
        return rival_reason(same, effects, at, label)
    if not trial.fails:
        return f"explained the residual too{at}, less well than what was accepted"
    fails = [text for _, text in trial.fails]
    if trial.gain > 3.84:
        promise = "" if trial.gain <= trial.required_gain else f"chi2 would fall by {trial.gain:.1f}, but "
        return f"suspected:{at} {promise}" + "; ".join(fails)
    return f"not seen{at}: {fails[0]}"


def _visible(trial):
    """The smallest value that would have moved a layer by what these data show."""
    candidate = trial.candidate
    if candidate.switch or trial.relative_shift <= 0 or trial.amount == 0:
        return ""
    return smallest_visible(candidate.number, abs(trial.amount) / trial.relative_shift, candidate.unit, candidate.null)
