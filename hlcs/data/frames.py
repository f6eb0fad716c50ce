"""Measurements that stand in no file: frames, dictionaries of arrays, structured arrays, each read as a CSV file is."""

from collections.abc import Iterable, Sized
from datetime import timedelta
from numbers import Integral, Real
from os import PathLike

import numpy as np

from hlcs.files.csv_files import CsvText
from hlcs.files.spreadsheets import rows_text
from minibullet.errors import InputError, shown_value

WORDS = ("group", "campaign", "grid")  # columns of words
LIKE = "a pandas frame, a dictionary of arrays or lists, or a structured array"


def is_frame(thing):
    """Does it hold columns by name?"""
    named = getattr(getattr(thing, "dtype", None), "names", None) is not None
    has_columns = callable(getattr(thing, "keys", None)) and not hasattr(thing, "groups")  # those of a frame are frames
    return named or has_columns and getattr(thing, "ndim", 2) == 2  # a Series is a column


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
    if all(isinstance(one, tuple) and len(one) == 2 and is_frame(one[1]) for one in frames):  # frame.groupby(..)
        frames = [frame for _, frame in frames]
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
    """The CsvText of a frame, so that one reader checks files and frames alike: names, rows that count as its index, blanks.

    frame: columns of equal length by name (pandas, a dictionary, a structured array); one value in place of a column stands in
    every row, and columns of one value each are one row; None, NaN and what is masked are blank, durations seconds; name: what
    messages call it. Raises InputError where it is no frame, or a column has another shape or length, or holds dates.
    """
    if not is_frame(frame):
        raise InputError(f"{name}: {type(frame).__name__} has no columns by name; give {LIKE}")
    names = list(frame.keys()) if hasattr(frame, "keys") else list(frame.dtype.names)
    if twice := sorted({str(column) for column in names if names.count(column) > 1}):
        raise InputError(f"{name}, column {twice[0]}: stands twice; leave one of them out")
    columns = {str(column): _objects(frame[column], f"{name}, column {column}", column in WORDS) for column in names}
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
    text = rows_text([list(columns), *zip(*(map(_cell, values) for values in columns.values()), strict=True)])
    return CsvText(name, text, tuple(_index_of(frame, rows)))


def _index_of(frame, rows):
    """The numbers by which its user finds the rows of a frame: its index where those are whole and differ, else 0, 1, .."""
    index = np.asarray(getattr(frame, "index", None))
    whole = index.dtype.kind in "iu" and index.shape == (rows,) and len(set(index.tolist())) == rows
    return index.tolist() if whole else range(rows)


def _objects(values, place, words):
    """A column as an array of objects, None where it is masked, seconds where it holds durations; place: begins a complaint;
    words: does it name what belongs together, as a day may?"""
    column = np.asarray(values) if hasattr(values, "dtype") else np.asarray(values, dtype=object)
    if column.dtype.kind == "M" and words:
        whole = np.all(np.isnat(column) | (column == column.astype("datetime64[D]")))
        column = np.where(np.isnat(column), "", column.astype("datetime64[D]" if whole else "datetime64[s]").astype(str))
    elif column.dtype.kind == "M":
        raise InputError(f"{place}: dates; give the seconds since the first, such as (t - t[0]) / numpy.timedelta64(1, 's')")
    if column.dtype.kind == "m":
        column = np.where(np.isnat(column), np.nan, column / np.timedelta64(1, "s"))
    column = column.astype(object)
    return np.where(np.ma.getmaskarray(values), None, column) if isinstance(values, np.ma.MaskedArray) else column


def _cell(value):
    """A cell with all its digits; blank where it is missing."""
    if isinstance(value, Integral) and not isinstance(value, bool):
        return str(int(value))
    if isinstance(value, Real) and not isinstance(value, bool):
        return "" if value != value else repr(float(value))
    if isinstance(value, timedelta) and value == value:
        return repr(value.total_seconds())
    return "" if _missing(value) else str(value)


def _missing(value):
    """Is it None, or one of pandas' marks of a missing value? Those differ from themselves, or refuse to say whether they do."""
    try:
        return value is None or bool(value != value)
    except TypeError:
        return True
    except ValueError:  # an array in a cell
        return False
