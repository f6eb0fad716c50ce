"""What is known of an effect, as one record: the rows of `hlcs effects` and of the catalogue in the documentation.

Nothing is said here: law, formula, numbers and what an effect looks like are taken from its class.
"""

import inspect
from dataclasses import asdict, dataclass

from hlcs.effects.library import class_named, with_own
from minibullet.effects.contract import Facts, Parameter, name_of, parameters, symbols_of

FLUID = "fluid"  # what plain words call the surroundings where none are given
BOUNDS_IN = {  # what bounds are multiples of, in words
    "ball as wide": "times the volume of a ball as wide as the body over its own",
    "radius": "times the radius of the body",
    "drag at speed": "times rho A/(2 m) at the speed of the body",
    "extent": "times the range of heights",
    "per extent": "over the range of heights",
}
FAMILIES = {  # headings of the catalogue, in its order: {group of the class: heading}
    "fluid": "What a fluid does",
    "contact_tangential": "Friction and rolling",
    "contact_normal": "Impact and contact",
    "ground": "The ground",
    "body": "The body",
    "measurement": "The measurement",
    "placement": "Placing, tests of layers only",
    "physics": "Units and bottom, tests of layers only",
    "plates": "Reading of layers, tests of layers only",
    "numerics": "The model itself, tests of layers only",
    "": "Effects of your own",
}


@dataclass(frozen=True)
class NumberFacts:
    """One number of an effect: name, letter in the formula, what it is, and what is usual."""

    name: str
    symbol: str
    about: str
    unit: str  # SI unit in words, "1" for a pure number
    default: float | None  # [unit]
    low: float | None  # plausible range [unit, or what bounds_in says]
    high: float | None
    bounds_in: str  # "", or what the range is a multiple of, in words
    null: float | None  # value at which the effect is absent [unit]
    given: bool  # known from the experiment file and not to be found
    typical: tuple[tuple[float, str], ...]  # (value [unit], of what)
    source: str

    @property
    def range(self):
        """The plausible range in words, "" where there is none."""
        if self.low is None and self.high is None:
            return ""
        ends = " to ".join("any" if end is None else f"{float(f'{end:.3g}'):g}" for end in (self.low, self.high))
        return f"{ends} {self.bounds_in}".rstrip()


@dataclass(frozen=True)
class EffectFacts:
    """What is known of one effect; texts are in plain words, formulas in plain letters."""

    name: str
    class_name: str  # "minibullet.QuadraticDrag"; "" for what only tests of layers know
    called: str  # in plain words
    group: str  # one of FAMILIES
    law: str  # a sentence
    formula: str
    symbols: tuple[tuple[str, str], ...]  # (letter, meaning [unit])
    numbers: tuple[NumberFacts, ...]
    looks_like: str
    confused_with: tuple[str, ...]
    details: str  # what else there is to know, with sources

    def to_json(self):
        """The record for a program."""
        return {**asdict(self), "symbols": dict(self.symbols)}


def facts_of(kind, own=()):
    """The EffectFacts of an effect class, shipped or the user's own."""
    law, _, details = inspect.cleandoc(kind.__doc__ or "").partition("\n\n")
    name = name_of(kind)
    return EffectFacts(
        name=name,
        class_name=class_name(kind),
        called=(kind.plain or name.replace("_", " ")).replace("{fluid}", FLUID),
        group=kind.group,
        law=" ".join(law.split()),
        formula=kind.formula,
        symbols=tuple(symbols_of(kind).items()),
        numbers=tuple(number_facts(known) for known in parameters(kind).values()),
        looks_like=kind.looks_like,
        confused_with=confused_with(name, own),
        details="\n\n".join(" ".join(part.split()) for part in details.split("\n\n")),
    )


def class_name(kind):
    """Where Python code finds a class: an effect of the engine under the name that minibullet offers it by."""
    shipped = kind.__module__.startswith("minibullet.effects.")
    return f"minibullet.{kind.__name__}" if shipped else f"{kind.__module__}.{kind.__name__}"


def number_facts(known: Parameter):
    """NumberFacts of a Parameter."""
    return NumberFacts(
        known.name,
        known.symbol or known.name,
        known.about,
        "1" if known.unit == "-" else known.unit,
        known.default,
        known.low,
        known.high,
        BOUNDS_IN.get(known.bounds_in, ""),
        known.null,
        known.given,
        known.typical,
        known.source,
    )


def confused_with(name, own=()):
    """Names of all effects that look like this one: those of its set, those that it names, those that name it; sorted."""
    known = with_own(own)
    kind = known[name]
    return tuple(
        sorted(
            other
            for other, theirs in known.items()
            if other != name and (_one_set(kind, theirs) or other in kind.confused_with or name in theirs.confused_with)
        )
    )


def _one_set(kind: type[Facts], other: type[Facts]):
    """Do two classes belong to one set of look-alikes?"""
    return any(label and label in (other.form_of, other.alike) for label in (kind.form_of, kind.alike))


def catalogue(own=()):
    """EffectFacts of every class of the library and of the user's own, in the order of FAMILIES, then by name."""
    order = list(FAMILIES)
    found = [facts_of(kind, own) for kind in with_own(own).values()]
    return sorted(found, key=lambda facts: (order.index(facts.group), facts.name))


def facts_named(name, own=()):
    """The EffectFacts of that name; InputError with the nearest known name."""
    return facts_of(class_named(name, own), own)
