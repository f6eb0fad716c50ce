"""Notes on the data, those that say the same of several files or columns told once."""

import re

from hlcs.report.document import Points

MOST = 8  # that a report tells; the JSON result has all
OF_A_FILE = re.compile(r"(\S+\.csv|frame \d+)(?:, column (\w+))?: (.*)", re.DOTALL)
SIZE = re.compile(r"(?<![\w.,])\d+(?:,\d{3})*(?:\.\d+)?(?:e[+-]\d+)?(?![\w.]*\w)")  # a number of its own, not a part of a name


def note_parts(notes):
    """The parts of a section of notes, () where there are none."""
    return (Points(tuple(gathered(notes))),) if notes else ()


def gathered(notes, most=MOST):
    """Notes that say the same of several files or columns as one, sizes that differ as a range; at most so many, then how many
    more there are."""
    places = {}
    for note in notes:
        found = OF_A_FILE.match(note)
        what, file, column = (found[3], found[1], found[2]) if found else (note, None, None)
        alike = SIZE.sub("#", what) if file and " row" not in what else what  # a row is a place, not a size
        said, files = places.setdefault(alike, ([], {}))
        said.append(what)
        if file:
            files.setdefault(file, []).extend([column] if column else [])
    told = []
    for said, files in places.values():
        many = {file: ", ".join(dict.fromkeys(columns)) for file, columns in files.items()}
        told.append(_placed(_with_ranges(said), many))
    return told[:most] + ([f"and {len(told) - most} more, all in the JSON result"] if len(told) > most else [])


def _placed(what, places):
    """A sentence with where it holds, {file: its columns, "" of all of it}; the same columns of several files are named once."""
    named = [f"{file}, {columns}" if columns else file for file, columns in places.items()]
    if len(named) < 2:
        return ": ".join([*named, what])
    if len(set(places.values())) > 1:
        return f"{what} (in each of {'; '.join(named)})"
    columns = next(iter(places.values()))
    return f"{what} (in {f'{columns} of ' if columns else ''}each of {', '.join(places)})"


def _with_ranges(said):
    """Sentences that differ in their numbers alone as one, each number that differs as "least to largest"."""
    numbers = [sorted(some, key=lambda size: float(size.replace(",", ""))) for some in zip(*map(SIZE.findall, said), strict=True)]
    ranges = iter([" to ".join(dict.fromkeys((some[0], some[-1]))) for some in numbers])
    return SIZE.sub(lambda _: next(ranges), said[0])
