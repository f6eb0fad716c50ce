"""All shipped effects by name, and effects from a user's own file."""

import hashlib
import importlib.util
import os
import pkgutil
import sys
import traceback
from contextlib import contextmanager
from functools import cache, wraps
from inspect import getsourcelines
from pathlib import Path

import numpy as np

from minibullet.effects.check import check_effect
from minibullet.effects.contract import Effect, EffectError, checked_answer, name_of, overrides, parameters
from minibullet.errors import InputError
from minibullet.files.reading import read_text

MOST_BYTES = 1_000_000  # of a file of effects: a thousand effects written by hand
LIGHT = 3e8  # no body is faster [m/s, rad/s]


@cache
def classes_in(package, base) -> dict[str, type]:
    """Name -> class of every subclass of `base` with numbers of its own that a module of a package defines."""
    folder = importlib.import_module(package).__path__
    modules = [importlib.import_module(f"{package}.{entry.name}") for entry in pkgutil.iter_modules(folder)]
    return {name_of(kind): kind for module in modules for kind in defined(module, base) if parameters(kind)}


def defined(module, base):
    """The classes that a module defines itself, those with an underscore before their name left out."""
    return [
        kind
        for name, kind in vars(module).items()
        if isinstance(kind, type) and issubclass(kind, base) and kind.__module__ == module.__name__ and not name.startswith("_")
    ]


def library() -> dict[str, type[Effect]]:
    """Name, as in files and reports, -> class of every shipped effect. Made without arguments, each is a value to start from."""
    return dict(classes_in(__package__, Effect))


def load_effects(path) -> dict[str, type[Effect]]:
    """Name -> class of every effect that a Python file defines, each checked by ``check_effect`` at its default values.

    path: of the file. Classes whose names begin with an underscore are left out. InputError names file, line and remedy. The
    file is run as code: load only files that you trust.
    """
    path = Path(path)
    kinds = defined(_run(path), Effect)
    if not kinds:
        raise InputError(f"{path}: defines no effect; write a subclass of minibullet.Effect")
    shipped, found = library(), {}
    for kind in kinds:
        name, line = name_of(kind), _line_of(kind)
        if name in shipped:
            raise InputError(f"{path}:{line}: the name {kind.__name__} belongs to a shipped effect; choose another")
        with _located(path, line, f"{kind.__name__}() cannot be made: ", "; give every field a default"):
            effect = kind()
        with _located(path, line):
            check_effect(effect)
        found[name] = kind
    for kind in kinds:
        _guard(kind, path)
    return found


def _guard(kind, path):
    """Report what a class of the file raises or answers in the middle of a run as at the start: by file and line."""
    line = _line_of(kind)
    for name, shape in (("forces", (6,)), ("added_mass", (6, 6)), ("contact_law", None), ("potential", None)):
        if overrides(kind, name):
            setattr(kind, name, _guarded(getattr(kind, name), shape, path, line))


def _guarded(method, shape, path, line):
    @wraps(method)
    def guarded(effect, *arguments):
        with _located(path, line):
            answer = method(effect, *arguments)
            # a search may try a flight that ends beyond all numbers; what is not finite there is not the effect's fault
            if shape and np.abs(arguments[0].twist).max(initial=0.0) < LIGHT and np.isfinite(arguments[0].position).all():
                answer = checked_answer(effect, answer, len(arguments[0].mass), shape)
            return answer

    return guarded


def _run(path):
    """The module of a file, run once; under a name of its own, so that two files of one name do not mix."""
    source = read_text(path, str(path), MOST_BYTES, "keep data out of it")
    name = "minibullet_user_" + hashlib.sha256(os.path.realpath(path).encode("utf-8", "surrogateescape")).hexdigest()[:12]
    with _located(path, 1):
        return module_of(source, name, str(path))


def module_of(source, name, origin):
    """The module that the text of an effects file defines; origin: where the text stands, or would stand."""
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader=None, origin=origin))
    module.__file__ = origin
    sys.modules[name] = module  # dataclasses look their module up
    exec(compile(source, origin, "exec"), vars(module))
    return module


class _LocatedError(InputError):
    """An error whose message names file and line already."""


@contextmanager
def _located(path, line, before="", after=""):
    """Turn whatever the user's code raises, also an attempt to end the program, into one line that names file and line."""
    try:
        yield
    except KeyboardInterrupt:
        raise
    except SyntaxError as error:
        where = error.lineno if error.filename == str(path) else None
        raise _LocatedError(f"{path}:{where or line}: {error.msg}") from error
    except _LocatedError:  # by another effect of the file that it asked
        raise
    except EffectError as error:
        raise _LocatedError(f"{path}:{_line_in(path, error.__cause__) or line}: {before}{error}") from error
    except BaseException as error:
        kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
        raise _LocatedError(
            f"{path}:{line if before else _line_in(path, error) or line}: {before}{kind}{error}{after}"
        ) from error


def _line_of(kind):
    """Where a class stands in its file; 1 where it was made in another way than by writing it."""
    try:
        return getsourcelines(kind)[1]
    except (OSError, TypeError):
        return 1


def _line_in(path, error):
    """The last line of this file that an exception passed through, or None."""
    frames = traceback.extract_tb(error.__traceback__) if error is not None else []
    return next((frame.lineno for frame in reversed(frames) if frame.filename == str(path)), None)
