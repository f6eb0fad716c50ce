"""Tables that people keep in a spreadsheet, saved as CSV: any order of columns, units in their names, decimal commas.

What separates columns, and how decimals are written, follows RFC 4180 or what spreadsheets write where the comma is the decimal
sign (semicolons). The first row with words names the columns; a row below it may hold their units. Names are looked up in
`column_names`; `--column "name=t_s"` states what no list can know. A column of outcomes (fall_time_s, ..) makes a table with one
experiment a row; else the rows are the samples of one recording.
"""

import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hlcs.data.model_entries import FILL_IN
from hlcs.data.quantities import OUTCOMES
from hlcs.data.recordings import ACCELERATIONS, COLUMNS, PIXELS
from hlcs.importing.axes import turned
from hlcs.importing.column_names import DIAMETERS, IN_RECORDINGS, IN_TABLES, MEANING, TIMED, meaning, misspelt
from hlcs.importing.found import FEW, Assumption, Found, recording
from hlcs.importing.grids import MISSING, grid_of, is_number, source_of
from hlcs.importing.repeats import COMPUTED, below_one_another, unit_below, without_computed, word_and_unit
from hlcs.importing.runs import bare, runs_of, without_short_names
from hlcs.importing.units import KNOWN, SI, UNITS, quantity_of, scale, split_unit
from minibullet.errors import InputError, how_many, shown

NAME = "spreadsheet"
USES = ("up", "length_unit", "time_unit", "frame_rate", "column", "constant")
OFTEN, PART = 3, 0.2  # how many times beside heights, and which part, do not rise where they are of falls: repeats scatter
DROPS = 40  # rows of a height and a time that may each be a drop of its own
HALF = re.compile(r"half|halb|demi|medio|½|/ ?2")  # of a diameter that is a radius already
FIRST_ROWS = 12  # in which the row of names stands


class Column(NamedTuple):
    """Where a column of the project stands in a file."""

    index: int
    unit: str
    part: float = 1.0  # of what stands there: half of a diameter


def read(path, overrides):
    """The Found of one file: one recording, or the rows of a table. Raises InputError with file, row, and what was expected."""
    grid = without_short_names(grid_of(source_of(path)))
    head = _header(grid, overrides)
    grid, overrides = _without_columns(grid, head, overrides)
    grid = without_computed(grid, head)
    grid.as_many_cells_as_names(head)
    runs = runs_of(grid, head, overrides)
    nameless = [] if runs[0][0] is grid else _nameless(grid, head, head + 1 + _has_units(grid, head))
    first, *others = [_read(part, head, given) for part, given in runs]
    if others and any(run.rows for run in (first, *others)):
        raise InputError(f"{grid.place(head)}: outcomes of several runs beside one another; write a row each, below one another")
    told = dict.fromkeys([*nameless, *(note for run in (first, *others) for note in run.assumptions)])
    return replace(first, recordings=tuple(one for run in (first, *others) for one in run.recordings), assumptions=tuple(told))


def _without_columns(grid, head, overrides):
    """(grid, overrides) without the columns that the user leaves out."""
    names = {cell for cell, name in overrides.column.items() if not name}
    left = {index for index, cell in enumerate(grid.cells[head]) if names & {cell, bare(cell)}}
    if not left:
        return grid, overrides
    cells = tuple([cell for index, cell in enumerate(row) if index not in left] for row in grid.cells)
    there = {name for index in left for name in (grid.cells[head][index], bare(grid.cells[head][index]))}
    said = {cell: name for cell, name in overrides.column.items() if name or cell not in there}
    return replace(grid, cells=cells), replace(overrides, column=said)


def _read(grid, head, overrides):
    """The Found of one table; head: index of the row of names."""
    as_read, units = grid, _has_units(grid, head)
    nameless = _nameless(grid, head, head + 1 + units)
    grid, overrides = below_one_another(grid, head, units, MEANING, overrides)
    first = head + 1 + units
    columns, left, notes = _columns(grid, head, first, overrides, grid is not as_read)
    for name, place in columns.items():
        if _empty(grid, first, place.index):
            cell = grid.cells[head][place.index]
            raise InputError(f"{grid.place(head, cell)}: no number below it, to be {name}: delete the column, or fill it in")
    is_table = any(name in columns for name in OUTCOMES)
    above = ", ".join(map(str, grid.lines[:head]))
    passed = [Assumption(f"{grid.name}: what stands above the names of its columns is passed over (row {above})")] if head else []
    notes = [*grid.assumptions, *passed, *nameless, *notes]
    if is_table:
        rows, told = _rows(grid, first, columns, overrides)
        return Found((), rows, {}, (*notes, *told))
    found, measurement, told = _recording(grid, first, columns, left, overrides)
    return Found((found,), None, measurement, (*notes, *told))


