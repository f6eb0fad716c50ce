"""How a LayerTable is shown and saved: printed, in a notebook, drawn, written into a folder."""

import html as markup

import numpy as np

from hlcs.files import folders
from hlcs.files.spreadsheets import csv_text
from hlcs.placement import figures
from hlcs.placement.statistics import Sample
from minibullet.errors import how_many


def line(table):
    """The table in a line: what was measured, its layers, its height."""
    return f"{table.title} ({table.source}); {how_many(table.mean.size, 'layer')}, {table.height_over_dn:.3f} Dn high"


def text(table):
    """The table as text."""
    lines = [f"{table.title} ({table.source})", f"{'layer':>5} {'mean':>7} {'CV':>7} {'N':>4}"]
    for layer, mean, cv, tests in zip(table.layers, table.mean, table.cv, table.tests, strict=True):
        lines.append(f"{layer:>5} {mean:>7.3f} {cv:>7.3f} {'?' if np.isnan(tests) else f'{tests:.0f}':>4}")
    return "\n".join([*lines, f"{'sum':>5} {table.height_over_dn:>7.3f}"])


def html(table):
    """A table in a notebook."""
    shown = table.to_dataframe()[["layer", "mean", "cv", "tests"]]
    return f"<p>{markup.escape(line(table))}</p>{shown.to_html(index=False)}"


def plot(table, ax=None):
    """The layer coefficients against the layer, with the 95 % interval of each mean; returns the Axes."""
    return figures.layer_axes([(table.title, Sample(table.mean, table.cv, table.tests))], ax)


def save(table, folder):
    """Write layers.csv, as a layers file has it, table.txt and layers.png."""
    files = {
        "layers.csv": csv_text(table.to_dataframe().to_dict("list")).encode(),
        "table.txt": (text(table) + "\n").encode(),
        "layers.png": figures.png_bytes(plot(table).figure),
    }
    return folders.save_files(folder, files)
