"""The text of a lesson, taken apart into cells: the part of MyST Markdown that lessons use, and nothing else.

A lesson is Markdown with fenced cells of code. A solution of an exercise is a cell with the tag hide-cell:

    ```{code-cell} ipython3
    :tags: [hide-cell]
    ```
"""

import re
from typing import NamedTuple

HEAD = re.compile(r"\A---\n.*?\n---\n", re.DOTALL)
CELL = re.compile(r"^```\{code-cell\} ipython3\n(?::tags: \[([\w, -]*)\]\n)?(.*?)^```$", re.DOTALL | re.MULTILINE)
HIDDEN = "hide-cell"


class Cell(NamedTuple):
    """One cell of a lesson."""

    is_code: bool
    text: str  # without empty lines around it
    tags: tuple[str, ...] = ()

    @property
    def is_solution(self):
        """Whether it stays closed until the reader opens it."""
        return HIDDEN in self.tags


def cells(text):
    """The cells of a lesson, in order; empty ones are left out."""
    text, found, end = HEAD.sub("", text), [], 0
    for match in CELL.finditer(text):
        tags = tuple(tag.strip() for tag in (match[1] or "").split(",") if tag.strip())
        found += [Cell(False, text[end : match.start()].strip()), Cell(True, match[2].strip(), tags)]
        end = match.end()
    return [cell for cell in (*found, Cell(False, text[end:].strip())) if cell.text]


def title(text):
    """The first heading."""
    return next(line[2:].strip() for line in text.splitlines() if line.startswith("# "))
