"""The picture of a design: the height of every option against its concrete."""

import numpy as np

from hlcs.placement.number_text import chance
from hlcs.placement.sea_bottom import Survey

COLOURS = ("#2f6db3", "#cf5a3c", "#5b8c4a", "#9683bf", "#8a6d3b", "#444444")  # one a grid

P = "P: probability to reach what is wanted"
LETTERS, ROOM = 8, 1.5  # size of the letters of a name, and what stays free round it [points]
MARKER, BAR = 5.0, 2.0  # half the width of a mark and of a bar [points]
NEAR, UP = 8.0, (0.0, 6.0, -6.0, 11.0, -11.0)  # of a name beside its mark, to the side and up [points]
PLACES = (  # of a name: to the right and up of its mark [points], and which of its sides is there
    *((side * NEAR, up, "left" if side > 0 else "right", "center") for up in UP for side in (1, -1)),
    (0.0, NEAR, "center", "bottom"),
)


def trade_off_axes(design, ax=None):
    """Height (or crest level) of every option against concrete per m2. The bar goes down to what is reached with the wanted
    probability: an option whose bar stays above the line reaches the target. Names for which there is no room are left out, the
    chosen one and those near the target last, and the picture says how many. Returns the Axes."""
    if ax is None:
        from matplotlib.figure import Figure

        ax = Figure(figsize=(9.0, 5.6), layout="constrained").add_subplot()
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
    ax.margins(x=0.24, y=0.12)  # of which names of the first and the last point stand
    ax.set_xlabel(f"concrete, m3 per m2 of plan\n{P}")
    what = "height above the bed" if wanted.crest is None else "crest level above datum"
    ax.set_ylabel(f"{what}, m; bar down to what {100 * wanted.probability:g} % reach")
    bed = "surveyed bed" if isinstance(wanted.bottom, Survey) else "flat bed" if not hasattr(wanted.bottom, "grade") else "slope"
    ax.set_title(f"Layers x size of unit on a {bed}; filled: reaches, star: least concrete", fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, fontsize=9, loc="lower right")
    order = sorted(shown, key=lambda entry: (entry[0] != design.chosen, abs(entry[1]["height_m"] - wanted.target)))
    unnamed = _name_points(ax, [(row, COLOURS[grids.index(row["grid"]) % len(COLOURS)]) for _, row in order], wanted.target)
    if unnamed:
        ax.set_xlabel(f"{ax.get_xlabel()}; {unnamed} of {len(shown)} points have no name for want of room")
    return ax


def _name_points(ax, points, line):
    """Layers, size and probability beside every point where they hide no other name, mark or bar, nor the line at height `line`,
    and are nearer to no other mark.

    points: (row, colour), the first one is named first. Returns how many found no room.
    """
    ax.figure.draw_without_rendering()  # from here on the Axes have their size
    taken, unnamed = _taken(ax, [row for row, _ in points], line), 0
    marks = ax.transData.transform([(row["concrete_m3_per_m2"], row["height_m"]) for row, _ in points])
    for (row, colour), mark in zip(points, marks, strict=True):
        words = f"{row['layers']} x {row['nominal_diameter_m']:g} m, P {chance(row['reaches'])} %"
        point = row["concrete_m3_per_m2"], row["height_m"]
        name = ax.annotate(words, point, (0.0, 0.0), textcoords="offset points", fontsize=LETTERS, color=colour)
        name.set_in_layout(False)  # no name moves the Axes
        if not any(_fits(ax, name, place, mark, marks, taken) for place in PLACES):
            name.remove()
            unnamed += 1
    return unnamed


def _fits(ax, name, place, mark, marks, taken):
    """Put a name at a place beside its mark [pixels]. Where it lies within the Axes, on nothing that is taken, and no other of
    the marks is as near, it takes its room: True."""
    right, up, horizontal, vertical = place
    name.set(position=(right, up), ha=horizontal, va=vertical)
    box = _extent(name)
    inside = ax.bbox.x0 <= box.x0 and box.x1 <= ax.bbox.x1 and ax.bbox.y0 <= box.y0 and box.y1 <= ax.bbox.y1
    if not inside or box.count_overlaps(taken) or np.sum(_distance(box, marks) <= _distance(box, mark)) > 1:
        return False
    taken.append(box)
    return True


def _distance(box, points):
    """Of points (.., 2) from a box [pixels]."""
    return np.linalg.norm(points - np.clip(points, box.min, box.max), axis=-1)


def _taken(ax, rows, line):
    """Boxes of what no name may hide: marks, bars, the line, the legend [pixels]."""
    from matplotlib.transforms import Bbox

    points = ax.figure.dpi / 72.0  # pixels of a point
    boxes = [ax.get_legend().get_window_extent()]
    level = ax.transData.transform((0.0, line))[1]
    boxes.append(Bbox([(ax.bbox.x0, level - points), (ax.bbox.x1, level + points)]))
    for row in rows:
        surely = row["height_m"] if row["height_at_probability_m"] is None else row["height_at_probability_m"]
        (x, y), (_, end) = ax.transData.transform([(row["concrete_m3_per_m2"], level) for level in (row["height_m"], surely)])
        boxes.append(Bbox([(x - MARKER * points, y - MARKER * points), (x + MARKER * points, y + MARKER * points)]))
        boxes.append(Bbox([(x - BAR * points, end), (x + BAR * points, y)]))
    return boxes


def _extent(name):
    """The box of the words of a name, with what stays free round it [pixels]."""
    from matplotlib.text import Text

    name.get_window_extent()  # puts the words where they belong; its own answer has the leader in it
    return Text.get_window_extent(name).padded(ROOM * name.figure.dpi / 72.0)
