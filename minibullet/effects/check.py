"""check_effect: does an effect keep the contract? Each rule is one function; the first one broken is named."""

from copy import deepcopy
from dataclasses import dataclass, fields, replace
from numbers import Real

import numpy as np

from minibullet.effects import samples
from minibullet.effects.contract import Effect, EffectError, checked_answer, checked_law, name_of, overrides, parameters
from minibullet.errors import InputError

LATER = 1.7  # a while after the start [s]
TIMES = (0.0, LATER)
OTHER_UNITS = (4.0, 0.125, 2.0)  # powers of two, so that a change of units rounds nothing


@dataclass(frozen=True)
class Report:
    """What check_effect found: the rules kept, and notes on what is allowed but worth knowing."""

    effect: str  # name of the effect
    rules: tuple[str, ...]  # names of the rules that it keeps, in the order of checking
    notes: tuple[str, ...]  # one sentence each

    def __str__(self):
        return "\n".join([f"{self.effect} keeps all rules: {', '.join(self.rules)}", *(f"  note: {note}" for note in self.notes)])


def check_effect(effect: Effect) -> Report:
    """Try an effect on sample bodies and contacts and return a Report; EffectError names the effect and the first rule it breaks.

    effect: a value of an Effect of yours. It is tried as it is, and with every number that stands at its null value moved well
    inside its bounds, so that ``check_effect(MyDrag())`` tells the whole truth.
    """
    if not isinstance(effect, Effect):
        hint = " (a class; make a value with parentheses)" if isinstance(effect, type) and issubclass(effect, Effect) else ""
        raise InputError(f"check_effect wants a value of a subclass of Effect, not {effect!r}{hint}")
    kept = []
    with np.errstate(all="ignore"):
        for rule, (concerns, check) in RULES.items():
            if not concerns(effect):
                continue
            for variant in _variants(effect):
                try:
                    check(variant)
                except _Broken as broken:
                    raise EffectError(type(effect).__name__, rule, str(broken)) from broken.__cause__
            kept.append(rule)
        return Report(name_of(effect), tuple(kept), (*_idle_numbers(effect), *_wrong_dimensions(effect)))


class _Broken(Exception):
    """A rule is broken; the message says how and what to do."""


def declaration(effect):
    """A frozen dataclass that overrides a method of Effect and whose numbers carry unit and bounds."""
    kind = type(effect)
    if "__dataclass_fields__" not in vars(kind):
        raise _Broken(f"put @dataclass(frozen=True) above class {kind.__name__}")
    if not any(overrides(effect, method) for method in ("forces", "added_mass", "contact_law")):
        raise _Broken("it does nothing; write one of the methods forces, added_mass, contact_law")
    known = parameters(effect)
    for field in fields(effect):
        value = getattr(effect, field.name)
        if field.name not in known and isinstance(value, Real) and not isinstance(value, bool):
            raise _Broken(
                f'{field.name} has no unit and bounds; write {field.name}: float = parameter({value!r}, unit="...", '
                f'low=..., high=..., null=...), or unit="..." and given=True for a number that is known'
            )
    for name, number in known.items():
        if not isinstance(number.unit, str) or not number.unit.strip():
            raise _Broken(f'{name} needs a unit, such as "1/s", or "-" for a pure number')
        if (number.low is None or number.high is None) and not number.given:
            raise _Broken(f"{name} needs bounds low and high, between which it is searched (or given=True where it is known)")
        if number.low is not None and number.high is not None and not number.low < number.high:
            raise _Broken(f"{name} has bounds {number.low} and {number.high}; low must be below high")
    try:
        hash(effect)
    except TypeError as error:
        raise _Broken("a field holds something that can change, such as an array or a list; use numbers and tuples") from error


def answer(effect):
    """Right shapes and finite numbers, for seven bodies and for one, at the start and later; possible laws at contacts."""
    for bodies in (samples.sample_bodies(), samples.rows(samples.sample_bodies(), slice(3, 4))):
        for time in TIMES:
            _results(effect, bodies, time)


def reads_only(effect):
    """Bodies, contacts and law are left as they were, to the last bit."""
    for time in TIMES:
        for method, arguments in _calls(effect, samples.sample_bodies(), time).items():
            before = deepcopy(arguments)
            _ask(effect, method, arguments)
            for record, copy in zip(arguments, before, strict=True):
                for name in getattr(record, "_fields", ()):
                    if getattr(record, name).tobytes() != getattr(copy, name).tobytes():
                        raise _Broken(f"{method} writes into {type(record).__name__}.{name}; copy it before you change it")


