"""How a SweepResult is shown and saved: its summary, in a notebook, drawn as height over what varied, as files."""

import html as markup
from pathlib import Path

import numpy as np

from hlcs.files import folders
from hlcs.placement import figures, parameter_sweep
from hlcs.placement.validation import UNITS
from minibullet.errors import how_many, is_number

MARKS = ("o", "s", "^", "D", "v", "P")


def line(result):
    """The sweep in a line: what varied, how many runs."""
    failed = sum("error" in row for row in result.rows)
    told = f"{result.sweep.title}; {how_many(len(result.rows), 'run')} over {', '.join(result.sweep.names)}"
    return f"{told}; {result.outcome['ran']} run now, {result.outcome['kept']} found in the store, {failed} failed"


def text(result):
    """What `hlcs sweep` prints."""
    return parameter_sweep.summary_text(result.sweep, result.outcome)


def html(result):
    """A sweep in a notebook: repeats as one row."""
    return f"<p>{markup.escape(line(result))}</p>{result.to_dataframe('summary').to_html(index=False)}"


def plot(result, ax=None):
    """The height of every run over the first number that varied, a mark for each combination of the others, their means joined.

    Runs that failed or left no structure have no height. Returns the Axes.
    """
    ax = figures.canvas(6.0, 4.2)[1][0] if ax is None else ax
    over = _first_number(result)
    cases = {}
    for number, row in enumerate(result.rows):
        if row.get("structure") and row["height_over_dn"] is not None:
            others = tuple(f"{name} {row[name]}" for name in result.sweep.names if name not in (over, "seed"))
            cases.setdefault(others, []).append((row[over] if over else number + 1, row["height_over_dn"]))
    for place, (others, points) in enumerate(cases.items()):
        x, heights = np.array(points, dtype=float).T
        (dots,) = ax.plot(x, heights, MARKS[place % len(MARKS)], alpha=0.5, markersize=5, label=", ".join(others) or None)
        if over:
            values = np.unique(x)
            ax.plot(values, [heights[x == value].mean() for value in values], color=dots.get_color(), linewidth=1)
    if len(cases) > 1:
        ax.legend(frameon=False, fontsize=9)
    unit = UNITS.get(over, "-")
    ax.set_xlabel(f"{over.replace('_', ' ')} [{unit}]" if over else "run")
    ax.set_ylabel("height [Dn]")
    ax.set_title(result.sweep.title, loc="left", fontsize=11, parse_math=False)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def _first_number(result):
    """The first setting but the seed that varies and is a number; None where there is none."""
    for place, name in enumerate(result.sweep.names):
        values = {values[place] for values in result.sweep.values}
        if name != "seed" and len(values) > 1 and all(map(is_number, values)):
            return name
    return None


def save(result, folder):
    """Write runs.csv, summary.csv, sweep.json and sweep.png."""
    with folders.result_folder(folder) as partial:
        write(result, partial)
    return Path(folder)


def write(result, folder):
    """All files of a sweep into an existing, empty folder."""
    parameter_sweep.write_sweep(result.sweep, result.outcome, folder)
    folders.write_bytes(folder / "sweep.png", figures.png_bytes(plot(result).figure))
