"""The library of candidates: every effect of the engine, and what else may be wrong, under one face.

A `Candidate` knows its class, the numbers to be found with bounds and null values, and how to fill in what the
surroundings already say (density of the fluid, gravity, height of the floor). A user's own effect takes part like any other.
"""

import dataclasses
import difflib
import itertools
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

import minibullet.effects as forces
from hlcs.data.experiment_file import Surroundings
from hlcs.effects import body, ground, measurement, numerics
from hlcs.effects.contract import Change, name_of, parameters
from minibullet.effects.contract import Effect
from minibullet.errors import InputError

SHARED_FORCES = {forces.Gravity}  # part of every model, never a candidate
STATED = (forces.Friction, forces.Restitution)  # other values of numbers that every model has
NOT_FORCES = (
    measurement.TiltedFrame,
    measurement.LengthScale,
    measurement.TimeScale,
    measurement.ClockOffset,
    measurement.CalibrationCurve,
    measurement.TrackerSmoothing,
    body.MassOffset,
    body.SizeError,
    body.InertiaError,
    body.CentreOfMassOffset,
    ground.BottomSlope,
    numerics.MarginOffset,
)

# Entries that may turn out to be one and the same for given data, with the name of their set.
SETS = {
    "effective_gravity": ("buoyancy", "length_scale", "time_scale"),
    "drag_form": ("linear_drag", "quadratic_drag", "drag_crisis"),
    "tilt": ("tilted_gravity", "tilted_frame", "uniform_flow"),
    "rest_height": ("margin_offset", "size_error", "plate_bias", "settlement"),
}
FORMS = ("drag_form",)  # sets whose members are forms of one law: never two of them in one model

# Numbers that mean nothing while their effect is absent: what they would do is looked at from several values.
PERIODS = {(forces.AnisotropicFriction, "angle"): float(np.pi)}
VIEWS = {
    (forces.AnisotropicFriction, "angle"): tuple(np.pi * k / 4 for k in range(4)),
    (forces.StribeckFriction, "speed"): (0.05, 0.1, 0.2, 0.4),
}

AIR_DENSITY, AIR_VISCOSITY = 1.2, 1.8e-5  # taken where the file names no fluid [kg/m3, Pa s]


@dataclass(frozen=True)
class Free:
    """One number to be found."""

    name: str
    unit: str
    low: float
    high: float
    null: float | None  # value at which the effect is absent; None = it has none
    start: float  # where a fit begins
    period: float | None = None  # values this far apart are the same (an angle); such a number has no bounds
    views: tuple[float, ...] = ()  # of a number that means nothing while the effect is absent: where to look from

    def inside(self, value):
        """The value within the bounds, or the same angle within one period."""
        if self.period is not None:
            return self.low + (value - self.low) % self.period
        return min(max(value, self.low), self.high)


@dataclass(frozen=True)
class Candidate:
    """One thing that may be missing from the model."""

    name: str
    kind: type
    free: tuple[Free, ...]
    own: bool = False  # brought by the user

    @property
    def group(self):
        return getattr(self.kind, "group", "") or ("own" if self.own else "")

    @cached_property
    def hook(self):
        """Where it acts: "effect", "setup" or "look"."""
        if issubclass(self.kind, Effect):
            return "effect"
        return "setup" if self.kind.setup is not Change.setup else "look"

    @cached_property
    def touches(self):
        """What it can change: a set out of "force" (motion in flight), "contact" (only while touching), "setup", "look"."""
        if self.hook != "effect":
            return {self.hook}
        found = set()
        if self.kind.forces is not Effect.forces or self.kind.added_mass is not Effect.added_mass:
            found.add("force")
        if self.kind.contact_law is not Effect.contact_law:
            found.add("contact")
        return found

    def build(self, values, surroundings: Surroundings):
        """The effect at the given values {name: number}, what is given by the surroundings filled in."""
        return build(self.kind, values, surroundings)

    @property
    def starts(self):
        """Where fits begin for a law that is never absent: tuples of (name, value)."""
        default = {entry.name: entry.start for entry in self.free}
        if "critical_reynolds" not in default:
            return (tuple(default.items()),)
        return tuple(tuple((default | {"critical_reynolds": value}).items()) for value in (1e5, 2e5, 4e5))

    @property
    def absent(self):
        """Values at which it is not there, or None where no values say so (then it is simply left out)."""
        if all(entry.null is None for entry in self.free):
            return None
        return {entry.name: entry.null if entry.null is not None else entry.start for entry in self.free}

    @property
    def views(self):
        """All ways to be absent that look different as soon as it is there: tuple of {name: value}."""
        if self.absent is None:
            return ()
        choices = [[(entry.name, value) for value in entry.views or (self.absent[entry.name],)] for entry in self.free]
        return tuple(dict(chosen) for chosen in itertools.product(*choices))


