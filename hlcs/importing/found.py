"""What a reader of exports hands over: recordings or rows in the project's own columns, and what it assumed on the way."""

from dataclasses import dataclass, field, replace

import numpy as np

from hlcs.data.recordings import COLUMNS, PIXELS
from minibullet.errors import InputError, how_many, shown

FEW = 3  # files that are named one by one
CLOCK = 1e7  # of a time that is read off a clock and counts from no event of the experiment: four months [s]
TWICE = 2.0  # as fast as between any two samples: no body comes to rest at the origin so


@dataclass(frozen=True)
class Assumption:
    """One thing that the file does not say."""

    text: str
    option: str = ""  # of `hlcs import` that says otherwise; "" where there is none
    of_motion: bool = False  # is it of no account of a body at rest, that tells the noise?


@dataclass(frozen=True)
class Recording:
    """The samples of one body, SI, z up."""

    name: str  # what it is called: the file, and the body where the file holds several
    group: str  # the file it is from
    columns: dict  # t_s, x_m, qw .. -> (n,), NaN where a sample is missing
    start: dict = field(default_factory=dict)  # what the samples themselves tell of it, as a [[trial]] has it
    flies: bool | None = None  # does it move through the air? None = the samples do not tell


@dataclass(frozen=True)
class Found:
    """What one file holds: recordings, or rows with one experiment each."""

    recordings: tuple[Recording, ...] = ()
    rows: dict | None = None  # columns of an outcome table -> (n,) numbers or words
    measurement: dict = field(default_factory=dict)  # keys for [measurement]
    assumptions: tuple[Assumption, ...] = ()


def each_once(assumptions):
    """The Assumptions of several files, each told once, of those files that share it.

    assumptions: [(name of a file, its Assumptions)].
    """
    whose = {}
    for name, of_file in assumptions:
        for one in of_file:
            file, _, rest = one.text.partition(": ")
            in_zip = file.startswith(f"{name}/") and file.lower().endswith(".csv")
            what = rest if file == name or in_zip else one.text
            whose.setdefault(replace(one, text=what), []).extend([name] if what != one.text else [])
    return [replace(one, text=_of_files(names, len(assumptions)) + one.text) for one, names in whose.items()]


def _of_files(names, count):
    """Of which of `count` files something is told, the begin of a sentence; names: [] = it says that itself."""
    if len(names) == count > 1:
        return f"all {count} files: "
    more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
    return ", ".join(names[:FEW]) + more + ": " * bool(names)


@dataclass(frozen=True)
class Overrides:
    """What the user says about a file, in place of what would be assumed; None or empty = not said."""

    up: str | None = None  # axis of the file that points up: x, -x, y, -y, z, -z; "none": seen from above
    length_unit: str | None = None
    time_unit: str | None = None
    frame_rate: float | None = None  # [1/s]
    rotation_order: str | None = None  # of Euler angles, about the axes of the turned body
    column: dict = field(default_factory=dict)  # name in the file -> name in the project
    only: tuple[str, ...] = ()  # point masses, rigid bodies or markers to take
    constant: dict = field(default_factory=dict)  # column of a table -> its value in every row
    release_time: float | None = None  # on the clock of a list of sounds [s]

    def given(self):
        """Names of what is said."""
        return [name for name, value in vars(self).items() if value is not None and value != {} and value != ()]

    def chosen(self, names, place):
        """Those of `names` that are to be taken, in their order; InputError where one that was asked for is not there."""
        for name in self.only:
            if name not in names:
                there = ", ".join(f"'{shown(one)}'" for one in names)
                raise InputError(f"{place}: no '{shown(name)}' in it (--only); there are {there}")
        return [name for name in names if not self.only or name in self.only]


