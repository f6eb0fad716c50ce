"""CSV files that a user names: a row that names the columns, then rows of numbers and words, every cell checked.

One reader for recordings, outcome tables, layer coefficients and surveys. Rows count as lines of the file, from 1; those of a
frame as its index. Empty rows and rows that begin with # are passed over. Every complaint is one line: file, row and column.
"""

import csv
import re
from dataclasses import dataclass, field
from math import isfinite, nan

import numpy as np

from hlcs.files.limits import LARGEST
from hlcs.files.other_words import in_place_of_column
from minibullet.errors import MOST_TOLD, InputError, known_one, shown
from minibullet.files.reading import read_text

MOST_ROWS = 200_000  # of a file, and of all recordings of an experiment: what `hlcs compare` does in 2 GB of memory
MOST_BYTES = 25 * 8 * MOST_ROWS  # eight columns of numbers with all their digits, 25 characters each with the comma
MOST_LINE = 10_000  # characters: fifty rows of eight such numbers; what is longer is no table
# what a spreadsheet writes in place of a number that it cannot show: ####, #N/A, #DIV/0!, #NAME?
NO_COMMENT = re.compile(r'"?#(?:#+|N/A|NV|[^\s,;]+[!?])"?\s*(?:[,;\t]|$)')
MOST_WORD = 100  # characters: names of groups and grids stand in every report


@dataclass(frozen=True)
class CsvTable:
    """The columns of a file."""

    name: str  # what messages call the file
    head: str  # what messages call the row that names the columns
    rows: np.ndarray  # row of the file that each entry stands in, of a frame its index (n,)
    columns: dict  # name -> numbers (n,), NaN where blank, or words (n,); in the order of the file

    def place(self, index, column):
        """ "file, row n, column c", to begin a complaint about one cell with."""
        return f"{self.name}, row {self.rows[index]}, column {column}"


@dataclass(frozen=True)
class CsvText:
    """A CSV file that is in memory alone: what messages call it, its text, and the numbers of the rows below its names."""

    name: str
    text: str = field(repr=False)
    rows: tuple[int, ...] = field(default=(), repr=False)  # empty: as in a file

    def __str__(self):
        return self.name


@dataclass(frozen=True)
class CsvLayout:
    """What a file of some kind may hold."""

    known: tuple[str, ...]  # names of the columns it may have
    required: tuple[str, ...] = ()  # those it must have
    words: tuple[str, ...] = ()  # columns of text; all others are numbers
    blank: tuple[str, ...] = ()  # columns whose numbers may be blank
    others: bool = False  # pass over columns that are not known, in place of refusing them
    short: bool = False  # let rows leave out their last cells
    imported: bool = False  # does `hlcs import` write such files?
    elsewhere: tuple[str, ...] = ()  # names of columns of files of another kind
    where: str = ""  # which these are


def read_csv(path, layout, name=None, most_rows=MOST_ROWS):
    """Read a CSV file; returns a CsvTable.

    path: of the file, or a CsvText; layout: CsvLayout; name: what messages call the file (default: its path); most_rows: of the
    file. Raises InputError that names file, row and column, and what to do.
    """
    name = shown(name or path, 255)
    text = path.text if isinstance(path, CsvText) else _text_of(path, name, most_rows)
    count = text.count("\n")
    if count > most_rows + 1:
        raise InputError(f"{name}: {count:,} lines; at most {most_rows:,} rows are read: thin them out, or split the file")
    lines = text.split("\n")
    numbers = range(1, len(lines) + 1)
    if isinstance(path, CsvText) and len(path.rows) == len(lines) - 2:  # the names above, nothing behind the last line end
        numbers = [0, *path.rows, 0]
    longest = max(range(len(lines)), key=lambda k: len(lines[k]))
    if len(lines[longest]) > MOST_LINE:
        raise InputError(
            f"{name}, row {numbers[longest]}: a line of {len(lines[longest]):,} characters, at most {MOST_LINE:,} are "
            "read; is this a CSV file?"
        )
    used = [k for k, line in enumerate(lines) if line.strip(" \t,") and not is_comment(line)]
    if not used:
        raise InputError(f"{name}: is empty; the first row names the columns {_names(layout)}")
    first, *body = used
    head = f"{name}, row {numbers[first]}" if numbers[first] else name  # the names of a frame stand in no row
    header = cells_of(name, numbers[first], lines[first])
    _check_header(head, header, layout)
    rows, table = [], []
    # Python reads 1_5 as 15: who writes it means something else
    plain = set(layout.known) - set(layout.words)
    numeric = "_" not in "".join(lines[k] for k in body) and plain.issuperset(header)
    for k in body:
        try:
            values = [float(cell) for cell in lines[k].split(",")] if numeric else ()
        except ValueError:
            values = ()
        if (
            len(values) != len(header) or not isfinite(sum(values)) or max(map(abs, values)) > LARGEST
        ):  # a word, a blank, a quote, or a mistake: cell by cell
            values = _row(name, numbers[k], lines[k], header, layout)
            if values is None:
                continue
        rows.append(numbers[k])
        table.append(values)
    columns = {
        column: np.array([row[place] for row in table], dtype=str if column in layout.words else float)
        for place, column in enumerate(header)
        if column in layout.known
    }
    return CsvTable(name, head, np.array(rows, dtype=int), columns)


