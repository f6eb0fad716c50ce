"""Recordings: the poses of a body at many times, read from CSV, and a hard look at them before any fit.

What cannot be used is refused by file, row and column (rows count from 1, the header is row 1). What is odd but usable
is reported in `notes`, never dropped in silence. This room knows no physics beyond plausible units.
"""

import warnings
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hlcs.data import starts, validation
from hlcs.data.accelerometers import check_accelerations
from hlcs.data.experiment_file import OF_RECORDINGS, Body, ExperimentFile, Surroundings
from hlcs.data.quantities import CHANNEL_UNITS, CHANNELS, INPUTS, OUTCOMES
from hlcs.files.csv_files import MOST_ROWS, CsvLayout, read_csv
from minibullet.errors import InputError, InputWarning, how_many

PIXELS = ("x_px", "y_px", "z_px")  # in place of x_m, y_m, z_m, where the file states the length of a pixel
COLUMNS = ("t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
ACCELERATIONS = ("ax_m_s2", "ay_m_s2", "az_m_s2")
CHECKS = (
    validation.check_steps,
    validation.check_clock,
    validation.check_units,
    validation.check_length,
    validation.check_axes,
    validation.check_quaternions,
    check_accelerations,
)
LEAST_AT_REST = 20  # samples of a static recording


class Accelerations(NamedTuple):
    """What an accelerometer at the centre of mass reads: acceleration less gravity, so +9.81 upwards at rest, 0 in free fall."""

    values: np.ndarray  # along the axes x, y, z, NaN = missing [m/s2], (n, 3)
    in_body: bool  # along the axes of the body, which turn with it; else those of the world
    window: float  # time over which a reading is a mean: the typical time between two as they were recorded [s]


@dataclass(frozen=True)
class Trial:
    """One recording: samples of a body's pose and of an accelerometer on it, NaN where a sample is missing."""

    name: str
    group: str  # what is held out together
    times: np.ndarray  # (n,), increasing [s]
    position: np.ndarray  # centre of mass, world frame, NaN = missing [m], (n, 3)
    orientation: np.ndarray  # unit quaternion (w, x, y, z), NaN = missing, (n, 4)
    start: dict
    body: Body
    surroundings: Surroundings
    recording: str = ""  # name of the recording where this is a segment of one
    rows: np.ndarray | None = None  # of the file, of each sample (n,); None where it is from no file
    first_row: int = 0  # samples of the recording before this segment
    session: str = ""  # in which clock, scale and lean of the camera stayed as they were
    accelerations: Accelerations | None = None  # None = not recorded

    @property
    def whole(self):
        """Name of the recording that this is, or that it is a segment of."""
        return self.recording or self.name

    @property
    def measured(self):
        """Which samples of which CHANNELS are measured, boolean (n, 9)."""
        turns = np.repeat(np.isfinite(self.orientation[:, :1]), 3, axis=1)
        read = np.isfinite(self.accelerations.values) if self.accelerations else np.zeros_like(turns)
        return np.concatenate([np.isfinite(self.position), turns, read], axis=1)

    @property
    def columns(self):
        """Names of the measured channels: x, y, z; the rotation about them rx, ry, rz; readings ax, ay, az."""
        return [name for name, there in zip(CHANNELS, self.measured.any(axis=0), strict=True) if there]

    @property
    def unplaced(self):
        """Are accelerations measured, and nothing of where the body is?"""
        return self.accelerations is not None and not np.isfinite(self.position).any()

    @property
    def seen_from_above(self):
        """Is there a floor and motion, but no height, measured or stated? Such a body is taken to move on its floor."""
        on_floor = self.surroundings.floor_height is not None and "position" not in self.start
        level = self.unplaced or np.isfinite(self.position[:, :2]).any()
        return on_floor and level and not np.isfinite(self.position[:, 2]).any()

    def at(self, which, **changes):
        """The trial with some of its samples (a slice or indices), and other fields changed."""
        rows = None if self.rows is None else self.rows[which]
        read = self.accelerations and self.accelerations._replace(values=self.accelerations.values[which])
        return replace(
            self,
            times=self.times[which],
            position=self.position[which],
            orientation=self.orientation[which],
            accelerations=read,
            rows=rows,
            **changes,
        )


@dataclass(frozen=True)
class Recordings:
    """The recordings of an experiment file, checked."""

    file: ExperimentFile
    trials: tuple[Trial, ...]
    static: Trial | None  # of a body at rest, where there is one
    notes: tuple[str, ...]


def read_recordings(file):
    """The Recordings of an ExperimentFile; raises InputError with file, row, column.

    They stand in the order of their names, whatever the order of the file: sums of the same numbers in another order have other
    last digits, and draws of noise go from one to the next.
    """
    notes, trials, paths, count = [], [], [], 0
    names = _short_names([entry.file for entry in file.trials])
    for name, entry in sorted(zip(names, file.trials, strict=True), key=lambda pair: (pair[0], str(pair[1].file))):
        times, position, orientation, read, rows = read_recording(entry.file, file.pixel, file.accelerometer)
        trial = Trial(name, entry.group, times, position, orientation, entry.start, entry.body, entry.surroundings, rows=rows)
        trial = replace(trial, session=entry.session, accelerations=read)
        for check in (validation.check_steps, validation.check_plane) if trial.surroundings.planar else CHECKS:
            check(trial, entry.file)
        starts.check_start(trial, file)
        notes += validation.describe(trial, entry.file) + validation.check_floor(trial, entry.file)
        trials.append(trial)
        paths.append(entry.file)
        count += len(times)
        if count > MOST_ROWS:
            raise InputError(
                f"{file.path}: more than {MOST_ROWS:,} rows in its recordings up to {name}; keep every n-th row of "
                "each, or leave recordings out"
            )
    validation.check_duration(trials, file)
    validation.refuse_copies(trials, paths)
    if file.accelerometer and not any(trial.accelerations for trial in trials):
        raise InputError(
            f'{file.path}: measurement.accelerometer = "{file.accelerometer}", but no recording has one of the columns '
            f"{', '.join(ACCELERATIONS)}; add them, or leave out accelerometer"
        )
    _check_noise(file, trials)
    static = _static(file) if file.static else None
    if static:
        _check_static(file, static, trials)
    return Recordings(file, tuple(trials), static, tuple(notes))


def _check_noise(file, trials):
    """Refuse a stated noise where no recording holds anything that it is the noise of."""
    measured = np.any([trial.measured.any(axis=0) for trial in trials], axis=0).reshape(3, 3).any(axis=1)
    recorded = [what for what, there in zip(OF_RECORDINGS, measured, strict=True) if there]
    if file.noise and not set(recorded) & set(file.noise):
        units = ", ".join(
            f"{what} = .. [{unit}]" for what, unit in zip(OF_RECORDINGS, CHANNEL_UNITS, strict=True) if what in recorded
        )
        raise InputError(
            f"{file.place('measurement.noise')}: is of {' and '.join(file.noise)}, and the recordings hold "
            f"{' and '.join(recorded)} alone; write noise = {{ {units} }}"
        )


def _check_static(file, static, trials):
    """Refuse a recording at rest that holds nothing of what the others hold; tell where it holds none of their columns."""
    held, there = static.measured.any(axis=0), np.any([trial.measured.any(axis=0) for trial in trials], axis=0)
    if np.any(held & there):
        return
    of_rest, of_others = (", ".join(name for name, some in zip(CHANNELS, known, strict=True) if some) for known in (held, there))
    what = f"file '{file.static.name}' holds {of_rest} of a body at rest, and the recordings hold {of_others}"
    if not np.any(held.reshape(3, 3).any(axis=1) & there.reshape(3, 3).any(axis=1)):
        file.source.fail("static", f"{what}: record the body at rest in the same way, or state noise in its place", "measurement")
    file.source.warn("static", f"{what}: along other axes the noise may be another; record the same ones", "measurement")


def _static(file):
    """The recording of a body at rest that an experiment file names."""
    times, position, orientation, read, _ = read_recording(file.static, file.pixel, file.accelerometer, at_rest=True)
    static = Trial(file.static.name, "static", times, position, orientation, {}, file.body, file.surroundings, accelerations=read)
    for drift in validation.check_at_rest(static, file.static):
        told = f"file '{file.static.name}', {drift}: that counts as noise; record a body that rests, or state noise in its place"
        file.source.warn("static", told, "measurement")
    return static


def read_recording(path, pixel=None, accelerometer=None, at_rest=False):
    """Times (n,), positions (n, 3), orientations (n, 4), NaN where blank or not recorded, Accelerations or None, and rows (n,).

    pixel: its length where positions may be in pixels [m]; None = they are in metres; accelerometer: "world" or "body", the axes
    along which it reads; None = the file states none, and such columns are refused; at_rest: it is to tell the noise.
    """
    optional = COLUMNS[1:] + PIXELS + ACCELERATIONS
    layout = CsvLayout(
        ("t_s", *optional),
        ("t_s",),
        blank=optional,
        imported=True,
        elsewhere=(*INPUTS, *OUTCOMES),
        where='a table, kind = "outcomes"',
    )
    table = in_metres(read_csv(path, layout), pixel)
    count, name = len(table.rows), table.name
    if len(table.columns) == 1:
        raise InputError(f"{name}: only times; at least one of {', '.join(COLUMNS[1:] + ACCELERATIONS)} is needed")
    quaternion = [column for column in COLUMNS[4:] if column in table.columns]
    if quaternion and len(quaternion) < 4:
        raise InputError(f"{name}: columns {', '.join(quaternion)} without the rest; a quaternion needs qw, qx, qy, qz")
    if at_rest and count < LEAST_AT_REST:
        raise InputError(f"{name}: {how_many(count, 'sample')} at rest; at least {LEAST_AT_REST} are needed to know the noise")
    if count < 2:
        raise InputError(
            f"{name}: {how_many(count, 'sample')}; a recording needs at least 2: export it anew, or leave the file out"
        )
    for column in (column for column in table.columns if np.isnan(table.columns[column]).all()):
        what = f"{table.head}: column '{column}' is wholly blank: taken as not recorded; leave it out"
        warnings.warn(what, InputWarning, stacklevel=2)
    values = np.column_stack([table.columns.get(column, np.full(count, np.nan)) for column in COLUMNS])
    times, position, orientation = values[:, 0], values[:, 1:4], values[:, 4:]
    steps = np.diff(times)
    if np.any(steps <= 0):
        worst = int(np.argmax(steps <= 0)) + 1
        what = "the same time twice (duplicate sample); keep one of them"
        if steps[worst - 1] < 0:
            even = _unevenness(times)  # a clock is: rows in reverse order are not exchanged columns
            ordered = [name for name, each in table.columns.items() if np.all(np.diff(each) > 0) and _unevenness(each) < even]
            remedy = f"{ordered[0]} grows from row to row: are the two columns mixed up?" if ordered else "sort the rows by time"
            what = f"time goes backwards (unsorted); {remedy}"
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
    return times, position, orientation / length[:, None], _accelerations(table, steps, accelerometer), table.rows


def _unevenness(values):
    """Scatter of the steps of some numbers (n,) over their mean [-]."""
    steps = np.diff(values)
    return np.std(steps) / abs(np.mean(steps)) if np.mean(steps) else np.inf


def _accelerations(table, steps, axes):
    """The Accelerations of the CsvTable of a recording, None where it has none; steps: between its samples [s]."""
    there = [column for column in ACCELERATIONS if column in table.columns]
    if not there:
        return None
    if axes is None:
        raise InputError(
            f"{table.head}: column '{there[0]}': along whose axes? Write accelerometer = \"world\" (z is "
            'up) or accelerometer = "body" (they turn with it) under [measurement]'
        )
    missing = np.full(len(table.rows), np.nan)
    values = np.column_stack([table.columns.get(column, missing) for column in ACCELERATIONS])
    return Accelerations(values, axes == "body", float(np.median(steps)))


def in_metres(table, pixel):
    """The CsvTable of a recording with its positions in metres."""
    columns = dict(table.columns)
    if pixel is not None and (stated := [name for name in COLUMNS[1:4] if name in columns]) and not set(PIXELS) & set(columns):
        raise InputError(
            f"{table.head}: column '{stated[0]}' is in metres, and measurement.metres_per_pixel is "
            f"stated; call it '{stated[0][0]}_px' where it is in pixels, or leave metres_per_pixel out"
        )
    for name, metres in zip(PIXELS, COLUMNS[1:4], strict=True):
        if name in columns:
            place = f"{table.head}: column '{name}'"
            if pixel is None:
                raise InputError(f"{place}: how long is a pixel? Write metres_per_pixel = 0.002 [m] under [measurement]")
            if metres in columns:
                raise InputError(f"{place} beside '{metres}'; keep one of them")
            columns[metres] = pixel * columns.pop(name)
    return replace(table, columns=columns)


def _short_names(paths):
    """File names; with their folder where two share a name. A file listed twice is refused."""
    if len(set(paths)) < len(paths):
        twice = next(path for path in paths if paths.count(path) > 1)
        raise InputError(f"{twice}: stands in two [[trial]] entries (duplicate trial); keep one")
    names = [path.name for path in paths]
    return [name if names.count(name) == 1 else f"{path.parent.name}/{name}" for path, name in zip(paths, names, strict=True)]