def repeatable(effect):
    """The same question has the same answer, to the last bit: no chance, no memory."""
    first, *others = (_results(effect, samples.sample_bodies()) for _ in range(3))
    if any(not np.array_equal(a, b) for other in others for a, b in zip(first, other, strict=True)):
        raise _Broken("two equal calls give different answers; an effect has no memory and draws no random numbers")


def null(effect):
    """With every number that has a null value at that value, the effect is absent to the last bit."""
    absent = _nulls(effect)
    if changed := _difference(replace(effect, **absent)):
        values = ", ".join(f"{name} = {value}" for name, value in absent.items())
        raise _Broken(f"with {values} it must be exactly absent, but {changed}")


def rotation(effect):
    """Turning the world turns the answer, for an effect that says it is isotropic."""
    q, bodies, (contacts, law) = samples.a_turn(), samples.sample_bodies(), samples.sample_contacts()
    straight = _results(effect, bodies, LATER, contacts, law)
    turned = _results(effect, samples.turned(q, bodies), LATER, samples.turned(q, contacts), law)
    turn = samples.turned_columns(q, np.eye(6)).T
    expected = [samples.turned_columns(q, straight[0]), turn @ straight[1] @ turn.T, *straight[2:]]
    if not _close(turned, expected):
        raise _Broken(
            "turning all bodies does not turn the answer with them; if a direction is meant, write isotropic = False in the class"
        )


def dissipative(effect):
    """The wrench of an effect that says it is dissipative does no positive work."""
    bodies = samples.sample_bodies()
    for time in TIMES:
        work = _results(effect, bodies, time)[0] * bodies.twist
        power = work.sum(axis=1)
        if np.any(power > 1e-12 * np.abs(work).sum(axis=1)):
            k = int(np.argmax(power))
            raise _Broken(f"it says dissipative = True, but gives body {k} a power of {power[k]:.3g} W; is the sign right?")


def independence(effect):
    """Each body and each contact has the same answer in any order; each body also on its own."""
    bodies, (contacts, law) = samples.sample_bodies(), samples.sample_contacts()
    straight, backwards = _results(effect, bodies, LATER, contacts, law), slice(None, None, -1)
    if not _same_rows(_results(effect, samples.rows(bodies, backwards))[:2], straight[:2], backwards):
        raise _Broken("the answer for a body depends on the order of the bodies; row k must be about body k")
    for k in range(len(bodies.mass)):
        alone = slice(k, k + 1)
        if not _same_rows(_results(effect, samples.rows(bodies, alone))[:2], straight[:2], alone):
            raise _Broken("the answer for a body changes when the others are not there; use each body's own row only")
    other = _results(effect, bodies, LATER, samples.rows(contacts, backwards), samples.rows(law, backwards))
    if not _same_rows(other[2:], straight[2:], backwards):
        raise _Broken("the law at a contact depends on the order of the contacts")


def mass_matrix(effect):
    """Added mass is symmetric and never negative, or the solver could gain energy from it."""
    matrices = _results(effect, samples.sample_bodies(), TIMES[0])[1]
    size = np.abs(matrices).max()
    if np.abs(matrices - matrices.transpose(0, 2, 1)).max() > 1e-12 * size:
        raise _Broken("added_mass is not symmetric")
    if np.linalg.eigvalsh(matrices).min() < -1e-12 * size:
        raise _Broken("added_mass has a negative eigenvalue: it would take mass away in some direction")


def _nulls(effect):
    """{name: null value} of the numbers of an effect that have one."""
    return {name: number.null for name, number in parameters(effect).items() if number.null is not None}


def _always(effect):
    return True


# rule: (which effects it concerns, what tries one value of such an effect)
RULES = {
    "declaration": (_always, declaration),
    "answer": (_always, answer),
    "reads only": (_always, reads_only),
    "repeatable": (_always, repeatable),
    "null": (_nulls, null),
    "rotation": (lambda effect: effect.isotropic, rotation),
    "dissipative": (lambda effect: effect.dissipative, dissipative),
    "independence": (_always, independence),
    "mass matrix": (lambda effect: overrides(effect, "added_mass"), mass_matrix),
}


def _idle_numbers(effect):
    """Notes on numbers without influence: allowed, and yet likely to be a slip."""
    known, absent = parameters(effect), _nulls(effect)
    for name, null_value in absent.items():
        own = getattr(effect, name)
        alone = absent | {name: own if own != null_value else _active_value(known[name])}
        if not _difference(replace(effect, **alone)):
            yield f"{name} on its own changes nothing on the sample bodies"


