"""The contract of an effect: physics that is added from outside, as one frozen value.

A complete effect of your own, ready for a World and for ``check_effect``:

    from dataclasses import dataclass
    import minibullet as mb

    @dataclass(frozen=True)
    class MyDrag(mb.Effect):
        '''Force against the velocity, rate times momentum.'''
        rate: float = mb.parameter(0.0, unit="1/s", low=0, high=5, null=0.0)

        def forces(self, bodies, time):
            wrench = -self.rate * bodies.mass[:, None] * bodies.twist
            wrench[:, 3:] = 0.0
            return wrench

An effect reads `bodies` and returns numbers; the engine adds them, integrates them and books their work. It sees moving
bodies only, so masses are finite. It keeps nothing between calls. With every parameter at its null value it is exactly
absent.
"""

import dataclasses
import re
from dataclasses import dataclass
from enum import Enum, auto
from functools import reduce
from typing import ClassVar, NamedTuple

import numpy as np

from minibullet.bodies import Bodies, ContactLaw, Contacts, moving
from minibullet.errors import InputError, is_number, shown
from minibullet.values import Value

# letters of formulas that mean the same in all laws; an effect states the others in `symbols`, and those of its numbers with them
SYMBOLS = {
    "F": "force on the body [N]",
    "M": "moment on the body [N m]",
    "F_n": "normal force at a contact [N]",
    "F_t": "tangential force at a contact [N]",
    "m": "mass of the body [kg]",
    "I": "inertia of the body [kg m2]",
    "L": "size of the body: side of the cube of equal volume [m]",
    "r": "radius of the sphere of equal volume [m]",
    "A": "mean projected area [m2]",
    "V": "volume [m3]",
    "h": "distance of the centre from the plane, at least r [m]",
    "t": "time [s]",
    "x": "position along x [m]",
    "y": "position along y [m]",
    "z": "position along z, upwards [m]",
    "v": "velocity [m/s]",
    "w": "velocity relative to the fluid [m/s]",
    "w_n": "speed of approach to the plane, 0 where it parts [m/s]",
    "v_n": "speed of approach along the normal of a contact [m/s]",
    "v_t": "slip speed in the tangent plane [m/s]",
    "omega": "angular velocity [rad/s]",
    "g": "acceleration of gravity [m/s2]",
    "d": "direction of gravity, of length 1",
    "D": "force of the fluid without this effect [N]",
    "mu": "friction coefficient without this effect",
    "load": "normal force at the contact [N]",
    "true": "position of the body as it is [m]",
    "seen": "position of the body as recorded [m]",
    "gap": "distance of two surfaces in contact [m]",
}
LETTERS = re.compile(r"[A-Za-z]\w*")
LARGEST = np.where(np.array(ContactLaw._fields) == "restitution", 1.0, np.finfo(float).max)[:, None]  # of each field of a law


class EffectError(InputError):
    """An effect breaks a rule of the contract. effect: its name; rule: the rule's name; message: what to do."""

    def __init__(self, effect: str, rule: str, message: str):
        super().__init__(f"{effect} breaks the rule '{rule}': {message}")
        self.effect, self.rule, self.message = effect, rule, message

    def __reduce__(self):
        return EffectError, (self.effect, self.rule, self.message)


