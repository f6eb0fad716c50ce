"""What a report says, said once for the terminal and for a page: sections of sentences, lists, tables and lines to copy."""

import textwrap
from dataclasses import dataclass, field

WIDTH = 110  # of sentences in a terminal


@dataclass(frozen=True)
class Table:
    """Rows of cells as text; the first `texts` columns hold words, the others numbers."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: int = 1
    marked: tuple[int, ...] = ()  # rows of what was found, to be seen first
    wordy: bool = False  # is the last column a sentence?
    note: str = ""  # what the columns and the signs in them mean


@dataclass(frozen=True)
class Points:
    """A list of sentences."""

    items: tuple[str, ...]


@dataclass(frozen=True)
class Lines:
    """Lines to be copied as they are."""

    lines: tuple[str, ...]


@dataclass(frozen=True)
class Section:
    """A part of a report with a heading; parts: sentences (str), Table, Points or Lines."""

    title: str
    parts: tuple = field(default=())
    key: str = ""  # by which a page finds the pictures that belong to it


def as_text(headline, sections):
    """The printed report of sections."""
    blocks = [headline]
    for section in sections:
        lines = [section.title] if section.title else []
        for part in section.parts:
            lines += _printed(part, "  " if section.title else "")
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks)


def _printed(part, indent):
    if isinstance(part, Table):
        return [indent + line for line in _table(part)]
    if isinstance(part, Points):
        return [line for item in part.items for line in _wrapped(item, f"{indent}- ", f"{indent}  ")]
    if isinstance(part, Lines):
        return [f"{indent}  {line}" for line in part.lines]
    return _wrapped(part, indent, indent)


def _wrapped(sentence, first, other):
    return textwrap.wrap(
        sentence, WIDTH, initial_indent=first, subsequent_indent=other, break_long_words=False, break_on_hyphens=False
    )


def _table(table):
    rows = [table.head, *table.rows]
    last = len(table.head) - 1
    widths = [max(len(row[place]) for row in rows) for place in range(len(table.head))]
    lines = []
    for number, row in enumerate(rows, start=-1):
        cells = [
            cell if place == last and table.wordy else f"{cell:{'<' if place < table.texts else '>'}{width}s}"
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        mark = ("* " if number in table.marked else "  ") if table.marked else ""
        lines.append((mark + "  ".join(cells)).rstrip())
    note = " ".join([*["* found."] * bool(table.marked), *[table.note] * bool(table.note)])
    return lines + (_wrapped(note, "", "") if note else [])
