"""Notes on the data, those that say the same of several files or columns told once."""

import re

from hlcs.report.document import Points

MOST = 8  # that a report tells; the JSON result has all
OF_A_FILE = re.compile(r"(\S+\.csv)(?:, column (\w+))?: (.*)", re.DOTALL)


def note_parts(notes):
    """The parts of a section of notes, () where there are none."""
    return (Points(tuple(gathered(notes))),) if notes else ()


def gathered(notes, most=MOST):
    """Notes that say the same of several files or columns as one; at most so many, then how many more there are."""
    places = {}
    for note in notes:
        found = OF_A_FILE.match(note)
        what, file, column = (found[3], found[1], found[2]) if found else (note, None, None)
        files = places.setdefault(what, {})
        if file:
            files.setdefault(file, []).extend([column] if column else [])
    told = []
    for what, files in places.items():
        many = [f"{file} ({', '.join(columns)})" if columns else file for file, columns in files.items()]
        told.append(what if not many else f"{many[0]}: {what}" if len(many) == 1 else f"{what}: {', '.join(many)}")
    return told[:most] + ([f"and {len(told) - most} more, all in the JSON result"] if len(told) > most else [])
