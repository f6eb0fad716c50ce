"""Exports of Tracker, the video analysis program of Open Source Physics, as delimited text.

Format, from the program's own source (`ExportDataDialog.java` in github.com/OpenSourcePhysics/tracker): `#multi:` in the first
row where several tracks are exported; a row with the names of the tracks, each above its first column; a row of columns, `t` and
then the columns of each track in turn; then the rows. What separates columns (tab, blank, comma, semicolon) is the user's choice,
and may stand at the end of a row too; a cell is empty where a track has no mark in that frame. An example with two tracks:
physics.brocku.ca/Courses/2P20/Tracker, page 21. Lengths are in the unit in which the calibration was given, which the export does
not name; x points right and y up in the picture unless the axes were turned.
"""

import numpy as np

from hlcs.importing.axes import turned
from hlcs.importing.found import Assumption, Found, recording
from hlcs.importing.grids import grid_of, source_of
from hlcs.importing.units import scale, split_unit
from minibullet.errors import InputError, shown

NAME = "Tracker"
USES = ("up", "length_unit", "time_unit", "frame_rate", "only")
CLOCK = ("t", "time")
HEADER = 4  # rows in which the names of the columns stand
LEAST = "Tracker's text export begins with a row of the names of the point masses and a row of columns: t, x, y, .."


def read(path, overrides):
    """The Found of one file: a recording for each point mass. Raises InputError with file, row, and what was expected."""
    grid = grid_of(source_of(path))
    head, words = _header(grid)
    grid.as_many_cells_as_names(head)
    masses, notes = _masses(grid, head, words), []
    up = overrides.up or "y"
    if overrides.up is None:
        notes.append(
            Assumption(
                "y of the video points up: it becomes z_m, and x of the video x_m; the way to the camera is unknown", "--up"
            )
        )
    notes += _left_out(grid, head, words)
    recordings = []
    for name in overrides.chosen(list(masses), grid.name):
        times, told = _times(grid, head, words, _clock(words, masses[name]), overrides)
        notes += told
        vectors = np.full((len(times), 3), np.nan)
        for axis, index in masses[name].items():
            factor, told = scale("length", words[index][1], overrides, "lengths", grid.place(head, grid.cells[head][index]))
            notes += told
            vectors[:, "xyz".index(axis)] = factor * grid.column(head + 1, index, f"{axis} of {name}")
        columns = {"t_s": times} | dict(zip(("x_m", "y_m", "z_m"), turned(vectors, up).T, strict=True))
        called = grid.stem if len(masses) == 1 else f"{grid.stem} {name}"
        found, told = recording(called, grid, grid.lines[head + 1 :], columns, "t")
        recordings.append(found)
        notes += told
    if len(masses) > 1:
        notes.append(Assumption("each point mass is the centre of the same kind of body, with a recording of its own", "--only"))
    else:
        notes.append(Assumption("the point mass is the centre of the body"))
    return Found(tuple(recordings), None, {"planar": True} if up == "none" else {}, (*grid.assumptions, *notes))


def _header(grid):
    """(index of the row of columns, its (name, unit) pairs)."""
    for row in range(min(HEADER, len(grid.cells))):
        words = [split_unit(cell) for cell in grid.cells[row]]
        if any(word in CLOCK for word, _ in words):
            return row, words
    raise InputError(
        f"{grid.place(0)}: begins with '{shown(grid.cells[0][0])}', and no row of the first {HEADER} with t; {LEAST}"
    )


def _masses(grid, head, words):
    """{name of a point mass: {"x": index, "y": index}}; others of its columns are left out."""
    above = grid.cells[head - 1] if head else []
    starts = [index for index, cell in enumerate(above) if cell]
    if len(starts) == 1:
        starts = [0]
    names = [cell for cell in above if cell] or [grid.stem]
    masses = {}
    for index, (word, _) in enumerate(words):
        if word in ("x", "y"):
            which = int(np.searchsorted(starts, index, side="right")) - 1 if starts else 0
            own = masses.setdefault(names[max(which, 0)], {})
            if word in own:
                raise InputError(
                    f"{grid.place(head)}: column {word} stands twice for '{shown(names[max(which, 0)])}'; each point mass needs "
                    "its name in the row above its columns: export the table again with the names of the tracks"
                )
            own[word] = index
    if not masses:
        there = ", ".join(cell for cell in grid.cells[head] if cell)
        raise InputError(
            f"{grid.place(head)}: columns {shown(there, 200)}; x or y is needed: choose them in Tracker's export dialog"
        )
    return masses


def _left_out(grid, head, words):
    """[Assumption] on the columns that are not read: Tracker computes velocities and angles from x and y."""
    others = dict.fromkeys(
        cell for cell, (word, _) in zip(grid.cells[head], words, strict=True) if cell and word not in (*CLOCK, "x", "y", "frame")
    )
    return [Assumption(f"{grid.name}: left out, t, x and y are read alone: {shown(', '.join(others), 200)}")] if others else []


def _clock(words, own):
    """Index of the column of times of a point mass: the last one before its own columns, else the first."""
    clocks = [index for index, (word, _) in enumerate(words) if word in CLOCK]
    return max((index for index in clocks if index < min(own.values())), default=clocks[0])


def _times(grid, head, words, clock, overrides):
    """(times of all rows [s], assumptions); clock: index of their column."""
    if overrides.frame_rate is None:
        factor, _ = scale("time", words[clock][1] or "s", overrides, "times", grid.place(head))
        note = "t is in s, with the frame rate that Tracker had: wrong where a slow-motion video states another one"
        return factor * grid.column(head + 1, clock, "t"), [Assumption(note, "--frame-rate")]
    frames = next((index for index, (word, _) in enumerate(words) if word == "frame"), None)
    if frames is None:
        raise InputError(f"{grid.place(head)}: no column 'frame', which --frame-rate needs; choose it in Tracker's export dialog")
    return grid.column(head + 1, frames, "frame") / overrides.frame_rate, []
