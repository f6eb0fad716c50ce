"""How a LayerComparison is shown and saved: printed, in a notebook, drawn, written into a folder."""

import html as markup

from hlcs.files import folders
from hlcs.files.spreadsheets import as_columns, csv_text
from hlcs.placement import figures
from hlcs.placement.number_text import or_dash, percent


def line(comparison):
    """The comparison in a line: layers and errors."""
    errors = {"mean relative error": "mean_relative_error", "signed bias": "signed_bias", "height error": "height_error"}
    told = ", ".join(f"{words} {percent(getattr(comparison, name), '+.2f')} %" for words, name in errors.items())
    return f"{comparison.title}; {len(comparison.model.mean)} layers, {told}"


def text(comparison):
    """The table as text."""
    lines = [
        comparison.title,
        f"{'layer':>5} {'model':>8} {'CV':>6} {'N':>3} {'measured':>10} {'CV':>6} {'N':>3} {'error %':>9} {'z':>6}",
    ]
    for row in comparison.layer_rows():
        own = f"{or_dash(row['mean'], '.3f'):>8} {or_dash(row['cv'], '.3f'):>6} {or_dash(row['tests'], '.0f'):>3}"
        measured = f"{row['measured_mean']:>10.3f} {or_dash(row['measured_cv'], '.3f'):>6}"
        difference = f"{percent(row['signed_error'], '+.2f'):>9} {or_dash(row['z'], '+.1f'):>6}"
        lines.append(f"{row['layer']:>5} {own} {measured} {or_dash(row['measured_tests'], '.0f'):>3} {difference}")
    lines.append(
        f"{'sum':>5} {or_dash(comparison.model.mean.sum(), '.3f'):>8} {'':>10} {comparison.measured.mean.sum():>10.3f} {'':>10} "
        f"{percent(comparison.height_error, '+.2f'):>9}"
    )
    lines.append(
        f"mean relative error {percent(comparison.mean_relative_error)} %, signed bias "
        f"{percent(comparison.signed_bias, '+.2f')} %, height error {percent(comparison.height_error, '+.2f')} % "
        "(positive: the model is too thick)"
    )
    return "\n".join([*lines, *comparison.notes])


def html(comparison):
    """A comparison in a notebook."""
    return f"<p>{markup.escape(comparison.title)}</p>" + comparison.to_dataframe().to_html(index=False)


def plot(comparison, ax=None):
    """Both against the layer, with error bars; returns the Axes."""
    return figures.layer_axes([("model", comparison.model), ("measured", comparison.measured)], ax)


def save(comparison, folder):
    """Write layers.csv, comparison.txt, comparison.png and comparison.json."""
    files = {
        "layers.csv": csv_text(as_columns(comparison.layer_rows())).encode(),
        "comparison.txt": (text(comparison) + "\n").encode(),
        "comparison.png": figures.png_bytes(plot(comparison).figure),
        "comparison.json": folders.to_json(comparison.to_dict()).encode(),
    }
    return folders.save_files(folder, files)
