"""What all pictures of reports share: Axes, colours that differ in grey as well, panels of residuals; and those of a comparison.

Every plot takes `ax=None` and returns the Axes; nothing is shown or kept open.
"""

import textwrap

import numpy as np

from hlcs.data.quantities import have_unit
from hlcs.rendering import counted
from hlcs.report.words import change_told, size, words

LABELS = {
    "time": "time [s]",
    "height": "height [m]",
    "speed": "speed [m/s]",
    "layer": "layer",
    "input": "row: the layers, set after set",
}
INK, BEFORE, AFTER, NOISE = "#222222", "#e07b1a", "#1c5a85", "#b5b5b5"  # of unlike lightness: they differ in print as well
CHANNEL = (("o", "#1c5a85"), ("s", "#e07b1a"), ("^", "#8cc084"), ("D", "#7b3294"), ("v", "#c2a5cf"), ("P", "#555555"))
SMALLER = {"m": (1e3, "mm"), "s": (1e3, "ms"), "1": (100.0, "%")}  # what an axis shows below one
LINE = 0.75  # [points]
BAND = 2.0  # sigma of the noise, drawn grey
MOST_NAMED = 10  # groups whose names have room below an axis
LETTERS = 49  # of a title across a whole panel
SIZE = (4.5, 3.2)  # of one panel: as wide as a phone shows it with letters of its own size [inch]


