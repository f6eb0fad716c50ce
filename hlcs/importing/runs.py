"""Runs that stand beside one another in one file, as the programs of school laboratories write them: a table of each.

Vernier's Logger Pro and Graphical Analysis name a column "Run 1: Time (s)", or "Latest: Time (s)" where there is one run; PASCO's
Capstone and SPARKvue name it "Time (s) Run #1". Viana names what it sees of each body "Objekt 1 x-Koordinate",
beside one time of all.
"""

import re
from dataclasses import replace

from hlcs.data.recordings import COLUMNS
from hlcs.importing.column_names import column_of
from hlcs.importing.found import Assumption
from minibullet.errors import InputError, shown

NAMES = (
    re.compile(r"(?P<run>[^:]*[^:\s])\s*:\s+(?P<name>\S.*)"),
    re.compile(r"(?P<name>.*\S)\s+(?P<run>Run #\d+)", re.IGNORECASE),
    BODIES := re.compile(r"(?P<run>(?:Objekt|Object|Objet|Objeto) \d+)\s+(?P<name>\S.*)", re.IGNORECASE),
)
LEAST = 2  # rows below the names of a run that was recorded
AS_TEXT = "Vernier Format"  # how a text export of Logger Pro begins: names, short names and units stand in three rows of it


def bare(cell):
    """The name of a column without that of its run."""
    return next((found["name"] for found in (names.fullmatch(cell) for names in NAMES) if found), cell)


def runs_of(grid, head, overrides):
    """[(Grid, Overrides)] of each run, its columns with their bare names; of the grid itself where not all columns name a run.

    What the user says of a bare name holds in every run. Runs without numbers are left out. head: index of the row of names.
    """
    cells = grid.cells[head]
    for names in NAMES:
        found = {index: names.fullmatch(cell) for index, cell in enumerate(cells) if cell}
        if all(found.values()) or names is BODIES and _of_bodies(found, cells):
            break
    else:
        return [(grid, overrides)]
    shared, runs = [index for index, match in found.items() if not match], {}
    for index, match in found.items():
        if match:
            runs.setdefault(match["run"], []).append(index)
    tables = {run: _columns(grid, head, shared, places) for run, places in runs.items()}
    filled = [run for run, table in tables.items() if len(table.cells) > head + LEAST]
    if not filled:
        raise InputError(f"{grid.place(head)}: fewer than two rows of numbers below the names of any run")
    told = (
        [f"{len(runs)} runs stand beside one another, a recording each: {shown(', '.join(runs), 200)}"] if len(runs) > 1 else []
    )
    told += [f"{shown(run)} is left out, it has fewer than two rows of numbers" for run in runs if run not in filled]
    notes = grid.assumptions + tuple(Assumption(f"{grid.name}: {text}") for text in told)
    parts = []
    for run in filled:
        of_others = {cell for index, cell in enumerate(cells) if index not in (*shared, *runs[run])}
        said = {cell: name for cell, name in overrides.column.items() if cell not in of_others}
        column = {bare(cell) if cell in cells else cell: name for cell, name in said.items()}
        stem = f"{grid.stem} {run}" if len(runs) > 1 else grid.stem
        parts.append((replace(tables[run], assumptions=notes, stem=stem), replace(overrides, column=column)))
    return parts


def _of_bodies(found, cells):
    """Are these columns, {place: match of BODIES or None}, a position of each body at least, and times of all of them?"""
    own = {(match["run"], column_of(match["name"])) for match in found.values() if match}
    shared = {column_of(cells[index]) for index, match in found.items() if not match}
    return (
        bool(own) and {run for run, _ in own} == {run for run, name in own if name in COLUMNS[1:4]} and shared <= {"t_s", "frame"}
    )


def _columns(grid, head, shared, own):
    """A Grid with columns that runs share and those of one alone, and of the rows below their names those in which one of the
    latter is filled."""
    rows = [[row[k] if k < len(row) else "" for k in (*shared, *own)] for row in grid.cells]
    rows[head] = [bare(cell) for cell in rows[head]]
    kept = [k for k, row in enumerate(rows) if k <= head or any(row[len(shared) :])]
    return replace(grid, lines=tuple(grid.lines[k] for k in kept), cells=tuple(rows[k] for k in kept))


def without_short_names(grid):
    """A Grid without the row of short names that a text export of Logger Pro has between names and units."""
    begins = [k for k, row in enumerate(grid.cells) if row and row[0].startswith(AS_TEXT)]
    if begins[:1] != [0] or len(grid.cells) < 5:
        return grid
    if len(begins) > 1:
        raise InputError(f"{grid.place(begins[1])}: another data set begins; export each as a file of its own, or as CSV")
    return replace(grid, lines=grid.lines[:4] + grid.lines[5:], cells=grid.cells[:4] + grid.cells[5:])
