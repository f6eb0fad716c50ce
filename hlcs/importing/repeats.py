"""Columns of one outcome that stand beside one another, put below one another, a row each: repeats of an experiment, "Trial 1",
"Trial 2", .., and bounces after one drop, "bounce 1", "bounce 2", ..
"""

import re
from dataclasses import replace

import numpy as np

from hlcs.data.quantities import OUTCOMES
from hlcs.importing.found import Assumption
from hlcs.importing.units import UNITS, split_unit
from minibullet.errors import InputError, how_many, shown

# what people call a repeat, in English, German, French and Spanish
REPEAT = re.compile(
    r"\b(?:trial|run|repeat|reading|attempt|measurement|versuch|messung|durchgang|wiederholung|essai|mesure|ensayo|intento|medida|"
    r"no|nr)\b\.?"
)
NUMBERED = re.compile(r"\d{1,2}(?:\.|st|nd|rd|th|er|e|ª|º)\s*(?P<after>\D+)|(?P<before>.*?)[\s#.\-]*\d{1,2}(?P<rest>\s+\D+)?")
# "2. run", "run 2", "bounce 2 time"
APART = 0.1  # part by which successive bounces differ at least, and repeats do not, all in one direction
# what is computed of readings is none of them
COMPUTED = re.compile(
    r"\b(?:mean|average|avg|median|mittel(?:wert)?|durchschnitt|moyenne|media|promedio|std|stdev|sd|st\.? ?dev|std\.? ?abw|"
    r"standard deviation|standardabweichung|écart[ -]type|desviación|error|fehler|uncertainty|unsicherheit|incertitude)\b"
)


# those of them that before a row may be initials, a level or a remark
NOT_OF_ROWS = {"sd", "media", "error", "fehler", "uncertainty", "unsicherheit", "incertitude"}


def without_computed(grid, head):
    """The Grid without rows of means or deviations, whose first word says so: they are no experiments of their own."""

    def first_word(row):
        return next((cell for cell in grid.cells[row] if cell), "").lower().strip(" .:")

    words = {row: first_word(row) for row in range(head + 1, len(grid.cells))}
    computed = [row for row, word in words.items() if COMPUTED.fullmatch(word) and word not in NOT_OF_ROWS]
    if not computed:
        return grid
    lines, cells = ([part for row, part in enumerate(each) if row not in computed] for each in (grid.lines, grid.cells))
    told = f"computed of others, not read: left out (row {', '.join(str(grid.lines[row]) for row in computed[:5])})"
    note = Assumption(f"{grid.name}: {how_many(len(computed), 'row')} {told}")
    return replace(grid, lines=tuple(lines), cells=tuple(cells), assumptions=(*grid.assumptions, note))


def below_one_another(grid, head, units, meaning, overrides):
    """(grid, overrides) in which columns that repeat one outcome are one column, and each row of them is as many rows.

    Columns are repeats where the user says that they are one outcome, or where their names are the same but for a number and
    tell an outcome, a time, or a bounce: its number is then a column of its own. head: index of the row of names; units: does
    the row below it hold their units; meaning: names that are known -> columns of the project.
    """
    names = grid.cells[head]
    units_below = grid.cells[head + 1] if units else []
    together = _said(names, overrides) or _numbered(grid, head, units_below, meaning, overrides)
    if len(together) < 2:
        return grid, overrides
    first, others = together[0], {*together[1:]}
    word, unit = word_and_unit(names, units_below, first)
    if other := next((k for k in others if _size(word_and_unit(names, units_below, k)[1]) != _size(unit)), None):
        two = f"'{shown(names[first])}' and '{shown(names[other])}'"
        raise InputError(f"{grid.place(head)}: {two} are one outcome in two units; write both in one")
    means = None if names[first] in overrides.column else meaning.get(_stem(word)[0])
    order = {"rebound_height_m": -1, "bounce_time_s": 1}.get(means, 0)
    bounces = means == "bounce" or bool(order) and _in_order(grid, head + 1 + units, together, order)

    def row(cells, repeat, number=""):
        filled = cells + [""] * (len(names) - len(cells))
        return [filled[repeat] if k == first else cell for k, cell in enumerate(filled) if k not in others] + [number] * bounces

    called = names[first] if names[first] in overrides.column else _without_number(word, unit)
    if bounces:
        called = _with_unit("time" if means == "bounce_time_s" or unit in UNITS["time"] else "rebound height", unit)
    lines, cells = list(grid.lines[: head + 1 + units]), [list(cells) for cells in grid.cells[: head + 1 + units]]
    cells[head:] = [row(part, first, "bounce" if k == 0 else "") for k, part in enumerate(cells[head:])]
    cells[head][cells[head].index(names[first])] = called
    for line, part in zip(grid.lines[head + 1 + units :], grid.cells[head + 1 + units :], strict=True):
        for repeat in together:
            lines.append(line)
            cells.append(row(part, repeat, re.search(r"\d+", split_unit(names[repeat])[0])[0] if bounces else ""))
    listed = ", ".join(f"'{shown(names[k])}'" for k in together)
    are = "are the bounces after one drop" if bounces else "repeat one experiment"
    note = Assumption(f"{grid.name}: columns {shown(listed, 200)} {are}: a row each", "--column")
    column = {cell: name for cell, name in overrides.column.items() if cell not in {names[k] for k in others}}
    found = replace(grid, lines=tuple(lines), cells=tuple(cells), assumptions=(*grid.assumptions, note))
    return found, replace(overrides, column=column)


