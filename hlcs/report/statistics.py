"""The statistics behind a Diagnosis: what `--details` adds to its report, and what a page folds away."""

from hlcs.data.quantities import unit_of
from hlcs.records import VERDICTS, Reason
from hlcs.report.document import Section, Table
from hlcs.report.doubted import doubt
from hlcs.report.ranking import LITTLE, left_by_base, ranking
from hlcs.report.sentences import LEFT_OUT, error_of
from hlcs.report.words import DASH, chance, joined, number, size, words

UNITS = {"time": "s", "height": "m", "speed": "m/s"}
SPOKE = {"variance": "the size of the residuals", "chi2": "chi-square"}  # other statistics are told by their own names


def sections(diagnosis):
    """Sections: the error step by step, the test of adequacy, the candidates, the sets, where the model misses."""
    found = [
        Section("Details: the verdict", _verdict(diagnosis)),
        Section("Details: the error, step by step", _errors(diagnosis)),
        Section("Details: are the residuals noise?", _adequacy(diagnosis)),
        Section("Details: what remains with every set that was tried", ranking_parts(diagnosis)),
        Section("Details: the candidates", _candidates(diagnosis)),
        Section("Details: sets of effects", _sets(diagnosis)),
        Section("Details: where the model misses", _where(diagnosis)),
    ]
    return [section for section in found if section.parts]


def facts(diagnosis):
    """What a page shows large: [(what, value)]."""
    error, unit = error_of(diagnosis), diagnosis.error.get("unit", "")
    if not error:
        return []
    held_out = diagnosis.error.get("held_out")
    where = f", on {LEFT_OUT.get(diagnosis.kind, 'data')} left out" if held_out else ", on the fitted data"
    told = [(f"error{' before' if diagnosis.effects else ''}{where}", size(error["before"], unit))]
    told += [(f"error after{where}", size(error["after"], unit))] if diagnosis.effects else []
    if diagnosis.learned is not None:
        told.append((f"error with what was learned{where}", size(diagnosis.learned.held_out["after"], unit)))
    told.append(("noise", size(error["noise"], unit)))
    left = "left, times the noise" if diagnosis.effects else "error, times the noise"
    return [*told, *([(left, number(error["after"] / error["noise"]))] if error["noise"] else [])]


def _verdict(diagnosis):
    effects = f" Effects, what the data need most first: {', '.join(diagnosis.effects)}." if diagnosis.effects else ""
    doubted = doubt(diagnosis)
    means = doubted.verdict if doubted else VERDICTS[diagnosis.verdict]
    return (f"Verdict: {diagnosis.verdict}: {means}.{effects}",)


def _errors(diagnosis):
    unit = diagnosis.error.get("unit", "")
    fitted = diagnosis.error.get("fitted")
    if not fitted:
        return ()
    rows = [
        (" + ".join(step["effects"]) or "the model as it is", size(step.get("fitted"), unit), size(step["held_out"], unit))
        for step in diagnosis.steps
    ]
    told = [Table((diagnosis.error.get("measure") or "rms", "fitted", "held out"), tuple(rows))] if rows else []
    told.append(f"Noise: {size(fitted['noise'], unit)} ({diagnosis.noise.get('source') or 'source unknown'}).")
    if starts := fitted.get("starts"):
        least = size(fitted["noise"] * (1 - starts) ** 0.5, unit)
        told.append(
            f"The fitted starts take up {100 * starts:.2g} % of the variance of the noise: a perfect model would show {least} on "
            "the fitted data."
        )
    if not diagnosis.error.get("held_out"):
        told.append('Nothing was held out (a single group, or hold_out = "none"): the price of a candidate is doubled instead.')
    return tuple(told)


def _adequacy(diagnosis):
    adequate = diagnosis.adequate
    if adequate["after"] is None:
        return ()
    says = {True: "adequate", False: "not adequate"}
    spoke = SPOKE.get(adequate.get("speaks"), adequate.get("speaks"))
    told = f"The model is {says[adequate['before']]} as it is"
    told += f", {says[adequate['after']]} with what was found" if diagnosis.effects else ""
    told += f". Statistic {number(adequate['statistic'])}" + (f" ({spoke})" if spoke else "")
    if adequate.get("threshold") is not None:
        told += f", noise alone stays below {number(adequate['threshold'])} in 99 of 100 cases"
    told += f"; p = {chance(adequate['p'], adequate.get('draws'))}."
    lines = [told]
    chi2 = adequate.get("chi2_per_freedom") or {}
    if chi2.get("after") is not None:
        lines.append(f"Chi-square per degree of freedom: {number(chi2['before'])} before, {number(chi2['after'])} after.")
    if diagnosis.explained is not None and diagnosis.effects:
        lines.append(
            f"{joined(map(words, diagnosis.effects))}: {100 * diagnosis.explained:.4g} % of the excess of chi-square over its "
            "expectation is removed."
        )
    return tuple(lines)


