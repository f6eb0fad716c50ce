"""check_effect: does an effect keep the contract? Each rule is one function; the first one broken is named."""

from dataclasses import dataclass, fields, replace
from numbers import Real

import numpy as np

from minibullet.effects import samples
from minibullet.effects.contract import Effect, EffectError, checked_answer, checked_law, name_of, parameters
from minibullet.errors import InputError

TIMES = (0.0, 1.7)  # the start, and a while later [s]
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

    It is tried as it is, and with every number that stands at its null value moved well inside its bounds, so that
    ``check_effect(MyDrag())`` tells the whole truth.
    """
    if not isinstance(effect, Effect):
        hint = " (a class; make a value with parentheses)" if isinstance(effect, type) and issubclass(effect, Effect) else ""
        raise InputError(f"check_effect wants a value of a subclass of Effect, not {effect!r}{hint}")
    kept = []
    with np.errstate(all="ignore"):
        for rule, check in RULES.items():
            try:
                applies = check(effect)
            except _Broken as broken:
                raise EffectError(type(effect).__name__, rule, str(broken)) from broken.__cause__
            if applies is not False:
                kept.append(rule)
        return Report(name_of(effect), tuple(kept), tuple(_notes(effect)))


class _Broken(Exception):
    """A rule is broken; the message says how and what to do."""


def declaration(effect):
    """A frozen dataclass that overrides a method of Effect and whose numbers carry unit and bounds."""
    kind = type(effect)
    if "__dataclass_fields__" not in vars(kind):
        raise _Broken(f"put @dataclass(frozen=True) above class {kind.__name__}")
    if not any(_overrides(effect, method) for method in ("forces", "added_mass", "contact_law")):
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
    for variant in _variants(effect):
        for bodies in (samples.sample_bodies(), samples.rows(samples.sample_bodies(), slice(3, 4))):
            for time in TIMES:
                _answers(variant, bodies, time)


def reads_only(effect):
    """Bodies, contacts and law are left as they were, to the last bit."""
    for variant in _variants(effect):
        for time in TIMES:
            for method, arguments in _calls(variant, samples.sample_bodies(), time):
                records = [record for record in arguments if isinstance(record, tuple)]
                before = [[array.copy() for array in record] for record in records]
                _ask(variant, method, arguments)
                for record, copies in zip(records, before, strict=True):
                    for name, array, copy in zip(record._fields, record, copies, strict=True):
                        if array.tobytes() != copy.tobytes():
                            raise _Broken(f"{method} writes into {type(record).__name__}.{name}; copy it before you change it")


def repeatable(effect):
    """The same question has the same answer, to the last bit: no chance, no memory."""
    for variant in _variants(effect):
        first, *others = (_answers(variant, samples.sample_bodies(), TIMES[1]) for _ in range(3))
        if any(not np.array_equal(a, b) for other in others for a, b in zip(first, other, strict=True)):
            raise _Broken("two equal calls give different answers; an effect has no memory and draws no random numbers")


def null(effect):
    """With every number that has a null value at that value, the effect is absent to the last bit."""
    absent = {name: number.null for name, number in parameters(effect).items() if number.null is not None}
    if not absent:
        return False
    values = ", ".join(f"{name} = {value}" for name, value in absent.items())
    for variant in _variants(effect):
        changed = _difference(replace(variant, **absent))
        if changed:
            raise _Broken(f"with {values} it must be exactly absent, but {changed}")
    return True


def rotation(effect):
    """Turning the world turns the answer, for an effect that says it is isotropic."""
    if not effect.isotropic:
        return False
    q = samples.a_turn()
    bodies = samples.sample_bodies()
    contacts, law = samples.sample_contacts()
    for variant in _variants(effect):
        straight = _answers(variant, bodies, TIMES[1], contacts, law)
        turned = _answers(variant, samples.turned(q, bodies), TIMES[1], samples.turned(q, contacts), law)
        turn = samples.turned_columns(q, np.eye(6)).T
        expected = [samples.turned_columns(q, straight[0]), turn @ straight[1] @ turn.T, *straight[2:]]
        if not _close(turned, expected):
            raise _Broken(
                "turning all bodies does not turn the answer with them; if a direction is meant, write "
                "isotropic = False in the class"
            )
    return True


def dissipative(effect):
    """The wrench of an effect that says it is dissipative does no positive work."""
    if not effect.dissipative:
        return False
    for variant in _variants(effect):
        bodies = samples.sample_bodies()
        for time in TIMES:
            work = _answers(variant, bodies, time)[0] * bodies.twist
            power = work.sum(axis=1)
            if np.any(power > 1e-12 * np.abs(work).sum(axis=1)):
                k = int(np.argmax(power))
                raise _Broken(f"it says dissipative = True, but gives body {k} a power of {power[k]:.3g} W; is the sign right?")
    return True


def independence(effect):
    """Each body and each contact has the same answer in any order; each body also on its own."""
    bodies = samples.sample_bodies()
    contacts, law = samples.sample_contacts()
    for variant in _variants(effect):
        straight = _answers(variant, bodies, TIMES[1], contacts, law)
        backwards = slice(None, None, -1)
        reverse = _answers(variant, samples.rows(bodies, backwards), TIMES[1])[:2]
        if not _close(reverse, [array[backwards] for array in straight[:2]]):
            raise _Broken("the answer for a body depends on the order of the bodies; row k must be about body k")
        for k in range(len(bodies.mass)):
            alone = _answers(variant, samples.rows(bodies, slice(k, k + 1)), TIMES[1])[:2]
            if not _close(alone, [array[k : k + 1] for array in straight[:2]]):
                raise _Broken("the answer for a body changes when the others are not there; use each body's own row only")
        other = _answers(variant, bodies, TIMES[1], samples.rows(contacts, backwards), samples.rows(law, backwards))
        if not _close(other[2:], [array[backwards] for array in straight[2:]]):
            raise _Broken("the law at a contact depends on the order of the contacts")


def mass_matrix(effect):
    """Added mass is symmetric and never negative, or the solver could gain energy from it."""
    if not _overrides(effect, "added_mass"):
        return False
    for variant in _variants(effect):
        matrices = _answers(variant, samples.sample_bodies(), TIMES[0])[1]
        size = np.abs(matrices).max()
        if np.abs(matrices - matrices.transpose(0, 2, 1)).max() > 1e-12 * size:
            raise _Broken("added_mass is not symmetric")
        if np.linalg.eigvalsh(matrices).min() < -1e-12 * size:
            raise _Broken("added_mass has a negative eigenvalue: it would take mass away in some direction")
    return True


RULES = {
    "declaration": declaration,
    "answer": answer,
    "reads only": reads_only,
    "repeatable": repeatable,
    "null": null,
    "rotation": rotation,
    "dissipative": dissipative,
    "independence": independence,
    "mass matrix": mass_matrix,
}


def _notes(effect):
    """What is allowed and yet likely to be a slip: numbers without influence, constants that depend on the units."""
    for name, number in parameters(effect).items():
        if number.null is not None:
            others = {other: known.null for other, known in parameters(effect).items() if known.null is not None}
            own = getattr(effect, name)
            alone = replace(effect, **(others | {name: own if own != number.null else _active_value(number)}))
            if not _difference(alone):
                yield f"{name} on its own changes nothing on the sample bodies"
    for variant in _variants(effect):
        other = samples.in_units(OTHER_UNITS, variant)
        if other is None:
            yield "a unit is not understood, so the dimensions are not checked"
            return
        records = (samples.sample_bodies(), *samples.sample_contacts())
        straight = _answers(variant, records[0], TIMES[1], *records[1:])
        bodies, contacts, law = (samples.in_units(OTHER_UNITS, record) for record in records)
        changed = _answers(other, bodies, TIMES[1] * OTHER_UNITS[2], contacts, law)
        force, moment = (samples.factor(kind, OTHER_UNITS) for kind in samples.WRENCH_DIMENSIONS)
        lever = moment / force
        block = OTHER_UNITS[1] * np.outer(*2 * [np.repeat([1.0, lever], 3)])
        expected = [
            samples.in_units_columns(OTHER_UNITS, straight[0], samples.WRENCH_DIMENSIONS),
            straight[1] * block,
            *samples.in_units(OTHER_UNITS, type(law)(*straight[2:])),
        ]
        if not _close(changed, expected):
            yield (
                "in other units the answer is another one: a dimension is wrong (is the mass missing from a force?), or a "
                "constant in SI units is built in; make that a parameter with given=True"
            )
            return


def _variants(effect):
    """The effect as it is, and with the numbers that stand at their null values moved away from them."""
    moved = {
        name: _active_value(number)
        for name, number in parameters(effect).items()
        if not number.given and number.null is not None and getattr(effect, name) == number.null
    }
    return (effect, replace(effect, **moved)) if moved else (effect,)


def _active_value(number):
    """A value well inside the bounds and away from null; bounds in multiples of the radius are read for 0.1 m."""
    low, high = number.low, number.high
    if low is None or high is None:
        low, high = number.null, number.null + 1.0
    return (low + 0.7 * (high - low)) * (0.1 if number.bounds_in else 1.0)


def _overrides(effect, method):
    return getattr(type(effect), method) is not getattr(Effect, method)


def _calls(effect, bodies, time, contacts=None, law=None):
    """The methods an effect has of its own, with arguments that refuse to be written."""
    touching = bodies
    if contacts is None:
        touching, (contacts, law) = samples.sample_bodies(), samples.sample_contacts()
    calls = {"forces": (bodies, time), "added_mass": (bodies,), "contact_law": (contacts, samples.with_fixed_body(touching), law)}
    for method, arguments in calls.items():
        if _overrides(effect, method):
            guarded = [type(a)(*(np.array(array) for array in a)) if isinstance(a, tuple) else a for a in arguments]
            for array in (array for record in guarded if isinstance(record, tuple) for array in record):
                array.setflags(write=False)
            yield method, guarded


def _ask(effect, method, arguments):
    """One call; whatever goes wrong in it is told in one line."""
    try:
        return getattr(effect, method)(*arguments)
    except Exception as error:
        if "read-only" in str(error):
            raise _Broken(f"{method} writes into what it is given ({error}); copy the array before you change it") from error
        raise _Broken(f"{method} fails with {type(error).__name__}: {error}") from error


def _answers(effect, bodies, time, contacts=None, law=None):
    """Wrench, added mass and the five arrays of the law, checked for shape and finite values; nothing where not overridden."""
    n = len(bodies.mass)
    plain_contacts, plain_law = samples.sample_contacts() if contacts is None else (contacts, law)
    result = {"forces": np.zeros((n, 6)), "added_mass": np.zeros((n, 6, 6)), "contact_law": plain_law}
    for method, arguments in _calls(effect, bodies, time, contacts, law):
        given = _ask(effect, method, arguments)
        try:
            if method == "contact_law":
                result[method] = checked_law(effect, given, plain_contacts)
            else:
                result[method] = checked_answer(effect, given, n, result[method].shape[1:])
        except (ValueError, TypeError) as error:
            hint = "; is it divided by a speed of zero?" if "body 0 is not finite" in str(error) else ""
            raise _Broken(f"{method}: {str(error).removeprefix(type(effect).__name__ + ': ')}{hint}") from error
    return [result["forces"], result["added_mass"], *result["contact_law"]]


def _difference(effect):
    """In words, what the effect does to the sample; empty where it is absent to the last bit."""
    contacts, law = samples.sample_contacts()
    forces, matrices, *changed = _answers(effect, samples.sample_bodies(), TIMES[1], contacts, law)
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
