"""How a Diagnosis is shown: printed, in a notebook, drawn, written into a folder."""

import json

from hlcs.data.model_entries import FILL_IN
from hlcs.files import folders
from hlcs.files.documents import toml_value
from hlcs.files.spreadsheets import csv_text
from hlcs.records import VERDICTS, Reason
from hlcs.report.figures import diagnosis_panels
from hlcs.report.page import as_html, fragment, png
from hlcs.report.words import note_lines, number, where_lines

NOT_PROVED = {
    "ambiguous": ": it can be added, and is not proved: others of its set do as well",
    "unexplained": ": it can be added, and is not proved: it helps, and more than noise remains",
}


def text(diagnosis):
    """The printed report of a Diagnosis."""
    lines = [
        f"Diagnosis: {diagnosis.title} ({diagnosis.kind})",
        "",
        f"Verdict: {diagnosis.verdict}: " + VERDICTS[diagnosis.verdict].format(effects=", then ".join(diagnosis.effects)),
    ]
    if diagnosis.verdict == "unexplained" and diagnosis.effects:
        lines.append(f"Helps, not enough: {', then '.join(diagnosis.effects)}; more than noise remains after that.")
    for members in diagnosis.ambiguous:
        lines.append("One of these, not to be told apart here: " + ", ".join(members))
    if diagnosis.parameters:
        lines += ["", "Numbers (90 % intervals)"]
        for effect, numbers in diagnosis.parameters.items():
            for name, entry in numbers.items():
                if entry["value"] is None:
                    lines.append(f"  {effect:24s} {name:20s}    withheld   {entry['why']}")
                    continue
                unit = "" if entry["unit"] == "1" else f" {entry['unit']}"
                bounds = f"[{entry['low']:.4g}, {entry['high']:.4g}]"
                lines.append(f"  {effect:24s} {name:20s} {entry['value']:11.4g}   {bounds}{unit}")
    lines += ["", *_error_lines(diagnosis)]
    adequate = diagnosis.adequate
    if adequate["after"] is not None:
        words = {True: "adequate", False: "not adequate"}
        lines.append(
            f"Model {words[adequate['before']]} before, {words[adequate['after']]} after (statistic "
            f"{number(adequate['statistic'])}, p = {number(adequate['p'])})"
        )
    lines += _explained_lines(diagnosis)
    if diagnosis.learned is not None:
        lines += ["", f"Learned from what is left: {diagnosis.learned.text}"]
    if diagnosis.candidates:
        lines += ["", "Candidates", f"  {'effect':30s} {'evidence':>10s} {'fitted':>10s} {'held out':>10s}  why"]
        for finding in (entry for entry in diagnosis.candidates if entry.reason is not Reason.NOT_TRIED):
            mark = "*" if finding.accepted else " "
            lines.append(
                f" {mark}{finding.effect:30s} {number(finding.evidence, digits=4):>10s} {number(finding.fitted):>10s} "
                f"{number(finding.held_out):>10s}  {finding.why}"
            )
    untried = {}
    for finding in diagnosis.candidates:
        if finding.reason is Reason.NOT_TRIED:
            untried.setdefault(finding.why.removeprefix(Reason.NOT_TRIED(why="").why), []).append(finding.effect)
    lines += [f"  not tried, {why}: {', '.join(names)}" for why, names in sorted(untried.items())]
    visible = [finding for finding in diagnosis.candidates if finding.visible_from and not finding.accepted]
    if diagnosis.verdict == "complete" and visible:
        lines += ["", "The smallest effects these data would have shown"]
        lines += [f"  {finding.effect:30s} {finding.visible_from}" for finding in visible]
    if diagnosis.where:
        unit = diagnosis.error.get("unit", "")
        lines += ["", "Where the model still misses most", *where_lines(diagnosis.where[:5], unit)]
    if diagnosis.next_experiment is not None:
        lines += ["", "Next experiment", f"  {diagnosis.next_experiment.text}"]
    return "\n".join(lines + note_lines(diagnosis.notes) + _add_lines(diagnosis))