def ranking_parts(diagnosis, most=None):
    """What remains with each set of effects, the least first; most: rows, None = all; the model as it is is always among them,
    and where nothing is missing no set that leaves as much as it."""
    found, unit = ranking(diagnosis), diagnosis.error.get("unit", "")
    shown = [row for place, row in enumerate(found) if most is None or place < most or not row["effects"]]
    base = left_by_base(found)
    alike = most is not None and diagnosis.verdict == "complete" and base is not None
    if alike:
        shown = [row for row in shown if not row["effects"] or row["chi2_per_freedom"] < (1 - LITTLE) * base]
    if not shown:
        return ()
    rows = tuple(
        (
            " + ".join(row["effects"]) or "the model as it is",
            size(row["error"], unit),
            number(row["over_noise"]),
            ("~" if row["foreseen"] else "") + number(row["chi2_per_freedom"]),
        )
        for row in shown
    )
    left_out = len(found) - len(shown)
    note = "~ foreseen, not fitted. " if any(row["foreseen"] for row in shown) else ""
    note += "Noise alone leaves 1 times the noise, and a chi-square of 1 per degree of freedom."
    much = f"no less, to {100 * LITTLE:.0f} %" if alike else "no less"
    note += f" {left_out} more leave {much}; they stand among the details." if left_out else ""
    head = ("with", "error left", "times the noise", "chi-square per degree of freedom")
    return (Table(head, rows, marked=tuple(place for place, row in enumerate(shown) if row["accepted"]), note=note),)


def _candidates(diagnosis):
    unit = diagnosis.error.get("unit", "")
    tried = [entry for entry in diagnosis.candidates if entry.reason is not Reason.NOT_TRIED]
    if not tried:
        return ()
    rows = tuple(
        (entry.effect, number(entry.evidence, digits=4), size(entry.fitted, unit), size(entry.held_out, unit), entry.why)
        for entry in tried
    )
    marked = tuple(place for place, entry in enumerate(tried) if entry.accepted)
    note = "Fitted and held-out error: of the cheapest set that holds the effect. Evidence: of what was found what the set "
    note += "would lose without it, of the others that of their cheapest set over the model as it is."
    head = ("effect", "evidence", "fitted", "held out", "why")
    return (Table(head, rows, marked=marked, wordy=True, note=note),)


def _sets(diagnosis):
    if not diagnosis.sets:
        return ()
    unit = diagnosis.error.get("unit", "")
    rows = tuple(
        (
            " + ".join(entry["effects"]) or "no effect",
            f"{entry['weight']:.2f}",
            number(entry["chi2"], digits=5),
            size(entry["held_out"], unit),
        )
        for entry in diagnosis.sets
    )
    parts = [Table(("set", "weight", "chi-square", "held out"), rows, note="weight: probability among all fitted sets.")]
    held = {name: weight for name, weight in diagnosis.inclusion.items() if weight >= 0.005}
    if held:
        told = ", ".join(f"{name} {weight:.2f}" for name, weight in sorted(held.items(), key=lambda each: -each[1]))
        parts.append(f"Weight of all sets that hold an effect: {told}.")
    return tuple(parts)


def _where(diagnosis):
    return (where_table(diagnosis.where, diagnosis.error.get("unit", "")),) if diagnosis.where else ()


def where_table(rows, unit, most=12):
    """Where a model misses, worst first, as a Table; rms in the unit of the channel."""
    first = rows[0]
    keys = [key for key in first if key not in ("rms", "sigma", "phase" if "layer" in first else "")]
    texts = sum(key in ("trial", "channel", "phase") for key in keys)
    cells = tuple(
        (
            *(f"{row[key]:.4g}" if isinstance(row[key], float) else DASH if row[key] is None else str(row[key]) for key in keys),
            number(row["rms"], unit_of(row.get("channel"), unit)),
            f"{row['sigma']:.2f}",
        )
        for row in rows[:most]
    )
    note = f"{len(rows) - most} more in the JSON result." if len(rows) > most else ""
    head = tuple(f"{key} [{UNITS[key]}]" if key in UNITS else key for key in keys)
    return Table((*head, "rms", "in sigma"), cells, texts=max(texts, 1), note=note)