def _wrong_dimensions(effect):
    """At most one note, on constants that depend on the units."""
    bodies, (contacts, law) = samples.sample_bodies(), samples.sample_contacts()
    force, moment = (samples.factor(kind, OTHER_UNITS) for kind in samples.WRENCH_DIMENSIONS)
    block = OTHER_UNITS[1] * np.outer(*2 * [np.repeat([1.0, moment / force], 3)])
    others = [samples.in_units(OTHER_UNITS, record) for record in (bodies, contacts, law)]
    for variant in _variants(effect):
        changed = samples.in_units(OTHER_UNITS, variant)
        if changed is None:
            return ["a unit is not understood, so the dimensions are not checked"]
        straight = _results(variant, bodies, LATER, contacts, law)
        expected = [
            samples.in_units_columns(OTHER_UNITS, straight[0], samples.WRENCH_DIMENSIONS),
            straight[1] * block,
            *samples.in_units(OTHER_UNITS, type(law)(*straight[2:])),
        ]
        if not _close(_results(changed, others[0], LATER * OTHER_UNITS[2], *others[1:]), expected):
            return [
                "in other units the answer is another one: a dimension is wrong (is the mass missing from a force?), or a "
                "constant in SI units is built in; make that a parameter with given=True"
            ]
    return []


def _variants(effect):
    """The effect as it is, and with the numbers that stand at their null values moved away from them."""
    yield effect
    moved = {
        name: _active_value(number)
        for name, number in parameters(effect).items()
        if not number.given and number.null is not None and getattr(effect, name) == number.null
    }
    if moved:
        yield replace(effect, **moved)


def _active_value(number):
    """A value well inside the bounds and away from null; bounds in multiples of the radius are read for 0.1 m."""
    low, high = number.low, number.high
    if low is None or high is None:
        low, high = number.null, number.null + 1.0
    return (low + 0.7 * (high - low)) * (0.1 if number.bounds_in else 1.0)


def _calls(effect, bodies, time, contacts=None, law=None):
    """{method: arguments of its own} of the methods an effect has of its own; without contacts, those of the sample."""
    touching = bodies
    if contacts is None:
        touching, (contacts, law) = samples.sample_bodies(), samples.sample_contacts()
    calls = {"forces": (bodies, time), "added_mass": (bodies,), "contact_law": (contacts, samples.with_fixed_body(touching), law)}
    return {method: deepcopy(arguments) for method, arguments in calls.items() if overrides(effect, method)}


def _ask(effect, method, arguments):
    """One call; whatever goes wrong in it is told in one line."""
    try:
        return getattr(effect, method)(*arguments)
    except Exception as error:
        raise _Broken(f"{method} fails with {type(error).__name__}: {error}") from error


def _results(effect, bodies, time=LATER, contacts=None, law=None):
    """Wrench, added mass and the five arrays of the law, checked for shape and finite values; nothing where not overridden."""
    n = len(bodies.mass)
    plain_contacts, plain_law = samples.sample_contacts() if contacts is None else (contacts, law)
    found = {"forces": np.zeros((n, 6)), "added_mass": np.zeros((n, 6, 6)), "contact_law": plain_law}
    for method, arguments in _calls(effect, bodies, time, contacts, law).items():
        given = _ask(effect, method, arguments)
        try:
            if method == "contact_law":
                found[method] = checked_law(effect, given, plain_contacts)
            else:
                found[method] = checked_answer(effect, given, n, found[method].shape[1:])
        except (ValueError, TypeError) as error:
            at_rest = method == "forces" and np.shape(given) == (n, 6) and not np.isfinite(given[0]).all()  # body 0 is
            hint = "; is it divided by a speed of zero?" if at_rest else ""
            raise _Broken(f"{method}: {str(error).removeprefix(type(effect).__name__ + ': ')}{hint}") from error
    return [found["forces"], found["added_mass"], *found["contact_law"]]


def _difference(effect):
    """In words, what the effect does to the sample; empty where it is absent to the last bit."""
    _, law = samples.sample_contacts()
    forces, matrices, *changed = _results(effect, samples.sample_bodies())
    for what, array in (("wrench", forces), ("added mass", matrices)):
        if np.any(array != 0.0):
            return f"the {what} of body {int(np.argmax(np.any(array.reshape(len(array), -1) != 0.0, axis=1)))} is not 0"
    for name, old, new in zip(law._fields, law, changed, strict=True):
        if not np.array_equal(old, new):
            k = int(np.argmax(old != new))
            return f"{name} of contact {k} is {new[k]} in place of {old[k]}"
    return ""


def _close(found, expected):
    """Equal but for rounding: within 1e-9 of the largest number of each array, of which rounding takes 1e-15."""
    return all(np.abs(a - b).max(initial=0.0) <= 1e-9 * np.abs(b).max(initial=0.0) for a, b in zip(found, expected, strict=True))


def _same_rows(found, arrays, rows):
    """Are these the given rows of the arrays, but for rounding?"""
    return _close(found, [array[rows] for array in arrays])
