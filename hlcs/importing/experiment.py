"""Writing what was imported: CSV files in the project's own format, and an experiment file with the places to fill in."""

import re
from typing import NamedTuple

import numpy as np

from hlcs.data.model_entries import FILL_IN
from hlcs.data.quantities import NEEDED_INPUTS, OUTCOMES
from hlcs.data.recordings import ACCELERATIONS, COLUMNS, PIXELS
from hlcs.files.documents import toml_value
from hlcs.files.spreadsheets import csv_text
from hlcs.importing.found import Assumption
from minibullet.errors import shown

EXPERIMENT = "experiment.toml"
RESTS_ON = {  # contact coefficient -> the outcomes that rest on it
    "friction": {"stop_distance_m", "slide_time_s"},
    "restitution": {"rebound_height_m", "bounce_time_s", "bounce_interval_s", "rebound_speed_m_s"},
}
CONTACTS = {
    "friction": "contact coefficient of body and floor: what you believe it is, such as 0.3; diagnose tells if it is not",
    "restitution": "speed after an impact over that before it, 0 to 1: what you believe it is; diagnose tells if it is not",
}
# what belongs in a column that is asked for where a table lacks it: inputs without which its outcome has no law
ASKED_OF_ROWS = {
    "height_m": "m: of the release, from the lowest point of the body to the floor; the same in all rows: --constant height_m=1",
    "speed_m_s": "m/s: of the body where it begins; the same in all rows: --constant speed_m_s=5",
    "impact_speed_m_s": "m/s: of the body just before it strikes; the same in all rows: --constant impact_speed_m_s=5",
    "mark_2_m": "m: of the second mark, below the release; the same in all rows: --constant mark_2_m=0.6",
    "bounce": "which impact after the release, 1 the first; the same in all rows: --constant bounce=2",
    "angle_deg": "degrees: how steep the slope is; the same in all rows: --constant angle_deg=5",
}
MOVES_A_SLIDE = {"angle_deg", "slope", "speed_m_s"}  # a slide without any of these stays where it is
AIR = 1.2  # density that is written [kg/m3]: left out it is any gas, whose lift and added mass need not go together
IN_AIR = Assumption(f"the body moves in air (surroundings.fluid_density = {AIR})")
DIGITS = ".12g"  # of numbers in the CSV: more than any export has, and 1.2 cm stay 0.012 m
WIDTH = 40  # where comments begin


class Place(NamedTuple):
    """A place in the experiment file, or in its table, that a person must fill in."""

    file: str
    line: int
    key: str
    what: str


def table_of(founds, overrides):
    """The columns of one outcome table from the rows of all files, those that not all have left blank.

    Constants that the user states are columns too; what the outcome cannot be computed without, and a slide from rest not without
    its slope, has "fill in" there.
    """
    names = dict.fromkeys(name for found in founds for name in found.rows)
    rows = {}
    for name in names:
        parts = []
        for found in founds:
            count = len(next(iter(found.rows.values())))
            missing = "" if name == "group" else np.nan
            parts += list(found.rows.get(name, [missing] * count))
        rows[name] = [part if isinstance(part, str) else rounded(part) for part in parts]
    count = len(next(iter(rows.values())))
    constants = {name: [value] * count for name, value in overrides.constant.items() if name not in rows}
    asked = [column for name in rows for column in NEEDED_INPUTS.get(name, ())]
    if "slide_time_s" in rows and not MOVES_A_SLIDE & {*rows, *constants}:
        asked.append("angle_deg")
    constants |= {column: [FILL_IN] * count for column in asked if column not in {*rows, *constants}}
    return constants | rows


def recording_text(recording):
    """The CSV text of a Recording."""
    return csv_text({name: [rounded(value) for value in column] for name, column in recording.columns.items()})


def rounded(value):
    """A number with the digits that are written, zero without a sign."""
    return float(format(value, DIGITS)) + 0.0


def has_replicates(rows):
    """Whether two rows of a table have the same inputs, so that their scatter tells the noise."""
    inputs = [values for name, values in rows.items() if name not in (*OUTCOMES, "group")]
    settings = list(zip(*inputs, strict=True)) if inputs else [()] * len(next(iter(rows.values())))
    return len(set(settings)) < len(settings)


def file_names(names):
    """{name: file name} of CSV files: letters, digits, - and _ alone, each its own whatever the case."""
    found = {}
    for name in names:
        stem = re.sub(r"[^\w-]+", "_", name, flags=re.ASCII).strip("_") or "recording"
        wanted, number = stem, 1
        while f"{wanted}.csv".lower() in {one.lower() for one in found.values()} or wanted == "rest":
            number += 1
            wanted = f"{stem}_{number}"
        found[name] = f"{wanted}.csv"
    return found


