"""The cells of an exported text file: its encoding, what separates its columns, how its decimals are written.

Rows count as lines of the file, from 1; blank lines and lines that begin with # are passed over.
"""

import re
import unicodedata
from dataclasses import dataclass, field
from math import isfinite, nan
from pathlib import Path

import numpy as np

from hlcs.files.csv_files import MOST_BYTES, MOST_ROWS, cells_of, decimal, is_comment
from hlcs.importing.found import Assumption
from minibullet.errors import InputError, how_many, shown
from minibullet.files.reading import no_workbook, read_bytes

# the first of these that stands in half of the first lines separates columns
SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas"}
MOST_LINE = 200_000  # characters: a thousand markers of a motion capture, three numbers each, would have 60,000
MOST_BROKEN = 5  # lines that the cells of one row may fill: a quote that is never closed must not swallow the file
# what programs and people write for a sample that was lost
MISSING = {"", "nan", "-nan", "na", "n/a", "<na>", "#n/a", "#nv", "null", "none", "-", "--"}
SIGN = r"[+\-\N{MINUS SIGN}]?"
COMMA_NUMBER = re.compile(SIGN + r"(?:\d+|\d{1,3}(?:\.\d{3})+),\d+(?:[eE][+-]?\d+)?")
# digits in groups of three, where the groups cannot be mistaken for decimals: 1 500,5 and 1'500.5; 1,500.5; 1.500,5
BLANK_GROUPS = re.compile(SIGN + r"\d{1,3}(?:[ \u00a0\u2009\u202f'\u2019]\d{3})+(?:[.,]\d+)?")
COMMA_GROUPS, POINT_GROUPS = (re.compile(SIGN + rf"\d{{1,3}}(?:{a}\d{{3}})+{b}\d+") for a, b in ((",", r"\."), (r"\.", ",")))
# 1,500 beside 998: one of them is a thousand times what it seems
EITHER, WHOLE = re.compile(SIGN + r"[1-9]\d{0,2}[.,]\d{3}"), re.compile(SIGN + r"\d{1,3}")
SEPARATOR_LINE = re.compile(r'"?sep=(.)"?[,;\s]*', re.IGNORECASE)  # the first line of what Excel writes for other programs
DATE = re.compile(r"\d[-./]\d+[-./]\d|\d:\d\d|\b(?:jan|feb|m[aä]r|apr|ma[iy]|jun|jul|aug|sep|o[ck]t|nov|de[cz])", re.IGNORECASE)
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
    comma: str  # where a decimal is written with a comma, in words; "" where none is
    assumptions: tuple[Assumption, ...]
    blanks: bool = False  # do blanks separate its columns, so that a lost cell shows nowhere?

    def place(self, row, column=""):
        """ "file, row n, column c", to begin a complaint with; row: index into `cells`."""
        return f"{self.name}, row {self.lines[row]}" + (f", column {shown(column)}" if column else "")

    def column(self, first, index, name):
        """Numbers of a column from row `first` on, (n,), NaN where missing; InputError for what is no number, or two."""
        self._refuse_thousands(first, index, name)
        return np.array([self._number(row, index, name) for row in range(first, len(self.cells))], dtype=float)

    def once(self, row, index):
        """InputError where the name of a column stands in its row again: one of the two would be passed over."""
        name = self.cells[row][index]
        if self.cells[row].count(name) > 1:
            raise InputError(
                f"{self.place(row)}: column '{shown(name)}' stands twice; give each recording a file of its own, repeats of "
                "an experiment a row each"
            )

    def as_many_cells_as_names(self, head):
        """Refuse a row in which something stands beyond the last column that has a name, or in which blanks hide which cell is
        lost; head: index of the row of names."""
        count = len(self.cells[head])
        for row in range(head + 1, len(self.cells) if self.blanks else 0):
            if len(self.cells[row]) < count and any(map(is_number, self.cells[row][1:])):
                there = how_many(len(self.cells[row]), "cell")
                raise InputError(
                    f"{self.place(row)}: {there} below {count} names, and blanks do not show which one is lost; write nan in its "
                    "place, or separate columns by commas"
                )
        for row in range(head + 1, len(self.cells)):
            if any(self.cells[row][count:]):
                raise InputError(
                    f"{self.place(row)}: {len(self.cells[row])} cells below {count} names; where decimals have a comma, columns "
                    "need another separator, such as ;"
                )

    def _text(self, row, index):
        cells = self.cells[row]
        return cells[index] if index < len(cells) else ""

    def _refuse_thousands(self, first, index, name):
        """Refuse a column of 998 and 1,002 alone: 1002, or 1 and two thousandths?"""
        found = None
        for row in range(first, len(self.cells)):
            text = self._text(row, index)
            if EITHER.fullmatch(text):
                found = row if found is None else found
            elif not (WHOLE.fullmatch(text) or text.lower() in MISSING):
                return
        texts = (self._text(row, index) for row in range(first, len(self.cells)))
        if found is not None and any(WHOLE.fullmatch(text) and text[-3:].isdecimal() and len(text) > 2 for text in texts):
            raise InputError(
                f"{self.place(found, name)}: '{self._text(found, index)}' beside whole numbers below 1000: are its last digits "
                "decimals? Write numbers without separators of thousands, decimals with one digit more"
            )

    def _number(self, row, index, name):
        text = self._text(row, index)
        if text.lower() in MISSING:
            return nan
        if BLANK_GROUPS.fullmatch(text) or (POINT_GROUPS if self.comma else COMMA_GROUPS).fullmatch(text):
            *whole, last = re.split(r"[.,](?=\d+$)(?!.*[.,])", text)
            text = "".join(re.findall(r"\d|[^\s\d.,'\u2019]", "".join(whole or [last]))) + ("." + last if whole else "")
        elif self.comma and "." in text:
            raise InputError(
                f"{self.place(row, name)}: '{shown(text)}' has a point where {self.comma} has a comma; write all decimals alike"
            )
        try:
            value = decimal(text.replace(",", ".") if self.comma else text)
        except ValueError:
            raise InputError(f"{self.place(row, name)}: '{shown(text)}' is not a number; {_remedy(text)}") from None
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
    used = [k for k, line in enumerate(lines) if line.strip(" \t,;") and not is_comment(line)]
    if used and (found := SEPARATOR_LINE.fullmatch(lines[used[0]])):
        separator, used = separator or found[1], used[1:]
    if not used:
        raise InputError(f"{source.name}: is empty")
    if (above := _names_in_a_comment(lines, used[0])) is not None:
        lines[above], used = lines[above].lstrip("# \t"), [above, *used]
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
    separator = separator or _separator(head)
    numbers, cells = _rows(source.name, lines, used, separator)
    commas = (f"'{shown(cell)}' in row {k}" for k, row in zip(numbers, cells, strict=True) for cell in row if _is_comma(cell))
    if comma := next(commas, ""):
        notes = (*notes, Assumption(f"{source.name}: decimals are written with a comma, 0,5 for a half"))
    if below := [k + 1 for k in range(used[0], len(lines)) if is_comment(lines[k])]:
        rows = ", ".join(map(str, below[:5])) + ", .." * (len(below) > 5)
        notes = (*notes, Assumption(f"{source.name}: what begins with # is passed over, as a comment (row {rows})"))
    return Grid(source.name, source.stem, numbers, cells, comma, notes, separator == " ")


