"""A candidate: one thing that may be missing from a model, and the numbers to be found if it is.

A `Candidate` is a class with the numbers that a search may change, their bounds and null values. `build` makes an effect of a
class and numbers; what the surroundings already say (density of the fluid, gravity, height of the floor) is filled in.
"""

import dataclasses
import itertools
from dataclasses import dataclass, replace

import numpy as np

from hlcs.data.experiment_file import Surroundings
from hlcs.data.rigid_body import RigidBody
from hlcs.effects.contract import BySession, in_sessions
from minibullet.effects import DragModifier
from minibullet.effects.contract import name_of, parameters
from minibullet.effects.fluid import AIR_VISCOSITY, Drag

KNOWN = (
    0.05  # relative error of a fluid density that a file states: temperature, salt, pressure; where none is stated any gas may be
)
BEYOND = 1.1  # times what a file states: plausible, though the law's own range ends below
MOST_AS_WIDE = 1.4  # times what a ball sets in motion: a cube, and rods in the mean over their attitudes (DNV-RP-C205, app. D)
FAST = 10.0  # speed of a body whose speed is not known, for what a drag in proportion to it may be [m/s]
FAR = 2.0  # times that error: beyond it a number contradicts the file
IN_NO_FLUID = 2.0  # times the end of its law's range: beyond it no fluid that a file states has a number, were the file mistaken
DENSITY = "fluid_density"  # the number that a file states under the same name
VISCOSITY = "viscosity"
STATED_OTHERWISE = {  # number -> (what a file states in its place, 0 = nothing; relative error of that)
    VISCOSITY: (lambda around: around.fluid_viscosity, 0.2),  # that of glycerine falls by 8 % for each degree
    "inverse_radius": (lambda around: around.tube_radius and 1 / around.tube_radius, 0.1),  # a sphere sinks beside the axis
}


def ends_of_law(low, null, ends, period=None):
    """(least, most) that a law allows of a number: what it states; else nothing above, and below zero or the null value where the
    plausible range begins there: what is positive stays positive, to a hundredth of that range's beginning."""
    least, most = ends
    if least is None:
        least = -np.inf if period is not None or low < 0 else low if low in (0.0, null) else 0.01 * low
    return least, np.inf if most is None else most


