"""Outcome tables: one row, one experiment, one number; read from CSV and checked.

What cannot be used is refused by file, row and column (rows count from 1, the header is row 1).
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hlcs.data import validation
from hlcs.data.quantities import INPUTS, OUTCOMES
from hlcs.files.csv_files import CsvLayout, CsvText, read_csv
from minibullet.errors import InputError


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


def read_outcomes(file):
    """The OutcomeTable of an ExperimentFile; raises InputError with file, row, column."""
    table = read_table(file.data_file)
    validation.check_falls(table, file.surroundings.gravity)
    return table


def read_table(path):
    """An OutcomeTable from a CSV, a Path or a CsvText, of inputs and one outcome column."""
    read = read_csv(path, CsvLayout((*INPUTS, "group", *OUTCOMES), words=("group",)))
    columns, rows = read.columns, read.rows
    outcomes = [name for name in columns if name in OUTCOMES]
    if len(outcomes) != 1:
        raise InputError(f"{read.name}: {len(outcomes)} outcome columns; exactly one of {', '.join(OUTCOMES)} is needed")
    if len(rows) < 3:
        raise InputError(f"{read.name}: {len(rows)} rows; at least 3 experiments are needed")
    (outcome,) = outcomes
    for name, (low, high) in (INPUTS | {outcome: (0 if outcome.endswith("_s") else -10, 1e4)}).items():
        outside = (columns[name] < low) | (columns[name] > high) if name in columns else np.zeros(1, bool)
        if outside.any():
            worst = int(np.argmax(outside))
            raise InputError(
                f"{read.place(worst, name)}: {columns[name][worst]:g} cannot be right; it must be "
                f"between {low:g} and {high:g} (m, s, kg; angles in degrees, a slope is rise over run)"
            )
    inputs = {name: values for name, values in columns.items() if name not in (outcome, "group")}
    settings = np.column_stack(list(inputs.values())) if inputs else np.zeros((len(rows), 1))
    setting = np.unique(settings, axis=0, return_inverse=True)[1].reshape(-1)
    notes, values = (), columns[outcome]
    _, first = np.unique(np.column_stack([settings, values]), axis=0, return_index=True)
    repeats = np.setdiff1d(np.arange(len(rows)), first)
    if len(repeats):
        notes = (
            f"{path.name}, row {rows[repeats[0]]}: repeats inputs and outcome of an earlier row digit for digit "
            f"({len(repeats)} such rows): a true repeat, or a copy?",
        )
    groups = columns.get("group", np.full(len(rows), "")).astype(str)
    # in order of their numbers, whatever that of the file: sums of the same numbers in another order have other last digits
    order = np.lexsort((groups, values, setting))
    inputs = {name: column[order] for name, column in inputs.items()}
    groups = groups[order] if "group" in columns else np.array([f"row {row}" for row in rows[order]])
    return OutcomeTable(path, outcome, values[order], inputs, groups, setting[order], rows[order], notes)