def _header(grid, overrides):
    """Index of the row that names the columns: of those with words alone the first with the most names that are known."""
    known = {*IN_RECORDINGS, *IN_TABLES, *MEANING}
    rows = []
    for row in range(min(FIRST_ROWS, len(grid.cells) - 1)):
        cells = [cell for cell in grid.cells[row] if cell]
        if len(cells) > 1 and not any(map(is_number, cells)):
            count = sum(cell in overrides.column or bool({cell, split_unit(bare(cell))[0]} & known) for cell in cells)
            rows.append((-count, row))
    if rows:
        return min(rows)[1]
    told = f"{grid.place(0)}: '{shown(', '.join(grid.cells[0]), 100)}'; "
    if not any(is_number(cell) for cells in grid.cells for cell in cells) and len(grid.cells[0]) > 1:
        raise InputError(f"{told}no row of numbers follows these names")
    more = "; columns are separated by tabs, semicolons, commas or blanks" if len(grid.cells[0]) == 1 else ""
    if {split_unit(cell)[0] for cell in grid.cells[0]} & known and any(map(is_number, grid.cells[0])):
        more = "; a number names no column: call repeats Trial 1 (s), Trial 2 (s), .."
    raise InputError(
        f"{told}expected a row with the names of two columns or more, such as Zeit [s]; Höhe [cm], above the rows of numbers"
        f"{more}"
    )


def _nameless(grid, head, first):
    """Assumptions on columns without a name: of words, or the first one; readings are never passed over."""
    names, notes = grid.cells[head], []
    for index in (k for k, name in enumerate(names) if not name and not _empty(grid, first, k)):
        below = [row[index] for row in grid.cells[first:] if index < len(row) and row[index].lower() not in MISSING]
        if {below[0], split_unit(below[0])[0]} & {*IN_RECORDINGS, *IN_TABLES, *MEANING}:
            raise InputError(
                f"{grid.place(first)}: '{shown(below[0])}' names a column that has no name in row {grid.lines[head]}; write the "
                "names of all columns in one row"
            )
        if index and any(map(is_number, below)):
            raise InputError(
                f"{grid.place(head)}: column {index + 1} has numbers and no name; name each column, and those that repeat a "
                "reading alike but for a number, such as fall time 1 [s]; fall time 2 [s]"
            )
        notes.append(Assumption(f"{grid.name}: column {index + 1} is left out, it has no name"))
    return notes


def _left_out(grid, head, left, found):
    """Assumptions on the columns whose meaning is not known: one of all, and one of each that may part the rows of a table."""
    hints = {cell: _may_be_groups(grid, head, cell, found) or misspelt(cell, found) for cell in left}
    plain = [f"'{shown(cell)}'" for cell in left if not hints[cell]]
    told = [f"column '{shown(cell)}' is left out, its meaning is not known{hint}" for cell, hint in hints.items() if hint]
    if plain:
        many = len(plain) > 1
        more = f" and {len(plain) - FEW} more" if len(plain) > FEW else ""
        named = f"column{'s' * many} {', '.join(plain[:FEW])}{more} {'are' if many else 'is'} left out"
        told.append(f"{named}, {'their' if many else 'its'} meaning is not known")
    return [Assumption(f"{grid.name}: {text}", "--column") for text in told]


def _may_be_groups(grid, head, cell, found):
    """What to do where words that stand below a name may part the rows of a table: a ball, a floor, a person."""
    column = grid.cells[head].index(cell)
    below = {cells[column] for cells in grid.cells[head + 1 :] if column < len(cells)} - MISSING
    parts = len(below) > 1 and not any(map(is_number, below)) and any(name in found for name in OUTCOMES)
    if not parts or "group" in found:
        return ""
    return f'; where its words part the rows (a ball, a day, a person), state "{shown(cell)}=group", or import these one by one'


def _has_units(grid, head):
    """Whether the row below the names holds their units, and nothing else."""
    below = {cell.strip("[]() ").lower() for cell in grid.cells[head + 1]} - MISSING
    return bool(below) and below <= KNOWN


def _empty(grid, first, index):
    return all(index >= len(row) or row[index].lower() in MISSING for row in grid.cells[first:])


