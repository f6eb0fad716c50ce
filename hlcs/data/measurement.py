"""Measurements: recordings and outcome tables read from CSV, and a hard look at them before any fit.

What cannot be used is refused by file, row and column (rows count from 1, the header is row 1). What is odd but usable
is reported in `notes`, never dropped in silence. This room knows no physics beyond plausible units.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hlcs.data import validation
from hlcs.data.experiment_file import AROUND, Body, ExperimentFile, Surroundings, read_experiment_file
from hlcs.files.csv_files import MOST_ROWS, CsvLayout, read_csv
from minibullet.errors import InputError

COLUMNS = ("t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
OUTCOMES = ("fall_time_s", "rebound_height_m", "stop_distance_m", "slide_time_s", "rest_height_m")
INPUTS = (
    "height_m",
    "slope",
    "speed_m_s",
    "angle_deg",
    "distance_m",
    "mass_kg",
    "radius_m",
    "friction",
    "restitution",
    "gravity_m_s2",
    "fluid_density_kg_m3",
    "fluid_viscosity_pa_s",
    "spin_rad_s",
    "group",
)


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
    rows: np.ndarray | None = None  # of the file, of each sample (n,); None where it is from no file
    first_row: int = 0  # samples of the recording before this piece

    @property
    def columns(self):
        """Names of the measured channels: x, y, z and, with orientation, the rotation about the three axes rx, ry, rz."""
        seen = np.isfinite(self.position).any(axis=0)
        return [name for name, there in zip("xyz", seen, strict=True) if there] + (
            ["rx", "ry", "rz"] if np.isfinite(self.orientation).any() else []
        )

    def at(self, which, **changes):
        """The trial with some of its samples (a slice or indices), and other fields changed."""
        rows = None if self.rows is None else self.rows[which]
        return replace(
            self,
            times=self.times[which],
            position=self.position[which],
            orientation=self.orientation[which],
            rows=rows,
            **changes,
        )


@dataclass(frozen=True)
class OutcomeTable:
    """One row, one experiment: inputs and one measured outcome."""

    file: Path
    outcome: str
    values: np.ndarray  # (n,)
    inputs: dict  # name -> (n,) array
    groups: np.ndarray  # (n,) names
    setting: np.ndarray  # (n,) integer, equal for rows with equal inputs (replicates)
    rows: np.ndarray  # (n,) row of the file that each experiment stands in


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
        validation.check_falls(table, file.surroundings.gravity)
        return Measurement(file, (), None, table, tuple(notes))
    notes, trials = [], []
    names = _short_names([entry.file for entry in file.trials])
    for entry, name in zip(file.trials, names, strict=True):
        times, position, orientation, rows = read_recording(entry.file)
        trial = Trial(name, entry.group, times, position, orientation, entry.start, entry.body, entry.surroundings, rows=rows)
        for check in (
            validation.check_clock,
            validation.check_units,
            validation.check_length,
            validation.check_axes,
            validation.check_quaternions,
        ):
            check(trial, entry.file)
        notes += validation.describe(trial, entry.file) + validation.check_floor(trial, entry.file)
        trials.append(trial)
        if sum(len(one.times) for one in trials) > MOST_ROWS:
            raise InputError(
                f"{file.path}: more than {MOST_ROWS:,} rows in its recordings up to {name}; keep every n-th row of "
                "each, or leave recordings out"
            )
    validation.check_duration(trials, file)
    validation.refuse_copies(trials, [entry.file for entry in file.trials])
    static = None
    if file.static:
        times, position, orientation, _ = read_recording(file.static)
        static = Trial(file.static.name, "static", times, position, orientation, {}, file.body, file.surroundings)
        if len(times) < 20:
            raise InputError(f"{file.static}: {len(times)} samples at rest; at least 20 are needed to know the noise")
        validation.check_at_rest(static, file.static)
    return Measurement(file, tuple(trials), static, None, tuple(notes))


def read_recording(path):
    """Times (n,), positions (n, 3), orientations (n, 4), NaN where blank or not recorded, and rows (n,) of one recording."""
    table = read_csv(path, CsvLayout(COLUMNS, ("t_s",), blank=COLUMNS[1:]))
    count, name = len(table.rows), table.name
    if len(table.columns) == 1:
        raise InputError(f"{name}: only times; at least one of {', '.join(COLUMNS[1:])} is needed")
    quaternion = [column for column in COLUMNS[4:] if column in table.columns]
    if quaternion and len(quaternion) < 4:
        raise InputError(f"{name}: columns {', '.join(quaternion)} without the rest; a quaternion needs qw, qx, qy, qz")
    if count < 2:
        raise InputError(f"{name}: {count} samples; a recording needs at least 2")
    values = np.column_stack([table.columns.get(column, np.full(count, np.nan)) for column in COLUMNS])
    times, position, orientation = values[:, 0], values[:, 1:4], values[:, 4:]
    steps = np.diff(times)
    if np.any(steps <= 0):
        worst = int(np.argmax(steps <= 0)) + 1
        what = "the same time twice (duplicate sample)" if steps[worst - 1] == 0 else "time goes backwards (unsorted)"
        raise InputError(f"{table.place(worst, 't_s')}: {times[worst]:g} s after {times[worst - 1]:g} s: {what}")
    there, length = np.isfinite(orientation), np.linalg.norm(orientation, axis=1)
    partly, wrong = there.any(axis=1) & ~there.all(axis=1), ~((length > 0.8) & (length < 1.25)) & there.all(axis=1)
    if np.any(partly | wrong):
        worst = int(np.argmax(partly | wrong))
        place = f"{name}, row {table.rows[worst]}, columns qw..qz"
        if partly[worst]:
            raise InputError(f"{place}: partly blank; give all four numbers or none")
        if length[worst] < 1e-6:
            raise InputError(f"{place}: quaternion of zero length; blank if missing")
        raise InputError(f"{place}: quaternion of length {length[worst]:.3g}, must be 1")
    return times, position, orientation / length[:, None], table.rows


def read_outcomes(path):
    """An OutcomeTable and notes from a CSV of inputs and one outcome column."""
    read = read_csv(path, CsvLayout(INPUTS + OUTCOMES, words=("group",)))
    columns, rows = read.columns, read.rows
    outcomes = [name for name in columns if name in OUTCOMES]
    if len(outcomes) != 1:
        raise InputError(f"{read.name}: {len(outcomes)} outcome columns; exactly one of {', '.join(OUTCOMES)} is needed")
    if len(rows) < 3:
        raise InputError(f"{read.name}: {len(rows)} rows; at least 3 experiments are needed")
    limits = {
        "height_m": (0, 1e3),
        "speed_m_s": (0, 400),
        "angle_deg": (-90, 90),
        "mass_kg": (1e-9, 1e7),
        "radius_m": (1e-6, 1e2),
        "distance_m": (0, 1e4),
        "slope": (-10, 10),
        "spin_rad_s": (-1e5, 1e5),
        "friction": AROUND["friction"],
        "restitution": AROUND["restitution"],
        "gravity_m_s2": AROUND["gravity"],
        "fluid_density_kg_m3": AROUND["fluid_density"],
        "fluid_viscosity_pa_s": AROUND["fluid_viscosity"],
        outcomes[0]: (0 if outcomes[0].endswith("_s") else -10, 1e4),
    }
    for name, (low, high) in limits.items():
        if name in columns and (np.any(columns[name] < low) or np.any(columns[name] > high)):
            worst = int(np.argmax((columns[name] < low) | (columns[name] > high)))
            raise InputError(
                f"{read.place(worst, name)}: {columns[name][worst]:g} cannot be right; it must be "
                f"between {low:g} and {high:g} (m, s, kg; angles in degrees, a slope is rise over run)"
            )
    inputs = {name: values for name, values in columns.items() if name not in (*outcomes, "group")}
    groups = columns.get("group", np.array([f"row {row}" for row in rows]))
    table = np.column_stack(list(inputs.values())) if inputs else np.zeros((len(rows), 1))
    setting = np.unique(table, axis=0, return_inverse=True)[1].reshape(-1)
    values = columns[outcomes[0]]
    notes = []
    pairs = np.column_stack([table, values])
    if len(np.unique(pairs, axis=0)) < len(pairs):
        _, first = np.unique(pairs, axis=0, return_index=True)
        repeat = sorted(set(range(len(pairs))) - set(first.tolist()))
        notes.append(
            f"{path.name}, row {rows[repeat[0]]}: repeats inputs and outcome of an earlier row digit for digit "
            f"({len(repeat)} such rows): a true repeat, or a copy?"
        )
    return OutcomeTable(Path(path), outcomes[0], values, inputs, groups.astype(str), setting, rows), notes


def _short_names(paths):
    """File names; with their folder where two share a name. A file listed twice is refused."""
    if len(set(paths)) < len(paths):
        twice = next(path for path in paths if paths.count(path) > 1)
        raise InputError(f"{twice}: stands in two [[trial]] entries (duplicate trial); keep one")
    names = [path.name for path in paths]
    return [name if names.count(name) == 1 else f"{path.parent.name}/{name}" for path, name in zip(paths, names, strict=True)]
