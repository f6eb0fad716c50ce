"""What the answer of a mystery says beside what its data can tell: words, a table, and the picture before and after."""

import html as markup
from textwrap import fill

from hlcs.data.notes import Stopped
from hlcs.files import folders
from hlcs.report.diagnosis_figures import fit_panel, residual_panels
from hlcs.report.document import WIDTH, Section, Table, as_text
from hlcs.report.figures import given_axes
from hlcs.report.page import png
from hlcs.report.words import interval, joined, number, size
from hlcs.report.words import value as written
from minibullet.errors import InputError

HEAD = ("law", "number", "true", "expected from the data", "90 % interval")
CUT_SHORT = "Stopped by Ctrl-C: what the data give was not fitted to its end."
SHEET = (13.5, 4.2)  # of three panels in a row [inch]


def told(answer, laws, diagnosis):
    """The text of a reveal.

    answer: what was sealed; laws: {effect: its formula in words}, without those that no library has; diagnosis: of the data with
    the hidden effects as candidates, or None.
    """
    parts = [Section("", (f"{name}: {law}",)) for name, law in laws.items()]
    if diagnosis:
        rows = rows_of(answer, diagnosis)
        parts += [Section("", (CUT_SHORT,))] if Stopped.among(diagnosis.notes) else []
        parts += [Section("The numbers", (Table(HEAD, rows, texts=2),))] if rows else []
        parts.append(Section("The error", (_error(diagnosis),)))
    lines = answer["text"].strip().splitlines()
    return as_text("\n".join(fill(line, WIDTH, break_on_hyphens=False) for line in lines), parts)


def rows_of(answer, diagnosis):
    """A row for every number of every hidden law, and of the look-alikes that the data cannot tell from it."""
    return tuple(
        (law, name, number(truth, digits=6), *_found(diagnosis, law, name))
        for law in (*answer["effects"], *answer["tied"])
        for name, truth in _numbers(answer, law, diagnosis).items()
    )


def _numbers(answer, law, diagnosis):
    """{name: true number, None for a look-alike}: as the library writes the law, else as it was hidden."""
    true = answer["parameters"].get(law) or answer["hidden_laws"].get(law, {})
    scalars = {name: entry for name, entry in true.items() if isinstance(entry, int | float) and name != "form"}
    return scalars or dict.fromkeys(diagnosis.parameters.get(law, {}))


def _found(diagnosis, law, name):
    """A number and its interval as these data give them."""
    entry = diagnosis.parameters.get(law, {}).get(name)
    if entry is None and Stopped.among(diagnosis.notes):
        return "not fitted", "-"
    if entry is None or entry["value"] is None:
        return "not to be had", "-"
    return written(entry), interval(entry)


def _error(diagnosis):
    error, unit = diagnosis.error["fitted"], diagnosis.error["unit"]
    noise = f"the noise is {size(error['noise'], unit)}"
    if not diagnosis.effects:
        return f"{size(error['before'], unit)} with the model as it is; {noise}."
    return f"{size(error['before'], unit)} before, {size(error['after'], unit)} with {joined(diagnosis.effects)}; {noise}."


def line(reveal):
    """What was hidden, in a line."""
    return f"{reveal.name}: {joined(reveal.answer['effects']) if reveal.answer['effects'] else 'nothing'} was hidden"


def text(reveal):
    """What `hlcs mystery reveal` prints."""
    return told(reveal.answer, reveal.laws, reveal.diagnosis)


def html(reveal):
    """A reveal in a notebook, as it is printed."""
    return f"<pre>{markup.escape(text(reveal))}</pre>"


def plot(reveal, ax=None):
    """Measured and modelled, and the residuals before and after: three Axes, or two where nothing is to be added; ax: as many.
    InputError where nothing was fitted."""
    if reveal.diagnosis is None or not reveal.diagnosis.pictures:
        raise InputError(f"reveal {reveal.name}: nothing was fitted, so there is no picture; leave out fit=False")
    return before_and_after(reveal.diagnosis, ax)


def save(reveal, folder):
    """Write reveal.json, reveal.txt and, where something was fitted, before_and_after.png."""
    found = {"reveal.json": folders.to_json(reveal.to_dict()).encode(), "reveal.txt": (text(reveal) + "\n").encode()}
    if reveal.diagnosis and reveal.diagnosis.pictures:
        found["before_and_after.png"] = png(plot(reveal))
    return folders.save_files(folder, found)


def before_and_after(diagnosis, ax=None):
    """Measured and modelled, and the residuals before and after, in one row; the Axes: two where nothing is to be added."""
    count = 3 if diagnosis.effects else 2
    axes = given_axes(ax, 1, count, SHEET if diagnosis.effects else (9.0, 4.2))
    fit_panel(diagnosis, axes[0])
    residual_panels(diagnosis, diagnosis.pictures.over, axes[1:])
    return axes
