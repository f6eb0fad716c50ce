"""Exports of the phone app phyphox: a CSV, a zip of them, or the folder that it was unpacked to.

Format, from the app's own source (`DataExport.java` in github.com/phyphox/phyphox-android): one CSV for each set of data, columns
separated by comma, tab or semicolon, decimals with point or comma, names in quotes, numbers as 1.234567890E0, NaN where a column
is shorter; in a zip with `meta/device.csv` and `meta/time.csv`. The names of the columns come from the experiments in
github.com/phyphox/phyphox-experiments: `Raw Data` with "Time (s)" and "Acceleration x (m/s^2)" (reads gravity at rest) or "Linear
Acceleration x (m/s^2)" (gravity taken out by the phone); the acoustic and motion stopwatch with "Event time (s)", or "Start (s)",
"Stop (s)", or "Stop 1 (s)"..; "(In)elastic collision" with "Bounce 0 (s)", "Bounce 1 (s)"...
"""

import os
import re
import zipfile
import zlib
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np

from hlcs.files.csv_files import MOST_BYTES
from hlcs.importing.axes import turned
from hlcs.importing.found import Assumption, Found, recording
from hlcs.importing.gravity_read import STANDARD_GRAVITY, attitude, flies
from hlcs.importing.grids import Source, grid_of, source_of
from hlcs.importing.units import scale, split_unit
from minibullet.errors import InputError, shown

NAME = "phyphox"
USES = ("up", "time_unit", "release_time", "constant")
MOST_MEMBERS = 100  # of a zip; phyphox writes one for each set of data, and two
DAMAGED = (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, ValueError, EOFError, OSError, KeyError)
LEAST = (
    "expected Time (s) with Acceleration x, y, z or Linear Acceleration x, y, z (m/s^2); or the times of a stopwatch: "
    "Event time (s), or Start (s) and Stop (s); or Bounce 0 (s), Bounce 1 (s), .."
)
ACCELERATION = re.compile(r"(linear |lineare )?(?:acceleration|beschleunigung) ([xyz])")
SOUND = re.compile(r"(start|stop|bounce)(?: (\d+))?")


def read(path, overrides):
    """The Found of one export: accelerations as a recording, or times of sounds as rows. Raises InputError."""
    grids = [grid_of(source) for source in _sources(Path(path))]
    readers = {"events": _events, "sounds": _sounds, "acceleration": _acceleration}
    for kind in readers:  # the list of all events before its first six
        for grid in grids:
            if words := _recognised(grid, kind):
                for index, _ in words.values():
                    grid.once(0, index)
                grid.as_many_cells_as_names(0)
                found = readers[kind](grid, words, overrides)
                others = ", ".join(other.name for other in grids if other is not grid)
                told = (Assumption(f"{grid.name} is read; left out: {others}"),) if others else ()
                return Found(found.recordings, found.rows, found.measurement, (*grid.assumptions, *told, *found.assumptions))
    there = "; ".join(f"{grid.name}, row {grid.lines[0]}: {shown(', '.join(grid.cells[0]), 120)}" for grid in grids)
    raise InputError(f"{there}: nothing of phyphox that can be compared; {LEAST}")


def _sources(path):
    """The CSV files of an export, its metadata left out."""
    if os.path.isdir(path):
        found = [source_of(member) for member in sorted(path.iterdir()) if member.suffix.lower() == ".csv"]
    else:
        source = source_of(path)
        found = _members(source) if source.data.startswith(b"PK\x03\x04") else [source]
    if not found:
        raise InputError(f"{shown(path, 255)}: holds no .csv; {LEAST}")
    return [Source(one.name, path.stem, one.data) for one in found]


def _members(source):
    """The CSV files in a zip, each no larger than a CSV may be."""
    try:
        with zipfile.ZipFile(BytesIO(source.data)) as archive:
            infos = archive.infolist()
            if any(info.filename == "xl/workbook.xml" for info in infos):
                raise InputError(
                    f"{source.name}: is an Excel workbook; choose one of the CSV formats when exporting from phyphox"
                )
            tables = [
                one
                for one in infos
                if one.filename.lower().endswith(".csv") and not one.filename.startswith(("meta/", "__MACOSX"))
            ]
            if len(infos) > MOST_MEMBERS or sum(one.file_size for one in tables) > MOST_BYTES:
                raise InputError(
                    f"{source.name}: unpacks to more than {MOST_MEMBERS} files or {MOST_BYTES / 1e6:g} MB; export fewer data"
                )
            stem = Path(source.name).stem
            return [Source(f"{source.name}/{shown(one.filename)}", stem, archive.read(one)) for one in tables]
    except InputError:
        raise
    except DAMAGED as problem:
        raise InputError(f"{source.name}: cannot be unpacked ({shown(problem, 100)}); export it again as CSV") from None


def _recognised(grid, kind):
    """{what a column is: (index, unit)} where the first row has the columns of that kind, else {}."""
    words = {name: (index, unit) for index, (name, unit) in reversed(list(enumerate(map(split_unit, grid.cells[0]))))}
    if kind == "events":
        return {"event": words["event time"]} if "event time" in words else {}
    if kind == "sounds":
        sounds = {name: place for name, place in words.items() if SOUND.fullmatch(name)}
        return sounds if len(sounds) > 1 else {}
    axes = {name: place for name, place in words.items() if ACCELERATION.fullmatch(name)}
    time = next((words[name] for name in ("time", "t", "zeit") if name in words), None)
    return {"time": time, **axes} if axes and time else {}


