"""Values as text that other programs can read: strict JSON, TOML."""

import dataclasses
import json
import math
import os

import numpy as np


def to_json(value):
    """Strict JSON text of dictionaries, sequences, NumPy values, dataclasses, named tuples and paths.

    NaN, the absence of a number, becomes null. An infinite number has no place in JSON and is refused with the key where it
    stands, as is a value of any other type (ValueError, TypeError): both are mistakes of the program, not of its user.
    """
    return json.dumps(_plain(value, ""), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def plain(value):
    """The same value in JSON's own types: arrays as lists, non-finite numbers as null."""
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(entry) for entry in value]
    if isinstance(value, np.bool_ | bool):
        return bool(value)
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def to_toml(table, inline=False):
    """TOML text of a nested dictionary: tables, arrays, arrays of tables. TOML knows no null, so keys whose value is None
    are left out.

    inline: write what stands within a table between braces, as people write experiment files, not under a title of its own.
    """
    return "\n".join(_toml_lines(_plain(table, "", finite=False), (), inline)).lstrip("\n") + "\n"


def toml_values(table):
    """A nested dictionary in TOML's own types: arrays and tuples as lists, numbers of NumPy as Python's.

    Raises TypeError, with the key, for a value of any other type.
    """
    return _plain(table, "", finite=False)


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


def _toml_lines(table, path, inline):
    """Lines of one table: its own values first, then its sub-tables, each under its full name, or inline in their place."""
    lines, tables = [], []
    for name, value in table.items():
        several = isinstance(value, list) and value and all(isinstance(item, dict) for item in value)
        if (several or isinstance(value, dict)) and not (inline and path):
            tables.append((name, value))
        elif several:  # one a line: they are long
            lines += [f"{_toml_key(name)} = [", *(f"  {toml_value(item)}," for item in value), "]"]
        elif value is not None:
            lines.append(f"{_toml_key(name)} = {toml_value(value)}")
    for name, value in tables:
        full = (*path, name)
        title = ".".join(_toml_key(part) for part in full)
        for item, header in ((value, f"[{title}]"),) if isinstance(value, dict) else ((item, f"[[{title}]]") for item in value):
            lines += ["", header, *_toml_lines(item, full, inline)]
    return lines


def _toml_key(name):
    bare = name and all(character.isascii() and (character.isalnum() or character in "-_") for character in name)
    return name if bare else toml_value(name)


def toml_value(value):
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
            "{ " + ", ".join(f"{_toml_key(name)} = {toml_value(item)}" for name, item in value.items() if item is not None) + " }"
        )
    return "[" + ", ".join(toml_value(item) for item in value if item is not None) + "]"
