"""Measurements that stand in no file: frames, dictionaries of arrays, structured arrays, each read as a CSV file is."""

import csv
import io
from collections.abc import Iterable, Sized
from numbers import Real
from os import PathLike

import numpy as np

from hlcs.files.csv_files import CsvText
from minibullet.errors import InputError, shown_value

LIKE = "a pandas frame, a dictionary of arrays or lists, or a structured array"


def is_frame(thing):
    """Does it hold columns by name?"""
    return hasattr(thing, "keys") or getattr(getattr(thing, "dtype", None), "names", None) is not None


def frames_in(given):
    """The list of frames that an argument `frames` holds: one, or several; InputError where it holds none."""
    if is_frame(given):
        columns = [given[name] for name in given] if isinstance(given, dict) else []
        if columns and all(map(is_frame, columns)):
            raise InputError("frames: a dictionary of frames; give a list of them, such as list(frames.values())")
        return [given]
    if isinstance(given, str | bytes | PathLike):
        read = "pandas.read_csv reads a CSV file into a frame, hlcs.Experiment.read an experiment file"
        raise InputError(f"frames: got {shown_value(given)}, a text; {read}")
    frames = [] if isinstance(given, np.ndarray) or not isinstance(given, Iterable) else list(given)
    if not frames:
        raise InputError(f"frames: got {what_is(given)}; give {LIKE}, or a list of them, one for each recording")
    return frames


def what_is(given):
    """An argument as messages show it: a number, a text and what is empty as it is written, data by their type and shape."""
    if given is None or isinstance(given, str | Real) or (isinstance(given, Sized) and not len(given)):
        return shown_value(given)
    shape = getattr(given, "shape", None)
    return f"{type(given).__name__}" + (f" of shape {shape}" if shape else "")


def csv_of(frame, name):
    """The CsvText of a frame, so that one reader checks files and frames alike: row 1 names the columns, a blank is missing.

    frame: columns of equal length by name (pandas, a dictionary, a structured array); one value in place of a column stands in
    every row, and columns of one value each are one row; None and NaN are blank; name: what messages call it. Raises InputError
    where it is no frame, or a column has another shape or length.
    """
    if not is_frame(frame):
        raise InputError(f"{name}: {type(frame).__name__} has no columns by name; give {LIKE}")
    names = list(frame.keys()) if hasattr(frame, "keys") else list(frame.dtype.names)
    columns = {str(column): np.asarray(frame[column], dtype=object) for column in names}
    for column, values in columns.items():
        if values.ndim > 1:
            told = f"has shape {values.shape}; give one number a row, shape (n,), or one number for all rows"
            raise InputError(f"{name}, column {column}: {told}")
    lengths = {column: len(values) for column, values in columns.items() if values.ndim}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{column} {length}" for column, length in lengths.items())
        raise InputError(f"{name}: columns of different lengths ({told}); give all of them the same number of rows")
    rows = next(iter(lengths.values()), 1)
    columns = {column: values if values.ndim else np.full(rows, values, dtype=object) for column, values in columns.items()}
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(map(_cell, row) for row in zip(*columns.values(), strict=True))
    return CsvText(name, stream.getvalue())


def _cell(value):
    """A cell with all its digits; blank where it is missing."""
    if isinstance(value, Real) and not isinstance(value, bool):
        return "" if value != value else repr(float(value))
    return "" if value is None or value != value else str(value)  # a missing time or text of pandas differs from itself
