"""The paper's Figs. 2 to 4, 6 to 8, 11, 13 and 14 in our own style, from our own runs. Figs. 9 and 12 are the pictures of
Tables 2 and 3; Figs. 1, 5 and 10 are a sketch and photographs.

Every function takes results and returns a matplotlib Figure. Lengths are in Dn; beyond every view stands a scale in metres.
"""

import numpy as np
from scipy.spatial import ConvexHull

from hlcs.placement import figures, playback
from hlcs.placement.grids import RPG, TPG
from hlcs.placement.plate_readings import plate_of
from minibullet.report import drawing

MARKED, PLATE = "#d11149", "#8fd3e8"  # colours of units that are lost or misplaced, and of plates
INK = "#333333"
LAYERS = ("black", "#d11149", "#1f8a43")  # of the grids of Fig. 13, as in the paper: black, red, green


def unit(one):
    """Fig. 2: the unit from the front with its lengths over the side L, and the unit as it lies on a flat bottom."""
    figure, (plan, view) = figures.canvas(10.0, 4.4, 2)
    side, height, base, top = one.side, one.protrusion_height, one.protrusion_base, one.protrusion_top
    for piece in one.pieces.pieces:
        corners = piece.vertices[:, [0, 2]] / side
        outline = corners[ConvexHull(corners).vertices]
        plan.fill(*outline.T, facecolor="#dfe6ee", edgecolor=INK, linewidth=1.0)
    reach = 0.5 + height
    dimension(plan, (-0.5, -reach - 0.12), (0.5, -reach - 0.12), "L")
    dimension(plan, (-reach, -reach - 0.30), (reach, -reach - 0.30), f"{2 * reach:g} L")
    dimension(plan, (-0.5 * base, 0.53), (0.5 * base, 0.53), f"{base:g} L", inside=True)
    dimension(plan, (-0.5 * top, reach + 0.07), (0.5 * top, reach + 0.07), f"{top:g} L")
    dimension(plan, (reach + 0.1, 0.5), (reach + 0.1, reach), f"{height:g} L")
    plan.set_aspect("equal")
    plan.set(xlim=(-1.0, 1.25), ylim=(-1.2, 1.05))
    plan.set_axis_off()
    plan.set_title(f"front view; L = {side:g} m, Dn = {one.nominal_diameter:.3f} m (reconstructed)", fontsize=10)
    lying = [(one.pieces, (0.0, 0.0, one.rest_height), one.first_layer_orientation(0.4), 0)]
    floor = (None, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), drawing.FLOOR_COLOUR)
    figures.picture_axes(view, [*lying, floor], f"at rest: {one.first_layer_coefficient:.3f} Dn high", elevation=14.0)
    return figure


def dimension(ax, start, end, words, inside=False):
    """A line with two arrow heads and its length in words."""
    ax.annotate("", end, start, arrowprops={"arrowstyle": "<->", "color": INK, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0})
    middle, across = 0.5 * np.add(start, end), abs(end[0] - start[0]) >= abs(end[1] - start[1])
    place = {"va": "top" if inside else "bottom", "ha": "center"} if across else {"va": "center", "ha": "left"}
    ax.text(*(middle + ((0, -0.02 if inside else 0.02) if across else (0.05, 0))), words, fontsize=9, color=INK, **place)


def grids(nominal_diameter):
    """Fig. 3: both grids with their spacings and hollows: where the first and the second layer are aimed at."""
    figure, axes = figures.canvas(10.5, 4.6, 2)
    for ax, grid in zip(axes, (RPG, TPG), strict=True):
        first, second = (grid.centres(4, 4, layer) for layer in (1, 2))
        ax.plot(*first.T, "o", color="#6a8caf", markersize=13, label="first layer")
        ax.plot(*second.T, "x", color="#b5651d", markersize=8, markeredgewidth=2, label="hollows: second layer")
        (x, y), left = first[0], first[:, 0].min() - 0.65
        dimension(ax, (x, y - 0.45), (x + grid.spacing_x, y - 0.45), f"a = {grid.spacing_x:g} Dn")
        dimension(ax, (left, y), (left, y + grid.spacing_y), f"b = {grid.spacing_y:g} Dn")
        scale(ax, nominal_diameter)
        ax.set_title(f"{grid.name}, packing density {grid.packing_density:.3f}", fontsize=10)
    axes[0].legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(0.0, -0.2), ncols=2)
    return figure


