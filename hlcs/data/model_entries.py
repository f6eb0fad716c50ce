"""What a diagnosis found, as entries of [model] effects in an experiment file."""

import shlex

import numpy as np

from hlcs.files.documents import toml_value

MODEL = "model.toml"  # name of the experiment with what was found added, in a folder of results
FILL_IN = "fill in"  # stands for a number that a diagnosis withheld; no model can be computed with it


def found_entry(name, numbers, values=None):
    """The entry {name, number: value, ..} of an effect, without what the data do not show; numbers: {number: {value, low, high,
    ..}}, value None = withheld; values: {number: value} as another fit has them, in place of those."""
    told = {
        key: entry | {"value": own} if (own := (values or {}).get(key)) is not None else entry for key, entry in numbers.items()
    }
    told = {key: FILL_IN if entry["value"] is None else _rounded(entry) for key, entry in told.items() if "left_out" not in entry}
    return {"name": name, **told}


def withheld(names, parameters, left_out):
    """{"effect.number": why} of the numbers of effects that are withheld, and left out or not."""
    numbers = [(f"{name}.{key}", entry) for name in names for key, entry in parameters.get(name, {}).items()]
    return {place: entry["why"] for place, entry in numbers if entry["value"] is None and ("left_out" in entry) == left_out}


def to_add(entries, parameters, names, experiment, law=None, saved=False):
    """What to write and to type next: {toml, next, file, fill_in, left_out, effect_file}; None without entries.

    entries: of [model] effects; parameters: {effect: numbers} of those named; experiment: that is to hold them, or None; law: the
    learned one among them; saved: does the experiment hold them already. effect_file: name of the file of the law, beside the
    experiment; None where there is no law.
    """
    if not entries:
        return None
    names = () if law else names  # numbers beside a law are those of its own fit, and none is withheld
    command = experiment.command if experiment else ""
    if command and law and not saved:
        command += f" --effects {shlex.quote(law.place(experiment.file.path.parent))}"
    return {
        "toml": ", ".join(map(toml_value, entries)),
        "next": command or "hlcs.compare(diagnosis.apply(experiment))",
        "file": str(experiment.file.path) if command else None,
        "fill_in": withheld(names, parameters, left_out=False),
        "left_out": withheld(names, parameters, left_out=True),
        "effect_file": law.file_name if law else None,
    }


def _rounded(entry):
    """The value of a number to a hundredth of its interval or finer: no verdict notices, and people can read it."""
    width = entry["high"] - entry["low"]
    if not (np.isfinite(width) and width > 0):
        return float(entry["value"])
    return float(round(entry["value"], 2 - int(np.floor(np.log10(width)))))
