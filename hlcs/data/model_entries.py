"""What a diagnosis found, as entries of [model] effects in an experiment file."""

import shlex

import numpy as np

from hlcs.files.documents import toml_value

FILL_IN = "fill in"  # stands for a number that a diagnosis withheld; no model can be computed with it


def found_entry(name, numbers):
    """The entry {name, number: value, ..} of an effect; numbers: {number: {value, low, high, ..}}, value None = withheld."""
    values = {key: FILL_IN if entry["value"] is None else _rounded(entry) for key, entry in numbers.items()}
    return {"name": name, **values}


def withheld(name, numbers):
    """{"effect.number": why} of the numbers of an effect that are withheld."""
    return {f"{name}.{key}": entry["why"] for key, entry in numbers.items() if entry["value"] is None}


def to_add(entries, parameters, names, experiment, law=None, saved=False):
    """What to write and to type next: {toml, next, file, fill_in, effect_file}; None without entries.

    entries: of [model] effects; parameters: {effect: numbers} of those named; experiment: that is to hold them, or None; law: the
    learned one among them; saved: does the experiment hold them already. effect_file: name of the file of the law, beside the
    experiment; None where there is no law.
    """
    if not entries:
        return None
    command, fill_in = experiment.command if experiment else "", {}
    for name in names:
        fill_in |= withheld(name, parameters.get(name, {}))
    if command and law and not saved:
        command += f" --effects {shlex.quote(str(experiment.file.path.parent / law.file_name))}"
    return {
        "toml": ", ".join(map(toml_value, entries)),
        "next": command or "hlcs.compare(diagnosis.apply(experiment))",
        "file": str(experiment.file.path) if command else None,
        "fill_in": fill_in,
        "effect_file": law.file_name if law else None,
    }


def _rounded(entry):
    """The value of a number to a hundredth of its interval or finer: no verdict notices, and people can read it."""
    width = entry["high"] - entry["low"]
    if not (np.isfinite(width) and width > 0):
        return float(entry["value"])
    return float(round(entry["value"], 2 - int(np.floor(np.log10(width)))))
