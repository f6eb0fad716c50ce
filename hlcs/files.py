"""Results on disk: a folder or file appears whole or not at all; JSON and TOML that other programs can read; versions.

Everything is first written under a temporary name beside its target and then renamed, so a run killed at any moment leaves
the old result, nothing, or the whole new one. No pickle anywhere.
"""

import dataclasses
import importlib.metadata
import json
import math
import os
import platform
import secrets
import shutil
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from hlcs import interrupts
from minibullet.errors import InputError
from minibullet.whole_files import whole

CONTENTS = ".hlcs"  # in every result folder: the names this program wrote, so that a later run replaces those and nobody else's
REPORTED = ("hlcs", "numpy", "numba", "python-fcl", "trimesh", "matplotlib", "scipy", "pandas", "tqdm", "click")


@contextmanager
def result_folder(path):
    """Context manager: yields a `Path` to an empty temporary folder that becomes `path` when the block ends well.

    An earlier result at `path` is replaced; a folder that holds anything else is refused (InputError) before any work is
    done, as are a file in the way and a place where nothing can be written. If the block raises or is interrupted, `path`
    is left as it was.
    """
    target = Path(path).expanduser().absolute()
    _refuse_foreign(target)
    partial = target.with_name(f".{target.name}.{os.getpid()}.{secrets.token_hex(4)}.partial")
    try:
        with _explained(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            _clear_up(target)
            partial.mkdir()
        yield partial
        interrupts.check()
        names = sorted(entry.name for entry in partial.iterdir())
        write_text(partial / CONTENTS, "\n".join([*names, ""]))
        with _explained(target):
            _put_in_place(partial, target)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def check_folder(path):
    """InputError where a file stands in a folder's place; returns the folder's Path."""
    target = Path(path).expanduser()
    if target.exists() and not target.is_dir():
        raise InputError(f"'{target}' is a file, not a folder; give another folder for the results")
    return target


def make_folder(path):
    """A folder that may hold other files already, made where it is not there; returns its Path. InputError where it cannot be."""
    target = check_folder(path)
    with _explained(target):
        target.mkdir(parents=True, exist_ok=True)
    return target


def write_bytes(path, data):
    """Write a file whole or not at all; `data` is bytes. Raises InputError where it cannot be written."""
    target = Path(path).expanduser().absolute()
    with _explained(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        with whole(target) as partial:
            partial.write_bytes(data)


def write_text(path, text):
    """Write UTF-8 text whole or not at all, with the line ends it has."""
    write_bytes(path, text.encode("utf-8"))


def write_json(path, value):
    """Write `value` as strict JSON, see `to_json`."""
    write_text(path, to_json(value))


def write_toml(path, table):
    """Write the nested dictionary `table` as TOML, see `to_toml`."""
    write_text(path, to_toml(table))


def to_json(value):
    """Strict JSON text of dictionaries, sequences, NumPy values, dataclasses, named tuples and paths.

    NaN, the absence of a number, becomes null. An infinite number has no place in JSON and is refused with the key where it
    stands, as is a value of any other type (ValueError, TypeError): both are mistakes of the program, not of its user.
    """
    return json.dumps(_plain(value, ""), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def to_toml(table):
    """TOML text of a nested dictionary: tables, arrays, arrays of tables. TOML knows no null, so keys whose value is None
    are left out.
    """
    return "\n".join(_toml_lines(_plain(table, "", finite=False), ())).lstrip("\n") + "\n"


def versions():
    """Versions of Python, the platform, this program and its dependencies; None for what is not installed."""
    found = {"python": platform.python_version(), "platform": f"{platform.system()} {platform.machine()}"}
    for name in REPORTED:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = None
    return found


# ------------------------------------------------------------------------------------------------------------- folders
def _refuse_foreign(target):
    """InputError if `target` is a file or a folder that holds what this program did not write."""
    if not target.exists() and not target.is_symlink():
        return
    if not target.is_dir():
        raise InputError(f"'{target}' is a file, not a folder; give another folder for the results")
    contents = target / CONTENTS
    with _explained(target):
        ours = {CONTENTS, *contents.read_text(encoding="utf-8").splitlines()} if contents.is_file() else set()
        foreign = sorted(entry.name for entry in target.iterdir() if entry.name not in ours)
    if foreign:
        raise InputError(
            f"folder '{target}' holds '{foreign[0]}', which is no earlier result; give an empty or a new folder for the results"
        )


def _clear_up(target):
    """Remove what runs that were killed (kill -9, power) left beside `target`; their process is no more."""
    for entry in target.parent.iterdir() if os.name == "posix" else ():
        start, end = f".{target.name}.", ".partial"
        if entry.name.startswith(start) and entry.name.endswith(end) and entry.is_dir():
            process = entry.name[len(start) :].split(".")[0]
            if process.isdecimal() and not _runs(int(process)):
                shutil.rmtree(entry, ignore_errors=True)


def _runs(process):
    """Whether a process of that number runs."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True  # somebody else's, or no number of a process
    return True


def _put_in_place(partial, target):
    """Rename `partial` to `target`, an earlier result stepping aside first and coming back if that fails."""
    if not target.exists():
        os.rename(partial, target)
        return
    aside = target.with_name(f".{target.name}.{secrets.token_hex(4)}.old")
    os.rename(target, aside)
    try:
        os.rename(partial, target)
    except BaseException:
        os.rename(aside, target)
        raise
    shutil.rmtree(aside, ignore_errors=True)


@contextmanager
def _explained(target):
    """Turn the operating system's refusal to write `target` into one line."""
    try:
        yield
    except OSError as error:
        place = error.filename if isinstance(error.filename, str) and not error.filename.endswith(".partial") else target.parent
        raise InputError(f"cannot write '{target}': {error.strerror or error} ('{place}')") from error


# -------------------------------------------------------------------------------------------------------------- values
def _plain(value, key, finite=True):
    """`value` in Python's own types; `key` is where it stands, for messages."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        if finite and math.isnan(value):
            return None
        if finite and math.isinf(value):
            raise ValueError(f"{key or 'value'} = {value}: JSON has no infinite numbers")
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, np.ndarray):
        return _plain(value.tolist(), key, finite)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, dict):
        return {str(name): _plain(item, f"{key}.{name}" if key else str(name), finite) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, f"{key}[{index}]", finite) for index, item in enumerate(value)]
    raise TypeError(f"{key or 'value'} is a {type(value).__name__}, which cannot be written to a file")


def _toml_lines(table, path):
    """Lines of one table: its own values first, then its sub-tables, each under its full name."""
    lines, tables = [], []
    for name, value in table.items():
        if isinstance(value, dict) or (isinstance(value, list) and value and all(isinstance(item, dict) for item in value)):
            tables.append((name, value))
        elif value is not None:
            lines.append(f"{_toml_key(name)} = {_toml_value(value)}")
    for name, value in tables:
        full = (*path, name)
        title = ".".join(_toml_key(part) for part in full)
        for item, header in ((value, f"[{title}]"),) if isinstance(value, dict) else ((item, f"[[{title}]]") for item in value):
            lines += ["", header, *_toml_lines(item, full)]
    return lines


def _toml_key(name):
    bare = name and all(character.isascii() and (character.isalnum() or character in "-_") for character in name)
    return name if bare else _toml_value(name)


def _toml_value(value):
    """One value on one line; strings as basic strings, which share JSON's escapes except for the delete character."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, dict):
        return (
            "{ "
            + ", ".join(f"{_toml_key(name)} = {_toml_value(item)}" for name, item in value.items() if item is not None)
            + " }"
        )
    return "[" + ", ".join(_toml_value(item) for item in value if item is not None) + "]"
