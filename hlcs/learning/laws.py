"""Laws that a missing force may follow: a function of one variable along one direction, each written as an effect.

A law is fitted as the very class that is written for the user: what is tried is the text of an effect file. Numbers in which
the force is linear come from least squares, so only the others are searched.
"""

from dataclasses import dataclass, replace
from itertools import product
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from minibullet.effects.catalogue import module_of

KNOTS = 10  # of a table: more than the bends of a law of one variable that a handful of recordings can show
STEEPEST = 6.0  # exponent of a power, either way
EDGE = 0.01  # a force goes on and off within this time, shorter than the spacing of the frames of most cameras [s]
AXES = "xyz"
HEAD = '''"""A force per mass, as learned from recordings. {text}"""

from dataclasses import dataclass

import minibullet as mb
import numpy as np


@dataclass(frozen=True)
class LearnedForce(mb.Effect):
    """{text}"""

{fields}
    isotropic = False

    def forces(self, bodies, time):
{body}
        return np.hstack([bodies.mass[:, None] * acceleration, np.zeros_like(acceleration)])
'''


@dataclass(frozen=True)
class Number:
    """One number of a law and the range in which it is searched; a given one has no range."""

    name: str
    unit: str
    low: float | None = None
    high: float | None = None
    value: float = 0.0
    linear: bool = False  # the force is proportional to it

    def written(self):
        """The line of the effect's class that declares it."""
        known = "given=True" if self.low is None else f"low={self.low!r}, high={self.high!r}" + ", null=0.0" * self.linear
        return f'    {self.name}: float = mb.parameter({self.value!r}, unit="{self.unit}", {known})'


@dataclass(frozen=True)
class Law:
    """One variable, one way to act, one form."""

    variable: str
    form: str
    way: str
    linear: tuple[Number, ...]
    searched: tuple[Number, ...]
    given: tuple[Number, ...]
    lines: tuple[str, ...]  # of the effect's method, up to `acceleration` (n, 3)
    begins: tuple[tuple[float, ...], ...] = ((),)  # values of the searched numbers from which a search begins
    own_phases: bool = False  # the linear numbers are other ones in every recording

    @property
    def knots(self):
        """Are the linear numbers values at places side by side?"""
        return self.form == "table" and self.variable != "heading"

    @property
    def fitted(self):
        return (*self.linear, *self.searched)

    @property
    def direction(self):
        """The fixed direction along which it acts (3,); None where it has none."""
        if self.way == "axes":
            vector = np.array([sum(n.value for n in self.linear if n.name == f"strength_{axis}") for axis in AXES])
            return vector / max(np.linalg.norm(vector), 1e-300)
        if self.way == "direction":
            known = {number.name: number.value for number in (*self.searched, *self.given)}
            azimuth, elevation = (known[name] for name in ANGLES)
            return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
        return None

    def force_at(self, values):
        """Force per mass along its direction at values (k,) of its variable [m/s2], in the very words of the law."""
        shape = "".join(f"    {line}\n" for line in self.lines if line.startswith("shape = "))
        text = f"import numpy as np\n\n\ndef force(self, u):\n{shape}    return shape\n"
        numbers = SimpleNamespace(**{number.name: number.value for number in (*self.fitted, *self.given)})
        found = module_of(text, "shape_of_law", "<shape of a law>").force(numbers, values)
        strengths = [number.value for number in self.linear if self.form != "table"]
        return found * (np.linalg.norm(strengths) if self.way == "axes" else np.prod(strengths))

    def source(self, text=""):
        """The text of an effect file."""
        fields = "\n".join(number.written() for number in (*self.fitted, *self.given))
        return HEAD.format(text=text, fields=fields, body="\n".join(" " * 8 + line for line in self.lines))

    def kind(self):
        """The class that this text defines."""
        return module_of(self.source(), "learned_effect", "learned_effect.py").LearnedForce

    def at(self, linear, searched):
        """The law at other values of its numbers; the linear ones may become ten times as large as the largest."""
        reach = float(f"{10 * np.max(np.abs(linear), initial=1e-6):.2g}")
        values = [*linear, *searched]
        moved = [
            replace(number, value=float(f"{value:.8g}"), **({"low": -reach, "high": reach} if number.linear else {}))
            for number, value in zip(self.fitted, values, strict=True)
        ]
        return replace(self, linear=tuple(moved[: len(self.linear)]), searched=tuple(moved[len(self.linear) :]))


