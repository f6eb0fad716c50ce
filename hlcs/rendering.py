"""How a result is shown. A result is data; its text, page, picture and files are made by the renderer of its class.

A renderer is a module with five functions of a result: `line`, `text`, `html`, `plot` (result, ax) and `save` (result, folder).
RENDERERS names it, and it is loaded when something is first shown: what computes needs no reports, and no report is needed to
compute.
"""

import importlib
from dataclasses import dataclass

from minibullet.errors import InputError, one_of, shown_value

RENDERERS = {
    "Comparison": "hlcs.report.comparison",
    "Design": "hlcs.placement.design_report",
    "Diagnosis": "hlcs.report.diagnosis",
    "LayerComparison": "hlcs.placement.comparison_report",
    "LayerTable": "hlcs.placement.table_report",
    "Learned": "hlcs.report.learned",
    "PlacementResult": "hlcs.placement.report",
    "Plan": "hlcs.report.plan",
    "Reproduction": "hlcs.paper.reproduction_report",
    "Reveal": "hlcs.report.reveal",
    "SweepResult": "hlcs.placement.sweep_report",
}


def renderer_of(kind):
    """The renderer of a class of results."""
    return importlib.import_module(RENDERERS[kind.__name__])


class Result:
    """What every result can do with its renderer."""

    def _renderer(self):
        return renderer_of(type(self))

    def summary(self):
        """The printed report."""
        return self._renderer().text(self)

    def __str__(self):
        return self.summary()

    def __repr__(self):
        return f"<{type(self).__name__}: {self._renderer().line(self)}>"

    def _repr_html_(self):
        return self._renderer().html(self)

    def plot(self, ax=None):
        """Draw it; ax: Axes to draw into, of a new figure where left out. Returns the Axes."""
        return self._renderer().plot(self, ax)

    def save(self, folder):
        """Write its files into a folder, made where it is missing; returns the folder. Raises InputError where it cannot."""
        return self._renderer().save(self, folder)


def table_of(tables, name, held=()):
    """The pandas frame of one of some tables {name: rows}, each row a dictionary; InputError names those that there are.

    held: {what somebody may ask for: the table that holds it}.
    """
    import pandas as pd

    if not isinstance(name, str) or name not in tables:
        none = f"table {shown_value(name)} is none of"
        if isinstance(name, str) and name in held:
            raise InputError(f"{none} {', '.join(tables)}; '{held[name]}' holds it")
        raise InputError(one_of(name, tables, none))
    return pd.DataFrame(list(tables[name]))


def counted(axes, count):
    """The Axes of a picture (n,), as many as it has panels; InputError for another number of them, or what is none."""
    for one in axes:
        if not hasattr(one, "set_xlabel"):
            raise InputError(f"plot: ax holds {shown_value(one)}; give Axes of matplotlib, {count} of them, or leave ax out")
    if len(axes) != count:
        raise InputError(f"plot: ax holds {len(axes)} Axes; this picture has {count}: give {count}, or leave ax out")
    return axes


@dataclass(frozen=True)
class Pictures:
    """What the figure of a Diagnosis draws: the observations beside the model before and after, name -> array (n,) each."""

    before: dict
    after: dict
    trials: tuple[str, ...]
    over: str  # column that they are drawn over
    label: str  # of that column, with its unit
    channels: tuple[str, ...] = ()  # names of the channels where each channel of a trial is a curve of its own; () = all are one
    units: tuple[str, ...] = ()  # of these channels
