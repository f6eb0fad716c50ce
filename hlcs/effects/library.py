"""The library of what may be missing: every effect of the engine and every change of this room, by name, and the user's own."""

import difflib
from functools import cache
from pathlib import Path

import numpy as np

import minibullet.effects as forces
from hlcs.effects.candidates import build, ends_of_law
from hlcs.effects.contract import Change
from minibullet.effects.catalogue import classes_in
from minibullet.effects.contract import Effect, name_of, parameters
from minibullet.errors import InputError, is_number


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
        near = difflib.get_close_matches(name, sorted(known), n=1, cutoff=0.0)[0]
        raise InputError(f"unknown effect '{name}'; the nearest known effect is '{near}'")
    return known[name]


def wanted(names, own):
    """The classes of these names and the user's own; names: None = all."""
    return with_own(own).values() if names is None else dict.fromkeys([*(class_named(name, own) for name in names), *own])


def build_entry(entry, surroundings, own=()):
    """The effect of one entry of [model] effects; InputError with the nearest known name or parameter, or where the law ends."""
    kind = class_named(entry["name"], own)
    values = {key: value for key, value in entry.items() if key != "name"}
    known = parameters(kind)
    for key in values:
        if key not in known:
            raise InputError(f"{entry['name']} has no parameter '{key}'; it has {', '.join(known)}")
        if not is_number(values[key]):
            raise InputError(f"{entry['name']}: {key} = {values[key]!r} must be a finite number")
        least, most = _ends(known[key])
        if not least <= values[key] <= most:
            wall = f"at least {least:g}" if values[key] < least else f"at most {most:g}"
            raise InputError(f"{entry['name']}: {key} = {values[key]:g} must be {wall}")
    if "fluid_density" in known and "fluid_density" not in values and surroundings.fluid_density > 0:
        values["fluid_density"] = surroundings.fluid_density  # what the file states once holds for all its effects
    return build(kind, values, surroundings)


def _ends(known):
    """(least, most) that a law allows of one of its parameters."""
    return ends_of_law(-np.inf if known.low is None else known.low, known.null, (known.least, known.most), known.period)


def check_names(file, own=()):
    """Refuse candidates and effects of an experiment file that nobody knows, or numbers that no law allows, by file and line;
    sentences on numbers that a law allows but nobody expects. A range that depends on the body or the data is not judged here."""
    notes = []
    for names, key in ((file.candidates or (), "diagnose.candidates"), (file.effects, "model.effects")):
        for entry in names:
            try:
                if isinstance(entry, str):
                    class_named(entry, own)
                else:
                    build_entry(entry, file.surroundings, own)
                    notes += [f"{file.place(key)}: {said}" for said in _unexpected(entry, own)]
            except InputError as problem:
                raise InputError(f"{file.place(key)}: {problem}") from None
    return tuple(notes)


def _unexpected(entry, own):
    """Sentences on the numbers of an entry beyond their plausible ranges."""
    for name, known in parameters(class_named(entry["name"], own)).items():
        if name not in entry or None in (known.low, known.high) or known.bounds_in or known.period is not None:
            continue
        if not known.low <= entry[name] <= known.high:
            usual = f"{known.low:g} to {known.high:g}" + ("" if known.unit == "-" else f" {known.unit}")
            yield f"{entry['name']}: {name} = {entry[name]:g} lies beyond what is plausible ({usual})"


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
