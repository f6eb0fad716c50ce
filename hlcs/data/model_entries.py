"""What a diagnosis found, as entries of [model] effects in an experiment file."""

import numpy as np

FILL_IN = "fill in"  # stands for a number that a diagnosis withheld; no model can be computed with it


def found_entry(name, numbers):
    """The entry {name, number: value, ..} of an effect; numbers: {number: {value, low, high, ..}}, value None = withheld."""
    values = {key: FILL_IN if entry["value"] is None else _rounded(entry) for key, entry in numbers.items()}
    return {"name": name, **values}


def withheld(name, numbers):
    """{"effect.number": why} of the numbers of an effect that are withheld."""
    return {f"{name}.{key}": entry["why"] for key, entry in numbers.items() if entry["value"] is None}


def _rounded(entry):
    """The value of a number to a hundredth of its interval or finer: no verdict notices, and people can read it."""
    width = entry["high"] - entry["low"]
    if not (np.isfinite(width) and width > 0):
        return float(entry["value"])
    return float(round(entry["value"], 2 - int(np.floor(np.log10(width)))))
