"""Measurements: recordings and outcome tables read from CSV, and a hard look at them before any fit.

What cannot be used is refused by file, row and column (rows count from 1, the header is row 1). What is odd but usable
is reported in `notes`, never dropped in silence. This room knows no physics beyond plausible units.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from minibullet.errors import InputError

from . import plausible
from .experiment_files import Body, ExperimentFile, Surroundings, read_experiment_file
from .toml_files import nearest

COLUMNS = ("t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
OUTCOMES = ("fall_time_s", "rebound_height_m", "stop_distance_m", "slide_time_s", "rest_height_m")
INPUTS = ("height_m", "slope", "speed_m_s", "angle_deg", "distance_m", "mass_kg", "radius_m", "friction", "restitution",
          "gravity_m_s2", "fluid_density_kg_m3", "fluid_viscosity_pa_s", "spin_rad_s", "group")


@dataclass(frozen=True)
class Trial:
    """One recording: samples of a body's pose, NaN where a sample is missing."""

    name: str
    group: str  # what is held out together
    times: np.ndarray  # (n,), increasing [s]
    position: np.ndarray  # centre of mass, world frame, NaN = missing [m], (n, 3)
    orientation: np.ndarray  # unit quaternion (w, x, y, z), NaN = missing, (n, 4)
    start: dict
    body: Body
    surroundings: Surroundings
    recording: str = ""  # name of the recording where this is a piece of one
    first_row: int = 0  # samples of the recording before this piece

    @property
    def columns(self):
        """Names of the measured channels: x, y, z and, with orientation, the rotation about the three axes rx, ry, rz."""
        seen = np.isfinite(self.position).any(axis=0)
        return [name for name, there in zip("xyz", seen, strict=True) if there] + (
            ["rx", "ry", "rz"] if np.isfinite(self.orientation).any() else [])


@dataclass(frozen=True)
class OutcomeTable:
    """One row, one experiment: inputs and one measured outcome."""

    file: Path
    outcome: str
    values: np.ndarray  # (n,)
    inputs: dict  # name -> (n,) array
    groups: np.ndarray  # (n,) names
    setting: np.ndarray  # (n,) integer, equal for rows with equal inputs (replicates)


@dataclass(frozen=True)
class Measurement:
    """An experiment file with its data, checked."""

    file: ExperimentFile
    trials: tuple[Trial, ...]
    static: Trial | None
    table: OutcomeTable | None
    notes: tuple[str, ...]


def read_measurement(path):
    """Read an experiment file with all its data (kinds trajectory and outcomes); raises InputError with file, row, column."""
    file = path if isinstance(path, ExperimentFile) else read_experiment_file(path)
    if file.kind == "outcomes":
        table, notes = read_outcomes(file.data_file)
        plausible.check_falls(table, file.surroundings.gravity)
        return Measurement(file, (), None, table, tuple(notes))
    notes, trials = [], []
    names = _short_names([entry.file for entry in file.trials])
    for entry, name in zip(file.trials, names, strict=True):
        times, position, orientation = read_recording(entry.file)
        trial = Trial(name, entry.group, times, position, orientation, entry.start, entry.body, entry.surroundings)
        for check in (plausible.check_clock, plausible.check_units, plausible.check_length, plausible.check_axes,
                      plausible.check_quaternions):
            check(trial, entry.file)
        notes += plausible.describe(trial, entry.file) + plausible.check_floor(trial, entry.file)
        trials.append(trial)
    plausible.check_duration(trials, file)
    plausible.refuse_copies(trials, [entry.file for entry in file.trials])
    static = None
    if file.static:
        times, position, orientation = read_recording(file.static)
        static = Trial(file.static.name, "static", times, position, orientation, {}, file.body, file.surroundings)
        if len(times) < 20:
            raise InputError(f"{file.static}: {len(times)} samples at rest; at least 20 are needed to know the noise")
        plausible.check_at_rest(static, file.static)
    return Measurement(file, tuple(trials), static, None, tuple(notes))