def _in_order(grid, first, columns, sign):
    """Does each of some columns read more (sign 1), or less (-1), than the one before by APART at least, in every row?"""
    readings = np.array([grid.column(first, k, "") for k in columns])
    return not np.any(sign * np.diff(readings, axis=0) <= APART * readings[:-1])  # one that is blank is no repeat


def _said(names, overrides):
    """Indices of the columns that the user calls one outcome."""
    for outcome in OUTCOMES:
        said = [k for k, cell in enumerate(names) if overrides.column.get(cell) == outcome]
        if len(said) > 1:
            return said
    return []


def _numbered(grid, head, units, meaning, overrides):
    """Indices of the columns whose names are the same but for a number, and tell an outcome, a time or a bounce; none where
    positions are numbered too: those are several bodies. Times that rise in every row are those at gates on one way, unless
    they are called trials, runs, ..
    """
    names, found, told = grid.cells[head], {}, {}
    for k, cell in enumerate(names):
        word, unit = word_and_unit(names, units, k)
        if cell not in overrides.column and word not in meaning and NUMBERED.fullmatch(word):
            stem, called = _stem(word)
            found.setdefault((stem, unit), []).append(k)
            name = meaning.get(stem) or ("t_s" if called and not stem and unit in UNITS["time"] else None)
            measured = name != "bounce" or unit in {*UNITS["time"], *UNITS["length"]}
            told[stem, unit] = (name, called) if measured else (None, called)
    if {name for name, _ in told.values()} - {*OUTCOMES, "t_s", "bounce", None}:
        return []
    for key, (name, called) in told.items():
        if name and len(found[key]) > 1:
            readings = np.array([grid.column(head + 1 + bool(units), k, names[k]) for k in found[key]])
            if name != "t_s" or called or np.any(np.diff(readings, axis=0) <= 0):
                return found[key]
    return []


def word_and_unit(names, units, k):
    """(name, unit) of a column; units: those of the row below the names, [] where there is none."""
    word, unit = split_unit(names[k])
    return word, unit or unit_below(units, k)


def unit_below(units, k):
    """What the row below the names says of a column; "" where there is none."""
    return units[k].strip("[]() ").lower() if k < len(units) else ""


def _stem(word):
    """(a numbered name without its number and what people call a repeat, how often that stood there)."""
    parts = NUMBERED.fullmatch(word)
    named = (parts["after"] or parts["before"] + (parts["rest"] or "")) if parts else word
    stem, many = REPEAT.subn(" ", named)
    return " ".join(stem.split()), many


def _without_number(word, unit):
    """What a column of repeats is called without its number: "Trial 1 (s)" -> "time (s)"."""
    return _with_unit(_stem(word)[0] or "time", unit)


def _size(unit):
    """The size of a unit in that of the project, which is meant where none stands."""
    return next((units[unit] for units in UNITS.values() if unit in units), 1.0 if not unit else unit)


def _with_unit(name, unit):
    return f"{name} ({unit})" if unit else name
