"""Measurements: recordings and outcome tables read from CSV, and a hard look at them before any fit.

What cannot be used is refused by file, row and column (rows count from 1, the header is row 1). What is odd but usable
is reported in `notes`, never dropped in silence. This room knows no physics beyond plausible units.
"""

import csv
import difflib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from minibullet.errors import InputError

from .experiment_files import Body, ExperimentFile, Surroundings, read_experiment_file

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
        return Measurement(file, (), None, table, tuple(notes))
    notes, trials = [], []
    names = _short_names([entry.file for entry in file.trials])
    for entry, name in zip(file.trials, names, strict=True):
        times, position, orientation = read_recording(entry.file)
        trial = Trial(name, entry.group, times, position, orientation, entry.start, entry.body, entry.surroundings)
        check_units(trial, entry.file)
        check_length(trial, entry.file)
        notes += describe(trial, entry.file)
        trials.append(trial)
    refuse_copies(trials, [entry.file for entry in file.trials])
    static = None
    if file.static:
        times, position, orientation = read_recording(file.static)
        static = Trial(file.static.name, "static", times, position, orientation, {}, file.body, file.surroundings)
        if len(times) < 20:
            raise InputError(f"{file.static}: {len(times)} samples at rest; at least 20 are needed to know the noise")
        check_at_rest(static, file.static)
    return Measurement(file, tuple(trials), static, None, tuple(notes))


