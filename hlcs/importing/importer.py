"""From exported files to an experiment: read, told what was assumed, written with the places that a person must fill in."""

import os
import shlex
import unicodedata
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from hlcs.data.model_entries import FILL_IN
from hlcs.data.quantities import OUTCOMES, ROW_KEYS
from hlcs.data.recordings import ACCELERATIONS, COLUMNS, LEAST_AT_REST, PIXELS, Accelerations, Trial
from hlcs.data.validation import check_at_rest
from hlcs.files import folders
from hlcs.files.spreadsheets import csv_text
from hlcs.importing import optitrack, phyphox, spreadsheet, tracker
from hlcs.importing.axes import ORDERS, UPS
from hlcs.importing.column_names import IN_RECORDINGS, IN_TABLES
from hlcs.importing.experiment import (
    ASKED_OF_ROWS,
    EXPERIMENT,
    IN_AIR,
    Place,
    body_lines,
    entry,
    experiment_text,
    file_names,
    has_replicates,
    optional,
    places_of,
    recording_text,
    surroundings_lines,
    table_of,
)
from hlcs.importing.found import Assumption, Overrides, each_once
from hlcs.importing.units import CHOICES
from minibullet.errors import InputError, how_many, is_number, known_one, one_of, shown, shown_value

FORMATS = {"tracker": tracker, "phyphox": phyphox, "optitrack": optitrack, "csv": spreadsheet}
GROUP = "what is held out together: name the day, the camera, the ball"
ASKED = {  # what belongs in a place of [measurement] that is to be filled in
    "metres_per_pixel": "m: the length of a pixel, from a ruler in the view",
    "accelerometer": '"world": the axes do not turn and z points up; "body": they turn with the body',
}
TURNING = {  # what is needed of the start where an accelerometer turns with the body
    "orientation": "(w, x, y, z): how the axes of the phone lie at the start; [1.0, 0.0, 0.0, 0.0]: its z points up",
    "angular_velocity": "rad/s: how it turns at the start; [0.0, 0.0, 0.0]: it does not",
}
NEAREST = "the nearest is"
START = "m/s: in each [[trial]] that was let go at rest; what is not stated is fitted"


@dataclass(frozen=True, repr=False)
class Imported:
    """What was read from exports and written as an experiment."""

    experiment: Path  # the file to fill in
    kind: str  # "trajectory" or "outcomes"
    files: dict  # name of a CSV -> what it holds, in words
    assumptions: tuple[Assumption, ...]
    fill_in: tuple[Place, ...]

    def summary(self):
        """What was written, what was assumed, what is to be filled in, and the next command; lines of text."""
        lines = [f"Written to {self.experiment.parent}:", *(f"  {name}: {what}" for name, what in self.files.items())]
        if self.assumptions:
            lines += ["", "Assumed (in brackets the option that says otherwise):"]
            lines += [f"  - {one.text}" + (f"  [{one.option}]" if one.option else "") for one in self.assumptions]
        if self.fill_in:
            lines += ["", "Fill in:"]
            lines += [f"  {self.experiment.parent / file}, {at}: {key}  ({what})" for file, at, key, what in _once(self.fill_in)]
        return "\n".join([*lines, "", f"Then: {self.next}"])

    __str__ = summary

    def __repr__(self):
        return (
            f"<Imported: {self.kind}, {len(self.files)} files in {self.experiment.parent}, {len(self.fill_in)} places to fill in>"
        )

    @property
    def next(self):
        """The command that compares it."""
        return f"hlcs compare {self.experiment}"

    def to_json(self):
        """The result for a program."""
        return {
            "format": 1,
            "experiment": str(self.experiment),
            "kind": self.kind,
            "files": self.files,
            "assumed": [{"text": one.text, "option": one.option or None} for one in self.assumptions],
            "fill_in": [one._asdict() for one in self.fill_in],
            "next": self.next,
        }


def _once(places):
    """[(file, its lines in words, key, what belongs there)] of Places: a column that is asked for in many rows stands once."""
    lines = {}
    for one in places:
        lines.setdefault((one.file, one.key, one.what), []).append(one.line)
    return [
        (file, f"line {at[0]}" if len(at) == 1 else f"{len(at)} lines from {at[0]} on", key, what)
        for (file, key, what), at in lines.items()
    ]