@dataclass(frozen=True)
class Free:
    """One number to be found: its plausible range low .. high is a belief, not a wall.

    Only where a law ends (a negative friction) is a number held."""

    name: str
    unit: str
    low: float
    high: float
    null: float | None  # value at which the effect is absent; None = it has none
    start: float  # where a fit begins
    period: float | None = None  # values this far apart are the same (an angle)
    starts: tuple[float, ...] = ()  # where fits and first looks begin, where the start does not do alone
    ends: tuple = (None, None)  # where the law itself ends (restitution 1), None: see `ends_of_law`
    stated: float | None = None  # value that the experiment file states or implies
    error: float = 0.0  # how far off that may be
    certain: bool = False  # the file states a fluid, in which the effect is there
    highest: float = np.inf  # end of the plausible range of the law itself, where the file states a narrower one
    holds_from: float = -np.inf  # value below which the law does not hold at the highest speed: Reynolds numbers are beyond it

    @property
    def expected(self):
        """What is believed beforehand: what is stated, else that the effect is absent, else the usual value."""
        if self.stated is not None:
            return self.stated
        return self.start if self.null is None else self.null

    @property
    def spread(self):
        """Half width of the belief: the error of what is stated, else half the plausible range on its longer side."""
        if self.stated is not None:
            return self.error
        return min(max(self.high - self.expected, self.expected - self.low), 1e6) / 2

    @property
    def least(self):
        """Where the law itself ends below."""
        return ends_of_law(self.low, self.null, self.ends, self.period)[0]

    @property
    def most(self):
        """Where the law itself ends above."""
        return ends_of_law(self.low, self.null, self.ends, self.period)[1]

    def inside(self, value):
        """The value where the law holds, or the same angle within one period."""
        if self.period is not None:
            return self.low + (value - self.low) % self.period
        return min(max(value, self.least), self.most)

    def towards(self, known, value, share):
        """A part of the way to a value, from where it stands among `known` numbers {name: value}, else from its null value; all
        of it where no value says that the effect is absent."""
        start = known.get(self.name, self.null)
        return value if start is None else self.inside((1 - share) * start + share * value)

    def about(self, value, zeroed):
        """The same number of an effect that the model states with this value; zeroed: is the effect absent at the null value? A
        range that goes as far to both sides of it, as that of a tilt, is now about what is stated."""
        even = zeroed and self.null is not None and np.isclose(self.null - self.low, self.high - self.null)
        shift = value - self.null if even else 0.0
        ends = (self.least, self.most)
        return replace(self, null=value, start=value, starts=(), ends=ends, low=self.low + shift, high=self.high + shift)

    def plausible(self, value):
        """Is a value within the plausible range?"""
        return self.period is not None or self.low <= value <= self.high

    def contradicts(self, value):
        """Is a value of what the file implies far from plausible, or one at which the law does not hold?"""
        return self.certain and not self.plausible(value) or value < self.holds_from

    def possible(self, value):
        """May it be so, were the file mistaken? No fluid that a file states is as dense as steel."""
        return not self.certain or self.plausible(value) or value <= IN_NO_FLUID * self.highest

    def beyond(self, value):
        """The value and on which side of the plausible range it lies, in words, each number with three digits or as
        many more as show that side; "" within it."""
        if self.plausible(value):
            return ""
        side, end = ("below", self.low) if value < self.low else ("above", self.high)
        pairs = [(of_end, of_value) for of_end in range(3, 18) for of_value in range(3, min(of_end + 4, 18))]
        of_end, of_value = next(
            ((m, n) for m, n in pairs if (float(f"{value:.{n}g}") - float(f"{end:.{m}g}")) * (value - end) > 0), (17, 17)
        )
        return f"{_to_digits(value, of_value)} lies {side} what is plausible ({self._range(of_end)})"

    def unlike_stated(self, low, value, high):
        """The value, of an interval low .. high, and on which side of what the file states by another name it lies, in words;
        "" of one that may be as stated, and of what no file states so."""
        if self.name not in STATED_OTHERWISE or not self.error:
            return ""
        if abs(np.clip(self.stated, low, high) - self.stated) < FAR * self.error:
            return ""
        unit, side = "" if self.unit == "1" else f" {self.unit}", "below" if value < self.stated else "above"
        told = f"{_to_digits(value, 3)} lies {side} the {_to_digits(self.stated, 3)}{unit} that the file states"
        return f"{told}, by more than twice the {100 * self.error / self.stated:.0f} % that this may be off"

    def doubt(self, effect, value):
        """What is said of a value beyond the plausible range, of a number of an effect of that name; "" within it."""
        beyond = self.beyond(value)
        return beyond and f"{effect}: {self.name} = {beyond}"

    @property
    def usual(self):
        """The plausible range in words, with its unit."""
        return self._range(3)

    def _range(self, digits):
        return f"{_to_digits(self.low, digits)} to {_to_digits(self.high, digits)}" + (
            "" if self.unit == "1" else f" {self.unit}"
        )

    def aside(self, value):
        """How far a value stands from what is expected, in spreads; an angle is as good as any other."""
        return 0.0 if self.period is not None else (value - self.expected) / self.spread

    def surprise(self, value):
        """-2 log of the belief in a value over that in the expected one: a Cauchy law, whose tails leave room for what nobody
        expected (A. Gelman et al., Ann. Appl. Stat. 2 (2008) 1360)."""
        return 2 * np.log1p(self.aside(value) ** 2)


def _to_digits(value, digits):
    """A number to so many digits, without a power of ten up to a million."""
    return f"{float(f'{value:.{digits}g}'):.{max(digits, 6)}g}"


