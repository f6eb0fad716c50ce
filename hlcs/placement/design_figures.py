"""The picture of a design: the height of every option against its concrete."""

import numpy as np

from hlcs.placement.number_text import chance
from hlcs.placement.sea_bottom import Survey

COLOURS = ("#2f6db3", "#cf5a3c", "#5b8c4a", "#9683bf", "#8a6d3b", "#444444")  # one a grid

LABEL, LINE, AWAY = 0.17, 0.03, 0.015  # width and height of a label, its distance from its point, as parts of the Axes


def trade_off_axes(design, ax=None):
    """Height (or crest level) of every option against concrete per m2. The bar goes down to what is reached with the wanted
    probability: an option whose bar stays above the line reaches the target. Returns the Axes."""
    if ax is None:
        from matplotlib.figure import Figure

        ax = Figure(figsize=(7.5, 4.8), layout="constrained").add_subplot()
    wanted, rows = design.wanted, [option.to_dict() for option in design.options]
    grids = list(dict.fromkeys(row["grid"] for row in rows))
    shown = [(number, row) for number, row in enumerate(rows) if row["height_m"] is not None]
    for number, row in shown:
        colour, x, y = COLOURS[grids.index(row["grid"]) % len(COLOURS)], row["concrete_m3_per_m2"], row["height_m"]
        surely = y if row["height_at_probability_m"] is None else row["height_at_probability_m"]
        good = row["reaches"] >= wanted.probability
        ax.plot([x, x], [surely, y], color=colour, linewidth=1.5)
        ax.plot([x], [surely], color=colour, marker="_", markersize=10)
        marker, size = ("*", 12) if number == design.chosen else ("o", 7)
        ax.plot([x], [y], color=colour, marker=marker, markersize=size, markerfacecolor=colour if good else "white")
    for number, grid in enumerate(grids):
        ax.plot([], [], marker="o", linestyle="none", color=COLOURS[number % len(COLOURS)], label=grid)
    ax.axhline(wanted.target, color="#222222", linewidth=1, linestyle="--", label=f"wanted: {wanted.target:g} m")
    ax.margins(x=0.2, y=0.12)
    ax.set_xlabel("concrete, m3 per m2 of plan")
    what = "height above the bed" if wanted.crest is None else "crest level above datum"
    ax.set_ylabel(f"{what}, m; bar down to what {100 * wanted.probability:g} % reach")
    bed = "surveyed bed" if isinstance(wanted.bottom, Survey) else "flat bed" if not hasattr(wanted.bottom, "grade") else "slope"
    ax.set_title(f"Layers x size of unit on a {bed}; filled: reaches, star: least concrete", fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, fontsize=9, loc="lower right")
    _label(ax, [row for _, row in shown], [COLOURS[grids.index(row["grid"]) % len(COLOURS)] for _, row in shown], wanted.target)
    return ax


def _label(ax, rows, colours, line):
    """Layers, size and probability beside every point, off other labels, points and the line at height `line`, if possible."""
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    places = [((row["concrete_m3_per_m2"] - left) / (right - left), (row["height_m"] - bottom) / (top - bottom)) for row in rows]
    taken = [(x - 0.01, x + 0.01, y) for x, y in places] + [(0.0, 1.0, (line - bottom) / (top - bottom))]
    for row, (x, y), colour in zip(rows, places, colours, strict=True):
        spots = [(x + away, y + rise) for rise in LINE * np.array([0, 1, -1, 2, -2]) for away in (AWAY, -AWAY - LABEL)]
        start, level = next((spot for spot in spots if _free(spot, taken)), spots[0])
        taken.append((start, start + LABEL, level))
        words = f"{row['layers']} x {row['nominal_diameter_m']:g} m, P {chance(row['reaches'])} %"
        side, at = ("left", start) if start > x else ("right", start + LABEL)
        ax.text(at, level, words, transform=ax.transAxes, ha=side, va="center", fontsize=8, color=colour)


def _free(spot, taken):
    """Whether a label that begins there lies within the Axes and on nothing else."""
    start, level = spot
    inside = start >= 0.0 and start + LABEL <= 1.0
    return inside and not any(start < end and begin < start + LABEL and abs(level - other) < LINE for begin, end, other in taken)