def import_measurements(files, format, out, static=None, **overrides):
    """Read exports and write them as an experiment; returns an Imported.

    files: one path or several, all of one format; format: "tracker", "phyphox", "optitrack" or "csv"; out: the folder to write,
    new or an earlier import as it was written; static: an export of the same format of the body at rest, from which the noise
    is taken. overrides say what the files do not: up ("x", "-x", "y", "-y", "z", "-z", "none"), length_unit, time_unit,
    frame_rate [1/s], rotation_order ("XYZ" .. of Euler angles), column ({name in the file: name in the project, "" to leave it
    out}), only (names of bodies), constant ({column: value}), release_time [s]. Everything is written in SI, z up,
    quaternions scalar first. Raises InputError with file, row and what was expected where a file is not of the format.
    """
    paths = [files] if isinstance(files, str | Path) else list(files)
    if format not in FORMATS:
        raise InputError(f"'{shown(format)}' is no format; {one_of(format, FORMATS, 'one of')}")
    if not paths:
        raise InputError("no file to import")
    _each_once(paths, static)
    reader, said = FORMATS[format], checked_overrides(format, overrides)
    founds = [reader.read(path, said) for path in paths]
    kinds = {"outcomes" if found.rows is not None else "trajectory" for found in founds}
    if len(kinds) > 1:
        raise InputError(
            f"{shown(paths[0])} and others: some hold recordings, others one experiment a row; import them one by one"
        )
    (kind,) = kinds
    _check_constants(founds, said)
    still = None if static is None else reader.read(static, said)
    rest = still and _at_rest(still, static)
    contents, trials, whats = _tables(founds, said) if kind == "outcomes" else _recordings(founds)
    written = dict(contents)
    if kind == "outcomes" and rest:
        raise InputError("--static belongs to recordings; the noise of a table comes from rows with equal inputs")
    if rest:
        contents["rest.csv"] = recording_text(rest)
        whats["rest.csv"] = _in_words(rest)
    sections = _sections(founds, said, written, rest)
    read = [(shown(path, 255), found.assumptions) for path, found in zip(paths, founds, strict=True)]
    if still:
        read.append((shown(static, 255), [one for one in still.assumptions if not one.of_motion]))
    of_files = each_once(read)
    assumed = any(line.startswith("fluid_density") for line in sections["surroundings"])
    in_air = [IN_AIR] if assumed and "fluid_density_kg_m3" not in said.constant else []
    notes = tuple(dict.fromkeys((*of_files, *in_air)))
    head = _head(kind, reader.NAME, paths, said, Path(out).name if len(paths) > 1 else Path(paths[0]).stem)
    text = experiment_text(head, sections, trials, notes)
    places = places_of(EXPERIMENT, text) + _places_in(contents)
    target = folders.check_folder(out)
    with folders.result_folder(target) as folder:
        for name, content in contents.items():
            folders.write_text(folder / name, content)
        folders.write_text(folder / EXPERIMENT, text)
    return Imported(target / EXPERIMENT, kind, whats, notes, tuple(places))


def checked_overrides(format, given):
    """The Overrides of a dictionary, each one that the format listens to and of the right kind; InputError otherwise."""
    known = [one.name for one in fields(Overrides)]
    for name in given:
        if name not in known:
            raise InputError(f"'{shown(name)}' is no option of an import; {known_one(name, known, NEAREST)}")
    said = Overrides(**{name: value for name, value in given.items() if value is not None})
    said = replace(said, column={unicodedata.normalize("NFC", str(cell)): name for cell, name in said.column.items()})
    for name in said.given():
        if name not in FORMATS[format].USES:
            fits = ", ".join(other for other, reader in FORMATS.items() if name in reader.USES)
            raise InputError(f"{option(name)} says nothing about a file --as {format}; it belongs to {fits}")
    for name, choices in (("up", UPS), ("rotation_order", ORDERS), *((f"{one}_unit", units) for one, units in CHOICES.items())):
        value = getattr(said, name)
        if value is not None and value not in choices:
            raise InputError(f"{option(name)} {shown_value(value)}: {one_of(value, choices, 'must be one of')}")
    if said.frame_rate is not None and not (is_number(said.frame_rate) and 1e-3 <= said.frame_rate <= 1e7):
        raise InputError(f"--frame-rate {shown_value(said.frame_rate)}: must be a number of pictures a second, such as 240")
    if said.release_time is not None and not is_number(said.release_time):
        raise InputError(f"--release-time {shown_value(said.release_time)}: must be a time in s")
    columns = (*IN_RECORDINGS, *IN_TABLES)
    for name in filter(None, said.column.values()):  # "" leaves a column out
        if name not in columns:
            raise InputError(f"--column ..={shown(name)}: no column of this project; {known_one(name, columns, NEAREST)}")
    inputs = [name for name in IN_TABLES if name not in (*OUTCOMES, "group", "bounce")]
    for name, value in said.constant.items():
        if name not in inputs:
            raise InputError(f"--constant {shown(name)}: no input of a table; {known_one(name, inputs, NEAREST)}")
        if not is_number(value):
            raise InputError(f"--constant {shown(name)}={shown_value(value)}: must be a number, in SI")
    return said