def recording(name, grid, lines, columns, time_name, advice="one recording a file, sorted by time"):
    """(Recording, its Assumptions) of columns in SI, checked: times known and increasing, at least one sample.

    name: what it is called; grid: the Grid it is from; lines: line of the file of each sample (n,); columns: t_s and others
    -> (n,), NaN = missing; time_name: what the file calls the time; advice: what to do where times do not increase. Zeros
    that stand for a body out of sight are missing samples. Rows without any sample before the first and after the last are
    left out. Raises InputError with file, row and column.
    """
    times = columns["t_s"]
    if len(times) < 2:
        raise InputError(f"{grid.name}: {how_many(len(times), 'row')} of numbers below its names; a recording needs at least 2")
    lost = np.flatnonzero(np.isnan(times))
    if len(lost):
        raise InputError(f"{grid.name}, row {lines[lost[0]]}, column {shown(time_name)}: blank; every sample needs its time")
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        first = back[0] + 1
        what = "the same time twice" if times[first] == times[back[0]] else "time goes backwards"
        if times[first] <= times[0] < times[back[0]]:
            what, advice = "time begins again", "where recordings stand below one another, save each as a file of its own"
        raise InputError(
            f"{grid.name}, row {lines[first]}, column {shown(time_name)}: {times[first]:g} s after {times[back[0]]:g} s: {what}; "
            f"{advice}"
        )
    notes = []
    if abs(times[0]) > CLOCK:
        notes.append(Assumption(f"{grid.name}: times count from the first sample, at {times[0]:.17g} s of a clock"))
        columns = columns | {"t_s": times - times[0]}
    columns = {key: column for key, column in columns.items() if np.isfinite(column).any()}
    columns, zeros = _without_zeros(columns)
    measured = np.array([np.isfinite(column) for key, column in columns.items() if key != "t_s"]).reshape(-1, len(times))
    seen = np.flatnonzero(measured.any(axis=0))
    if len(seen) < 2:
        raise InputError(f"{grid.name}: {how_many(len(seen), 'sample')} of '{shown(name)}'; a recording needs at least 2")
    kept = slice(seen[0], seen[-1] + 1)
    if zeros.any():
        told = "1 sample reads" if zeros.sum() == 1 else f"{int(zeros.sum())} samples read"
        notes.append(
            Assumption(
                f"{grid.name}: {told} 0 far from where the body was (the first in row {lines[np.argmax(zeros)]}): taken for "
                "a body out of sight, and left blank"
            )
        )
    if (left := int((~zeros[: seen[0]]).sum() + (~zeros[seen[-1] + 1 :]).sum())) > 0:
        one, many = "1 row before the first or after", f"{left} rows before the first and after"
        rows, are = (one, "is") if left == 1 else (many, "are")
        notes.append(Assumption(f"{grid.name}: {rows} the last sample of '{name}' {are} left out"))
    blank = int(((~measured[:, kept]).any(axis=0) & ~zeros[kept]).sum())
    if blank:
        lost = f"1 sample of '{name}' was lost; it is" if blank == 1 else f"{blank} samples of '{name}' were lost; they are"
        notes.append(Assumption(f"{grid.name}: {lost} left blank, not filled in"))
    return Recording(name, grid.stem, {key: column[kept] for key, column in columns.items()}), tuple(notes)


def _without_zeros(columns):
    """(columns, which samples (n,)): zeros that stand for a body out of sight are missing; columns: t_s and others -> (n,).

    Programs that follow a body by themselves write 0 for every coordinate where they lose it. A body that is at the origin
    came there: not in a jump of more than twice the greatest speed between any other two samples. The first sample may be the
    origin however fast the body goes on.
    """
    times, axes = columns["t_s"], [columns[name] for name in (*COLUMNS[1:4], *PIXELS) if name in columns]
    zeros = np.zeros(len(times), bool)
    there = np.flatnonzero(np.isfinite(axes).all(axis=0)) if axes else []
    if len(there) < 2:
        return columns, zeros
    places = np.array(axes)[:, there]
    origin = (places == 0).all(axis=0)
    speed = np.linalg.norm(np.diff(places, axis=1), axis=0) / np.diff(times[there])
    among = ~origin[:-1] & ~origin[1:]
    if not among.any():
        return columns, zeros
    edges = origin[:-1] != origin[1:]
    jump = edges & (speed > TWICE * speed[among].max())
    for run in np.split(np.arange(len(there)), np.flatnonzero(edges) + 1):
        ends = [run[0] - 1, *([run[-1]] if run[-1] < len(speed) else [])]
        zeros[there[run]] = bool(origin[run[0]] and run[0] > 0 and jump[ends].all())
    others = {name: np.where(zeros & (column == 0), np.nan, column) for name, column in columns.items() if name != "t_s"}
    return {"t_s": times, **others}, zeros
