"""Places of an experiment file that were left for a person to fill in."""

from hlcs.data.model_entries import FILL_IN
from minibullet.errors import InputError, shown


def refuse_unfilled(reader):
    """InputError that names the line of each place where "fill in" still stands, and what belongs there by its comment.

    reader: TomlFile. Numbers of effects are left to what builds the model, which knows their ranges.
    """
    left = list(_unfilled(reader.values, ""))
    if not left:
        return
    told = [(reader.line_of(key, section, index), f"{section}.{key}".lstrip(".")) for section, key, index in left]
    (line, name), others = told[0], told[1:]
    text = reader.text.split("\n")[line - 1] if line else ""
    comment = text.partition("#")[2].strip()
    where = f"{reader.path}" + (f", line {line}" if line else "")
    more = "".join(f", line {line} ({name})" if line else f", {name}" for line, name in others)
    raise InputError(
        f'{where}: {name}: still says "{FILL_IN}"; write its value'
        + (f" ({shown(comment, 100)})" if comment else "")
        + (f"; then also{more[1:]}" if more else "")
    )


def _unfilled(table, section, index=None):
    """(section, key, number of its [[trial]] or None) of every place that holds "fill in"."""
    for key, value in table.items():
        below = f"{section}.{key}".lstrip(".")
        if value == FILL_IN:
            yield section, key, index
        elif isinstance(value, dict):
            yield from _unfilled(value, below, index)
        elif key == "trial" and isinstance(value, list):
            for number, entry in enumerate(value):
                if isinstance(entry, dict):
                    yield from _unfilled(entry, below, number)
