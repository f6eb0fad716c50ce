"""Experiment files: the TOML a user writes, checked key by key, as frozen records.

Every complaint is one line that names the file, the line, the key and the remedy. Numbers are SI; paths are relative
to the file. The recordings themselves are read and checked by `hlcs.data.recordings` and `hlcs.data.outcome_tables`.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hlcs.data.bodies import Body, read_body, refuse_unsized
from hlcs.data.combinations import check_combinations
from hlcs.data.effects_of_model import OF_EFFECTS, names_of_effects, read_effects
from hlcs.data.quantities import AROUND, INPUTS, OUTCOMES
from hlcs.data.unfilled import refuse_unfilled
from hlcs.files.toml_files import TomlFile
from minibullet.effects.fluid import AIR_DENSITY
from minibullet.errors import InputError, is_number, shown, shown_value

HELD_OUT = {False: ("group", "none"), True: ("campaign", "grid", "none", "group")}  # together, of tables of layers or of others
OF_RECORDINGS = ("position", "orientation", "acceleration")  # what a recording may hold, and has a noise of its own
# keys of which later complaints tell the line
WITH_LINES = (("model", "effects"), ("model", "replaced"), ("diagnose", "candidates"), ("measurement", "noise"))
SECTIONS = {
    "": ["kind", "title", "body", "surroundings", "placement", "model", "measurement", "diagnose", "trial"],
    "body": ["shape", "radius", "height", "size", "side", "mesh", "mass", "inertia", "drag_area"],
    "surroundings": ["gravity", "fluid_density", "fluid_viscosity", "tube_radius", "floor", "friction", "restitution"],
    "surroundings.floor": ["height", "normal"],
    "model": [*OF_EFFECTS, "time_step"],
    "measurement": ["noise", "static", "file", "input_sd", "planar", "metres_per_pixel", "metres_per_pixel_sd", "accelerometer"],
    "measurement.noise": [*OF_RECORDINGS, "outcome", *OUTCOMES],
    "measurement.input_sd": list(INPUTS),
    "diagnose": ["candidates", "hold_out", "tolerance"],
    "trial": ["file", "group", "session", "start"],
    "trial.start": ["position", "orientation", "velocity", "angular_velocity"],
}
SECTIONS["trial"] += SECTIONS["body"] + SECTIONS["surroundings"]
LONGEST_SESSION = 40  # letters: it stands in the names of numbers
FLUIDS = {  # name -> least and most density of it [kg/m3]
    "air": (0.9, 1.5),  # warm and high, cold and low
    "water": (980.0, 1040.0),  # fresh and warm, salt and cold
}
LIQUID = 100.0  # density above which a fluid may carry a body or brake it within centimetres [kg/m3]


@dataclass(frozen=True)
class Layout:
    """What the experiment file of a kind of measurement holds, beside what all of them hold."""

    in_trials: bool  # what was measured stands in the files of [[trial]], else in one file under [measurement]
    foreign: dict  # keys that have no place in it -> the kinds that they belong to


LAYOUTS = {
    "trajectory": Layout(
        True,
        {
            "placement": '"layers"',
            "measurement.file": '"outcomes" or "layers"; here files stand in [[trial]]',
            "measurement.input_sd": '"outcomes"',
        },
    ),
    "outcomes": Layout(
        False,
        {
            "placement": '"layers"',
            "trial": '"trajectory"',
            "measurement.static": '"trajectory"',
            "measurement.planar": '"trajectory"',
            "measurement.metres_per_pixel": '"trajectory"',
            "measurement.metres_per_pixel_sd": '"trajectory"',
            "measurement.accelerometer": '"trajectory"',
        },
    ),
    "layers": Layout(
        False,
        {
            "body": '"trajectory" or "outcomes"',
            "trial": '"trajectory"',
            "measurement.static": '"trajectory"',
            "measurement.planar": '"trajectory"',
            "measurement.metres_per_pixel": '"trajectory"',
            "measurement.metres_per_pixel_sd": '"trajectory"',
            "measurement.accelerometer": '"trajectory"',
            "measurement.noise": '"trajectory" or "outcomes"; here cv and tests stand in the CSV',
            "measurement.input_sd": '"outcomes"',
        },
    ),
}
START_LENGTHS = {"position": 3, "orientation": 4, "velocity": 3, "angular_velocity": 3}


@dataclass(frozen=True)
class Surroundings:
    """What the body moves in and on."""

    gravity: float = 9.81  # downwards [m/s2]
    fluid_density: float = AIR_DENSITY  # where none is stated it is a gas such as air; 0 = a vacuum [kg/m3]
    fluid_stated: bool = False  # does the file say so?
    fluid_viscosity: float = 0.0  # [Pa s]
    tube_radius: float = 0.0  # inner one of an upright tube that holds the fluid, 0 = none is stated [m]
    floor_height: float | None = None  # None = no floor; distance of the plane from the origin along its normal [m]
    floor_normal: tuple[float, ...] = (0.0, 0.0, 1.0)
    friction: float = 0.5  # of the pair [-]
    restitution: float = 0.0  # [-]
    planar: bool = False  # does it move in the plane of x and y, carried without friction where there is no floor?

    @property
    def normal(self):
        """Normal of the floor, away from it (3,)."""
        return np.asarray(self.floor_normal, dtype=float)

    def above_floor(self, position):
        """Height of positions (.., 3) above the floor, along its normal [m]."""
        return position @ self.normal - self.floor_height

    @property
    def in_liquid(self):
        """Does the file state a liquid?"""
        return self.fluid_density > LIQUID

    @property
    def walled(self):
        """May there be walls around the fluid? A liquid is in something."""
        return self.in_liquid or self.tube_radius > 0

    @property
    def fluid(self):
        """What the fluid is called: air or water where its density is of none else in a laboratory, else by that."""
        named = (name for name, (low, high) in FLUIDS.items() if low <= self.fluid_density <= high)
        return next(named, f"fluid of {self.fluid_density:.4g} kg/m3")


@dataclass(frozen=True)
class TrialEntry:
    """One [[trial]] of the file: where its recording lies and what is known of its start."""

    file: Path
    group: str
    body: Body
    surroundings: Surroundings
    start: dict = field(default_factory=dict)  # position [m], orientation (w, x, y, z), velocity [m/s], angular_velocity [rad/s]
    session: str = ""  # in which clock, scale and lean of the camera stayed as they were


@dataclass(frozen=True)
class ExperimentFile:
    """An experiment file, read and checked; nothing of the recordings yet."""

    path: Path
    kind: str
    title: str
    body: Body
    surroundings: Surroundings
    effects: tuple[dict, ...]  # entries of [model] effects: name and parameters
    added: tuple[str, ...]  # names of those that were added last: what a comparison shows the model with and without
    replaced: tuple[dict, ...]  # entries that stood in the place of some of these before
    time_step: float  # [s]
    noise: dict  # stated one-sigma values, may be empty; of a position the root mean square of those along x, y, z
    noise_along: tuple  # of a position along x, y, z, over that
    input_sd: dict  # of the inputs of a table, one sigma each, may be empty
    static: Path | None
    pixel: float | None  # [m], of recordings in pixels; None = they are in metres
    scale_error: float  # one sigma of the length of a pixel, relative; 0 = none is stated [-]
    accelerometer: str | None  # along which axes it reads, "world" or "body"; None = accelerations are not recorded
    data_file: Path | None  # outcomes and layers
    candidates: tuple[str, ...] | None
    hold_out: str
    tolerance: float | None  # what the user needs [unit of the observations]
    trials: tuple[TrialEntry, ...]
    placement: dict  # kind "layers" only, as written
    allow_outside: bool = False  # whether it may name files outside its own folder
    lines: dict = field(default_factory=dict, compare=False)  # where [model] effects and [diagnose] candidates stand
    source: TomlFile | None = field(default=None, repr=False, compare=False)  # what it was read from

    def place(self, key):
        """ "file, line n: key", to begin a complaint with that only the library of effects can make."""
        return f"{self.path}" + (f", line {self.lines[key]}" if self.lines.get(key) else "") + f": {key}"


def read_experiment_file(path, allow_outside=False, layouts=LAYOUTS):
    """Read and check an experiment file; raises InputError naming file, line, key, value and remedy.

    allow_outside: let it name files outside its own folder; otherwise they are refused, links followed; layouts: {kind: Layout}
    of all kinds that it may be of.
    """
    return checked_experiment(TomlFile(path, SECTIONS, allow_outside), layouts)


def checked_experiment(reader, layouts=LAYOUTS):
    """The ExperimentFile of a TomlFile, checked; errors and layouts as in `read_experiment_file`."""
    values = reader.values
    refuse_unfilled(reader)
    reader.known(values, "")
    if "kind" not in values:
        *others, last = (f'"{name}"' for name in layouts)
        raise InputError(f"{reader.path}: kind is missing; add kind = {', '.join(others)} or {last}")
    kind = reader.words(values, "kind", "", tuple(layouts))
    layout = layouts[kind]
    for section in ("body", "surroundings", "model", "measurement", "diagnose"):
        reader.known(values.get(section, {}), section)
    body = read_body(reader, values.get("body", {}), "body", Body())
    surroundings = _surroundings(reader, values.get("surroundings", {}), "surroundings", Surroundings())
    model, measurement, diagnose = values.get("model", {}), values.get("measurement", {}), values.get("diagnose", {})
    surroundings = replace(surroundings, planar=reader.flag(measurement, "planar", "measurement"))
    trials = tuple(_trial(reader, entry, index, body, surroundings) for index, entry in enumerate(_trial_list(reader, values)))
    for index, entry in enumerate(trials or [None]):
        used = entry.body if entry else body
        place = ("body",) if "shape" in values.get("body", {}) else ("trial", index)
        refuse_unsized(reader, used, not layout.in_trials, *place)
    if layout.in_trials and not trials:
        raise InputError(f'{reader.path}: no [[trial]]; add one [[trial]] with file = "....csv" for each recording')
    if not layout.in_trials and "file" not in measurement:
        raise InputError(f'{reader.path}: measurement.file is missing; "{kind}" needs file = "....csv" in [measurement]')
    _belongs(reader, values, kind, layout)
    file = ExperimentFile(
        path=reader.path,
        kind=kind,
        title=reader.title(),
        body=body,
        surroundings=surroundings,
        **dict(zip(OF_EFFECTS, read_effects(reader, model), strict=True)),
        **dict(zip(("noise", "noise_along"), _noise(reader, measurement, kind, layout.in_trials), strict=True)),
        input_sd=_input_sd(reader, measurement),
        time_step=reader.number(model, "time_step", "model", above=0.0, high=0.1) or 1 / 240,
        static=_path(reader, measurement, "static", "measurement"),
        pixel=(pixel := reader.number(measurement, "metres_per_pixel", "measurement", above=0.0, low=1e-9, high=1e3)),
        scale_error=_scale_error(reader, measurement, pixel),
        accelerometer=_accelerometer(reader, measurement),
        data_file=_path(reader, measurement, "file", "measurement"),
        candidates=names_of_effects(reader, diagnose, "candidates", "diagnose"),
        hold_out=reader.words(diagnose, "hold_out", "diagnose", HELD_OUT[kind == "layers"], default="group"),
        tolerance=reader.number(diagnose, "tolerance", "diagnose", above=0.0),
        trials=trials,
        placement=_placement(reader, values),
        allow_outside=reader.allow_outside,
        source=reader,
        lines={f"{section}.{key}": reader.line_of(key, section) for section, key in WITH_LINES},
    )
    check_combinations(file)
    return file


def _belongs(reader, values, kind, layout):
    """Refuse what another kind of experiment needs and this one would pass over in silence."""
    for other, keys in layout.foreign.items():
        section, _, key = other.rpartition(".")
        table = values.get(section, {}) if section else values
        if key in table:
            reader.fail(key, f'has no place where kind = "{kind}"; it belongs to kind = {keys}', section)


def _path(reader, table, key, section):
    value = reader.words(table, key, section)
    return None if value is None else reader.file_of(value, key, section)


def _placement(reader, values):
    """[placement] as it stands; what is in it is checked where layers are read."""
    table = values.get("placement", {})
    if not isinstance(table, dict):
        reader.fail("placement", f"must be a table, got {shown_value(table)}")
    return dict(table)


def _trial_list(reader, values):
    trials = values.get("trial", [])
    if not isinstance(trials, list) or not all(isinstance(entry, dict) for entry in trials):
        reader.fail("trial", "must be written as [[trial]] tables, one for each recording")
    return trials


def _surroundings(reader, table, section, base, index=None):
    if is_number(gravity := table.get("gravity")) and gravity < 0:
        reader.fail("gravity", f"got {gravity:g}; it is counted downwards: write {-gravity:g}", section, index)
    numbers = {key: reader.number(table, key, section, index=index, low=low, high=high) for key, (low, high) in AROUND.items()}
    changes = {key: value for key, value in numbers.items() if value is not None}
    if "fluid_density" in changes:
        changes["fluid_stated"] = True
        if changes["fluid_density"] == 0 and changes.get("fluid_viscosity"):
            reader.fail("fluid_viscosity", "a vacuum, fluid_density = 0, has none; leave one of them out", section, index)
    if "floor" in table:
        floor = table["floor"]
        reader.known(floor, "surroundings.floor", index)
        normal = reader.vector(floor, "normal", f"{section}.floor", 3, index=index) or (0.0, 0.0, 1.0)
        length = float(np.linalg.norm(normal))
        if not length > 0:
            reader.fail("normal", "has zero length; give a direction such as [0, 0, 1]", f"{section}.floor", index)
        changes["floor_height"] = reader.number(floor, "height", f"{section}.floor", index=index) or 0.0
        changes["floor_normal"] = tuple(component / length for component in normal)
    return replace(base, **changes)


def _trial(reader, entry, index, body, surroundings):
    for part in ("body", "surroundings"):  # overrides may stand in sub-tables or beside the file name
        if isinstance(entry.get(part), dict):
            reader.known(entry[part], part, index)
            entry = {**{key: value for key, value in entry.items() if key != part}, **entry[part]}
    reader.known(entry, "trial", index)
    if "file" not in entry:
        raise InputError(f'{reader.path}: [[trial]] number {index + 1} has no file; add file = "....csv"')
    name = reader.words(entry, "file", "trial", index=index)
    file = reader.file_of(name, "file", "trial", index)
    group = entry.get("group", name)
    if isinstance(group, bool) or not isinstance(group, str | int | float):
        reader.fail("group", f'must be a name between quotes, such as "day 1", got {shown(group)}', "trial", index)
    session = reader.words(entry, "session", "trial", default="", index=index)
    if len(session) > LONGEST_SESSION or not session.isprintable():
        reader.fail("session", f"must be a printable name of at most {LONGEST_SESSION} letters", "trial", index)
    given = entry.get("start", {})
    reader.known(given, "trial.start", index)
    start = {
        key: reader.vector(given, key, "trial.start", length, index=index)
        for key, length in START_LENGTHS.items()
        if key in given
    }
    if "orientation" in start and abs(np.linalg.norm(start["orientation"]) - 1) > 1e-2:
        reader.fail(
            "orientation", f"must be a unit quaternion (w, x, y, z), got {list(start['orientation'])}", "trial.start", index
        )
    return TrialEntry(
        file=file,
        group=" ".join(str(group).split()),
        start=start,
        session=" ".join(session.split()),
        body=read_body(reader, entry, "trial", body, index),
        surroundings=_surroundings(reader, entry, "trial", surroundings, index),
    )


def _noise(reader, measurement, kind, of_poses):
    """(stated one-sigma values, those of a position along x, y, z over their root mean square)."""
    noise = measurement.get("noise", {})
    if isinstance(noise, int | float) and not isinstance(noise, bool):
        if of_poses:
            reader.fail(
                "noise",
                f"of what? Write noise = {{ position = {noise:g} }} [m], orientation [rad], acceleration [m/s2] where measured",
                "measurement",
            )
        noise = {"outcome": noise}
    reader.known(noise, "measurement.noise")
    for key in noise:
        if (key in OF_RECORDINGS) != of_poses:
            right = (
                "position [m], orientation [rad] and acceleration [m/s2]"
                if of_poses
                else "noise = 0.003, one sigma of the outcome"
            )
            reader.fail(key, f'has no place where kind = "{kind}"; write {right}', "measurement.noise")
    sizes, along = dict(noise), np.ones(3)
    if isinstance(noise.get("position"), list):
        along = np.array(reader.vector(noise, "position", "measurement.noise", 3, low=1e-12, high=1e6))
        sizes["position"] = float(np.sqrt(np.mean(along**2)))
        along /= sizes["position"]
    sizes = {key: reader.number(sizes, key, "measurement.noise", above=0.0, low=1e-12, high=1e6) for key in sizes}
    return sizes, tuple(along.tolist())


def _scale_error(reader, measurement, pixel):
    """One sigma of the length of a pixel, relative; 0 where none is stated."""
    error = reader.number(measurement, "metres_per_pixel_sd", "measurement", above=0.0)
    if error is None:
        return 0.0
    if pixel is None:
        reader.fail("metres_per_pixel_sd", "the error of what? Add metres_per_pixel = 0.002 [m]", "measurement")
    if not error < pixel / 2:
        reader.fail(
            "metres_per_pixel_sd", f"{error:g} m beside pixels of {pixel:g} m: measure a ruler in the view", "measurement"
        )
    return error / pixel


def _accelerometer(reader, measurement):
    """The axes along which an accelerometer reads, None where the file states none."""
    axes = reader.words(measurement, "accelerometer", "measurement", ("world", "body"))
    if axes and measurement.get("planar"):
        reader.fail(
            "accelerometer",
            "has no place beside planar = true: it also reads what carries the body; leave out planar, and state the floor",
            "measurement",
        )
    return axes


def _input_sd(reader, measurement):
    """{input: one sigma of its error} of a table."""
    section, table = "measurement.input_sd", measurement.get("input_sd", {})
    reader.known(table, section)
    return {key: reader.number(table, key, section, above=0.0) for key in table}