def _add_lines(diagnosis):
    """The line for [model], the file to put it in, the command to type next."""
    add, experiment = diagnosis.add, diagnosis.experiment
    if add is None:
        return []
    lines = ["", "Add it" + NOT_PROVED.get(diagnosis.verdict, "")]
    if diagnosis.mended:
        lines += [f"  written into [model] of {add['file']}:", f"    {add['toml']}"]
    elif add["file"]:
        known = experiment.file.effects
        entries = ", ".join([*map(toml_value, known), add["toml"]])
        lines += [
            f"  in {add['file']}, under [model]:",
            f"    effects = [{entries}]",
            f"    added = {toml_value(list(diagnosis.effects))}",
        ]
    else:
        lines.append(f"  {add['toml']}")
    if diagnosis.verdict == "ambiguous":
        lines += [f"  or instead: {', '.join(map(toml_value, entries))}" for entries in diagnosis.alternatives]
    lines += [f'  fill in first: {name} ("{FILL_IN}" stands for it): {why}' for name, why in add["fill_in"].items()]
    lines.append(f"  next: {add['next']}")
    if add["file"] and not diagnosis.mended:
        lines.append('  or let it be written: --apply NEW.toml; in Python diagnosis.apply(experiment).save("NEW.toml")')
    return lines


def _explained_lines(diagnosis):
    """How much of the misfit is explained, and what is left in units of the noise and of the user's tolerance."""
    lines, chi2 = [], (diagnosis.adequate.get("chi2_per_freedom") or {}).get("after")
    if diagnosis.explained is not None and diagnosis.effects and chi2 is not None:
        left = max(chi2 - 1.0, 0.0) ** 0.5
        verb = "explains" if len(diagnosis.effects) == 1 else "explain"
        share = f"{100 * diagnosis.explained:.4g} % of what the model misses beyond the noise"
        lines.append(f"{' and '.join(diagnosis.effects)} {verb} {share}; {left:.2g} sigma is left.")
    if diagnosis.tolerance:
        unit, met = diagnosis.tolerance["unit"], "met" if diagnosis.tolerance["met"] else "not met"
        left, value = (number(diagnosis.tolerance[name], unit) for name in ("left", "value"))
        lines.append(f"Tolerance {value}: {met}; {left} is left beyond the noise.")
    return lines


def _error_lines(diagnosis):
    unit, measure = diagnosis.error.get("unit", ""), diagnosis.error.get("measure") or "rms"
    lines = []
    for key, title in (("fitted", "on the fitted data"), ("held_out", "held out")):
        entry = diagnosis.error.get(key)
        if entry:
            before, after, noise = (number(entry[name], unit) for name in ("before", "after", "noise"))
            lines.append(f"Error ({measure}) {title:18s} {before:>12s} -> {after:<12s} noise {noise}")
    if diagnosis.error.get("fitted") and not diagnosis.error.get("held_out"):
        lines.append("Nothing could be held out: a single group, so the price of a candidate is doubled.")
    for step in diagnosis.steps:
        name = " + ".join(step["effects"]) or "the model as it is"
        lines.append(f"  {name:40s} fitted {number(step.get('fitted'), unit):>9s}  held out {number(step['held_out'], unit)}")
    return lines


def html(diagnosis):
    """A diagnosis in a notebook, with its figure."""
    return fragment(diagnosis.title, text(diagnosis), _picture(diagnosis))


def plot(diagnosis, ax=None):
    """Four panels: fit, residuals, ranking, the error falling to the noise floor; returns the four Axes."""
    return diagnosis_panels(diagnosis, ax)


def _picture(diagnosis):
    """The figure as PNG bytes, None where there is nothing to draw."""
    return png(plot(diagnosis)) if diagnosis.pictures else None


def save(diagnosis, folder):
    """Write result.json, candidates.csv, report.txt, report.html, model.toml and its data and, where one is drawn, a picture."""
    picture, words = _picture(diagnosis), text(diagnosis)
    found = {
        "candidates.csv": csv_text(diagnosis.to_dataframe().to_dict("list")).encode(),
        "report.txt": (words + "\n").encode(),
        "report.html": as_html(diagnosis.title, words, picture).encode(),
    }
    if picture is not None:
        found["diagnosis.png"] = picture
    if diagnosis.learned is not None and diagnosis.learned.effect_file:
        found[diagnosis.learned.file_name] = diagnosis.learned.effect_file.encode()
    if diagnosis.experiment is not None:
        found |= diagnosis.apply(diagnosis.experiment).files(folder, (*found, "result.json"))
    found["result.json"] = json.dumps(diagnosis.to_json(), indent=1).encode()  # last: where it stands, the others stand too
    return folders.save_files(folder, found)
