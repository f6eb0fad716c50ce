"""A candidate: one thing that may be missing from a model, and the numbers to be found if it is.

A `Candidate` is a class with the numbers that a search may change, their bounds and null values. `build` makes an effect of a
class and numbers; what the surroundings already say (density of the fluid, gravity, height of the floor) is filled in.
"""

import dataclasses
import itertools
from dataclasses import dataclass

from hlcs.data.experiment_file import Surroundings
from minibullet.effects.contract import name_of, parameters
from minibullet.effects.fluid import AIR_DENSITY, AIR_VISCOSITY


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
    starts: tuple[float, ...] = ()  # where fits and first looks begin, where the start does not do alone

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
        return self.kind.group or ("own" if self.own else "")

    @property
    def start(self):
        """Where a fit begins, {name: value}: at the null values where there are any."""
        return {entry.name: entry.start for entry in self.free}

    @property
    def absent(self):
        """Values at which it is not there, or None where no values say so (then it is simply left out)."""
        return None if all(entry.null is None for entry in self.free) else self.start

    @property
    def starts(self):
        """Where fits begin, tuples of (name, value): several for a law that is never absent."""
        return tuple(self._begun()) if self.absent is None else (tuple(self.start.items()),)

    @property
    def views(self):
        """All ways to be absent that look different as soon as it is there: tuple of {name: value}."""
        return () if self.absent is None else tuple(dict(values) for values in self._begun())

    def _begun(self):
        """Every choice of the values that its numbers may begin from, as tuples of (name, value)."""
        return itertools.product(*([(entry.name, value) for value in entry.starts or (entry.start,)] for entry in self.free))


def build(kind, values, surroundings: Surroundings):
    """A value of an effect class at these numbers {name: value}, what the surroundings say filled in."""
    normal, height = tuple(surroundings.floor_normal), surroundings.floor_height or 0.0
    known = {
        "fluid_density": surroundings.fluid_density or AIR_DENSITY,
        "fluid_viscosity": surroundings.fluid_viscosity or AIR_VISCOSITY,
        "acceleration": surroundings.gravity,
        "wall_height": height,
        "ground_height": height,
        "wall_normal": normal,
        "ground_normal": normal,
    }
    numbers = parameters(kind)
    filled_in = {
        field.name: known[field.name]
        for field in dataclasses.fields(kind)
        if field.name in known and (field.name not in numbers or numbers[field.name].given)
    }
    return kind(**filled_in | {name: float(value) for name, value in values.items()})


def candidate(kind, surroundings: Surroundings, radius, body_known, own=False):
    """The Candidate of an effect class for a body of this radius [m], whose mass and size are known or not."""
    free = []
    for name, known in parameters(kind).items():
        if known.given or known.body_known not in (None, body_known):
            continue
        null = getattr(surroundings, name_of(kind), None) if kind.replaces and known.null is None else known.null
        scale = radius if known.bounds_in == "radius" else 1.0
        low, high = (bound * scale if bound is not None else sign * 1e6 for bound, sign in ((known.low, -1), (known.high, 1)))
        unit, start = "1" if known.unit == "-" else known.unit, null if null is not None else known.default
        free.append(Free(name, unit, low, high, null, start, known.period, known.starts))
    return Candidate(name_of(kind), kind, tuple(free), own)