def new_axes(rows=1, columns=1, size=SIZE):
    """Axes of a new figure, drawn without a window: array (rows * columns,)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return np.asarray(figure.subplots(rows, columns)).reshape(-1)


def given_axes(ax, rows=1, columns=1, size=SIZE):
    """The Axes that were given, or those of a new figure, (rows * columns,). InputError for another number, or what is none."""
    if ax is None:
        return new_axes(rows, columns, size)
    return counted(np.asarray(ax, dtype=object).reshape(-1), rows * columns)


def plain(ax, title, x, y, pad=None, letters=43):
    """Title, names of the axes, and no frame that is not needed; words of a file are no formula.

    pad: room below the title [points]; letters: in a line of it, and of the name of the axis below.
    """
    ax.set_title(textwrap.fill(title, letters), loc="left", fontsize=11, color=INK, parse_math=False, pad=pad)
    ax.set_xlabel(textwrap.fill(x, letters), fontsize=10, parse_math=False)
    ax.set_ylabel(y, fontsize=10, parse_math=False)
    ax.tick_params(labelsize=9)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)


def letters_beside(ax):
    """How many letters of a title stand in a line beside the names at the upright axis, whose letters are a tenth narrower."""
    names = [line for label in ax.get_yticklabels() for line in label.get_text().split("\n")]
    return max(LETTERS - round(0.9 * max(map(len, names), default=0)), 12)


def legend(ax, below=False, **more):
    """The legend; below: under the axes, where the data leave no room."""
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.18), "ncols": 3, "columnspacing": 1.0} if below else {}
    ax.legend(fontsize=9, frameon=False, markerscale=1.5, **place | more)


def unpowered(axis, values):
    """Numbers without powers of ten at a logarithmic axis; where values span less than two decades some between have theirs."""
    axis.set_major_formatter("{x:g}")
    narrow = max(values) < 100 * min(values)
    axis.set_minor_formatter(lambda x, _: f"{x:g}" if narrow and f"{x:e}"[0] in "25" else "")


def scaled(values, unit):
    """(factor, unit) in which values, arrays or numbers, are shown: millimetres below a metre."""
    largest = max((float(np.max(np.abs(part))) for part in values if np.size(part)), default=0.0)
    return SMALLER[unit] if unit in SMALLER and (largest < 1.0 or unit == "1") else (1.0, unit)


def axis_label(column, label=""):
    """The label of a column of a table of observations: "height_m" -> "height [m]"."""
    for ending, unit in (("_m_s", "m/s"), ("_m", "m"), ("_s", "s"), ("_kg", "kg"), ("_deg", "degrees")):
        if column.endswith(ending):
            return f"{words(column.removesuffix(ending))} [{unit}]"
    return LABELS.get(column, label or words(column))


def parts_of(pictures):
    """(what has a mark of its own, what one mark stands for) in the picture of what is missed by how much."""
    if "layer" in pictures.before:
        return "sets", "set of layers"
    return ("recordings", "recording and channel") if pictures.channels else ("groups", "group of rows that is left out together")


def name_groups(ax, table, pictures):
    """Whole numbers at the axis of the marks; groups of a table have their names there, and where the user gave none the values
    of the main input that they hold. The label of the axis, or None where it is what the marks stand for."""
    trials = np.unique(table["trial"])
    ax.xaxis.get_major_locator().set_params(integer=True)
    if parts_of(pictures)[0] != "groups" or len(trials) > MOST_NAMED:
        return None
    names = [pictures.trials[int(trial)] for trial in trials]
    unnamed = all(name.startswith("block ") for name in names)
    if unnamed:
        values = [table[pictures.over][table["trial"] == trial] for trial in trials]
        names = [" to ".join(dict.fromkeys(f"{end:.3g}" for end in (each.min(), each.max()))) for each in values]
    ax.set_xticks(trials + 1, [textwrap.fill(name, 8) for name in names], fontsize=8)
    return axis_label(pictures.label) if unnamed else None


def root_mean_square(values):
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else 0.0


def marks_of(table):
    """{channel: (mark, colour)} of a table of observations, the strongest colour where there is one channel alone."""
    channels = np.unique(table["channel"])
    return {channel: CHANNEL[int(channel) % len(CHANNEL) if len(channels) > 1 else 0] for channel in channels}


def residuals(ax, table, column, channels=(), lines=False):
    """Residuals in units of the noise over a column, each channel with a mark of its own; lines: join those of a recording."""
    values = np.asarray(table[column], float)
    ax.axhspan(-BAND, BAND, color=NOISE, alpha=0.35, lw=0)
    ax.axhline(0, color=INK, lw=LINE)
    for channel, (mark, colour) in marks_of(table).items():
        inside = table["channel"] == channel
        name = channels[int(channel)] if channels else None
        if lines:
            for trial in np.unique(table["trial"][inside]):
                its = inside & (table["trial"] == trial)
                ax.plot(values[its], table["sigmas"][its], "-", color=colour, lw=0.6, alpha=0.5)
        ax.plot(values[inside], table["sigmas"][inside], mark, color=colour, ms=3, mew=0, alpha=0.7, label=name)
    if np.ptp(values) < 1e-6:  # a body that slides on a level floor has one height, to rounding
        ax.set_xlim(values.mean() - 0.01, values.mean() + 0.01)


RESIDUAL = "measured - model\n[sigma of the noise]"


# --- comparisons ------------------------------------------------------------------------------------------------------------


def comparison_panels(comparison, ax=None):
    """Measured over model, and the residuals against time, height and speed; where effects were added, before and after them.

    Returns the four Axes.
    """
    axes = given_axes(ax, 2, 2, (11, 8))
    table, unit = comparison.table, comparison.error.get("unit") or ""
    if not table:
        return axes
    models = [(comparison, AFTER, ".")]
    if comparison.before:
        models.insert(0, (comparison.before, BEFORE, "x"))
    for one, colour, mark in models:
        measured, model = (one.table[name][_of_the_error(one)] for name in ("measured", "model"))
        label = None if not comparison.before else "before" if one is not comparison else "after"
        axes[0].plot(model, measured, mark, color=colour, ms=3, label=label)
    axes[0].plot([measured.min(), measured.max()], [measured.min(), measured.max()], "-", color=NOISE, lw=1, zorder=0)
    plain(axes[0], "Measured over model: on the line they agree", f"model [{unit}]", f"measured [{unit}]")
    if comparison.before:
        legend(axes[0])
    for panel, name in zip(axes[1:], comparison.against, strict=False):
        label = axis_label(name)
        wide = _residual_panel(panel, comparison, models, name, panel is axes[1])
        told = f" (logarithmic beyond {2 * BAND:g} sigma)" if wide else ""
        plain(panel, f"Residuals against {label.split(' [')[0].split(':')[0]}{told}", label, RESIDUAL)
    for panel in axes[1 + len(comparison.against) :]:
        panel.set_axis_off()
    axes[0].figure.suptitle(_title(comparison, unit), fontsize=12, x=0.01, ha="left", parse_math=False)
    return axes


def _residual_panel(panel, comparison, models, name, first):
    """Residuals of each model against one column; where what was there is far larger than what is left, the scale is logarithmic
    beyond the noise, so that both can be seen: True."""
    table = comparison.table
    if not comparison.before:
        channels = comparison.channels if len(np.unique(table["channel"])) > 1 else ()
        residuals(panel, table, name, channels)
        if channels and first:
            legend(panel, ncols=3)
        return False
    panel.axhspan(-BAND, BAND, color=NOISE, alpha=0.35, lw=0)
    for one, colour, mark in models:
        panel.plot(one.table[name], one.table["sigmas"], mark, color=colour, ms=3, alpha=0.6)
    if np.ptp(table[name]) < 1e-6:
        panel.set_xlim(np.mean(table[name]) - 0.01, np.mean(table[name]) + 0.01)
    wide = max(np.max(np.abs(one.table["sigmas"])) for one, *_ in models) > 10 * BAND
    if wide:
        panel.set_yscale("symlog", linthresh=2 * BAND)
        panel.yaxis.set_major_formatter("{x:g}")
    return wide


def _of_the_error(comparison):
    """Which observations have the unit of the error, boolean (n,): metres and radians are not one axis."""
    table = comparison.table
    if not comparison.channels:
        return np.ones(len(table["measured"]), bool)
    return have_unit(table["channel"], comparison.error.get("unit"))


def _title(comparison, unit):
    """What was compared, and its error beside the noise; where effects were added, before and after."""
    told = [size(row["error"], unit) for row in comparison.errors]
    if comparison.before:
        return f"{comparison.title}\n{change_told(comparison)}: error {told[0]} -> {told[1]}, noise {told[2]}"
    return f"{comparison.title}\nerror {told[0]}, noise {told[1]}; grey: two sigma of the noise; above zero the model is too low"