@dataclass(frozen=True)
class Candidate:
    """One thing that may be missing from the model."""

    name: str
    kind: type
    free: tuple[Free, ...]
    own: bool = False  # brought by the user
    constants: tuple[tuple[str, float], ...] = ()  # that say how it is there, where that is not to be found
    doubted: bool = False  # the file states by how much it may be there: nothing speaks against it but that
    presumed: bool = False  # the file states no fluid, and so means air, in which it acts
    family: str = ""  # what a verdict on layers can tell apart: "physics", "placement", "measurement" or "numerics"
    words: str = ""  # what it is called in plain words, where its class does not say
    setting: bool = False  # its number is one that the model under test states: it can be wrong, not missing

    @property
    def group(self):
        return self.kind.group or ("own" if self.own else "")

    def called(self, fluid="air"):
        """What it is called in plain words, in a fluid of this name: "water resistance", "resistance of the fluid of .."."""
        plain = self.words or self.kind.plain or self.name.replace("_", " ")
        if " " in fluid:
            plain = plain.replace("{fluid} resistance", "resistance of the {fluid}")
        return plain.replace("{fluid}", fluid)

    @property
    def start(self):
        """Where a fit begins, {name: value}: at the null values where there are any."""
        return {entry.name: entry.start for entry in self.free}

    @property
    def expected(self):
        """What is believed of its numbers beforehand, {name: value}."""
        return {entry.name: entry.expected for entry in self.free}

    def surprise(self, numbers):
        """-2 log of what is believed of its numbers {name: value}, relative to what is expected."""
        return sum(free.surprise(numbers[free.name]) for free in self.free)

    @property
    def form_of(self):
        """Label of the law that it is one form of, or an empty text."""
        return self.kind.form_of

    @property
    def alike(self):
        """Label of the set of look-alikes that it belongs to, or an empty text."""
        return self.kind.form_of or self.kind.alike

    @property
    def is_drag(self):
        return issubclass(self.kind, Drag)

    @property
    def through_drag(self):
        """Does it act through a drag alone?"""
        return issubclass(self.kind, DragModifier)

    def holds(self, other):
        """Is the law of another candidate a special case of its own?"""
        return other.kind in self.kind.contains

    @property
    def absent(self):
        """Values at which it is not there, or None where no values say so (then it is simply left out)."""
        return None if all(entry.null is None for entry in self.free) else self.start

    @property
    def views(self):
        """All ways to be absent that look different as soon as it is there: tuple of {name: value}."""
        choices = [[(entry.name, value) for value in entry.starts or (entry.start,)] for entry in self.free]
        return () if self.absent is None else tuple(map(dict, itertools.product(*choices)))

    @property
    def valleys(self):
        """Every choice of the numbers that name several starts, tuple of {name: value}; () without."""
        choices = [[(entry.name, value) for value in entry.starts] for entry in self.free if entry.starts]
        return tuple(map(dict, itertools.product(*choices))) if choices else ()


