"""All shipped effects by name, and effects from a user's own file."""

import hashlib
import importlib.util
import sys
import traceback
from inspect import getsourcelines
from pathlib import Path

from minibullet.effects import body, contact, flow, fluid
from minibullet.effects.check import check_effect
from minibullet.effects.contract import Effect, EffectError, name_of
from minibullet.errors import InputError

SHIPPED = (
    body.Gravity, fluid.LinearDrag, fluid.QuadraticDrag, fluid.DragCrisis, flow.OrientationDrag, fluid.Buoyancy,
    fluid.AddedMass, flow.UniformFlow, fluid.Magnus, fluid.SpinDecay, fluid.HistoryForce, flow.WallDrag, fluid.GroundCushion,
    body.TiltedGravity, contact.Restitution, contact.VelocityDependentRestitution, contact.Adhesion, contact.Friction,
    contact.StaticFriction, contact.StribeckFriction, contact.ViscousFriction, contact.LoadDependentFriction,
    contact.AnisotropicFriction, contact.RollingFriction, contact.SpinningFriction,
)


def library() -> dict[str, type[Effect]]:
    """Name, as in files and reports, -> class of every shipped effect. Made without arguments, each is a value to start from."""
    return {name_of(kind): kind for kind in SHIPPED}


def load_effects(path) -> dict[str, type[Effect]]:
    """Name -> class of every effect that a Python file defines, each checked by ``check_effect`` at its default values.

    Classes whose names begin with an underscore are left out. InputError names file, line and remedy. The file is run: load only
    files that you trust.
    """
    path = Path(path)
    module = _run(path)
    kinds = [kind for name, kind in vars(module).items() if isinstance(kind, type) and issubclass(kind, Effect)
             and kind.__module__ == module.__name__ and not name.startswith("_")]
    if not kinds:
        raise InputError(f"{path}: defines no effect; write a subclass of minibullet.Effect")
    shipped, found = library(), {}
    for kind in kinds:
        name, line = name_of(kind), getsourcelines(kind)[1]
        if name in shipped:
            raise InputError(f"{path}:{line}: the name {kind.__name__} belongs to a shipped effect; choose another")
        try:
            check_effect(kind())
        except EffectError as error:
            raise InputError(f"{path}:{_line_in(path, error.__cause__) or line}: {error}") from error
        except (TypeError, InputError) as error:
            raise InputError(f"{path}:{line}: {kind.__name__}() cannot be made: {error}; give every field a default") from error
        found[name] = kind
    return found


def _run(path):
    """The module of a file, run once; under a name of its own, so that two files of one name do not mix."""
    name = "minibullet_user_" + hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]
    try:
        source = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader=None, origin=str(path)))
    module.__file__ = str(path)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        exec(compile(source, str(path), "exec"), vars(module))
    except SyntaxError as error:
        raise InputError(f"{path}:{error.lineno}: {error.msg}") from error
    except Exception as error:
        raise InputError(f"{path}:{_line_in(path, error) or 1}: {type(error).__name__}: {error}") from error
    return module


def _line_in(path, error):
    """The last line of this file that an exception passed through, or None."""
    frames = traceback.extract_tb(error.__traceback__) if error is not None else []
    return next((frame.lineno for frame in reversed(frames) if frame.filename == str(path)), None)