def _text_of(path, name, most_rows):
    """The text of a file, its lines ended in one way."""
    most_bytes = MOST_BYTES * most_rows // MOST_ROWS
    text = read_text(path, name, most_bytes, "thin the rows out, or split the file")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def is_comment(line):
    """Does a line begin with #, and not with a cell of which a spreadsheet says that it is no number?"""
    return line.lstrip().startswith("#") and not NO_COMMENT.match(line.lstrip())


def cells_of(name, row, line, separator=","):
    """The texts of a row's cells, without the blanks around them; name and row: what a complaint calls it."""
    try:
        (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t", strict=True)
    except csv.Error as problem:
        what = "a quote is opened and not closed in its row" if "end of data" in str(problem) else shown(problem)
        raise InputError(f"{name}, row {row}: {what}; leave quotes out, or close each one before the next comma") from None
    return [cell.strip() for cell in cells]


def _names(layout):
    """Names of the columns that a file may have, as a message tells them."""
    if len(layout.known) > MOST_TOLD:
        return f"{layout.known[0]}, .., {layout.known[-1]}: those of {len(layout.known)} known ones that were measured"
    return ",".join(layout.known)


def _check_header(place, header, layout):
    """Refuse a row of names with columns missing, unknown, without a name, or twice."""
    for sign, word in ((";", "semicolons"), ("\t", "tabs")):
        if any(sign in name for name in header):
            told = ", or let hlcs import convert the file" if layout.imported else ""
            raise InputError(
                f"{place}: columns are separated by {word}; write commas between columns and points in decimals{told}"
            )
    if all(map(_is_number, header)):
        numbers = shown(", ".join(header), 60)
        raise InputError(
            f"{place}: numbers, '{numbers}', where the names of the columns stand: write above them {_names(layout)}"
        )
    for number, name in enumerate(header, start=1):
        if not name and not layout.others:
            raise InputError(f"{place}: column {number} has no name; is there a comma too many?")
        if name not in layout.known and not layout.others:
            told = f"it stands in {layout.where}"
            if name not in layout.elsewhere:
                told = in_place_of_column(name) or known_one(name, layout.known, "the nearest known column is")
            raise InputError(f"{place}: unknown column '{shown(name)}'; {told}")
        if name in layout.known and header.count(name) > 1:
            raise InputError(f"{place}: column '{name}' stands twice; keep one")
    for name in layout.required:
        if name not in header:
            raise InputError(f"{place}: column '{name}' is missing in '{shown(','.join(header))}'")


def _row(name, row, line, header, layout):
    """The values of a row, a list; None where all its cells are blank."""
    cells = cells_of(name, row, line)
    if not any(cells):
        return None
    if layout.short and len(cells) < len(header):
        cells += [""] * (len(header) - len(cells))
    if len(cells) != len(header):
        count, names = f"{len(cells)} cell{'s' * (len(cells) != 1)}", shown(", ".join(header), MOST_WORD)
        hint = "write what is missing, or keep its comma and leave the cell blank"
        if len(cells) > len(header):
            hint = "leave out what is too much"
        if len(cells) == 2 * len(header):
            hint = "decimals are written with a point, 0.5, not 0,5"
        raise InputError(f"{name}, row {row}: {count} for {len(header)} columns ({names}); {hint}")
    values = []
    for column, cell in zip(header, cells, strict=True):
        place = f"{name}, row {row}, column {shown(column)}"
        if column in layout.words:
            values.append(_word(place, cell))
        else:
            values.append(_number(place, cell, column in layout.blank) if column in layout.known else nan)
    return values


def _word(place, text):
    """A cell that names something: a report shows it, so a terminal must be able to."""
    if len(text) > MOST_WORD or not text.isprintable():
        raise InputError(f"{place}: '{shown(text)}'; a name has at most {MOST_WORD} characters, all of which can be printed")
    return text


def decimal(text):
    """The number that a text means, also with the minus of printers; ValueError where it means none.

    To Python 1_5 is 15, to whoever typed it hardly.
    """
    if "_" in text:
        raise ValueError(text)
    return float(text.replace("\N{MINUS SIGN}", "-"))


def _is_number(text):
    try:
        decimal(text)
    except ValueError:
        return False
    return True


def _number(place, text, blank):
    """One cell as a finite number; blank is NaN where that is allowed."""
    if text == "":
        if blank:
            return nan
        raise InputError(f"{place}: blank; every row needs this value")
    try:
        value = decimal(text)
    except ValueError:
        hint = (
            "write decimals with a point, 0.5"
            if "," in text
            else "leave a missing sample blank"
            if blank
            else ("every row needs this value")
        )
        raise InputError(f"{place}: '{shown(text)}' is not a number; {hint}") from None
    if not isfinite(value):
        raise InputError(
            f"{place}: '{shown(text)}' is not finite; "
            + ("leave a missing sample blank" if blank else "every row needs this value")
        )
    if abs(value) > LARGEST:
        raise InputError(
            f"{place}: '{shown(text)}'; nothing that is measured is beyond {LARGEST:g} in SI units: correct it"
            + (", or leave a missing sample blank" if blank else "")
        )
    return value