def experiment_text(head, sections, trials, assumptions):
    """The text of the experiment file.

    head: its first lines; sections: {title: lines}; trials: lists of lines; assumptions: of all files.
    """
    lines = list(head)
    if assumptions:
        lines += [
            "",
            "# Assumed where the export does not say it; an option in brackets, given to `hlcs import`, says otherwise:",
        ]
        lines += [f"# - {shown(one.text, 300)}" + (f"  [{one.option}]" if one.option else "") for one in assumptions]
    for title, entries in sections.items():
        lines += ["", f"[{title}]", *entries]
    for entries in trials:
        lines += ["", "[[trial]]", *entries]
    return "\n".join(lines) + "\n"


def entry(key, value, comment=""):
    """One line `key = value  # comment`."""
    text = f"{key} = {toml_value(value)}"
    return f"{text:{WIDTH}}  # {comment}" if comment else text


def optional(text, comment):
    """One line that is a comment until somebody wants it."""
    return f"{'# ' + text:{WIDTH}}  # {comment}"


def body_lines(known=(), stated=None):
    """[body], of a phone a box; known: columns of the recordings, or of a table that states it row by row.

    stated: {key: value} that the user states of all recordings.
    """
    stated = stated or {}
    weighed = "kg: weigh it; delete the line if it is not known"
    if "radius_m" in known:
        weighed = "kg, if bodies of all sizes have one mass; else delete the line and add a column mass_kg to the table"
    if known & {*ACCELERATIONS} and not known & {*COLUMNS[1:4], *PIXELS} and "radius" not in stated:
        size = '[x, y, z] in m along the axes of the phone, such as [0.075, 0.16, 0.008]; or shape = "sphere" with radius'
        return [entry("shape", "box"), entry("size", FILL_IN, size), entry("mass", stated.get("mass", FILL_IN), weighed)]
    others = '"disc", "cylinder", "cone" with radius, height; "box" with size = [x, y, z]; "cubipod" with side; "mesh" with mesh'
    lines = [entry("shape", "sphere", f"or {others}")]
    for key, column, comment in (("radius", "radius_m", "m: half the diameter"), ("mass", "mass_kg", weighed)):
        if column not in known:
            lines.append(entry(key, stated.get(key, FILL_IN), comment))
    area = "m2: what a drag coefficient refers to, of a body of none of these shapes, such as a coffee filter"
    return [*lines, optional("drag_area = 0.018", area)]


def surroundings_lines(known, flies=None, stated=None):
    """[surroundings], with what may be added, and what must be filled in.

    known: columns of the recordings, or of the table; flies: do the bodies of the recordings move through the air? None = nothing
    tells; stated: {key: value} that the user states of all recordings.

    A contact that the outcome rests on is asked for: a default would act in silence, and be told as if it had been measured.
    """
    stated = stated or {}
    lines = [entry("gravity", stated.get("gravity", 9.81), "m/s2")]
    if "fluid_density_kg_m3" not in known:
        lines.append(entry("fluid_density", stated.get("fluid_density", AIR), "kg/m3; 998 in water, 0.0 in a vacuum"))
    lines += [entry(key, stated[key]) for key in ("fluid_viscosity", "tube_radius") if key in stated]
    asked = [key for key, outcomes in RESTS_ON.items() if known & outcomes and key not in known]
    if known & {*OUTCOMES}:
        return lines + [entry(key, FILL_IN, CONTACTS[key]) for key in asked]
    if known & {*ACCELERATIONS} and not known & {*COLUMNS[1:4], *PIXELS} and not flies:
        floor = "m: 0.0 where the body lies or slides on a table or floor; delete the line if it flies"
        lines.append(entry("floor.height", FILL_IN if flies is None else 0.0, floor))
    elif known & {*COLUMNS[1:3], *PIXELS[:2]} and not known & {COLUMNS[3], PIXELS[2]}:
        held = "m: 0.0 where the body slides or rolls; delete the line where nothing holds it, or air carries it as a puck"
        lines.append(entry("floor.height", FILL_IN, held))
    else:
        where = "m: where the floor is, in the z of the recordings; left out = no floor"
        lines.append(optional("floor.height = 0.0", where))
    example = {"friction": 0.5, "restitution": 0.0}  # what acts where there is a floor and they are left out
    for key, told in CONTACTS.items():
        comment = f"{told}; where there is a floor"
        lines.append(entry(key, stated[key], comment) if key in stated else optional(f"{key} = {example[key]}", comment))
    return lines


def places_of(name, text):
    """The Places of a text of the experiment file where "fill in" stands."""
    found, section = [], ""
    for number, line in enumerate(text.split("\n"), start=1):
        code, _, comment = line.partition("  # ")
        if re.fullmatch(r"\[+\w+\]+", code.strip()):
            section = code.strip("[] ")
        if toml_value(FILL_IN) in code and not code.startswith("#"):
            found.append(Place(name, number, f"{section}.{code.split(' = ')[0].strip()}", comment.strip()))
    return found
