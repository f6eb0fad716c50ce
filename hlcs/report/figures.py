"""Pictures of comparisons and diagnoses. Every plot takes `ax=None` and returns the Axes; nothing is shown or kept open."""

import numpy as np

from hlcs.records import Reason
from hlcs.report.words import number

LABELS = {
    "time": "time [s]",
    "height": "height [m]",
    "speed": "speed [m/s]",
    "layer": "layer",
    "input": "row: the layers, set after set",
}
INK, MEASURED, BEFORE, AFTER, NOISE = "#333333", "#444444", "#c44e52", "#2a7f9e", "#999999"


def _axes(ax, size=(11, 8)):
    """Four Axes: the given ones, or a new figure's (drawn without a window)."""
    if ax is not None:
        return np.asarray(ax).reshape(-1)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure.subplots(2, 2).reshape(-1)


def _plain(ax, title, x, y):
    ax.set_title(title, loc="left", fontsize=10, color=INK, parse_math=False)  # words of a file, no formula
    ax.set_xlabel(x, fontsize=9)
    ax.set_ylabel(y, fontsize=9)
    ax.tick_params(labelsize=8)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)


def diagnosis_panels(diagnosis, ax=None):
    """Fit, residuals, ranking, and the error falling step by step to the noise floor; returns the four Axes."""
    axes = _axes(ax)
    if diagnosis.pictures:
        fit_panel(axes[0], diagnosis)
        residual_panel(axes[1], diagnosis)
    ranking_panel(axes[2], diagnosis)
    error_panel(axes[3], diagnosis)
    found = f" ({', then '.join(diagnosis.effects)})" if diagnosis.effects else ""
    axes[0].figure.suptitle(f"{diagnosis.title}: {diagnosis.verdict}{found}", fontsize=12, x=0.01, ha="left", parse_math=False)
    return axes


