"""The library of what may be missing: every effect of the engine and every change of this room, by name, and the user's own."""

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np

import minibullet.effects as forces
from hlcs.data.rigid_body import known_to_drag, rigid_body
from hlcs.effects.candidates import STATED_OTHERWISE, build, candidate, ends_of_law, stated_otherwise
from hlcs.effects.contract import Change
from minibullet.effects.catalogue import classes_in
from minibullet.effects.contract import Effect, name_of, parameters
from minibullet.errors import InputError, is_number, known_one, shown


@cache
def classes():
    """Name -> class of everything shipped that has a number to be found; gravity has none, it is part of every model."""
    shipped = forces.library() | classes_in(__package__, Change)
    return {name: kind for name, kind in shipped.items() if not all(known.given for known in parameters(kind).values())}


def with_own(own):
    """The same, the user's classes among them."""
    return classes() | {name_of(kind): kind for kind in own}


def class_named(name, own=()):
    """The class of that name, shipped or the user's; InputError with the nearest known name."""
    known = with_own(own)
    if name not in known:
        own_file = "" if own else "; one of your own, or one that was learned, is in a file to be named: --effects FILE.py"
        near = known_one(name, known, "the nearest known effect is")
        raise InputError(f"unknown effect '{shown(name)}'; {near}{own_file}")
    return known[name]


def wanted(names, own):
    """The classes of these names and the user's own; names: None = all."""
    return with_own(own).values() if names is None else dict.fromkeys([*(class_named(name, own) for name in names), *own])


def build_entry(entry, surroundings, own=()):
    """The effect of one entry of [model] effects; InputError with the nearest known name or parameter, or where the law ends."""
    kind = class_named(entry["name"], own)
    values = {key: value for key, value in entry.items() if key != "name"}
    known = parameters(kind)
    for key, name in [(key, key.partition(" ")[0] if getattr(kind, "by_session", False) else key) for key in values]:
        if name not in known:
            raise InputError(f"{entry['name']} has no parameter '{key}'; it has {', '.join(known)}")
        if not is_number(values[key]):
            raise InputError(f"{entry['name']}: {key} = {values[key]!r} must be a finite number")
        least, most = _ends(known[name])
        if not least <= values[key] <= most:
            wall = f"at least {least:g}" if values[key] < least else f"at most {most:g}"
            raise InputError(f"{entry['name']}: {key} = {values[key]:g} must be {wall}")
    if "fluid_density" in known and "fluid_density" not in values:
        values["fluid_density"] = surroundings.fluid_density  # what the file states once holds for all its effects
    for name in known.keys() & STATED_OTHERWISE.keys() - values.keys():
        if stated := stated_otherwise(name, surroundings):
            values[name] = stated[0]
    return build(kind, values, surroundings)


def as_stated(effects, seen, own=()):
    """Entries of [model] effects, with the numbers that the surroundings of all that is `seen` state alike by another name, such
    as the viscosity of a drag: {effect: entry}."""
    alike = {name: {stated_otherwise(name, each.surroundings) for each in seen} for name in STATED_OTHERWISE}
    stated = {name: next(iter(values))[0] for name, values in alike.items() if len(values) == 1 and () not in values}
    found = {}
    for entry in effects:
        numbers = stated.keys() & parameters(class_named(entry["name"], own)).keys()
        found[entry["name"]] = {name: stated[name] for name in sorted(numbers)} | entry
    return found


def entry_of(effect):
    """The entry of [model] effects of an effect, the inverse of `build_entry`; an entry is itself.

    A property of the surroundings (density of the fluid) at its default is left to the file; InputError where something else than
    numbers says what the effect is.
    """
    if isinstance(effect, dict):
        return effect
    if isinstance(effect, type) or not isinstance(effect, Effect | Change):
        raise InputError(f"effects: {effect!r} is no effect; give values such as minibullet.QuadraticDrag(drag_coefficient=0.47)")
    numbers, entry = parameters(effect), {"name": name_of(effect)}
    for field in dataclasses.fields(effect):
        value, known = getattr(effect, field.name), numbers.get(field.name)
        if known is None and value != field.default:
            raise InputError(f"{entry['name']}: {field.name} = {value!r} is no number; a model is written in numbers alone")
        if known is not None and not (value == known.default and (known.given or known.body_known is False)):
            entry[field.name] = float(value)
    return entry


def _ends(known):
    """(least, most) that a law allows of one of its parameters."""
    return ends_of_law(-np.inf if known.low is None else known.low, known.null, (known.least, known.most), known.period)


def check_names(file, own=(), seen=()):
    """Refuse candidates and effects of an experiment file that nobody knows, effects without their numbers, or with numbers that
    no law allows, by file and line; sentences on numbers that a law allows but nobody expects.

    seen: what has surroundings, where others than the recordings: the rows of a table.
    """
    notes = []
    for names, key in (
        (file.candidates or (), "diagnose.candidates"),
        (file.effects, "model.effects"),
        (file.replaced, "model.replaced"),
    ):
        for entry in names:
            try:
                if isinstance(entry, str):
                    class_named(entry, own)
                else:
                    build_entry(entry, file.surroundings, own)
                    _check_numbers(entry, file, own, seen or file.trials or (file,))
                    notes += [f"{file.place(key)}: {said}" for said in _doubts(entry, file, own)]
            except InputError as problem:
                raise InputError(f"{file.place(key)}: {problem}") from None
    return tuple(notes)


def _check_numbers(entry, file, own, seen):
    """InputError where an entry states none of the numbers of its effect, and these have no value of their own; seen: what has
    surroundings.

    Then a default would be taken in silence, which most often means that the effect is not there at all.
    """
    numbers = [known for known in parameters(class_named(entry["name"], own)).values() if not known.given]
    said = {
        *entry,
        *(key.partition(" ")[0] for key in entry),
        *(["fluid_density"] if file.surroundings.fluid_density > 0 else []),
        *(name for name in STATED_OTHERWISE if all(stated_otherwise(name, each.surroundings) for each in seen)),
    }  # as in `build_entry`
    ready = any(known.null not in (None, known.default) for known in numbers)  # a class of the user's may bring its value
    if numbers and not ready and said.isdisjoint(known.name for known in numbers):
        useful = [known for known in numbers if known.body_known is not False or not known_to_drag(_body(file))]
        raise InputError(f"{entry['name']} stands without a number; give {', '.join(map(_shown_number, useful))}")


def _shown_number(known):
    """A number that must be given, as it is written, its unit, and its plausible range where it depends on nothing else."""
    unit = "" if known.unit == "-" else f" [{known.unit}]"
    usual = "" if known.bounds_in or None in (known.low, known.high) else f" ({known.low:g} to {known.high:g})"
    return f"{known.name} = ..{unit}{usual}"


def _doubts(entry, file, own):
    """Sentences on the numbers of an entry beyond their plausible ranges; one that depends on the data is not judged."""
    kind = class_named(entry["name"], own)
    by_data = {name for name, known in parameters(kind).items() if known.bounds_in in ("extent", "per extent")}
    free = candidate(kind, file.surroundings, rigid_body(_body(file)), body_known=True).free
    said = [number.doubt(entry["name"], entry[number.name]) for number in free if number.name in {*entry} - by_data]
    return filter(None, said)


def _body(file):
    """The body that an experiment file speaks of: its first trial's where it has any."""
    return (file.trials[0] if file.trials else file).body


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
