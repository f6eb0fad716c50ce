"""A lesson as a Jupyter notebook: nbformat 4.5 (https://nbformat.readthedocs.io), JSON that needs no package to be written."""

import re

from hlcs.course import lesson_text
from hlcs.files.documents import to_json

DOC = re.compile(r"\{doc\}`([^`<]+?)\s*<([\w./]+)>`")
ROLE = re.compile(r"\{[\w:-]+\}`[^`]*`?|^:?```\{[\w:-]+\}|^:::", re.MULTILINE)
YOURS = "# your answer; the solution is in the closed cell below\n"
CLOSED = {"source_hidden": True, "outputs_hidden": True}  # how JupyterLab and Notebook 7 keep a cell closed


def write(text, names):
    """The text of the .ipynb file of a lesson; names: of all lessons, which link to one another.

    Before each solution, which is closed, there is an empty cell for the reader's own. Raises ValueError for markup of the
    documentation that a notebook could not show.
    """
    found = []
    for cell in lesson_text.cells(text):
        if cell.is_solution:
            found.append(_code(YOURS, {}))
        if cell.is_code:
            closed = {"jupyter": CLOSED} if cell.is_solution else {}
            found.append(_code(cell.text, {**closed, "tags": list(cell.tags)} if cell.tags else {}))
        else:
            found.append({"cell_type": "markdown", "metadata": {}, "source": _markdown(cell.text, names)})
    numbered = [{"id": f"cell-{number:02d}", **cell} for number, cell in enumerate(found, start=1)]
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return to_json({"cells": numbered, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5})


def _code(text, metadata):
    """A cell of code that has not been run."""
    return {"cell_type": "code", "execution_count": None, "metadata": metadata, "outputs": [], "source": text}


def _markdown(text, names):
    """Markdown that a notebook shows: links to lessons become links to notebooks, those to other pages their names."""

    def link(match):
        page = match[2].rsplit("/", 1)[-1]
        if page in names:
            return f"[{match[1]}]({page}.ipynb)"
        return f"{match[1]} (page *{match[2].replace('../', '')}* of the documentation)"

    text = DOC.sub(link, text)
    if left := ROLE.search(text):
        raise ValueError(f"lesson: '{left[0]}' means nothing in a notebook; write {{doc}}`words <page>` or plain Markdown")
    return text