def _worst(table):
    """Recording and channel with the largest misfit in sigma."""
    pairs = table["trial"] * 6 + table["channel"]
    names, index = np.unique(pairs, return_inverse=True)
    pair = names[np.argmax(np.bincount(index, table["sigmas"] ** 2) / np.bincount(index))]
    return int(pair // 6), int(pair % 6)


def fit_panel(ax, diagnosis):
    """Measured and modelled, before and after: of the channel of a trial where the model misses most, or of all rows."""
    pictures, where, unit = diagnosis.pictures, "all rows", diagnosis.error.get("unit") or ""
    before, after = pictures.before, pictures.after
    inside = np.argsort(before[pictures.over], kind="stable")
    if pictures.channels:
        trial, channel = _worst(before)
        inside = np.flatnonzero((before["trial"] == trial) & (before["channel"] == channel))
        where, unit = f"{pictures.trials[trial]}, {pictures.channels[channel]}", pictures.units[channel]
    x = before[pictures.over][inside]
    ax.plot(x, before["measured"][inside], ".", color=MEASURED, ms=4, label="measured")
    ax.plot(x, before["model"][inside], "-", color=BEFORE, lw=1.2, label="model before")
    ax.plot(x, after["model"][inside], "-", color=AFTER, lw=1.2, label="model after")
    ax.legend(fontsize=8, frameon=False)
    _plain(ax, f"Fit where it missed most: {where}", pictures.label, f"[{unit}]")


def residual_panel(ax, diagnosis):
    """All residuals in units of the noise, before and after."""
    pictures = diagnosis.pictures
    for table, colour, text in ((pictures.before, BEFORE, "before"), (pictures.after, AFTER, "after")):
        ax.plot(table[pictures.over], table["sigmas"], ".", color=colour, ms=3, alpha=0.5, label=text)
    ax.axhspan(-2, 2, color=NOISE, alpha=0.2, lw=0)
    ax.legend(fontsize=8, frameon=False)
    _plain(ax, "Residuals (grey: two sigma of the noise)", pictures.label, "measured - model [sigma]")


def ranking_panel(ax, diagnosis, most=10):
    """Evidence of the candidates, on a logarithmic scale where it spans more than a decade; accepted ones in colour."""
    found = [entry for entry in diagnosis.candidates if entry.evidence is not None][:most][::-1]
    values = [max(entry.evidence, 0.5) for entry in found]
    colours = [AFTER if entry.accepted else BEFORE if entry.reason is Reason.SUSPECTED else NOISE for entry in found]
    ax.barh(range(len(found)), values, color=colours)
    ax.set_yticks(range(len(found)), [entry.effect for entry in found], fontsize=8)
    if found and max(values) > 10 * min(values):
        ax.set_xscale("log")
    _plain(ax, "Candidates (blue accepted, red suspected)", "evidence: fall of chi2 - p log n", "")


def error_panel(ax, diagnosis):
    """The error after each accepted effect, down to the noise."""
    steps = [step for step in diagnosis.steps if step.get("held_out") is not None or step.get("fitted") is not None]
    names, known = ["as it is"], set()
    for step in steps[1:]:  # what is new in each step, a line each
        names.append("\n".join(f"+ {effect}" for effect in step["effects"] if effect not in known))
        known.update(step["effects"])
    for key, colour in (("fitted", NOISE), ("held_out", AFTER)):
        values = [step.get(key) for step in steps]
        if values and all(value is not None for value in values):
            ax.plot(range(len(values)), values, "o-", color=colour, label=key.replace("_", " "))
    entry = diagnosis.error.get("held_out") or diagnosis.error.get("fitted")
    if entry and entry.get("noise"):
        ax.axhline(entry["noise"], color=INK, ls=":", lw=1, label="noise")
    ax.set_xticks(range(len(names[: len(steps)])), names[: len(steps)], fontsize=8)
    ax.set_xlim(-0.4, max(len(steps) - 0.6, 0.6))
    ax.set_ylim(bottom=0)
    if ax.lines:
        ax.legend(fontsize=8, frameon=False)
    _plain(ax, "The error falling", "", f"rms error [{diagnosis.error.get('unit') or ''}]")


def comparison_panels(comparison, ax=None):
    """Measured over model, and the residuals against time, height and speed; where effects were added, before and after them.

    Returns the four Axes.
    """
    axes = _axes(ax)
    table, unit = comparison.table, comparison.error.get("unit") or ""
    if not table:
        return axes
    models = [(comparison, AFTER, AFTER if comparison.before else BEFORE)]  # with the colours over the model and of the residuals
    if comparison.before:
        models.insert(0, (comparison.before, BEFORE, BEFORE))
    for one, colour, _ in models:
        measured, model = (one.table[name][_of_the_error(one)] for name in ("measured", "model"))
        axes[0].plot(model, measured, ".", color=colour, ms=3)
    axes[0].plot([measured.min(), measured.max()], [measured.min(), measured.max()], "-", color=NOISE, lw=1, zorder=0)
    _plain(axes[0], "Measured over model", f"model [{unit}]", f"measured [{unit}]")
    for panel, name in zip(axes[1:], comparison.against, strict=False):
        values, label = np.asarray(table[name]), LABELS.get(name, name)
        panel.axhspan(-2, 2, color=NOISE, alpha=0.2, lw=0)
        for one, _, colour in models:
            panel.plot(one.table[name], one.table["sigmas"], ".", color=colour, ms=3, alpha=0.6)
        if np.ptp(values) < 1e-6:  # a body that slides on a level floor has one height, to rounding
            panel.set_xlim(values.mean() - 0.01, values.mean() + 0.01)
        _plain(panel, f"Residuals against {label.split(' [')[0].split(':')[0]}", label, "measured - model [sigma]")
    for panel in axes[1 + len(comparison.against) :]:
        panel.set_axis_off()
    axes[0].figure.suptitle(_title(comparison, unit), fontsize=12, x=0.01, ha="left", parse_math=False)
    return axes


def _of_the_error(comparison):
    """Which observations have the unit of the error, boolean (n,): metres and radians are not one axis."""
    table = comparison.table
    return table["channel"] < 3 if comparison.error.get("unit") == "m" else np.ones(len(table["measured"]), bool)


def _title(comparison, unit):
    """What was compared and, where effects were added, the error before and after beside the noise."""
    if not comparison.before:
        return comparison.title
    before, after, noise = (number(row["error"], unit) for row in comparison.errors)
    return f"{comparison.title}\n{', '.join(comparison.added)} added: error {before} (red) -> {after} (blue), noise {noise}"