def scale(ax, nominal_diameter):
    """Axes in plan, in Dn, and how long a metre is there."""
    ax.set_aspect("equal")
    ax.margins(0.2)
    ax.set_xlabel(f"x [Dn], Dn = {nominal_diameter:.2f} m")
    ax.set_ylabel("y [Dn]")
    ax.spines[["top", "right"]].set_visible(False)


def measuring(result):
    """Fig. 4: the envelope of every layer as its plates read it, and the layer coefficients between them (Eq. 3)."""
    figure, (ax,) = figures.canvas(9.0, 4.6)
    figures.view_axes(ax, figures.unit_rows(result), "side", result.test.unit.nominal_diameter)
    left, right = ax.get_xlim()
    ax.set_xlim(left - 0.8, right + 1.4)
    below = 0.0
    for layer, (height, k) in enumerate(zip(result.heights, result.layer_coefficients, strict=True), start=1):
        if not np.isfinite(height):
            continue
        ax.axhline(height, color=INK, linewidth=0.8, linestyle="--")
        ax.text(left - 0.7, height + 0.05, f"h{layer} = {height:.3f} Dn", fontsize=8)
        if np.isfinite(k):
            dimension(ax, (right + 0.1, below), (right + 0.1, height), f"k{layer} = {k:.3f}")
        below = height
    ax.axhline(0.0, color=INK, linewidth=1.2)
    ax.set_title("mean height of the plates on each layer; a plane bottom at 0", fontsize=10)
    return figure


def before_and_after(fall):
    """Fig. 6: a layer as it hangs before it is let go, and at rest."""
    figure, axes = figures.canvas(11.0, 4.2, 2)
    for ax, poses, words in zip(axes, (fall.poses[0], fall.poses[-1]), ("before", "after"), strict=True):
        figures.picture_axes(ax, fall_rows(fall, poses), f"layer {fall.layer} {words} it is let go, {_name(fall.result)}")
    return figure


def fall_rows(fall, poses):
    """Drawing rows of a `playback.Fall`: the layers below at rest, its own units at these poses (n, 7)."""
    shape = fall.result.test.unit.shape(fall.result.test.shape)
    own = [(shape, pose[:3], pose[3:], fall.layer - 1) for pose in poses]
    return figures.unit_rows(fall.result, fall.layer - 1) + own


def falling_page(fall):
    """The text of a page that opens offline, with the layer as it falls and a slider for the time."""
    below = sum(len(poses) for poses in fall.result.poses[: fall.layer - 1])
    title = f"Layer {fall.layer} on {_name(fall.result)} as it falls"
    return drawing.page(fall_rows(fall, fall.poses[0]), title=title, motion=drawing.Motion(below, fall.times, fall.poses))


def falling(fall):
    """A layer as it falls, as the bytes of a GIF; it stands still for two seconds at the end."""
    images = drawing.moving_views([fall_rows(fall, poses) for poses in fall.poses])
    return drawing.gif_bytes(images, [*np.diff(fall.times[:-1]), 0.2, 2.0])


def front_and_side(result):
    """Fig. 7: the structure from the front and from the side."""
    figure, axes = figures.canvas(12.0, 4.2, 2)
    for ax, view in zip(axes, ("front", "side"), strict=True):
        figures.view_axes(ax, figures.unit_rows(result), view, result.test.unit.nominal_diameter, f"{view} view, {_name(result)}")
    return figure


