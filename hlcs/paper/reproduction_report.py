"""How a Reproduction is shown and saved: as the command prints and draws it."""

import html as markup

from hlcs.files import folders
from hlcs.paper import reproduce_files
from hlcs.paper.reproduce_text import text_of
from hlcs.placement import figures


def line(result):
    """The table in a line: its name, how often every case was run."""
    return f"{result.table} of the paper, {result.document['repeats']} tests of every case"


def text(result):
    """What `hlcs reproduce` prints."""
    return text_of(result.document)


def html(result):
    """A reproduction in a notebook, as it is printed."""
    return f"<pre>{markup.escape(text(result))}</pre>"


def plot(result, ax=None):
    """Table 1: eps_R of every parameter; table2, table3, figures: layer coefficients, a panel a grid; workability: lost and
    misplaced units. ax: as many Axes as there are panels. Returns the Axes of all panels, (n,)."""
    return reproduce_files.axes_of(result.document, ax)


def save(result, folder):
    """Write the document, the text and the picture, named as by the command."""
    files = {
        f"{result.table}.json": folders.to_json(result.document).encode(),
        f"{result.table}.txt": (text(result) + "\n").encode(),
        reproduce_files.PICTURES[result.table]: figures.png_bytes(plot(result)[0].figure),
    }
    return folders.save_files(folder, files)
