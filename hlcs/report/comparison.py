"""How a Comparison is shown: printed, in a notebook, drawn, written into a folder."""

import json
import math

from hlcs.data.shown_by_impacts import impact_lines
from hlcs.files import folders
from hlcs.files.spreadsheets import csv_text
from hlcs.report.document import Lines, Points, Section, Table, as_text
from hlcs.report.doubted import doubt
from hlcs.report.figures import comparison_panels
from hlcs.report.notes import note_parts
from hlcs.report.page import fragment, png
from hlcs.report.sentences import NEAR_NOISE, left_by_adequate, place
from hlcs.report.statistics import where_table
from hlcs.report.words import DASH, chance, change_told, joined, number, size, two_digits

LEFT = {True: "nothing but noise", False: "more than noise", None: ""}
MOST_PLACES = 5
SLIGHT = 0.1  # of the noise, below which a bias is not worth a sentence


def left(comparison, adequate, over_noise, **_):
    """What a model leaves, in words; adequate, over_noise: as in a row of its `errors`.

    Of layers that are judged as adequate more may be left than tests scatter by."""
    if adequate and comparison.kind == "layers" and over_noise and over_noise > NEAR_NOISE:
        return "noise, campaigns, engines"
    doubted = doubt(comparison)
    return doubted.left if adequate is False and doubted else LEFT[adequate]


def line(comparison):
    """The comparison in a line: the error, and the noise beside it."""
    error, unit = comparison.error, comparison.error.get("unit", "")
    if comparison.adequate is None:
        return f"{comparison.title} ({comparison.kind}); not judged, the noise is unknown"
    what = f"{size(comparison.before.error['rms'], unit)} before, " if comparison.before else ""
    told = f"{what}error {size(error['rms'], unit)}, noise {size(error['noise'], unit)}"
    return f"{comparison.title} ({comparison.kind}); {told}: {left(comparison, **comparison.errors[-2])} is left"


def text(comparison, details=False):
    """The printed report of a Comparison; details: with the statistics."""
    more = () if details else (Section("", ("The statistics behind this: --details, or summary(details=True).",)),)
    known = [*sections(comparison), *(_details(comparison) if details else [])]
    return as_text(f"{comparison.title} ({comparison.kind})", [*known, *more])


def sections(comparison):
    """The report in plain words: does the model agree, the errors, where it misses, the impacts, notes."""
    unit = comparison.error.get("unit", "")
    places = tuple(place(row, unit) for row in comparison.where[:MOST_PLACES])
    impacts = impact_lines(comparison.impacts, comparison.at_impacts)
    found = [
        Section("", tuple(_opening(comparison)), "opening"),
        Section("The error", (_errors(comparison),) if comparison.adequate is not None else (), "errors"),
        Section("Where it misses most", (Points(places),) if places and not comparison.adequate else (), "where"),
        Section("Impacts", (Lines(tuple(line for line in impacts if line)),) if impacts else (), "impacts"),
        Section("How to go on", _next(comparison), "next"),
        Section("Notes on the data", note_parts(comparison.notes), "notes"),
    ]
    return [section for section in found if section.parts]


def _next(comparison):
    """What to type next where the model misses; where the file itself is doubted the opening says what to do first."""
    if comparison.adequate is not False or not comparison.following:
        return ()
    lead = "Which effect is missing, if the file is right:" if doubt(comparison) else "Which effect is missing:"
    return (lead, Lines((comparison.following,)))


