"""What the user reads: printed reports in the manner of a fit report, one offline page, a folder of files."""

import base64
import html

from hlcs.data.impacts import impact_lines
from hlcs.files import folders
from hlcs.files.spreadsheets import csv_text
from hlcs.selection.diagnosis import VERDICTS, dumps


def number(value, unit="", digits=3):
    """A number for reading, a dash where there is none."""
    if value is None:
        return "-"
    return f"{value:.{digits}g}" + (f" {unit}" if unit and unit != "1" else "")


def comparison_text(comparison):
    """The printed report of a Comparison."""
    lines = [f"Compare: {comparison.title} ({comparison.kind})", ""]
    error, unit = comparison.error, comparison.error.get("unit", "")
    if comparison.adequate is None:
        lines.append("The noise of the measurement is unknown, so no misfit can be judged.")
        if comparison.kind == "trajectory":
            lines.append("Record the tracker looking at a body at rest (measurement.static), or state measurement.noise.")
    else:
        says = "nothing but noise" if comparison.adequate else "more than noise"
        lines.append(f"The residuals show {says}: statistic {number(comparison.statistic)}, p = {number(comparison.p)}")
        measure = error.get("measure") or "rms"
        lines.append(
            f"error {measure} {number(error['rms'], unit)}, noise {number(error['noise'], unit)} "
            f"({_noise(comparison.noise)}), bias (model - measured) {number(error.get('bias'), unit)}"
        )
    if comparison.where:
        lines += ["", "Where (worst first)", *_where_lines(comparison.where[:12], unit)]
        if len(comparison.where) > 12:
            lines.append(f"  .. and {len(comparison.where) - 12} more")
    return "\n".join(lines + impact_lines(comparison.impacts, comparison.stated) + _notes(comparison.notes))


def _noise(noise):
    text = noise.get("source") or "unknown"
    return text + (f", correlation {noise['rho']:.2f} per step" if noise.get("rho") else "")


def _where_lines(rows, unit):
    keys = [key for key in rows[0] if key not in ("rms", "sigma", "phase" if "layer" in rows[0] else "")]
    rms = "rms" if unit in ("", "1") else f"rms {unit}"
    head = "  " + " ".join(f"{key:>{_width(key)}s}" for key in keys) + f" {rms:>12s} {'in sigma':>9s}"
    cells = ["  " + " ".join(f"{_cell(row[key]):>{_width(key)}s}" for key in keys) for row in rows]
    return [head] + [text + f" {row['rms']:12.4g} {row['sigma']:9.2f}" for text, row in zip(cells, rows, strict=True)]


def _cell(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)[-24:]


def _width(key):
    return 24 if key == "trial" else 9


def _notes(notes):
    if not notes:
        return []
    more = [f"  .. and {len(notes) - 12} more (all in the JSON result)"] if len(notes) > 12 else []
    return ["", "Notes on the data", *(f"  {note}" for note in notes[:12]), *more]