def build(kind, values, surroundings: Surroundings):
    """A value of an effect class from numbers and the surroundings."""
    normal = tuple(surroundings.floor_normal)
    known = {
        "fluid_density": surroundings.fluid_density or AIR_DENSITY,
        "fluid_viscosity": surroundings.fluid_viscosity or AIR_VISCOSITY,
        "acceleration": surroundings.gravity,
        "wall_height": surroundings.floor_height or 0.0,
        "ground_height": surroundings.floor_height or 0.0,
        "wall_normal": normal,
        "ground_normal": normal,
    }
    fields = {field.name for field in dataclasses.fields(kind) if field.init}
    numbers = parameters(kind)
    given = {
        name: value
        for name, value in known.items()
        if name in fields and name not in values and (name not in numbers or numbers[name].given)
    }
    return kind(**given, **{name: float(value) for name, value in values.items()})


def candidate(kind, surroundings: Surroundings, radius=None, own=False, only=None):
    """The Candidate of an effect class; `radius` [m] scales bounds given in radii, `only` restricts the free numbers."""
    free = []
    for name, known in parameters(kind).items():
        if known.given or (only and name not in only):
            continue
        null = known.null
        if null is None and kind in STATED:
            null = getattr(surroundings, name_of(kind))
        scale = radius if known.bounds_in == "radius" and radius else 1.0
        low, high = (bound * scale if bound is not None else sign * 1e6 for bound, sign in ((known.low, -1), (known.high, 1)))
        start = null if null is not None else known.default
        free.append(
            Free(
                name,
                "1" if known.unit == "-" else known.unit,
                low,
                high,
                null,
                start,
                PERIODS.get((kind, name)),
                VIEWS.get((kind, name), ()),
            )
        )
    return Candidate(name_of(kind), kind, tuple(free), own)


def classes():
    """Name -> class of everything the library ships."""
    shipped = [kind for kind in forces.library().values() if kind not in SHARED_FORCES]
    return {name_of(kind): kind for kind in (*shipped, *NOT_FORCES)}


def class_named(name, extra=()):
    """The class of that name, shipped or the user's; InputError with the nearest known name."""
    known = classes() | {name_of(kind): kind for kind in extra}
    if name not in known:
        near = difflib.get_close_matches(name, sorted(known), n=1, cutoff=0.0)[0]
        raise InputError(f"unknown effect '{name}'; the nearest known effect is '{near}'")
    return known[name]


def check_names(file, own=()):
    """Refuse candidates and effects of an experiment file that nobody knows, or numbers that mean nothing, by file and line."""
    from hlcs.simulation.model import build_entry

    for names, key in ((file.candidates or (), "diagnose.candidates"), (file.effects, "model.effects")):
        for entry in names:
            try:
                if isinstance(entry, str):
                    class_named(entry, own)
                else:
                    build_entry(entry, file.surroundings, own)
            except InputError as problem:
                raise InputError(f"{file.place(key)}: {problem}") from None


def own_classes(effects=None, effects_file=None):
    """The user's own effect classes, from a Python file and from a list of classes or values."""
    kinds = [effect if isinstance(effect, type) else type(effect) for effect in (effects or ())]
    for kind in kinds:
        if not issubclass(kind, Effect | Change):
            raise InputError(f"{kind.__name__}: not an effect; derive it from minibullet.Effect")
    if effects_file is not None:
        kinds += list(forces.load_effects(Path(effects_file)).values())
    for kind in kinds:
        if not any(known.null is not None and not known.given for known in parameters(kind).values()):
            raise InputError(
                f"{kind.__name__}: no number with a null value to look for; write "
                "name: float = minibullet.parameter(0.0, unit=..., low=..., high=..., null=0.0)"
            )
    return tuple(dict.fromkeys(kinds))


def set_of(name):
    """Label of the set of look-alikes a name belongs to, or None."""
    return next((label for label, members in SETS.items() if name in members), None)
