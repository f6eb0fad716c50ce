"""Tables as CSV text that a spreadsheet only shows: no cell of it is a formula there."""

import csv
import io

STARTS = ("=", "+", "-", "@", "\t", "\r")  # what spreadsheets take for the beginning of a formula


def csv_text(columns):
    """The CSV text of columns {name: values}, missing values (None, NaN)
    blank; a text that would be a formula gets an apostrophe before it."""
    return rows_text([tuple(map(_shown, columns)), *zip(*(map(_shown, values) for values in columns.values()), strict=True)])


def rows_text(rows):
    """The CSV text of rows of cells; what begins a row with # stands in quotes, for it is no comment."""
    stream = io.StringIO()
    plain, quoted = (csv.writer(stream, lineterminator="\n", quoting=kind) for kind in (csv.QUOTE_MINIMAL, csv.QUOTE_ALL))
    for row in rows:
        (quoted if row and str(row[0]).startswith("#") else plain).writerow(row)
    return stream.getvalue()


def as_columns(rows):
    """Rows, dictionaries with the same keys, as columns."""
    return {name: [row[name] for row in rows] for name in rows[0]}


def _shown(cell):
    """A cell as it is written: text that begins a formula gets an apostrophe; a number, written as text or not, is itself."""
    if isinstance(cell, float):
        return "" if cell != cell else repr(float(cell))
    if not isinstance(cell, str) or not cell.startswith(STARTS):
        return cell
    try:
        float(cell)
    except ValueError:
        return "'" + cell
    return cell