def _columns(grid, head, first, overrides, repeats=False):
    """({name in the project: Column}, columns that are not known, assumptions); known, or named by the user.

    first: row of the first numbers; repeats: do rows repeat one another, so that they are no samples?
    """
    known = dict.fromkeys((*IN_RECORDINGS, *IN_TABLES))
    units = grid.cells[head + 1] if _has_units(grid, head) else []
    found, left, said, asked = {}, [], [], dict(overrides.column)
    for index, cell in enumerate(grid.cells[head]):
        word, unit = word_and_unit(grid.cells[head], units, index)
        own = cell.strip() if cell.strip() in known else None
        name = asked.pop(cell, None) or own or meaning(word, unit)
        if name in COLUMNS[1:4] and cell not in overrides.column and unit in UNITS["pixels"] and overrides.length_unit is None:
            name = PIXELS[COLUMNS.index(name) - 1]
        if own and cell not in overrides.column:  # its name has its unit, unless the row below says another
            below = unit_below(units, index)
            unit = SI.get(quantity_of(own), "") if below in MISSING else below
            said += [f"column {cell} is in {unit}, as the row below its name says"] * (below not in {*MISSING, *SI.values()})
        if name is None:
            left += [cell] if cell else []
            continue
        if name in found:
            grid.once(head, index)
            raise InputError(
                f"{grid.place(head)}: both '{shown(grid.cells[head][found[name].index])}' and '{shown(cell)}' would be {name}; "
                f'state with --column "{shown(cell)}=.." what each is, or leave one out with "{shown(cell)}="'
            )
        halved = name == "radius_m" and any(part in DIAMETERS for part in word.split()) and not HALF.search(word)
        found[name] = Column(index, unit, 0.5 if halved else 1.0)
    if "t_s" in found and not {*found} & {*COLUMNS[1:3], *COLUMNS[4:], *PIXELS, *ACCELERATIONS}:  # samples: one after another
        repeats |= _rows_repeat(grid, first, found)
    if beside := _time_beside(found, overrides, repeats):
        found[beside] = found.pop("t_s")
    if "bounce" in found and "z_m" in found and not {*found} & {*OUTCOMES, "t_s", "frame"}:
        found["rebound_height_m"] = found.pop("z_m")  # of one drop
    if "z_m" in found and "height_m" not in found and any(name in found for name in OUTCOMES):
        found["height_m"] = found.pop("z_m")  # a height beside an outcome is that from which the body was let go
    there = ", ".join(f"'{shown(cell)}'" for cell in grid.cells[head] if cell)
    for cell in asked:
        raise InputError(f"{grid.place(head)}: no column '{shown(cell)}' (--column); there are {shown(there, 300)}")
    if not set(found) - {"t_s", "frame", "group"}:
        raise InputError(
            f"{grid.place(head)}: columns {shown(there, 300)}; none is known as a position or an outcome: "
            f"{_example(left)}; where each row is an experiment of its own, one is its "
            f"outcome: {', '.join(OUTCOMES)}; what is measured of none of these cannot be compared"
        )
    notes = [*_left_out(grid, head, left, found), *(Assumption(f"{grid.name}: {text}") for text in said)]
    for name, place in found.items():
        cell = grid.cells[head][place.index]
        half = "half of " if place.part != 1 else ""
        if cell != name and (half or cell not in overrides.column):
            since = ", counted from the release" if name == "bounce_time_s" else ""
            notes.append(Assumption(f"{grid.name}: {half}column '{shown(cell)}' is {name}{since}", "--column"))
    if {*found} == {"t_s", "z_m"} and len(grid.cells) - first <= DROPS and "t_s" not in overrides.column.values():
        cell = shown(grid.cells[head][found["t_s"].index])
        told = f'its rows are samples of one motion; where each is a drop of its own, state "{cell}=fall_time_s"'
        notes.append(Assumption(f"{grid.name}: {told}", "--column"))
    return found, left, notes


def _rows_repeat(grid, first, found):
    """Do times not rise from row to row, so that rows are no samples? Beside heights some may not, of samples out of order; equal
    ones at two heights are rounded times of a quick clock."""
    steps = np.diff(grid.column(first, found["t_s"].index, "t_s"))
    if "z_m" not in found:
        return bool(np.any(steps <= 0))
    back = (steps < 0) | (steps == 0) & (np.diff(grid.column(first, found["z_m"].index, "z_m")) == 0)
    return bool(back.sum() >= OFTEN and back.mean() > PART)