def _opening(comparison):
    """The first sentences of a Comparison."""
    if comparison.adequate is None:
        return [
            "The noise of the measurement is unknown, so nobody can say whether the model misses anything.",
            f"To know it, {comparison.advice}.",
        ]
    unit, error = comparison.error.get("unit", ""), comparison.error
    here, noise = size(error["rms"], unit), size(error["noise"], unit)
    told = []
    if comparison.before:
        before = size(comparison.before.error["rms"], unit)
        told.append(f"With {change_told(comparison)} the error goes from {before} to {here}; the noise is {noise}.")
    if comparison.adequate:
        left = left_by_adequate(comparison, error["rms"], error["noise"], unit)
        told.append(f"The model agrees with the measurement: it misses by {here}, which {left}.")
    elif doubted := doubt(comparison):
        told.append(f"The model misses the measurement by {here}. {doubted.told}")
    elif error["rms"] > 1.5 * error["noise"]:
        told.append(
            f"The model misses the measurement by {here}, {two_digits(error['rms'] / error['noise'])} times the noise ({noise})."
        )
    else:
        told.append(
            f"The model misses the measurement by {here}; that is hardly more than the noise ({noise}), but it has a pattern "
            "that noise has not."
        )
    if abs(error.get("bias") or 0.0) > SLIGHT * error["noise"] and not comparison.adequate:
        much, side = size(abs(error["bias"]), unit), "more" if error["bias"] > 0 else "less"
        told.append(f"On average the model reads {much} {side} than was measured.")
    if comparison.where and not (comparison.adequate or doubt(comparison)):
        told.append(f"It misses most in {place(comparison.where[0], unit)}.")
    return [" ".join(told)]


def _errors(comparison):
    """The error beside the noise, before and after what was added."""
    unit = comparison.error.get("unit", "")
    noise = comparison.error["noise"]

    def bias(value):  # rounding is none
        return DASH if value is None else size(value if abs(value) > 1e-3 * noise else 0.0, unit)

    rows = tuple(
        (row["model"], size(row["error"], unit), number(row["over_noise"]), bias(row["bias"]), left(comparison, **row))
        for row in comparison.errors
    )
    head = (" ", comparison.error.get("measure") or "rms error", "times the noise", "bias", "what is left")
    note = f"Noise: {_noise(comparison.noise, unit)}. "
    note += "Bias: model - measured, positive where the model reads more than was measured."
    if comparison.before and comparison.kind == "trajectory":
        note += " Before: on the samples that are kept beside the model after."
        if comparison.impacts:  # starts of runs through them end at one of many dents of the sum of squares
            note += " Through impacts the error of a model that misses is known to one per cent, here and in a diagnosis."
    return Table(head, rows, wordy=True, note=note)


def _noise(noise, unit):
    told = noise.get("source") or "unknown"
    if along := noise.get("along_axes"):
        told += f", {joined(size(each, unit) for each in along)} along x, y and z"
    if step := noise.get("rounding"):
        told += f", and readings in steps of {size(step, unit)} ({size(step / math.sqrt(12), unit)} of it)"
    if inputs := noise.get("inputs"):
        told += f", and what inputs are stated to be off by ({size(inputs, unit)} of it)"
    return told + (f", correlation {noise['rho']:.2f} per step" if noise.get("rho") else "")


def _details(comparison):
    """The test of adequacy, and every place where the model misses."""
    if comparison.adequate is None:
        return []
    told = f"Statistic {number(comparison.statistic)}, p = {chance(comparison.p)}."
    found = [Section("Details: are the residuals noise?", (told,))]
    if comparison.where:
        found.append(
            Section("Details: where the model misses", (where_table(comparison.where, comparison.error.get("unit", "")),))
        )
    return found


def html(comparison):
    """A comparison in a notebook."""
    return fragment(f"{comparison.title} ({comparison.kind})", sections(comparison), _details(comparison))


def plot(comparison, ax=None):
    """Measured over model, and the residuals against time, height and speed, or the inputs of a table; returns the four Axes."""
    return comparison_panels(comparison, ax)


def save(comparison, folder):
    """Write comparison.json, residuals.csv, comparison.txt and, where there is something to draw, comparison.png."""
    found = {
        "residuals.csv": csv_text(comparison.to_dataframe().to_dict("list")).encode(),
        "comparison.txt": (text(comparison, details=True) + "\n").encode(),
    }
    if comparison.table:
        found["comparison.png"] = png(plot(comparison))
    found["comparison.json"] = json.dumps(comparison.to_json(), indent=1).encode()  # last: where it stands, the others do too
    return folders.save_files(folder, found)