def _check_constants(founds, said):
    """Refuse a constant that says nothing: about recordings what no experiment file states, about a table one of its columns."""
    for name in said.constant:
        if all(found.rows is None for found in founds) and name not in ROW_KEYS:
            raise InputError(
                f"--constant {name}: says nothing about recordings, only about a table with one experiment a row; "
                f"about recordings: {', '.join(ROW_KEYS)}"
            )
        if any(name in (found.rows or ()) for found in founds):
            raise InputError(f"--constant {name}: is a column of the table already; leave it out")


def option(name):
    """How the command calls an override."""
    return "--" + name.replace("_", "-")


def _each_once(paths, static):
    """Refuse a file that is named twice, under whatever names: a copy is no second measurement."""
    seen = {}
    for path in (*paths, *([static] if static is not None else [])):
        real = os.path.realpath(path)
        if real in seen:
            told = "it is among the files that are imported" if path is static else f"it is '{shown(seen[real], 255)}' again"
            raise InputError(f"{shown(path, 255)}: {told}; name each file once")
        seen[real] = path


def _at_rest(found, path):
    """The one recording of a body at rest; InputError where it moves."""
    if len(found.recordings) != 1:
        raise InputError(
            f"{shown(path, 255)}: {len(found.recordings)} recordings; --static takes one, of one body at rest (--only)"
        )
    (rest,) = found.recordings
    count = len(rest.columns["t_s"])
    if count < LEAST_AT_REST:
        raise InputError(
            f"{shown(path, 255)}: {how_many(count, 'sample')} at rest; at least {LEAST_AT_REST} are needed to know the noise"
        )
    missing = np.full((3, count), np.nan)
    position, read = (
        np.array([rest.columns.get(name, blank) for name, blank in zip(axes, missing, strict=True)]).T
        for axes in (COLUMNS[1:4], ACCELERATIONS)
    )
    still = Trial(rest.name, rest.group, rest.columns["t_s"], position, np.full((count, 4), np.nan), {}, None, None)
    check_at_rest(replace(still, accelerations=Accelerations(read, False, 0.0)), shown(path, 255))
    return rest


def _recordings(founds):
    """({file: CSV text}, lines of each [[trial]], {file: in words}) of recordings."""
    recordings = [one for found in founds for one in found.recordings]
    measurement = _of_measurement(founds)
    numbered = [
        f"{k} {one.name}" if [r.name for r in recordings].count(one.name) > 1 else one.name for k, one in enumerate(recordings, 1)
    ]
    names = file_names(numbered)
    contents, trials, whats = {}, [], {}
    for called, one in zip(numbered, recordings, strict=True):
        name = names[called]
        contents[name], whats[name] = recording_text(one), _in_words(one)
        trials.append([entry("file", name), entry("group", shown(one.group, 90), "" if trials else GROUP)])
        if measurement.get("accelerometer") == "body":
            trials[-1] += [entry(f"start.{key}", one.start.get(key, FILL_IN), comment) for key, comment in TURNING.items()]
    trials[0].append(optional("start.velocity = [0.0, 0.0, 0.0]", START))
    return contents, trials, whats


def _in_words(recording):
    """What a CSV holds, in words."""
    times = recording.columns["t_s"]
    step = (times[-1] - times[0]) / (len(times) - 1)
    return f"{', '.join(recording.columns)}; {len(times)} samples over {times[-1] - times[0]:.4g} s, one in {step:.4g} s"