def plates(result):
    """Fig. 8: the measuring plates on the third layer from above, and on the fourth."""
    figure, axes = figures.canvas(11.5, 4.8, 2)
    layers = [min(layer, len(result.poses)) for layer in (3, 4)]
    dn = result.test.unit.nominal_diameter
    figures.view_axes(axes[0], with_plates(result, layers[0]), "top", dn, f"plates on layer {layers[0]}")
    figures.picture_axes(axes[1], with_plates(result, layers[1]), f"plates on layer {layers[1]}", elevation=34.0)
    return figure


def with_plates(result, layer):
    """Drawing rows of a structure up to a layer (numbered from 1) with the plates that lie on it."""
    plate = plate_of(result.test.unit.nominal_diameter)
    laid = playback.lay_plates(result, layer)
    on_it = [pose for pose, height in zip(laid.poses, laid.heights, strict=True) if np.isfinite(height)]
    return figures.unit_rows(result, layer) + [(plate, pose[:3], pose[3:], PLATE) for pose in on_it]


def side_and_top(result):
    """Fig. 11: the structure on its slope from the side, and from above with the plates on its last layer."""
    figure, axes = figures.canvas(12.0, 4.8, 2)
    dn = result.test.unit.nominal_diameter
    figures.view_axes(axes[0], figures.unit_rows(result), "side", dn, f"side view, {_name(result)}")
    bed_line(axes[0], result)
    last = len(result.poses)
    figures.view_axes(axes[1], with_plates(result, last), "top", dn, f"top view, plates on layer {last}")
    return figure


def bed_line(ax, result):
    """The bottom through x = 0 in a side view."""
    dn, y = result.test.unit.nominal_diameter, np.array(ax.get_xlim())
    ax.plot(y, result.test.bottom.height(0.0 * y, y * dn) / dn, color=INK, linewidth=1.2)
    ax.set_xlim(y)


def blind_grids(nominal_diameter):
    """Fig. 13: the grids of the first three layers over each other, all from one unit of the first layer."""
    figure, (ax,) = figures.canvas(6.4, 5.0)
    for layer, (colour, marker) in enumerate(zip(LAYERS, "os^", strict=True), start=1):
        ax.plot(*TPG.centres(6, 6, layer).T, marker, color=colour, markersize=6, linestyle="none", label=f"layer {layer}")
    scale(ax, nominal_diameter)
    ax.legend(frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    ax.set_title("TPG: where three layers are aimed at, blind reference", fontsize=10)
    return figure


def marked(result):
    """Whether each unit is lost or misplaced, layer after layer (n,)."""
    return np.concatenate([far | ~inside for far, inside in zip(result.misplaced, result.in_layer, strict=True)])


def marked_rows(result):
    """Drawing rows of a structure with the units that are lost or misplaced in their own colour."""
    marks = marked(result)
    return [
        (shape, place, turn, MARKED if bad else layer)
        for (shape, place, turn, layer), bad in zip(figures.unit_rows(result), marks, strict=True)
    ]


def blind(result):
    """Fig. 14: a structure of blind reference from the side and from above, lost and misplaced units marked."""
    figure, axes = figures.canvas(12.0, 4.8, 2)
    rows, dn = marked_rows(result), result.test.unit.nominal_diameter
    count = int(marked(result).sum())
    title = f"{_name(result)}: {count} of {len(rows)} units marked"
    for ax, view in zip(axes, ("side", "top"), strict=True):
        figures.view_axes(ax, rows, view, dn, f"{view} view, {title}")
    bed_line(axes[0], result)
    return figure


def _name(result):
    """A test in a few words."""
    test = result.test
    slope = getattr(test.bottom, "grade", 0.0)
    return f"{test.grid.name}{f', slope {slope:.0%}' if slope else ''}{', blind' if test.reference == 'blind' else ''}"
