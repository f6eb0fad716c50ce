"""What remains with each set of effects that was tried: the rows of the ranking, for tables and pictures."""


def ranking(diagnosis):
    """Rows {effects, chi2_per_freedom, error, over_noise, foreseen, accepted}, what was found first, then the least that remains.

    The model under test is one of them, with no effects. error is None where a set was foreseen and not fitted.
    """
    rows = {frozenset(entry.remains["effects"]): dict(entry.remains) for entry in diagnosis.candidates if entry.remains}
    for step in diagnosis.steps:
        if "chi2_per_freedom" in step and set(step["effects"]) in (set(), set(diagnosis.effects)):
            told = {"chi2_per_freedom": step["chi2_per_freedom"], "error": step["fitted"], "foreseen": False}
            rows[frozenset(step["effects"])] = {"effects": list(step["effects"]), **told}
    noise = (diagnosis.error.get("fitted") or {}).get("noise")
    for members, row in rows.items():
        over = row["error"] / noise if row["error"] is not None and noise else None
        row |= {"over_noise": over, "accepted": bool(members) and members == frozenset(diagnosis.effects)}
    return sorted(rows.values(), key=lambda row: (not row["accepted"], row["chi2_per_freedom"], row["effects"]))
