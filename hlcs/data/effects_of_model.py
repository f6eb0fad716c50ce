"""What [model] of an experiment file says of the effects in it: which there are, which were added last, which they replaced."""

from hlcs.files.limits import LARGEST
from minibullet.errors import shown, shown_value

OF_EFFECTS = ("effects", "added", "replaced")  # the keys that say so


def read_effects(reader, model):
    """(entries of effects, names of those added last, entries that stood in the place of some of these), checked."""
    effects, replaced = _entries(reader, model, "effects"), _entries(reader, model, "replaced")
    added = names_of_effects(reader, model, "added", "model") or ()
    for key, names, place, known in (
        ("added", added, "effects", [entry["name"] for entry in effects]),
        ("replaced", [entry["name"] for entry in replaced], "added", added),
    ):
        if name := next((name for name in names if name not in known), None):
            reader.fail(key, f"'{shown(name)}' stands not in {place}: write it there, or leave it out here", "model")
    return effects, added, replaced


def _entries(reader, model, key):
    """A list of effects as entries {name, number: value, ..}; a name alone stands for an entry."""
    entries = model.get(key, [])
    if not isinstance(entries, list):
        reader.fail(key, 'must be a list such as [{ name = "quadratic_drag", drag_coefficient = 0.47 }]', "model")
    entries = [{"name": entry} if isinstance(entry, str) else entry for entry in entries]
    for entry in entries:
        if not isinstance(entry, dict) or not isinstance(entry.get("name"), str):
            reader.fail(key, f"every entry needs a name, got {shown_value(entry)}", "model")
        for name, value in entry.items():
            if isinstance(value, int | float) and not abs(value) <= LARGEST:
                reader.fail(name, f"must be a number of at most {LARGEST:g}, got {shown_value(value)}", "model")
    return tuple(dict(entry) for entry in entries)


def names_of_effects(reader, table, key, section):
    """A list of names of effects as a tuple, None where the key is left out."""
    names = table.get(key)
    if names is None:
        return None
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        reader.fail(key, f"must be a list of effect names, got {shown_value(names)}", section)
    if not names and key == "candidates":
        reader.fail(key, "names no effect; name some, or leave it out for all that fit", section)
    return tuple(names)
