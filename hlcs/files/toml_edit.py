"""TOML files that a user wrote, with the values of one of their tables set: all else stays as it stands, comments too."""

import re
import tomllib

from hlcs.files.documents import toml_value

HEADER = re.compile(r"^\s*(\[{1,2})\s*([A-Za-z0-9_.-]+)\s*\]{1,2}\s*(?:#.*)?$")
COMMENT = re.compile(r"""^(?:[^"'#]|"(?:[^"\\]|\\.)*"|'[^']*')*?(#.*)$""")  # of a line, behind what stands in quotation marks


def with_values(text, table, values, before=()):
    """The text with {key: value} set in one of its tables, written in front of those named `before` where it has none.

    A value None takes the key out. What stands in a form that is not understood here may come out as no TOML, or as another:
    whoever asks compares what is read of it with what is meant.
    """
    lines = text.splitlines()
    headers = {k: found.groups() for k, line in enumerate(lines) if (found := HEADER.match(line))}
    begin = next((k for k, header in headers.items() if header == ("[", table)), None)
    if begin is None and all(value is None for value in values.values()):
        return text
    if begin is None:
        place = next((k for k, (_, name) in headers.items() if name in before), len(lines))
        while place > 0 and lines[place - 1].lstrip().startswith("#"):  # a comment above a title belongs to it
            place -= 1
        lines[place:place] = [f"[{table}]", *(f"{key} = {toml_value(v)}" for key, v in values.items() if v is not None), ""]
        return "\n".join(lines) + "\n"
    end = next((k for k in headers if k > begin), len(lines))
    inside, place = lines[begin + 1 : end], 0
    for key, value in values.items():
        inside, place = _set(inside, place, key, value)
    return "\n".join([*lines[: begin + 1], *inside, *lines[end:]]) + "\n"


def _set(lines, place, key, value):
    """(lines of a table with a value set, the place behind it); place: where it goes if the key is not there."""
    begin = next((k for k, line in enumerate(lines) if re.match(rf"\s*{re.escape(key)}\s*=", line)), None)
    if begin is None:
        written = [] if value is None else [f"{key} = {toml_value(value)}"]
        return [*lines[:place], *written, *lines[place:]], place + len(written)
    end = next((k for k in range(begin + 1, len(lines) + 1) if _read(lines[begin:k]) is not None), begin + 1)
    written = _rewritten(lines[begin:end], key, value)
    return [*lines[:begin], *written, *lines[end:]], begin + len(written)


def _rewritten(lines, key, value):
    """The lines of one value with another in its place; the comments among them stay."""
    old = (_read(lines) or {}).get(key)
    if value is not None and old == value:
        return lines
    if len(lines) > 1 and isinstance(value, list) and isinstance(old, list) and value[: len(old)] == old:
        head, _, tail = lines[-1].rpartition("]")
        more = [f"  {toml_value(item)}," for item in value[len(old) :]]
        for comma in ("", "  ,"):
            longer = [*lines[:-1], *filter(str.strip, [head + comma]), *more, "]" + tail]
            if (_read(longer) or {}).get(key) == value:
                return longer
    comments = [found.group(1) for line in lines if (found := COMMENT.match(line))]
    if value is None:
        return comments
    if len(lines) == 1 and comments:
        return [f"{key} = {toml_value(value)}  {comments[0]}"]
    return [*comments, f"{key} = {toml_value(value)}"]


def _read(lines):
    """What some lines say, None where they are no TOML."""
    try:
        return tomllib.loads("\n".join(lines))
    except tomllib.TOMLDecodeError:
        return None