def read_rows(path, known, required):
    """Header and rows of a CSV: list of column names, list of (row number, list of texts); refuses unknown columns by name."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror or problem})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not text; give a CSV file in UTF-8") from None
    if "\0" in text:
        raise InputError(f"{path}: is not text; give a CSV file in UTF-8")
    rows = [(number, [cell.strip() for cell in row]) for number, row in enumerate(csv.reader(text.splitlines()), start=1)
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")]
    if not rows:
        raise InputError(f"{path}: is empty; the first row names the columns")
    header_row, header = rows[0]
    for sign, word in ((";", "semicolons"), ("\t", "tabs")):
        if any(sign in name for name in header):
            raise InputError(f"{path}, row {header_row}: columns are separated by {word}; write commas between columns, and "
                             "points, not commas, in decimals")
    for place, name in enumerate(header, start=1):
        if not name:
            raise InputError(f"{path}, row {header_row}: column {place} has no name; is there a comma too many?")
        if name not in known:
            raise InputError(f"{path}, row {header_row}: unknown column '{name[:40]}'; the nearest known column is "
                             f"'{nearest(name, known)}'")
        if header.count(name) > 1:
            raise InputError(f"{path}, row {header_row}: column '{name}' stands twice; keep one")
    for name in required:
        if name not in header:
            raise InputError(f"{path}, row {header_row}: column '{name}' is missing")
    for number, row in rows[1:]:
        if len(row) != len(header):
            hint = "; decimals are written with a point, 0.5, not 0,5" if len(row) == 2 * len(header) else ""
            raise InputError(f"{path}, row {number}: {len(row)} cells for {len(header)} columns{hint}")
    return header, rows[1:]


def read_number(path, row, column, text, blank_allowed=True):
    """One cell as a finite number; blank is NaN where allowed."""
    if text == "":
        if blank_allowed:
            return np.nan
        raise InputError(f"{path}, row {row}, column {column}: blank; every row needs this value")
    try:
        value = float(text)
    except ValueError:
        hint = "write decimals with a point, 0.5" if "," in text else "leave a missing sample blank"
        raise InputError(f"{path}, row {row}, column {column}: '{text}' is not a number; {hint}") from None
    if not np.isfinite(value):
        raise InputError(f"{path}, row {row}, column {column}: '{text}' is not finite; leave a missing sample blank")
    return value


def read_recording(path):
    """Times (n,), positions (n, 3) and orientations (n, 4) of one recording; NaN where blank or not recorded."""
    header, rows = read_rows(path, COLUMNS, ["t_s"])
    if len(header) == 1:
        raise InputError(f"{path}: only times; at least one of {', '.join(COLUMNS[1:])} is needed")
    quaternion = [name for name in COLUMNS[4:] if name in header]
    if quaternion and len(quaternion) < 4:
        raise InputError(f"{path}: columns {', '.join(quaternion)} without the rest; a quaternion needs qw, qx, qy, qz")
    table = np.full((len(rows), len(COLUMNS)), np.nan)
    for index, (row, cells) in enumerate(rows):
        for name, text in zip(header, cells, strict=True):
            table[index, COLUMNS.index(name)] = read_number(path, row, name, text, blank_allowed=name != "t_s")
    numbers = [row for row, _ in rows]
    times, position, orientation = table[:, 0], table[:, 1:4], table[:, 4:]
    if len(rows) < 2:
        raise InputError(f"{path}: {len(rows)} samples; a recording needs at least 2")
    steps = np.diff(times)
    if np.any(steps <= 0):
        worst = int(np.argmax(steps <= 0)) + 1
        what = "the same time twice (duplicate sample)" if steps[worst - 1] == 0 else "time goes backwards (unsorted)"
        raise InputError(f"{path}, row {numbers[worst]}, column t_s: {times[worst]:g} s after {times[worst - 1]:g} s: {what}")
    for index in range(len(rows)):
        there = np.isfinite(orientation[index])
        if there.any() and not there.all():
            raise InputError(f"{path}, row {numbers[index]}, columns qw..qz: partly blank; give all four numbers or none")
        length = np.linalg.norm(orientation[index]) if there.all() else 1.0
        if length < 1e-6:
            raise InputError(f"{path}, row {numbers[index]}, columns qw..qz: quaternion of zero length; blank if missing")
        if not 0.8 < length < 1.25:
            raise InputError(f"{path}, row {numbers[index]}, columns qw..qz: quaternion of length {length:.3g}, must be 1")
        orientation[index] /= length
    return times, position, orientation


def read_outcomes(path):
    """An OutcomeTable and notes from a CSV of inputs and one outcome column."""
    header, rows = read_rows(path, INPUTS + OUTCOMES, [])
    outcomes = [name for name in header if name in OUTCOMES]
    if len(outcomes) != 1:
        raise InputError(f"{path}: {len(outcomes)} outcome columns; exactly one of {', '.join(OUTCOMES)} is needed")
    if len(rows) < 3:
        raise InputError(f"{path}: {len(rows)} rows; at least 3 experiments are needed")
    columns = {name: np.array([cells[header.index(name)] if name == "group" else
                               read_number(path, row, name, cells[header.index(name)], blank_allowed=False)
                               for row, cells in rows]) for name in header}
    limits = {"height_m": (0, 1e3), "speed_m_s": (0, 400), "angle_deg": (-90, 90), "mass_kg": (1e-9, 1e7),
              "radius_m": (1e-6, 1e2), "distance_m": (0, 1e4), outcomes[0]: (0 if outcomes[0].endswith("_s") else -10, 1e4)}
    for name, (low, high) in limits.items():
        if name in columns and (np.any(columns[name] < low) or np.any(columns[name] > high)):
            worst = int(np.argmax((columns[name] < low) | (columns[name] > high)))
            raise InputError(f"{path}, row {rows[worst][0]}, column {name}: {columns[name][worst]:g} cannot be right; it must be "
                             f"between {low:g} and {high:g} (m, s, kg; angles in degrees)")
    inputs = {name: values for name, values in columns.items() if name not in (*outcomes, "group")}
    groups = columns.get("group", np.array([f"row {row}" for row, _ in rows]))
    table = np.column_stack(list(inputs.values())) if inputs else np.zeros((len(rows), 1))
    setting = np.unique(table, axis=0, return_inverse=True)[1].reshape(-1)
    values = columns[outcomes[0]]
    notes = []
    pairs = np.column_stack([table, values])
    if len(np.unique(pairs, axis=0)) < len(pairs):
        _, first = np.unique(pairs, axis=0, return_index=True)
        repeat = sorted(set(range(len(pairs))) - set(first.tolist()))
        notes.append(f"{path.name}, row {rows[repeat[0]][0]}: repeats inputs and outcome of an earlier row digit for digit "
                     f"({len(repeat)} such rows): a true repeat, or a copy?")
    return OutcomeTable(Path(path), outcomes[0], values, inputs, groups.astype(str), setting), notes


def _short_names(paths):
    """File names; with their folder where two share a name. A file listed twice is refused."""
    if len(set(paths)) < len(paths):
        twice = next(path for path in paths if paths.count(path) > 1)
        raise InputError(f"{twice}: stands in two [[trial]] entries (duplicate trial); keep one")
    names = [path.name for path in paths]
    return [name if names.count(name) == 1 else f"{path.parent.name}/{name}" for path, name in zip(paths, names, strict=True)]
