"""Outcome tables: one row, one experiment, one number; read from CSV and checked.

What cannot be used is refused by file, row and column (rows count from 1, the header is row 1).
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hlcs.data.frames import csv_of
from hlcs.data.free_falls import check_free
from hlcs.data.quantities import INPUTS, OUTCOMES
from hlcs.data.recordings import COLUMNS
from hlcs.data.rounded_readings import reading_step
from hlcs.files.csv_files import CsvLayout, CsvText, read_csv
from minibullet.errors import InputError, how_many

NAMELESS = "no name"  # what rows are called whose group is blank, where others have one
SD = "_sd"  # what the column of an input's error ends with


@dataclass(frozen=True)
class OutcomeTable:
    """One row, one experiment: inputs and one measured outcome."""

    file: Path | CsvText
    outcome: str
    values: np.ndarray  # (n,)
    inputs: dict  # name -> (n,) array
    groups: np.ndarray  # (n,) names
    setting: np.ndarray  # (n,) integer, equal for rows with equal inputs (replicates)
    rows: np.ndarray  # (n,) row of the file that each experiment stands in
    notes: tuple[str, ...]
    input_sd: dict = field(default_factory=dict)  # name -> (n,) one sigma of an error common to the rows of one setting

    @property
    def main(self):
        """Name of the main input: the first that differs from row to row, else the first; None where there is none."""
        varied = (name for name, values in self.inputs.items() if np.ptp(values) > 0)
        return next(varied, next(iter(self.inputs), None))


def read_outcomes(file):
    """The OutcomeTable of an ExperimentFile; raises InputError with file, row, column."""
    table = with_stated_errors(read_table(file.data_file), file)
    check_free(table, file.surroundings.gravity)
    return table


def with_stated_errors(table, file):
    """The table with the errors of its inputs that the experiment file states; InputError where it has no such input."""
    for name in file.input_sd:
        place = f"{file.path}: measurement.input_sd.{name}"
        if name not in table.inputs:
            raise InputError(f"{place}: the table has no column '{name}'; it has {', '.join(table.inputs) or 'no inputs'}")
        if name in table.input_sd:
            raise InputError(f"{place}: the table has a column '{name}_sd' too; keep one of them")
    stated = {name: np.full(len(table.values), sd) for name, sd in file.input_sd.items()}
    for name, _, what in _not_measured(table, stated):
        file.source.fail(name, what, "measurement.input_sd")
    for name, row, what in _not_measured(table, table.input_sd):
        raise InputError(f"{table.file}, row {table.rows[row]}, column {name}{SD}: {what}")
    return replace(table, input_sd=table.input_sd | stated)


def _not_measured(table, errors):
    """[(name, first row, what is said)] of errors of inputs, name -> (n,), as large as the largest value of their input.

    Such an input was not measured at all. Where all its values are zero (let go at rest, at the first mark) any error may be, and
    so may that of an input with a sign (a slope about level).
    """
    found = []
    for name, sd in errors.items():
        largest = float(np.max(table.inputs[name]))
        wrong = np.flatnonzero(sd >= largest)
        if INPUTS[name][0] >= 0 and largest > 0 and len(wrong):
            row = wrong[np.argmin(table.rows[wrong])]
            what = (
                f"{sd[row]:g} cannot be right where {name} is at most {largest:g}; it is one standard deviation in the unit of "
                "the column (of a length in m: 0.01, not 10, for 10 mm)"
            )
            found.append((name, row, what))
    return found


def read_table(path):
    """An OutcomeTable from a CSV, a Path or a CsvText, of inputs and one outcome column."""
    errors = {f"{name}{SD}": name for name in INPUTS}
    of_table, of_recordings = (*INPUTS, *errors, "group", *OUTCOMES), 'a recording, kind = "trajectory"'
    read = read_csv(path, CsvLayout(of_table, words=("group",), imported=True, elsewhere=COLUMNS, where=of_recordings))
    columns, rows = read.columns, read.rows
    outcomes = [name for name in columns if name in OUTCOMES]
    if len(outcomes) != 1:
        raise InputError(f"{read.name}: {len(outcomes)} outcome columns; exactly one of {', '.join(OUTCOMES)} is needed")
    if len(rows) < 3:
        raise InputError(f"{read.name}: {how_many(len(rows), 'row')}; at least 3 experiments are needed")
    (outcome,) = outcomes
    _check_ranges(read, INPUTS | {outcome: (0 if OUTCOMES[outcome] != "m" else -10, 1e4)})
    inputs = {name: values for name, values in columns.items() if name not in (outcome, "group", *errors)}
    settings = np.column_stack(list(inputs.values())) if inputs else np.zeros((len(rows), 1))
    setting = np.unique(settings, axis=0, return_inverse=True)[1].reshape(-1)
    input_sd = {errors[column]: _input_error(read, column, errors[column], setting) for column in errors if column in columns}
    notes, values = (), columns[outcome]
    _, first = np.unique(np.column_stack([settings, values]), axis=0, return_index=True)
    repeats = np.setdiff1d(np.arange(len(rows)), first)
    if len(repeats) and not coarse(values, setting):
        notes = (
            f"{path.name}, row {rows[repeats[0]]}: repeats inputs and outcome of an earlier row digit for digit "
            f"({len(repeats)} such rows): a true repeat, or a copy?",
        )
    groups = columns.get("group", np.full(len(rows), "")).astype(str)
    groups = np.where(groups == "", NAMELESS, groups)  # a blank one is a group, too
    # in order of their numbers, whatever that of the file: sums of the same numbers in another order have other last digits
    order = np.lexsort((groups, values, setting))
    inputs, input_sd = ({name: column[order] for name, column in some.items()} for some in (inputs, input_sd))
    groups = groups[order] if "group" in columns else np.array([f"row {row}" for row in rows[order]])
    return OutcomeTable(path, outcome, values[order], inputs, groups, setting[order], rows[order], notes, input_sd)


def coarse(values, setting):
    """Are readings (n,) so coarse that those of one setting (n,) agree to the digit by chance: is their step a tenth of what they
    scatter by, or more?"""
    freedom = len(values) - len(np.unique(setting))
    scatter = np.sqrt(np.sum(off_means(values, setting) ** 2) / freedom) if freedom else 0.0
    return 0 < 0.1 * scatter <= reading_step(values)


def off_means(values, cell):
    """Values (n,) less the mean of their cell, integers (n,): zero to the last bit where all of a cell are equal."""
    _, first, cell = np.unique(cell, return_index=True, return_inverse=True)
    off_first = values - values[first[cell]]  # a mean of equal numbers is rounded, one of zeros is not
    return off_first - (np.bincount(cell, off_first) / np.bincount(cell))[cell]


def inputs_like(table, frame):
    """The OutcomeTable of other rows than those of `table`, in the order in which they are given; their outcomes are nan.

    frame: inputs as columns, as `frames.csv_of` takes them, without the outcome. InputError where one is unknown or cannot be.
    """
    text = csv_of(frame, "inputs")
    read = read_csv(text, CsvLayout(tuple(INPUTS)))
    _check_ranges(read, INPUTS)
    count, given = len(read.rows), text.text.count("\n") - 1
    if count < given:  # of a file a row without any cell is no row; here an answer for each is awaited
        blank = next(row for row in text.rows if row not in read.rows)
        raise InputError(f"inputs, row {blank}: blank; every row needs its inputs")
    each, names = np.arange(count), np.array([f"row {row}" for row in read.rows])
    return OutcomeTable(text, table.outcome, np.full(count, np.nan), read.columns, names, each, read.rows, ())


def _check_ranges(read, ranges):
    """InputError at the first value of a CsvTable beyond its range; ranges: {column: (low, high)}."""
    for name, (low, high) in ranges.items():
        outside = (read.columns[name] < low) | (read.columns[name] > high) if name in read.columns else np.zeros(1, bool)
        if outside.any():
            worst = int(np.argmax(outside))
            raise InputError(
                f"{read.place(worst, name)}: {read.columns[name][worst]:g} cannot be right; it must be "
                f"between {low:g} and {high:g} (m, s, kg; angles in degrees, a slope is rise over run)"
            )


def _input_error(read, column, name, setting):
    """One sigma of the error of an input (n,), from a column; rows of one setting share the error, so they state one number."""
    if name not in read.columns:
        raise InputError(f"{read.head}: column '{column}' without the column '{name}' that it belongs to")
    values = read.columns[column]
    _, first = np.unique(setting, return_index=True)
    wrong, unlike = ~(values >= 0), values != values[first][setting]
    if (wrong | unlike).any():
        worst = int(np.argmax(wrong | unlike))
        what = f"{values[worst]:g}; a standard deviation is zero or more"
        if not wrong[worst]:
            what = f"{values[worst]:g} where a row of equal inputs has {values[first][setting][worst]:g}; they share one error"
        raise InputError(f"{read.place(worst, column)}: {what}")
    return values