def _example(left):
    """How to say what columns are of which none is known: by their units, where these tell."""
    parts = [cell.split() for cell in left]
    if left and all(len(part) == 2 and is_number(part[0].replace(",", ".")) and part[1].lower() in KNOWN for part in parts):
        return f"their names are values: write '{shown(left[0])}' and the others into a column of their own, a row each reading"
    timed, placed = (next((c for c in left if split_unit(c)[1] in UNITS[unit_of]), None) for unit_of in ("time", "length"))
    motions = {*UNITS["speed"], *UNITS["acceleration"], *UNITS["rate of turn"]}
    placed = placed or next((cell for cell in left if cell != timed and split_unit(cell)[1] not in motions), "h")
    time = f' --column "{shown(timed)}=t_s"' if timed else ""
    return f'state what each is, such as --column "{shown(placed)}=z_m"{time}'


def _time_beside(found, overrides, repeats):
    """The outcome that a column of times is, by what stands beside it; None where rows are samples, or say what they are.

    repeats: rows repeat one another: a way or an angle beside a time is that of a slide, a height that of a fall.
    """
    if repeats and "t_s" in found and not {*found} & {*OUTCOMES, "bounce", "mark_2_m"}:
        return "slide_time_s" if {*found} & {"distance_m", "angle_deg", "slope"} else "fall_time_s"
    beside = next((outcome for column, outcome in TIMED.items() if column in found), None)
    other = {*OUTCOMES}
    if beside == "fall_time_s":  # beside a position it is that of a sample, beside a way or an angle that of a slide
        other |= {*COLUMNS[1:], *PIXELS, *ACCELERATIONS, "distance_m", "angle_deg"}
    stated = "t_s" in overrides.column.values() or {*found} & other
    return beside if "t_s" in found and not stated else None


def _si(grid, first, name, place, overrides):
    """(numbers of a column in SI, assumptions); place: its Column."""
    factor, told = scale(quantity_of(name), place.unit, overrides, f"{grid.name}: {name} is", f"{grid.name}, column {name}")
    return place.part * factor * grid.column(first, place.index, name), told


def _recording(grid, first, columns, left, overrides):
    """(Recording, keys of [measurement], assumptions) of rows that are samples; left: columns that are not known."""
    foreign = [name for name in columns if name not in IN_RECORDINGS]
    if not {*columns} - {*foreign, "t_s", "frame"}:
        raise InputError(
            f"{grid.place(first - 1)}: {', '.join(columns)}, and nothing of where the body is; samples of a recording need a "
            f"position, such as z_m, and a table one experiment a row an outcome: {', '.join(OUTCOMES)}{_what_left_is(left)}"
        )
    notes = [
        Assumption(f"{grid.name}: column {name} is left out: rows with t_s are samples of one recording", "--column")
        for name in foreign
    ]
    times, told = _times(grid, first, columns, left, overrides)
    notes += told
    if {*PIXELS} & {*columns} and {*COLUMNS[1:4]} & {*columns}:
        raise InputError(f"{grid.place(first - 1)}: positions in pixels beside positions in metres; leave one kind of column out")
    places = PIXELS if {*PIXELS} & {*columns} else COLUMNS[1:4]
    up = overrides.up or ("z" if places[2] in columns or places[1] not in columns else "y")
    if up == "y" and overrides.up is None:
        down = "; -y where pixels are counted downwards" if places is PIXELS else ""
        notes.append(Assumption(f"{grid.name}: y points up, as in a video; it becomes {places[2]}{down}", "--up"))
    values, measurement = {"t_s": times}, {"planar": True} if up == "none" else {}
    for axes in (places, ACCELERATIONS):
        vectors, told = _vectors(grid, first, axes, columns, overrides)
        values |= dict(zip(axes, turned(vectors, up).T, strict=True))
        notes += told
    if places is PIXELS:
        measurement["metres_per_pixel"] = FILL_IN
    if {*ACCELERATIONS} & {*columns}:
        measurement["accelerometer"] = FILL_IN
        if up not in ("z", "none"):
            raise InputError(
                f"{grid.name}: has accelerations, and {up} points up; turn them so that z points up, and state --up z"
            )
    quaternion = [name for name in COLUMNS[4:] if name in columns]
    if quaternion and len(quaternion) < 4:
        raise InputError(f"{grid.name}: {', '.join(quaternion)} without the rest; a quaternion needs qw, qx, qy, qz")
    if quaternion and up not in ("z", "none"):
        raise InputError(f"{grid.name}: has quaternions, and {up} points up; turn them so that z points up, and state --up z")
    values |= {name: grid.column(first, columns[name].index, name) for name in quaternion}
    outcome = "slide_time_s" if {"distance_m", "angle_deg"} & {*columns} else "fall_time_s"
    advice = f'where each row is an experiment of its own, say so with --column "..={outcome}"'
    found, told = recording(grid.stem, grid, grid.lines[first:], values, "t_s", advice)
    return found, measurement, [*notes, *told]