class Parameter(NamedTuple):
    """What is known of one number of an effect."""

    name: str  # name of the field
    default: float  # value where none is given [unit]
    unit: str  # SI unit in words such as "kg/m3"; "-" for a pure number
    low: float | None = None  # lowest plausible value, None = any [unit, or in multiples of bounds_in]
    high: float | None = None  # highest plausible value, None = any [unit, or in multiples of bounds_in]
    null: float | None = None  # value at which the effect is exactly absent, None = there is none [unit]
    source: str = ""  # where law, value or bounds come from
    given: bool = False  # True: a property of the surroundings, known and not fitted (density of the fluid, ...)
    bounds_in: str = ""  # "" or what the bounds are multiples of: "radius" of the body, "drag at speed": rho_f A/(2 m) times
    # its speed, "ball as wide": volume of a ball of the same area over that of the body, "extent": the range of heights that
    # were measured, or "per extent": 1 over that
    least: float | None = None  # where the law itself ends below, None = at `low` where that is zero or the null value [unit]
    most: float | None = None  # where the law itself ends above, None = nowhere [unit]
    period: float | None = None  # values this far apart mean the same (an angle); then the bounds do not bind [unit]
    starts: tuple[float, ...] = ()  # from where a fit begins, where the null value or the default does not do alone [unit]
    in_fluid: tuple[float, float] | None = None  # usual value and its error in a stated fluid, where the effect is certain
    body_known: bool | None = None  # True, False: for bodies whose mass and size are known, unknown; None: for all
    symbol: str = ""  # letter that stands for it in the formula, "" = its name does
    about: str = ""  # what it is, in a few words
    typical: tuple[tuple[float, str], ...] = ()  # (value [unit], of what, with a source of its own where `source` is another)


def parameter(default, *, unit, low=None, high=None, null=None, source="", **more):
    """A number of an effect, as a dataclass field that knows its unit, bounds and null value.

    default: value where none is given; unit: SI unit in words such as "kg/m3", "-" for a pure number; low, high: plausible range;
    null: value at which the effect is absent; source: where value or bounds come from; more: other fields of Parameter.
    """
    known = Parameter("", default, unit, low, high, null, source, **more)
    return dataclasses.field(default=default, metadata={"parameter": known})


def parameters(effect) -> dict[str, Parameter]:
    """Name -> Parameter of every number of an effect or an effect class, in order of definition."""
    return {
        field.name: field.metadata["parameter"]._replace(name=field.name)
        for field in dataclasses.fields(effect)
        if "parameter" in field.metadata
    }


