"""The table of validation cases: one row per figure, written to docs/validation.md from the run that measured it."""

import platform
from importlib.metadata import version
from typing import NamedTuple

HEAD = """# Validation

Written by `python -m pytest -m validation`; not edited by hand. Every row is a figure that the run measured. A row that
misses its target stays in the table with its reason. Settings are the engine's defaults with a step of 1/240 s unless
the case names others. The peer is pybullet 3.2.7 at the same step and 50 iterations unless another is named.

| case | what | figure | target | met | peer |
|---|---|---|---|---|---|
"""


class Row(NamedTuple):
    """One measured figure of one case."""

    case: str  # number in the list, or a word
    what: str
    figure: object  # number or text
    target: object  # largest allowed magnitude, or text
    unit: str
    met: bool
    peer: str
    reason: str  # why a target was missed; empty if met

    def cells(self):
        """The row as six texts."""
        limit = self.target if isinstance(self.target, str) else f"≤ {number(self.target)} {self.unit}".rstrip()
        met = "yes" if self.met else f"**no**: {self.reason or 'see the test'}"
        return [self.case, self.what, f"{number(self.figure)} {self.unit}".rstrip(), limit, met, self.peer]


def number(value):
    """Three digits for a float; texts unchanged."""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def order(row):
    """Numbered cases first and in order, then the rest."""
    return (0, int(row.case), "") if row.case.isdigit() else (1, 0, row.case)


def page(rows, broken=()):
    """The whole page as Markdown; broken: names of the tests that failed, with or without a figure."""
    rows = sorted(rows, key=order)
    met = sum(row.met for row in rows)
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row.cells()) + " |" for row in rows]
    versions = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "python-fcl"))
    foot = f"\n{met} of {len(rows)} figures meet their target. Python {platform.python_version()}, {versions}.\n"
    foot += "".join(f"\nFailed: `{name}`\n" for name in broken)
    return HEAD + "\n".join(lines) + "\n" + foot