def read_rows(path, known, required):
    """Header and rows of a CSV: list of column names, list of (row number, list of texts); refuses unknown columns by name."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror or problem})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not text; give a CSV file in UTF-8") from None
    rows = [(number, [cell.strip() for cell in row]) for number, row in enumerate(csv.reader(text.splitlines()), start=1)
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")]
    if not rows:
        raise InputError(f"{path}: is empty; the first row names the columns")
    header_row, header = rows[0]
    for name in header:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)
            raise InputError(f"{path}, row {header_row}: unknown column '{name}'; the nearest known column is '{near[0]}'")
        if header.count(name) > 1:
            raise InputError(f"{path}, row {header_row}: column '{name}' stands twice; keep one")
    for name in required:
        if name not in header:
            raise InputError(f"{path}, row {header_row}: column '{name}' is missing")
    for number, row in rows[1:]:
        if len(row) != len(header):
            raise InputError(f"{path}, row {number}: {len(row)} cells for {len(header)} columns")
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
        raise InputError(f"{path}, row {row}, column {column}: '{text}' is not a number; leave a missing sample blank") from None
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


def check_units(trial, path):
    """Refuse what no dropped, thrown or rolling body does: wrong units of length or time."""
    duration = trial.times[-1] - trial.times[0]
    for axis, name in enumerate("xyz"):
        there = np.isfinite(trial.position[:, axis])
        if there.sum() < 4:
            continue
        t, z = trial.times[there], trial.position[there, axis]
        speed = np.median(np.abs(np.diff(z) / np.diff(t)))
        if speed > 400.0 or np.ptp(z) > 2000.0:
            raise InputError(f"{path}, column {name}_m: typical speed {speed:.3g} m/s over {np.ptp(z):.3g} m; "
                             "units that cannot be right: lengths in m, times in s")
    z = trial.position[:, 2]
    there = np.isfinite(z)
    if trial.surroundings.floor_height is None and trial.surroundings.gravity > 1 and there.sum() >= 5:
        a = 2 * np.polyfit(trial.times[there] - trial.times[0], z[there], 2)[0]
        if a < -6 * trial.surroundings.gravity:
            raise InputError(f"{path}, column z_m: apparent acceleration {-a:.3g} m/s2 in free flight; units that cannot be "
                             "right: lengths in m, times in s")
        if duration > 120:
            raise InputError(f"{path}, column t_s: free flight of {duration:.4g} s; units that cannot be right: times in s")


def check_length(trial, path):
    """Refuse a recording with fewer samples in a channel than its unknown start has numbers."""
    for axis, name in enumerate("xyz"):
        count = int(np.isfinite(trial.position[:, axis]).sum())
        unknown = 2 - ("position" in trial.start) - ("velocity" in trial.start)
        if 0 < count < unknown + 2:
            raise InputError(f"{path}, column {name}_m: {count} samples; {unknown + 2} are needed "
                             f"({unknown} for the start and 2 to judge by)")
    if not trial.columns:
        raise InputError(f"{path}: no sample at all in the columns {', '.join(COLUMNS[1:])}")


def check_at_rest(trial, path):
    """Refuse a static recording that moves: its two halves must agree within their scatter."""
    for axis, name in enumerate("xyz"):
        z = trial.position[np.isfinite(trial.position[:, axis]), axis]
        if len(z) >= 20:
            first, last = z[: len(z) // 2], z[len(z) // 2:]
            scatter = max(np.std(first), np.std(last), 1e-12)
            if abs(np.median(last) - np.median(first)) > 6 * scatter:
                raise InputError(f"{path}, column {name}_m: moves by {abs(np.median(last) - np.median(first)):.3g} m; a static "
                                 "recording must show a body at rest")


def describe(trial, path):
    """What is odd but usable in a recording: dropped frames, jitter, quantisation, repeated samples; a list of sentences."""
    notes = []
    steps = np.diff(trial.times)
    typical = np.median(steps)
    gaps = np.flatnonzero(steps > 1.6 * typical)
    if len(gaps):
        where = trial.times[np.argmax(steps)]
        notes.append(f"{path.name}: {len(gaps)} gaps, the longest {steps.max():.3g} s at t_s = {where:.4g} (typical step "
                     f"{typical:.3g} s)")
    jitter = np.std(steps[steps <= 1.6 * typical]) / typical
    if jitter > 0.005:
        notes.append(f"{path.name}: time steps jitter by {100 * jitter:.1f} % of {typical:.3g} s; true stamps are used")
    for axis, name in enumerate("xyz"):
        z = trial.position[:, axis]
        missing = int(np.isnan(z).sum())
        if 0 < missing < len(z):
            notes.append(f"{path.name}, column {name}_m: {missing} of {len(z)} samples missing")
        z = z[np.isfinite(z)]
        same = np.flatnonzero(np.diff(z) == 0)
        if len(z) > 10 and np.ptp(z) > 0 and len(same) > 0.2 * len(z):
            notes.append(f"{path.name}, {name}_m: {len(same)} samples repeat the one before: quantised or a frozen tracker")
        step = quantisation(z)
        if step:
            notes.append(f"{path.name}, column {name}_m: readings are multiples of {step:.3g} m")
    return notes


def quantisation(values):
    """Step of the reading [unit of values] if all values are multiples of one step coarser than 1e-6 of their range, else 0."""
    distinct = np.unique(values)
    if len(distinct) < 3 or len(distinct) > 0.7 * len(values):
        return 0.0
    step = np.min(np.diff(distinct))
    multiples = (distinct - distinct[0]) / step
    return float(step) if np.max(np.abs(multiples - np.round(multiples))) < 0.02 and step > 1e-6 * np.ptp(distinct) else 0.0


def refuse_copies(trials, paths):
    """Refuse a recording that stands twice, shifted or rotated copies included: copies leak from training into test."""
    for second in range(len(trials)):
        for first in range(second):
            a, b = trials[first], trials[second]
            if len(a.times) != len(b.times) or not np.allclose(np.diff(a.times), np.diff(b.times), rtol=1e-6, atol=1e-9):
                continue
            moved_a = np.linalg.norm(np.diff(a.position[:, np.isfinite(a.position).any(axis=0)], axis=0), axis=1)
            moved_b = np.linalg.norm(np.diff(b.position[:, np.isfinite(b.position).any(axis=0)], axis=0), axis=1)
            there = np.isfinite(moved_a) & np.isfinite(moved_b)
            if np.array_equal(np.isfinite(moved_a), np.isfinite(moved_b)) and there.sum() > 3 and np.ptp(moved_a[there]) > 0 and (
                    np.max(np.abs(moved_a[there] - moved_b[there])) < 1e-6 * np.max(moved_a[there])):
                same = np.allclose(a.position, b.position, rtol=0, atol=1e-9, equal_nan=True)
                kind = "the same recording" if same else "a shifted or rotated copy"
                raise InputError(f"{paths[second]}: {kind} as {paths[first].name}; copies may not stand as separate trials")


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
              "radius_m": (1e-6, 1e2), "distance_m": (0, 1e4), outcomes[0]: (-10, 1e4)}
    for name, (low, high) in limits.items():
        if name in columns and (np.any(columns[name] < low) or np.any(columns[name] > high)):
            worst = int(np.argmax((columns[name] < low) | (columns[name] > high)))
            raise InputError(f"{path}, row {rows[worst][0]}, column {name}: {columns[name][worst]:g} cannot be right; SI units")
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