def build(kind, values, surroundings: Surroundings):
    """A value of an effect class at these numbers {name: value}, what the surroundings say filled in.

    Numbers of several sessions, {"offset A": value, ..}, make a change that is another one in each.
    """
    if sessions := in_sessions(values):
        return BySession(tuple((session, build(kind, numbers, surroundings)) for session, numbers in sessions.items()))
    normal, height = tuple(surroundings.floor_normal), surroundings.floor_height or 0.0
    known = {
        "fluid_density": surroundings.fluid_density,
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


def each_session(entry, sessions):
    """The Candidate with one number for each session, in place of one for all; itself where its law or the model has but one."""
    if len(sessions) < 2 or entry.setting or not getattr(entry.kind, "by_session", False):
        return entry
    return replace(entry, free=tuple(replace(free, name=f"{free.name} {session}") for session in sessions for free in entry.free))


def stated_otherwise(name, surroundings):
    """(value, error) of a number that a file states of the surroundings by another name; () where it does not."""
    stated, error = STATED_OTHERWISE.get(name, (lambda around: 0.0, 0.0))
    value = stated(surroundings)
    return (value, error * value) if value else ()


def in_doubt(entry, number, error):
    """A Candidate whose number the file states to be uncertain: by `error` about its null value, and FAR times that is plausible.
    It is there for certain."""

    def believed(free):
        low, high = (free.null + sign * FAR * error for sign in (-1, 1))
        return replace(
            free, stated=free.null, error=error, low=min(free.low, low), high=max(free.high, high), ends=(free.least, free.most)
        )

    free = tuple(believed(each) if each.name.split()[0] == number else each for each in entry.free)
    return replace(entry, free=free, doubted=True)


def as_wide(body):
    """Volume of a ball of the same area as a rigid body over its own: what it sets in motion over what as large a ball does.

    Without end for a flat one only: a rod sets no more in motion than a cube does, part by part.
    """
    if not body.volume > 0:
        return 1.0
    least, middle, largest = sorted(body.inertia)
    flat = largest - middle > middle - least
    return float(np.clip(4 / 3 * np.pi * (body.area / np.pi) ** 1.5 / body.volume, 1.0, np.inf if flat else MOST_AS_WIDE))


def speed_of_drag(surroundings, body, speed):
    """Speed [m/s] at which a drag coefficient of 2.5 slows a body as much as is plausible at the fastest that it was, `speed`.

    In a gas the coefficient is 24/Re more where the flow creeps (G. G. Stokes 1851); a liquid may have any viscosity.
    """
    if not speed or surroundings.in_liquid or not surroundings.fluid_density:
        return FAST
    viscosity = surroundings.fluid_viscosity or AIR_VISCOSITY
    return speed + 24 / 2.5 * viscosity / (2 * body.radius * surroundings.fluid_density)


def numbers_stated(kind, entry):
    """Names of the numbers to be found that an entry of [model] effects states, one for all sessions; they may be wrong."""
    return tuple(name for name, known in parameters(kind).items() if name in entry and not known.given)


def candidate(kind, surroundings: Surroundings, body: RigidBody, body_known, own=False, extent=1.0, speed=0.0, entry=None):
    """The Candidate of an effect class for a rigid body whose mass and size are known or not.

    extent: range of heights [m]; speed: the fastest that the body was, 0 = not known [m/s]; entry: of [model] effects, where the
    model has the effect already: its numbers may be others than stated there.

    What the file states of the density of its fluid is believed.
    """
    free, fluid = [], surroundings.fluid_stated and surroundings.fluid_density > 0
    drag = 0.5 * surroundings.fluid_density * body.area / body.mass if body_known and surroundings.fluid_density else 0.2
    fast = speed_of_drag(surroundings, body, speed) if body_known else FAST
    scales = {"": 1.0, "ball as wide": as_wide(body), "radius": body.radius, "drag at speed": drag * fast}
    scales |= {"extent": extent, "per extent": 1 / extent}
    for name, known in parameters(kind).items():
        if (
            known.given or known.body_known not in (None, body_known)
            if entry is None
            else name not in numbers_stated(kind, entry)
        ):
            continue
        null = getattr(surroundings, name_of(kind), None) if kind.replaces and known.null is None else known.null
        scale = scales[known.bounds_in]
        low, high = (bound * scale if bound is not None else sign * 1e6 for bound, sign in ((known.low, -1), (known.high, 1)))
        unit, start = "1" if known.unit == "-" else known.unit, null if null is not None else known.default
        stated = getattr(surroundings, name, None) or None  # no number of a fluid is expected of a vacuum
        error = (KNOWN if fluid else 1.0) * stated if stated else 0.0
        if otherwise := stated_otherwise(name, surroundings):
            stated, error = otherwise
        if stated is not None:
            high = max(high, BEYOND * stated)
        highest = high
        if name == DENSITY and fluid:
            low, high = ((1 + sign * FAR * KNOWN) * stated for sign in (-1, 1))  # a lighter fluid contradicts the file as well
        if known.in_fluid and fluid:
            usual, error = (part * scale for part in known.in_fluid)
            stated = usual if entry is None else entry[name]  # whoever writes a number into the model knows more of the body
        ends, certain = (known.least, known.most), fluid and stated is not None
        inertia = 2 * body.radius * surroundings.fluid_density * speed  # of the flow: over the viscosity a Reynolds number
        holds_from = inertia / kind.reynolds[1] if name == VISCOSITY else -np.inf
        free.append(
            Free(
                name, unit, low, high, null, start, known.period, known.starts, ends, stated, error, certain, highest, holds_from
            )
        )
    if entry is not None:
        free = [each.about(entry[each.name], not kind.replaces) for each in free]
    return Candidate(name_of(kind), kind, tuple(free), own, setting=kind.replaces or entry is not None)
