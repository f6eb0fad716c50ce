"""What remains with each set of effects that was tried: the rows of the ranking, for tables and pictures."""

from hlcs.report.words import joined, number, words

LITTLE = 0.02  # share of chi-square, below which nobody would speak of an explanation


def ranking(diagnosis):
    """Rows {effects, chi2_per_freedom, error, over_noise, foreseen, accepted}, what was found first, then the least that remains.

    The model under test is one of them, with no effects. error is None where a set was foreseen and not fitted.
    """
    rows = {frozenset(entry.remains["effects"]): dict(entry.remains) for entry in diagnosis.candidates if entry.remains}
    for step in diagnosis.steps:
        if "chi2_per_freedom" in step and set(step["effects"]) in (set(), set(diagnosis.effects)):
            told = {"chi2_per_freedom": step["chi2_per_freedom"], "error": step["fitted"], "foreseen": False}
            rows[frozenset(step["effects"])] = {"effects": list(step["effects"]), **told}
    if diagnosis.learned is not None and diagnosis.learned.remains:
        rows[frozenset(diagnosis.learned.remains["effects"])] = dict(diagnosis.learned.remains)
    noise = (diagnosis.error.get("fitted") or {}).get("noise")
    for members, row in rows.items():
        over = row["error"] / noise if row["error"] is not None and noise else None
        row |= {"over_noise": over, "accepted": bool(members) and members == frozenset(diagnosis.effects)}
    return sorted(rows.values(), key=lambda row: (not row["accepted"], row["chi2_per_freedom"], row["effects"]))


def left_by_base(found):
    """chi-square per degree of freedom that the model under test leaves, of rows of the ranking; None where it is not there."""
    return next((row["chi2_per_freedom"] for row in found if not row["effects"]), None)


def ranking_title(diagnosis):
    """What the picture of a ranking says, in a line."""
    found = ranking(diagnosis)
    if not found:
        return "Nothing was tried"
    if not diagnosis.effects and diagnosis.learned is not None and diagnosis.learned.remains:
        return f"No effect explains enough; what was learned leaves {number(diagnosis.learned.remains['chi2_per_freedom'])}"
    if not diagnosis.effects:
        return "Noise alone is left by the model as it is" if diagnosis.verdict == "complete" else "No effect explains enough"
    row = next((row for row in found if row["accepted"]), None)
    what = joined(map(words, diagnosis.effects))
    base = left_by_base(found)
    if row is None or base is None:
        return "What remains"
    return f"Down from {number(base)} to {number(row['chi2_per_freedom'])} with {what}"


def ranking_caption(found):
    """What the marks of the ranking mean, of those that are there."""
    told = ["Further left is better; 1 is noise alone."]
    told += ["Blue: found."] * any(row["accepted"] for row in found)
    told += ["Open: foreseen from slopes, not fitted."] * any(row["foreseen"] for row in found)
    return " ".join(told)