# variable -> (unit, unit of its inverse, lines that give it as u (n,))
SPEED, SPIN = ("bodies.twist[:, :3]", "bodies.twist[:, 3:]")
VARIABLES = {
    "speed": ("m/s", "s/m", (f"u = np.maximum(np.linalg.norm({SPEED}, axis=1), 1e-9)",)),
    "height": ("m", "1/m", ("u = bodies.position[:, 2]",)),
    "x": ("m", "1/m", ("u = bodies.position[:, 0]",)),
    "y": ("m", "1/m", ("u = bodies.position[:, 1]",)),
    "heading": ("rad", "1/rad", ("u = np.arctan2(bodies.twist[:, 1], bodies.twist[:, 0])",)),
    "distance": (
        "m",
        "1/m",
        (
            "gap = np.array([self.point_x, self.point_y, self.point_z]) - bodies.position",
            "u = np.maximum(np.linalg.norm(gap, axis=1), 1e-9)",
        ),
    ),
    "time": ("s", "1/s", ("u = time + np.zeros(len(bodies.mass))",)),
    "spin": ("rad/s", "s/rad", (f"u = np.maximum(np.linalg.norm({SPIN}, axis=1), 1e-9)",)),
}
WRITTEN = "import numpy as np\n" + "".join(
    f"\n\ndef {name}(bodies, time):\n" + "".join(f"    {line}\n" for line in lines) + "    return u\n"
    for name, (_, _, lines) in VARIABLES.items()
    if name != "distance"  # from a point that is to be found
)
NEEDED = {"height": "z", "x": "x", "y": "y", "heading": "xy"}  # axes along which positions must be measured to know a variable
SIGNED = ("height", "x", "y")  # a power of such a variable keeps its sign
# way -> lines that give the direction `along` (n, 3) in which a positive force acts
UNIT = "along = {0} / np.maximum(np.linalg.norm({0}, axis=1, keepdims=True), 1e-9)"
WAYS = {
    "velocity": ("velocity = bodies.twist[:, :3]", UNIT.format("velocity")),
    "lift": ("side = np.cross(bodies.twist[:, 3:], bodies.twist[:, :3])", UNIT.format("side")),
    "point": ("along = gap / u[:, None]",),
    "direction": (
        "level = np.cos(self.elevation)",
        "along = np.array([[level * np.cos(self.azimuth), level * np.sin(self.azimuth), np.sin(self.elevation)]])",
    ),
}
ANGLES = ("azimuth", "elevation")  # of a direction [rad]
HELD = {  # axes along which positions were measured -> angles that keep a direction among them [rad]
    "x": {"azimuth": 0.0, "elevation": 0.0},
    "y": {"azimuth": np.pi / 2, "elevation": 0.0},
    "z": {"azimuth": 0.0, "elevation": np.pi / 2},
    "xy": {"elevation": 0.0},
    "xz": {"azimuth": 0.0},
    "yz": {"azimuth": np.pi / 2},
}
HALF_SPHERE = ((0.0, 0.0), (np.pi / 2, 0.0), (0.0, np.pi / 2)) + tuple(
    (quarter * np.pi / 4, height * np.pi / 5) for quarter in (1, 3, 5, 7) for height in (0, 1)
)  # ANGLES of the directions to begin with
TRIED = {  # variable -> ((way, forms), ..); "axes": along x, y and z, each with a strength of its own
    "speed": (("velocity", ("power", "exponential", "table")),),
    "height": (("axes", ("power", "exponential", "table")), ("velocity", ("power", "exponential", "table"))),
    "x": (("axes", ("power", "exponential", "table")),),
    "y": (("axes", ("power", "exponential", "table")),),
    "heading": (("velocity", ("table",)),),
    "distance": (("point", ("power", "exponential")),),
    "time": (("axes", ("power", "exponential", "switch", "oscillation", "table")),),
    "spin": (("lift", ("power", "exponential")),),
}


def seen(bodies, time):
    """{variable: its values (n,)} of all that need no number to be found, in the very words of the laws."""
    module = module_of(WRITTEN, "seen_variables", "<variables of laws>")
    return {name: getattr(module, name)(bodies, time) for name in VARIABLES if hasattr(module, name)}


class Ranges(NamedTuple):
    """Where and when the bodies were seen."""

    box: np.ndarray  # corners of their places (2, 3) [m]
    duration: float  # of the longest recording [s]
    slowest: float  # frequency that every flight shows to come back [Hz]
    fastest: float  # frequency that the frames can show [Hz]
    measured: str = AXES  # axes along which positions were measured: of no other is a force seen


def laws(values, ranges):
    """Every law to try on recordings.

    values: variable -> its values in the data, absent where it is not seen.
    """
    found = []
    for variable, ways in TRIED.items():
        for way, forms in ways:
            for form in forms if variable in values else ():
                found.append(one_law(variable, form, way, values[variable], ranges))
    return found + [replace(one, own_phases=True) for one in found if one.form == "oscillation"]