def name_of(effect) -> str:
    """The name in files and reports: QuadraticDrag, or a value of it, -> "quadratic_drag"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", _class_of(effect).__name__).lower()


def law_of(effect) -> str:
    """The law of an effect, or of an effect class, the first sentence of its docstring and its formula."""
    kind = _class_of(effect)
    text = " ".join((kind.__doc__ or "").split("\n\n")[0].split())
    sentence = re.split(r"\.(?:\s|$)", text, maxsplit=1)[0]
    return f"{sentence}: {kind.formula}" if kind.formula else sentence


def symbols_of(effect) -> dict[str, str]:
    """Letter -> meaning [unit] of the formula of an effect, or of an effect class; its own numbers are not among them.

    A letter that nobody explains is left out; of the shipped effects a test asks for all.
    """
    kind = _class_of(effect)
    known, numbers = SYMBOLS | kind.symbols, {number.symbol or name for name, number in parameters(kind).items()}
    letters = dict.fromkeys(LETTERS.findall(kind.formula))
    return {letter: known[letter] for letter in letters if letter in known and letter not in numbers}


def _class_of(effect):
    return effect if isinstance(effect, type) else type(effect)


class Need(Enum):
    """What must be there or be known of a body, its surroundings and its motion, or a law cannot act or cannot be seen to act."""

    MASS_AND_SIZE = auto()  # of the body
    SIZE = auto()  # of the body, whatever its mass
    SPHERE = auto()  # the law is that of no other shape
    EDGES = auto()  # and faces: what a sphere has not
    FLUID = auto()  # around the body: nothing of it acts in a vacuum
    FLOOR = auto()  # a plane that something happens at
    TUBE = auto()  # walls around a liquid
    CONTACT = auto()  # bodies that touch
    SPIN = auto()  # the law depends on it
    ROTATION = auto()  # the law acts on nothing else
    RELEASE = auto()  # the moment at which the motion began
    SIDEWAYS = auto()  # horizontal motion, along which the law acts
    UNLIKE_LOADS = auto()  # forces with which bodies press on each other


class Facts(Value):
    """What is known of a law, or of anything else that may be missing from a model, besides its numbers: class attributes."""

    plain: ClassVar[str] = ""  # in plain words, after "the data show": "{fluid} resistance", with {fluid} to be filled in
    formula: ClassVar[str] = ""  # the law in letters, one line of plain text
    symbols: ClassVar[dict[str, str]] = {}  # letters of the formula that SYMBOLS does not know: {letter: meaning [unit]}
    looks_like: ClassVar[str] = ""  # what it leaves in data where the model lacks it, a sentence
    confused_with: ClassVar[tuple[str, ...]] = ()  # names of effects that look like it, beside those of its set; one of two says
    group: ClassVar[str] = ""  # heading in lists of candidates: fluid, contact_normal, contact_tangential, measurement, ...
    needs: ClassVar[tuple[Enum, ...]] = ()  # what it needs, the first to be named where it is missing
    alike: ClassVar[str] = ""  # label of the set whose members may turn out to be one and the same for given data
    form_of: ClassVar[str] = ""  # the same for forms of one law
    powers: ClassVar[tuple[int, ...]] = (0,)  # of the speed with which such a form goes; forms of other powers add up to a law
    reynolds: ClassVar[tuple[float, float]] = (0.0, np.inf)  # Reynolds numbers that must be reached, and up to which it holds
    contains: ClassVar[tuple[type, ...]] = ()  # laws that it is instead of: with one of these it would count twice
    replaces: ClassVar[bool] = False  # True: it states a coefficient that every model has; others then change that one


@dataclass(frozen=True)
class Effect(Facts):
    """One law of physics; subclasses override one or more of the three methods and state their facts and flags."""

    isotropic: ClassVar[bool] = True  # turning the whole world turns the answer; set False where a direction is built in
    dissipative: ClassVar[bool] = False  # True: the wrench never does positive work on any body

    def __post_init__(self):
        for name in parameters(self):
            value = getattr(self, name)
            if not is_number(value):
                raise InputError(f"{type(self).__name__}: {name} must be a finite number, not {shown(value)}")

    def forces(self, bodies: Bodies, time: float) -> np.ndarray:
        """Wrench at each centre of mass, world frame: force [N], then moment [N m], (n, 6)."""
        return np.zeros((len(bodies.mass), 6))

    def potential(self, bodies: Bodies) -> float:
        """Potential energy of the bodies where the effect has one, whose slope is the force [J]."""
        return 0.0

    def added_mass(self, bodies: Bodies) -> np.ndarray | None:
        """Mass that the surroundings add to each body, world frame, order of twist [kg, kg m, kg m2], (n, 6, 6) or None."""
        return None

    def contact_law(self, contacts: Contacts, bodies: Bodies, law: ContactLaw) -> ContactLaw:
        """The law at each contact, changed by ``law._replace(...)``; `bodies` here holds the fixed ones too."""
        return law


def overrides(effect, method) -> bool:
    """Whether an effect, or an effect class, has this method of its own."""
    return getattr(_class_of(effect), method) is not getattr(Effect, method)


def wrenches(effects, bodies: Bodies, time: float) -> list[np.ndarray]:
    """The wrench of each effect on all bodies, checked, exactly zero on fixed ones, (n, 6) each. This is how the engine asks.

    Raises InputError, naming the effect, where an answer has a wrong shape or is not finite.
    """
    rows, movable = _movable(bodies)
    return [
        _spread(effect, rows, movable, effect.forces(movable, time), bodies, (6,))
        if overrides(effect, "forces") and len(movable.mass)
        else np.zeros((len(bodies.mass), 6))
        for effect in effects
    ]


def mean_wrenches(before, after, jump, correction, time_step):
    """The mean over a step of each effect's wrench (n, 6), from that before and that after the impacts of the step.

    A body that rebounds is braked the other way. The wrench at the velocity before an impact for the whole step would be an
    error of the order of the step, and one that leaps with the moment of the impact. Of several impacts the mean time counts.
    """
    late = (jump * (jump - correction / time_step)).sum(axis=1, keepdims=True)
    left = np.clip(late / np.maximum((jump * jump).sum(axis=1, keepdims=True), 1e-300), 0.0, 1.0)  # part of the step
    return [first + left * (later - first) for first, later in zip(before, after, strict=True)]


def wrench(effect: Effect, bodies: Bodies, time: float) -> np.ndarray:
    """The wrench of one effect on all bodies, as in `wrenches`, (n, 6)."""
    return wrenches((effect,), bodies, time)[0]


def added_mass(effects, bodies: Bodies) -> np.ndarray | None:
    """The added mass of all effects together, zero for fixed bodies, (n, 6, 6), or None where no effect adds any."""
    effects = [effect for effect in effects if overrides(effect, "added_mass")]
    if not effects:
        return None
    rows, movable = _movable(bodies)
    if not len(movable.mass):
        return None
    return reduce(np.add, (_spread(effect, rows, movable, effect.added_mass(movable), bodies, (6, 6)) for effect in effects))


def changes_contact_law(effects) -> bool:
    """Whether any of the effects has something to say about contacts."""
    return any(overrides(effect, "contact_law") for effect in effects)


def contact_law(effects, contacts: Contacts, bodies: Bodies, law: ContactLaw) -> ContactLaw:
    """The law after every effect, in their order, has changed it; checked after each one.

    Raises InputError, naming the effect, where a value is not finite, is negative, or a restitution is above 1.
    """
    for effect in effects:
        if len(contacts.gap) and overrides(effect, "contact_law"):
            law = checked_law(effect, effect.contact_law(contacts, bodies, law), contacts)
    return law


def _movable(bodies):
    """Rows of the bodies that can move, and these bodies; as a slice where they follow one another: it copies nothing."""
    rows = moving(bodies)
    count = np.count_nonzero(rows)
    if count == len(rows):
        return slice(None), bodies
    first = int(rows.argmax())
    if np.count_nonzero(rows[first : first + count]) == count:
        rows = slice(first, first + count)
    return rows, Bodies(*[array[rows] for array in bodies])


def _spread(effect, rows, movable, answer, bodies, shape):
    """The checked answer about the moving bodies in the rows of all bodies, zeros elsewhere."""
    answer = checked_answer(effect, answer, len(movable.mass), shape)
    if movable is bodies:
        return answer
    result = np.zeros((len(bodies.mass), *shape))
    result[rows] = answer
    return result


def checked_answer(effect, answer, n, shape):
    """The answer of forces or added_mass as a float array of n rows, or InputError; None for added mass counts as zeros."""
    if answer is None and shape == (6, 6):
        return np.zeros((n, *shape))
    answer = np.asarray(answer, dtype=float)
    if answer.shape != (n, *shape):
        raise InputError(f"{type(effect).__name__}: answered shape {answer.shape} for {n} bodies; it must be {(n, *shape)}")
    if np.count_nonzero(np.isfinite(answer)) < answer.size:
        row = int(np.argmin(np.isfinite(answer).reshape(n, -1).all(axis=1)))
        raise InputError(f"{type(effect).__name__}: the answer for moving body {row} is not finite: {answer[row].tolist()}")
    return answer


def checked_law(effect, law, contacts):
    """The law itself, refused by effect, field and contact where no contact can have it."""
    if not isinstance(law, ContactLaw):
        raise InputError(f"{type(effect).__name__}: contact_law must return a ContactLaw, not {type(law).__name__}")
    law = ContactLaw(*[np.asarray(values, dtype=float) for values in law])
    for field, values in zip(law._fields, law, strict=True):
        if values.shape != contacts.gap.shape:
            raise InputError(f"{type(effect).__name__}: {field} has shape {values.shape}; it must be {contacts.gap.shape}")
    rows = np.array(law)
    possible = (rows >= 0.0) & (rows <= LARGEST)
    if np.count_nonzero(possible) < possible.size:
        row, k = np.argwhere(~possible)[0]
        field, pair = law._fields[row], f"bodies {contacts.body_a[k]} and {contacts.body_b[k]}"
        rule = "between 0 and 1" if field == "restitution" else "finite and not negative"
        raise InputError(f"{type(effect).__name__}: {field} of contact {k} ({pair}) is {rows[row, k]}; it must be {rule}")
    return law