def _acceleration(grid, words, overrides):
    """A recording of what an accelerometer reads, in the axes of the phone or, where one is known to point up, of the world."""
    factor, notes = scale("time", words["time"][1], overrides, "times", grid.place(0))
    times = factor * grid.column(1, words["time"][0], "Time (s)")
    vectors, linear = np.full((len(times), 3), np.nan), set()
    for name, (index, unit) in words.items():
        if found := ACCELERATION.fullmatch(name):
            size, told = scale("acceleration", unit, overrides, "accelerations", grid.place(0, grid.cells[0][index]))
            notes += told
            vectors[:, "xyz".index(found[2])] = size * grid.column(1, index, grid.cells[0][index])
            linear.add(bool(found[1]))
    if len(linear) > 1:
        raise InputError(f"{grid.place(0)}: holds accelerations with and without gravity; export them one by one")
    up = overrides.up or ("z" if True in linear else None)
    if up == "none":
        raise InputError("--up none: an axis of the phone is needed: x, -x, y, -y, z, -z")
    if True in linear:
        vectors = turned(vectors, up) + np.array([0.0, 0.0, STANDARD_GRAVITY])
        still = (
            "the phone does not turn, and its z axis, out of the screen, points up"
            if overrides.up is None
            else "the phone does not turn"
        )
        notes.append(
            Assumption(
                f"{still}: {STANDARD_GRAVITY} m/s2, which it took out, is added along z, as an accelerometer reads it", "--up"
            )
        )
    elif up is not None:
        vectors = turned(vectors, up)
        notes.append(Assumption("the phone does not turn: its accelerations are written in the axes of the world", "--up"))
    else:
        notes.append(Assumption("accelerations are in the axes of the phone, which turns with the body", "--up"))
    columns = {"t_s": times} | dict(zip(("ax_m_s2", "ay_m_s2", "az_m_s2"), vectors.T, strict=True))
    found, told = recording(grid.stem, grid, grid.lines[1:], columns, "Time (s)")
    flying, why = flies(times, vectors, grid.name)
    start, reading = ({}, ()) if up else attitude(vectors, grid.name)
    found = replace(found, start=start, flies=flying)
    return Found((found,), None, {"accelerometer": "world" if up else "body"}, (*notes, *told, *why, *reading))


def _events(grid, words, overrides):
    """Rows of bounces from a list of the times of all sounds."""
    index, unit = words["event"]
    factor, notes = scale("time", unit, overrides, "times", grid.place(0))
    times = factor * grid.column(1, index, "Event time (s)")
    return _bounces(grid, times[np.isfinite(times)], False, overrides, notes)


def _sounds(grid, words, overrides):
    """Rows of bounces from the first row of Start, Stop 1, Stop 2.., or Bounce 0, Bounce 1..; what was not heard is NaN or 0."""
    times, notes = [], []
    if len(grid.cells) < 2:
        raise InputError(f"{grid.place(0)}: no row of times below it")
    for name in sorted(words, key=lambda name: (not name.startswith("start"), int(SOUND.fullmatch(name)[2] or 0))):
        index, unit = words[name]
        factor, told = scale("time", unit, overrides, "times", grid.place(0))
        first, *others = factor * grid.column(1, index, grid.cells[0][index])
        if np.isfinite(others).any():
            raise InputError(f"{grid.place(2)}: a second row of times; give each drop a file of its own")
        times.append(first)
        notes += told
    heard = [time for time in times if np.isfinite(time) and (time > 0 or time == times[0])]
    if len(heard) < len(times):
        notes.append(Assumption(f"{grid.name}: {len(times) - len(heard)} sounds were not heard, and are left out"))
    return _bounces(grid, np.array(heard), any(name.startswith("bounce") for name in words), overrides, notes)


def _bounces(grid, times, of_impacts, overrides, notes):
    """Rows with `bounce` = 1, 2, .. and `bounce_time_s` since the release; of_impacts: the first sound is an impact, and where
    nobody knows when the body was let go, `bounce_interval_s` from each to the next."""
    release, outcome = overrides.release_time, "bounce_time_s"
    if of_impacts and release is None:
        told = "the first sound is an impact, and the release made none: the times are those from one bounce to the next"
        notes, outcome = [*notes, Assumption(f"{grid.name}: {told}", "--release-time")], "bounce_interval_s"
    elif release is None and len(times):
        release, times = float(times[0]), times[1:]
        notes = [*notes, Assumption("the first sound is the release, the others are bounces 1, 2, ..", "--release-time")]
    between = outcome == "bounce_interval_s"
    since, heard = (times[:-1], times[1:]) if between else (np.full(len(times), release), times)
    if len(heard) == 0:
        raise InputError(f"{grid.name}: no sound of a bounce; at least two sounds are needed, the release and one bounce")
    if np.any(heard <= since) or np.any(np.diff(times) <= 0):
        raise InputError(f"{grid.name}: the sounds are not in order after the release at {since[0]:g} s; check --release-time")
    rows = {"bounce": np.arange(1.0, len(heard) + 1), outcome: heard - since, "group": np.array([grid.stem] * len(heard))}
    return Found((), rows, {}, tuple(notes))