def _vectors(grid, first, axes, columns, overrides):
    """(vectors (n, 3) in SI or pixels, NaN where missing, assumptions) of the columns of three axes."""
    vectors, notes = np.full((len(grid.cells) - first, 3), np.nan), []
    for axis, name in enumerate(axes):
        if name in columns:
            vectors[:, axis], told = _si(grid, first, name, columns[name], overrides)
            notes += told
    return vectors, notes


def _times(grid, first, columns, left, overrides):
    if "t_s" in columns and overrides.frame_rate is None:
        return _si(grid, first, "t_s", columns["t_s"], overrides)
    if "frame" not in columns:
        needed = "a column 'frame', which --frame-rate needs" if overrides.frame_rate else "a column of times, such as Zeit [s]"
        raise InputError(f"{grid.place(first - 1)}: {needed}, is missing; there are {', '.join(columns)}{_what_left_is(left)}")
    if overrides.frame_rate is None:
        raise InputError(f"{grid.place(first - 1)}: frame numbers but no times; state --frame-rate, in pictures a second")
    return grid.column(first, columns["frame"].index, "frame") / overrides.frame_rate, []


def _what_left_is(left):
    """How to say what columns are that nobody understood, the end of a refusal: times are known by their unit alone."""
    if not left:
        return ""
    names, units = ", ".join(f"'{shown(cell)}'" for cell in left), [split_unit(cell)[1] for cell in left]
    told = f"; not understood: {shown(names, 200)}: state what each is with --column"
    timed = [cell for cell, unit in zip(left, units, strict=True) if unit in UNITS["time"]]
    if timed := [cell for cell in timed if not COMPUTED.search(split_unit(cell)[0])] or timed[:1]:
        again = f'; say the same outcome of each column that repeats it, --column "{shown(timed[1])}=.."' if timed[1:] else ""
        return (
            f'{told} "{shown(timed[0])}=t_s", or =slide_time_s or =fall_time_s where each row is an experiment of its own{again}'
        )
    told = f'{told} "NAME=COLUMN"; where each row is an experiment of its own, one is its outcome: {", ".join(OUTCOMES)}'
    if not {*units} & {*UNITS["speed"]}:
        return told
    return f"{told}; a final speed is none: give the time between two marks, passage_time_s with mark_1_m and mark_2_m"


def _rows(grid, first, columns, overrides):
    """(columns of an outcome table, assumptions): every row is an experiment of its own; rows without an outcome are left out."""
    foreign = [name for name in columns if name not in IN_TABLES]
    notes = [
        Assumption(f"{grid.name}: column {name} is left out: rows are experiments, not samples", "--column") for name in foreign
    ]
    rows = {}
    for name, place in columns.items():
        if name == "group":
            rows[name] = np.array([row[place.index] if place.index < len(row) else "" for row in grid.cells[first:]])
        elif name in IN_TABLES:
            rows[name], told = _si(grid, first, name, place, overrides)
            notes += told
    outcomes = [name for name in rows if name in OUTCOMES]
    if len(outcomes) > 1:
        raise InputError(
            f"{grid.place(first - 1)}: {' and '.join(outcomes)} are both outcomes; a table has one: leave the other out with "
            "--column NAME=, and import it by itself"
        )
    lost = np.isnan(rows[outcomes[0]])
    if lost.any():
        lines = ", ".join(str(grid.lines[first + k]) for k in np.flatnonzero(lost)[:5])
        notes.append(Assumption(f"{grid.name}: {how_many(int(lost.sum()), 'row')} without {outcomes[0]} left out (row {lines})"))
    rows = {name: values[~lost] for name, values in rows.items()}
    for name, values in rows.items():
        if name != "group" and np.isnan(values).any():
            line = grid.lines[first + int(np.flatnonzero(~lost)[np.argmax(np.isnan(values))])]
            raise InputError(f"{grid.name}, row {line}, column {name}: blank; every experiment needs its inputs")
    if "group" in rows and all(not word for word in rows["group"]):
        del rows["group"]
    return rows, notes