def _names_in_a_comment(lines, first):
    """Index of the last comment above rows of numbers that has as many words as they have numbers, as `numpy.savetxt` and Kinovea
    write the names of columns; None where there is none. first: index of the first row."""
    separator = _separator(lines[first])

    def parts(text):
        return [part.strip() for part in text.split(None if separator == " " else separator)]

    numbers = parts(lines[first])
    read = [is_number(cell) for cell in numbers if cell.lower() not in MISSING]
    if len(numbers) < 2 or not read or not all(read):
        return None
    comments = ((k, parts(lines[k].lstrip("# \t"))) for k in range(first - 1, -1, -1) if is_comment(lines[k]))
    return next((k for k, words in comments if len(words) == len(numbers) and not any(map(is_number, words))), None)


def is_number(cell):
    """Is a cell a number, with a point or a comma, and not one of the signs of a lost sample?"""
    try:
        decimal(cell.replace(",", "."))
    except ValueError:
        return False
    return cell.lower() not in MISSING


def _is_comma(cell):
    return COMMA_NUMBER.fullmatch(cell) is not None


def _separator(head):
    """What separates the columns of the first lines; commas between digits alone are those of decimals where blanks do."""
    lines = head.split("\n")
    count = {sign: sum(sign in line for line in lines) for sign in SEPARATORS}  # a title may hold another one
    found = next((sign for sign in SEPARATORS if 2 * count[sign] >= len(lines)), max(SEPARATORS, key=count.get))
    found = found if count[found] else " "
    decimals = found == "," and not re.search(r"(?<!\d),|,(?!\d)", head) and re.search(r"\d +[+-]?\d", head)
    return " " if decimals else found


def _rows(name, lines, used, separator):
    """(line of the file of each row, its cells); a line break between quotes is a blank of its cell."""
    numbers, cells, end = [], [], 0
    for k in (k for k in used if k >= end):
        numbers.append(k + 1)
        if separator == " ":
            cells.append(_between_blanks(name, k + 1, lines[k]))
            continue
        ends = (stop for stop in range(k + 1, k + 1 + MOST_BROKEN) if " ".join(lines[k:stop]).count('"') % 2 == 0)
        try:
            cells.append(cells_of(name, k + 1, lines[k], separator))
        except InputError:
            end = next(ends, k + 1)
            cells.append(cells_of(name, k + 1, " ".join(lines[k:end]), separator))
    return tuple(numbers), tuple(cells)


def _remedy(text):
    """What to do about a cell that is no number."""
    if DATE.search(text):
        return "a date or a time of day: give the column the format of plain numbers, times in s"
    if re.match(r"[+-]?\d", text):
        return "write the number alone, its unit in the name of the column"
    return "write a number, or leave a missing sample blank"


def _between_blanks(name, line, text):
    """The cells of a line whose columns are separated by blanks; blanks between quotes separate nothing."""
    if '"' not in text:
        return text.split()
    return [cell for cell in cells_of(name, line, text.strip(), " ") if cell]


def _text(source):
    """(text, assumptions) of the bytes of a file: UTF-8, UTF-16 with its mark, else the letters of Western Windows."""
    no_workbook(source.data, source.name)
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
    return unicodedata.normalize("NFC", text), notes  # an umlaut is one letter, whether it was saved as one or two