def diagnosis_text(diagnosis):
    """The printed report of a Diagnosis."""
    lines = [
        f"Diagnosis: {diagnosis.title} ({diagnosis.kind})",
        "",
        f"Verdict: {diagnosis.verdict}: " + VERDICTS[diagnosis.verdict].format(effects=", then ".join(diagnosis.effects)),
    ]
    if diagnosis.verdict == "unexplained" and diagnosis.effects:
        lines.append(f"Accepted on the way: {', then '.join(diagnosis.effects)}; more than noise remains after that.")
    for members in diagnosis.ambiguous:
        lines.append("One of these, not to be told apart here: " + ", ".join(members))
    if diagnosis.parameters:
        lines += ["", "Numbers (90 % intervals)"]
        for effect, numbers in diagnosis.parameters.items():
            for name, entry in numbers.items():
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
    if diagnosis.candidates:
        lines += ["", "Candidates", f"  {'effect':30s} {'evidence':>10s} {'fitted':>10s} {'held out':>10s}  why"]
        for finding in (entry for entry in diagnosis.candidates if not entry.why.startswith("not tried")):
            mark = "*" if finding.accepted else " "
            lines.append(
                f" {mark}{finding.effect:30s} {number(finding.evidence, digits=4):>10s} {number(finding.fitted):>10s} "
                f"{number(finding.held_out):>10s}  {finding.why}"
            )
    untried = {}
    for finding in diagnosis.candidates:
        if finding.why.startswith("not tried: "):
            untried.setdefault(finding.why[11:], []).append(finding.effect)
    lines += [f"  not tried, {why}: {', '.join(names)}" for why, names in sorted(untried.items())]
    visible = [finding for finding in diagnosis.candidates if finding.visible_from and not finding.accepted]
    if diagnosis.verdict == "complete" and visible:
        lines += ["", "The smallest effects these data would have shown"]
        lines += [f"  {finding.effect:30s} {finding.visible_from}" for finding in visible]
    if diagnosis.where:
        unit = diagnosis.error.get("unit", "")
        lines += ["", "Where the model still misses most", *_where_lines(diagnosis.where[:5], unit)]
    if diagnosis.next_experiment is not None:
        lines += ["", "Next experiment", f"  {diagnosis.next_experiment.text}"]
    return "\n".join(lines + _notes(diagnosis.notes))


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


def fragment(title, text, picture=None):
    """A piece of HTML for a page of somebody else's, as a notebook is: the printed report and a picture (PNG bytes)."""
    image = ""
    if picture is not None:
        image = f'<img alt="{html.escape(title)}" src="data:image/png;base64,{base64.b64encode(picture).decode()}">'
    return (
        '<div class="hlcs-report"><style>.hlcs-report pre{overflow-x:auto;line-height:1.35}'
        f".hlcs-report img{{max-width:100%;height:auto}}</style>{image}<pre>{html.escape(text)}</pre></div>"
    )


def as_html(title, text, picture=None):
    """One page that opens offline: the printed report and, embedded, a picture (PNG bytes)."""
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>' + html.escape(title) + "</title><style>"
        "body{font-family:system-ui,sans-serif;margin:2em auto;max-width:75em;padding:0 1em;color:#222}"
        "pre{background:#f6f6f4;padding:1em}"
        f"</style></head><body><h1>{html.escape(title)}</h1>{fragment(title, text, picture)}</body></html>"
    )


def diagnosis_html(diagnosis):
    """A diagnosis in a notebook, with its figure."""
    return fragment(diagnosis.title, diagnosis.summary(), _picture(diagnosis))


def _picture(result):
    """The figure of a result as PNG bytes, None where there is nothing to draw."""
    from hlcs.report.figures import figure_bytes

    return figure_bytes(result)


def save_diagnosis(diagnosis, folder):
    """Write the files of a diagnosis into a folder; returns the folder."""
    picture = _picture(diagnosis)
    found = {
        "candidates.csv": csv_text(diagnosis.to_dataframe()).encode(),
        "report.txt": (diagnosis.summary() + "\n").encode(),
        "report.html": as_html(diagnosis.title, diagnosis.summary(), picture).encode(),
    }
    if picture is not None:
        found["diagnosis.png"] = picture
    if diagnosis.model is not None and hasattr(diagnosis.model, "files"):
        found |= diagnosis.model.files(folder)
    found["result.json"] = dumps(diagnosis).encode()  # last: where it stands, the others stand too
    return folders.save_files(folder, found)


def save_comparison(comparison, folder):
    """Write the files of a comparison into a folder; returns the folder."""
    import json

    found = {
        "residuals.csv": csv_text(comparison.to_dataframe()).encode(),
        "comparison.txt": (comparison.summary() + "\n").encode(),
    }
    picture = _picture(comparison)
    if picture is not None:
        found["comparison.png"] = picture
    found["comparison.json"] = json.dumps(comparison.to_json(), indent=1).encode()  # last, see above
    return folders.save_files(folder, found)