def one_law(variable, form, way, values, ranges, axes=AXES):
    """One Law, its numbers ranged and begun by the data."""
    unit, inverse, lines = VARIABLES[variable]
    if form == "oscillation":
        return oscillation(lines, ranges, axes)
    if form == "table":
        way = "direction" if way == "axes" else way
        searched, given, shape, begins, linear = table(variable, values)
    else:
        searched, given, shape, begins = SHAPES[form](variable, unit, inverse, values, ranges.duration)
        names = [f"strength_{axis}" for axis in axes] if way == "axes" else ["strength"]
        linear = tuple(Number(name, "m/s2", -1.0, 1.0, linear=True) for name in names)
    if way == "axes":
        vector = ", ".join(f"self.strength_{axis}" if axis in axes else "0.0" for axis in AXES)
        lines = (*lines, *shape, f"acceleration = np.outer(shape, ({vector}))")
    else:
        factor = "" if form == "table" else "self.strength * "
        lines = (*lines, *WAYS[way], *shape, f"acceleration = ({factor}shape)[:, None] * along")
    if way == "direction":
        held = HELD.get(ranges.measured, {})
        free = [name for name in ANGLES if name not in held]
        angles = dict.fromkeys(tuple(one[ANGLES.index(name)] for name in free) for one in HALF_SPHERE)
        searched = (*searched, *(Number(name, "rad", -10.0, 10.0) for name in free))
        begins = tuple((*a, *b) for a in begins for b in angles)
        given = (*given, *(Number(name, "rad", value=value) for name, value in held.items()))
    if way == "point":
        room = ranges.box + np.outer([-1.0, 1.0], np.ptp(ranges.box, axis=0) + 0.5)
        point = tuple(
            Number(f"point_{axis}", "m", *map(float, np.round(ends, 3))) for axis, ends in zip(AXES, room.T, strict=True)
        )
        places = [tuple(place) for place in product(*(np.linspace(low, high, 8)[1:-1] for low, high in room.T))]
        searched, begins = (*searched, *point), tuple((*a, *b) for a in begins for b in places)
    return Law(variable, form, way, linear, searched, given, lines, begins)


def power(variable, unit, inverse, values, duration):
    exponents = (0.5, 1.0, 2.0, 3.0) if variable == "time" else (-4.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 4.0)
    exponent = Number("exponent", "-", 0.05 if variable == "time" else -STEEPEST, STEEPEST)
    size = Number("reference", unit, value=float(f"{np.median(np.abs(values)) + 1e-9:.2g}"))
    line = "shape = (u / self.reference) ** self.exponent"
    if variable in SIGNED:
        line = "shape = np.sign(u) * np.maximum(np.abs(u / self.reference), 1e-9) ** self.exponent"
    return (exponent,), (size,), (line,), tuple((n,) for n in exponents)


def exponential(variable, unit, inverse, values, duration):
    span = max(float(np.ptp(values)), 1e-9)
    middle = Number("reference", unit, value=float(f"{np.mean(values):.2g}"))
    reach = float(f"{20 / span:.2g}")
    line = "shape = np.exp(np.clip(self.rate * (u - self.reference), -50.0, 50.0))"
    begins = tuple((k / span,) for k in (-8.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 8.0))
    return (Number("rate", inverse, -reach, reach),), (middle,), (line,), begins


def switch(variable, unit, inverse, values, duration):
    moments = np.linspace(0.0, duration, 13)
    numbers = tuple(Number(name, "s", -0.5 * duration, 1.5 * duration) for name in ("start_s", "end_s"))
    line = "shape = (np.tanh((u - self.start_s) / self.edge) - np.tanh((u - self.end_s) / self.edge)) / 2"
    begins = tuple((float(a), float(b)) for a in moments for b in moments if b > a)
    return numbers, (Number("edge", "s", value=EDGE),), (line,), begins


SHAPES = {"power": power, "exponential": exponential, "switch": switch}


def knots_of(values):
    """Places side by side at which a table has its values (KNOTS,)."""
    return np.linspace(*np.quantile(values, (0.01, 0.99)), KNOTS)


def table(variable, values):
    """(searched, given, lines, begins, linear numbers) of straight lines between knots; of a heading, of two harmonics."""
    if variable == "heading":
        terms = {
            "mean": "",
            "cos_1": " * np.cos(u)",
            "sin_1": " * np.sin(u)",
            "cos_2": " * np.cos(2 * u)",
            "sin_2": " * np.sin(2 * u)",
        }
        line = "shape = " + " + ".join(f"self.{name}{factor}" for name, factor in terms.items())
        names = tuple(terms)
    else:
        knots = ", ".join(f"{knot:.4g}" for knot in knots_of(values))
        names = tuple(f"value_{k + 1}" for k in range(KNOTS))
        line = f"shape = np.interp(u, ({knots}), ({', '.join('self.' + name for name in names)}))"
    return (), (), (line,), ((),), tuple(Number(name, "m/s2", -1.0, 1.0, linear=True) for name in names)


def oscillation(lines, ranges, axes=AXES):
    """A force that swings with time, along each axis with an amplitude and a phase of its own."""
    parts = {part: ", ".join(f"self.{part}_{axis}" if axis in axes else "0.0" for axis in AXES) for part in ("cos", "sin")}
    shapes = " + ".join(f"np.outer(np.{part}(angle), ({vector}))" for part, vector in parts.items())
    linear = tuple(Number(f"{part}_{axis}", "m/s2", -1.0, 1.0, linear=True) for axis in axes for part in parts)
    frequency = Number("frequency_hz", "Hz", ranges.slowest, max(ranges.fastest, 2 * ranges.slowest))
    begins = tuple((float(f),) for f in np.arange(ranges.slowest, frequency.high, 0.2 / ranges.duration))
    lines = (*lines, "angle = 2 * np.pi * self.frequency_hz * u", "acceleration = " + shapes)
    return Law("time", "oscillation", "axes", linear, (frequency,), (), lines, begins)