def _tables(founds, said):
    """({file: CSV text}, [], {file: in words}) of an outcome table."""
    rows = table_of(founds, said)
    name = "bounces.csv" if "bounce" in rows else "measurements.csv"
    return {name: csv_text(rows)}, [], {name: f"{', '.join(rows)}; {how_many(len(next(iter(rows.values()))), 'row')}"}


def _places_in(contents):
    """The Places in tables where a number is to be filled in."""
    places = []
    for name, text in contents.items():
        header, *lines = (line.split(",") for line in text.split("\n"))
        for number, cells in enumerate(lines, start=2):
            if FILL_IN in cells:
                asked = header[cells.index(FILL_IN)]
                places.append(Place(name, number, asked, ASKED_OF_ROWS[asked]))
    return places


def _of_measurement(founds):
    """The keys of [measurement] that the files of an import say, {key: value}."""
    return {key: value for found in founds for key, value in found.measurement.items()}


def _measurement(founds, written, rest):
    """Lines of [measurement]; written: {file: CSV text}."""
    given = _of_measurement(founds)
    lines = [entry(key, value, ASKED.get(key, "") if value == FILL_IN else "") for key, value in given.items()]
    columns = _columns(founds)
    if not columns:
        (name,) = written
        lines.append(entry("file", name))
        if has_replicates(table_of(founds, Overrides())):
            return [*lines, optional("noise = 0.003", "one sigma of the outcome; left out = from rows with equal inputs")]
        return [*lines, entry("noise", FILL_IN, "one sigma of the outcome; or delete this line and repeat experiments")]
    if rest:
        return [*lines, entry("static", "rest.csv", "the noise is taken from the body at rest")]
    advice = "; or record the body at rest, and import it with --static"
    if columns & {*COLUMNS[1:4], *PIXELS}:
        lines.append(entry("noise.position", FILL_IN, f"m, one sigma{advice}"))
    if "qw" in columns:
        lines.append(entry("noise.orientation", FILL_IN, f"rad, one sigma{advice}"))
    if "ax_m_s2" in columns:
        lines.append(entry("noise.acceleration", FILL_IN, f"m/s2, one sigma{advice}"))
    return lines


def _columns(founds):
    """Names of the columns of all recordings."""
    return {name for found in founds for one in found.recordings for name in one.columns}


def _sections(founds, said, written, rest):
    """{title: lines} of the experiment file; written: {file: CSV text}; rest: Recording of the body at rest, or None."""
    rows = {name for found in founds for name in found.rows or ()}
    told = {one.flies for found in founds for one in found.recordings}
    flies = told.pop() if len(told) == 1 else None
    columns = {*rows, *_columns(founds)}
    if rows:  # constants are columns of the table; of recordings they stand in the experiment file
        columns, stated = {*columns, *said.constant}, {}
    else:
        stated = {ROW_KEYS[name][1]: value for name, value in said.constant.items()}
    return {
        "body": body_lines(columns, stated),
        "surroundings": surroundings_lines(columns, flies, stated),
        "model": [entry("effects", [], 'what is known to act, such as { name = "buoyancy", fluid_density = 1.2 }')],
        "measurement": _measurement(founds, written, rest),
    }


def _typed(name, value):
    """An override as it is typed, once for each of its values: --column "Höhe [cm]=height_m"."""
    values = [f"{key}={one}" for key, one in value.items()] if isinstance(value, dict) else value
    values = [values] if isinstance(values, str | float | int) else values
    return [f"{option(name)} {_quoted(str(one))}" for one in values]


def _quoted(word):
    """A word of a command, in the quotes that every shell takes where they do, else as the shells of Unix want it."""
    plain = shlex.quote(word)
    return plain if plain == word or set('"$`\\!') & set(word) else f'"{word}"'


def _head(kind, source, paths, said, title):
    """The first lines of the experiment file."""
    names = ", ".join(Path(path).name for path in paths)
    given = [words for name in said.given() for words in _typed(name, getattr(said, name))]
    return [
        f"# {shown(f'Imported by hlcs from {source}: {names}', 300)}",
        *([f"# with {shown(' '.join(given), 300)}"] if given else []),
        f'# Replace every "{FILL_IN}" by what you know, then: hlcs compare {EXPERIMENT}',
        "",
        entry("kind", kind),
        entry("title", shown(title, 100)),
    ]
