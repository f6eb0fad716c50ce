"""How a Comparison is shown: printed, in a notebook, drawn, written into a folder."""

import json

from hlcs.data.impacts import impact_lines
from hlcs.files import folders
from hlcs.files.spreadsheets import csv_text
from hlcs.report.figures import comparison_panels
from hlcs.report.page import fragment, png
from hlcs.report.words import note_lines, number, where_lines


def text(comparison):
    """The printed report of a Comparison."""
    lines = [f"Compare: {comparison.title} ({comparison.kind})", ""]
    unit = comparison.error.get("unit", "")
    if comparison.adequate is None:
        lines.append("The noise of the measurement is unknown, so no misfit can be judged.")
        lines.append(f"To know it, {comparison.advice}.")
    else:
        says = "nothing but noise" if comparison.adequate else "more than noise"
        lines.append(f"The residuals show {says}: statistic {number(comparison.statistic)}, p = {number(comparison.p)}")
        lines += _before_and_after(comparison) if comparison.before else _error(comparison)
    if comparison.where:
        lines += ["", "Where (worst first)", *where_lines(comparison.where[:12], unit)]
        if len(comparison.where) > 12:
            lines.append(f"  .. and {len(comparison.where) - 12} more")
    return "\n".join(lines + impact_lines(comparison.impacts, comparison.stated) + note_lines(comparison.notes))


def _error(comparison):
    """The error of the model beside the noise, in a line."""
    error, unit = comparison.error, comparison.error.get("unit", "")
    return [
        f"error {error.get('measure') or 'rms'} {number(error['rms'], unit)}, noise {number(error['noise'], unit)} "
        f"({_noise(comparison.noise)}), bias (model - measured) {number(error.get('bias'), unit)}"
    ]


def _before_and_after(comparison):
    """The error before and after what was added, and the noise, in a table."""
    error, unit = comparison.error, comparison.error.get("unit", "")
    head = f"error {error.get('measure') or 'rms'}"
    wide = max(len(head), 14)
    lines = ["", f"Added: {', '.join(comparison.added)}; noise: {_noise(comparison.noise)}; bias: model - measured"]
    lines.append(f"  {'':6s} {head:>{wide}s} {'over noise':>11s} {'bias':>12s}  what is left")
    for row in comparison.errors:
        left = {True: "nothing but noise", False: "more than noise", None: ""}[row["adequate"]]
        bias = "" if row["bias"] is None else number(row["bias"], unit)
        cells = f"{number(row['error'], unit):>{wide}s} {number(row['over_noise']):>11s} {bias:>12s}"
        lines.append(f"  {row['model']:6s} {cells}  {left}".rstrip())
    return lines


def _noise(noise):
    words = noise.get("source") or "unknown"
    return words + (f", correlation {noise['rho']:.2f} per step" if noise.get("rho") else "")


def html(comparison):
    """A comparison in a notebook."""
    return fragment(comparison.title, text(comparison))


def plot(comparison, ax=None):
    """Measured over model, and the residuals against time, height and speed, or the inputs of a table; returns the four Axes."""
    return comparison_panels(comparison, ax)


def save(comparison, folder):
    """Write comparison.json, residuals.csv, comparison.txt and, where there is something to draw, comparison.png."""
    found = {
        "residuals.csv": csv_text(comparison.to_dataframe().to_dict("list")).encode(),
        "comparison.txt": (text(comparison) + "\n").encode(),
    }
    if comparison.table:
        found["comparison.png"] = png(plot(comparison))
    found["comparison.json"] = json.dumps(comparison.to_json(), indent=1).encode()  # last: where it stands, the others do too
    return folders.save_files(folder, found)
