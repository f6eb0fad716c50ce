"""The cells of an exported text file: its encoding, what separates its columns, how its decimals are written.

Rows count as lines of the file, from 1; blank lines and lines that begin with # are passed over.
"""

import re
from dataclasses import dataclass, field
from math import isfinite, nan
from pathlib import Path

import numpy as np

from hlcs.files.csv_files import MOST_BYTES, MOST_ROWS, cells_of, decimal
from hlcs.importing.found import Assumption
from minibullet.errors import InputError, shown
from minibullet.files.reading import read_bytes

SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas"}  # the first of these that stands in a file separates its columns
MOST_LINE = 200_000  # characters: a thousand markers of a motion capture, three numbers each, would have 60,000
MISSING = {"", "nan", "na", "n/a", "#n/a", "-", "--"}  # what programs and people write for a sample that was lost
COMMA_NUMBER = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
WORKBOOKS = {b"PK\x03\x04": "an Excel workbook or a zip archive", b"\xd0\xcf\x11\xe0": "an old Excel workbook"}
FIRST_LINES = 12  # in which the names of the columns stand


@dataclass(frozen=True)
class Source:
    """A file, or a member of an archive, as bytes."""

    name: str  # what messages call it
    stem: str  # what recordings of it are called
    data: bytes = field(repr=False)


@dataclass(frozen=True)
class Grid:
    """The cells of a file."""

    name: str
    stem: str
    lines: tuple[int, ...]  # line of the file of each row
    cells: tuple[list[str], ...]
    comma: bool  # whether decimals are written with a comma
    assumptions: tuple[Assumption, ...]

    def place(self, row, column=""):
        """ "file, row n, column c", to begin a complaint with; row: index into `cells`."""
        return f"{self.name}, row {self.lines[row]}" + (f", column {shown(column)}" if column else "")

    def column(self, first, index, name):
        """Numbers of a column from row `first` on, (n,), NaN where missing; InputError for what is no number."""
        return np.array([self._number(row, index, name) for row in range(first, len(self.cells))], dtype=float)

    def _number(self, row, index, name):
        cells = self.cells[row]
        text = cells[index] if index < len(cells) else ""
        if text.lower() in MISSING:
            return nan
        if self.comma and "." in text:
            raise InputError(
                f"{self.place(row, name)}: '{shown(text)}' has a point where other decimals have a comma; write all of them alike"
            )
        try:
            value = decimal(text.replace(",", ".") if self.comma else text)
        except ValueError:
            raise InputError(f"{self.place(row, name)}: '{shown(text)}' is not a number; leave a missing sample blank") from None
        if not isfinite(value):
            raise InputError(f"{self.place(row, name)}: '{shown(text)}' is not finite; leave a missing sample blank")
        return value


def source_of(path):
    """The Source of a file; InputError where it cannot be read or is too large."""
    data = read_bytes(path, shown(path, 255), MOST_BYTES, "export fewer columns, or a part of it")
    return Source(shown(path, 255), Path(path).stem, data)


def grid_of(source, separator=None):
    """The Grid of a Source; separator: what stands between columns, None = found in the first lines, " " = any blanks.

    Raises InputError for what is no text, is empty, has too many rows, or a quote that is not closed.
    """
    text, notes = _text(source)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    used = [k for k, line in enumerate(lines) if line.strip(" \t,;") and not line.lstrip().startswith("#")]
    if not used:
        raise InputError(f"{source.name}: is empty")
    if len(used) > MOST_ROWS:
        raise InputError(
            f"{source.name}: {len(used):,} rows; at most {MOST_ROWS:,} are read: export a part, or fewer samples a second"
        )
    longest = max(used, key=lambda k: len(lines[k]))
    if len(lines[longest]) > MOST_LINE:
        raise InputError(
            f"{source.name}, row {longest + 1}: a line of {len(lines[longest]):,} characters, at most {MOST_LINE:,} are read; is "
            "this an export as text?"
        )
    head = "\n".join(lines[k] for k in used[:FIRST_LINES])
    separator = separator or next((sign for sign in SEPARATORS if sign in head), " ")
    if separator == " ":
        cells = tuple(_between_blanks(source.name, k + 1, lines[k]) for k in used)
    else:
        cells = tuple(cells_of(source.name, k + 1, lines[k], separator) for k in used)
    comma = any(COMMA_NUMBER.fullmatch(cell) for row in cells for cell in row)
    if comma:
        notes = (*notes, Assumption(f"{source.name}: decimals are written with a comma, 0,5 for a half"))
    return Grid(source.name, source.stem, tuple(k + 1 for k in used), cells, comma, notes)


def _between_blanks(name, line, text):
    """The cells of a line whose columns are separated by blanks; blanks between quotes separate nothing."""
    if '"' not in text:
        return text.split()
    return [cell for cell in cells_of(name, line, text.strip(), " ") if cell]


def _text(source):
    """(text, assumptions) of the bytes of a file: UTF-8, UTF-16 with its mark, else the letters of Western Windows."""
    for mark, what in WORKBOOKS.items():
        if source.data.startswith(mark):
            raise InputError(f"{source.name}: is {what}, not text; export it as CSV, or save it as CSV from the spreadsheet")
    notes = ()
    try:
        if source.data.startswith((b"\xff\xfe", b"\xfe\xff")):
            text = source.data.decode("utf-16")
        else:
            text = source.data.decode("utf-8-sig")
    except UnicodeDecodeError:
        try:
            text = source.data.decode("cp1252")
        except UnicodeDecodeError:
            text = "\0"
        notes = (Assumption(f"{source.name}: its letters are those of Western Windows (cp1252)"),)
    if "\0" in text:
        raise InputError(f"{source.name}: is not text; export it as CSV, and save it as UTF-8")
    return text, notes
