"""Pictures of placement tests: layer coefficients against the layer, the structure itself."""

import io

import numpy as np

from hlcs.placement import statistics
from hlcs.placement.sea_bottom import Survey
from minibullet import rotations
from minibullet.report import drawing

# by the first of these words in a label
STYLES = {
    "laboratory": ("#222222", "s"),
    "measured": ("#222222", "s"),
    "paper": ("#8a8a8a", "D"),
    "hull": ("#cf5a3c", "^"),
    "pieces": ("#2f6db3", "o"),
    "model": ("#2f6db3", "o"),
}
# of further series that the same word names
OTHER_STYLES = (("#cf8f2f", "v"), ("#3c8f63", "P"), ("#8a63b0", "X"), ("#2d9aa6", "<"), ("#b0476d", ">"))


# of a view the eye's azimuth and elevation [degrees], and what is to the right and upwards
VIEWS = {"front": ((-90.0, 0.0), "xz"), "side": ((0.0, 0.0), "yz"), "top": ((-90.0, 90.0), "xy")}


def layer_axes(samples, ax=None, title=None):
    """Layer coefficients against the layer; samples: (label, Sample) pairs. Bars: 95 % interval of the mean. Returns the Axes."""
    if ax is None:
        from matplotlib.figure import Figure

        ax = Figure(figsize=(6, 4), layout="constrained").add_subplot()
    spread = np.linspace(-0.12, 0.12, len(samples)) if len(samples) > 1 else [0.0]
    styles = _styles([label for label, _ in samples])
    for (label, sample), shift, (colour, marker) in zip(samples, spread, styles, strict=True):
        line = "none" if "laboratory" in label or "measured" in label else "-"
        layers = np.arange(1, len(sample.mean) + 1)
        half = _half_interval(sample)
        ax.errorbar(
            layers + shift,
            sample.mean,
            yerr=half,
            label=label,
            color=colour,
            marker=marker,
            markersize=5,
            linestyle=line,
            linewidth=1,
            capsize=2.5,
        )
    ax.set_xticks(np.arange(1, max(len(sample.mean) for _, sample in samples) + 1))
    ax.set_xlabel("layer")
    ax.set_ylabel("layer coefficient k = thickness / Dn")
    if title:
        ax.set_title(title, fontsize=11)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, fontsize=9)
    return ax


def _styles(labels):
    """A (colour, marker) for each label, no two the same: by the first word known, then the others in their order."""
    found, others = [], iter(OTHER_STYLES)
    for label in labels:
        own = next((style for word, style in STYLES.items() if word in label), None)
        found.append(own if own and own not in found else next(others))
    return found


def _half_interval(sample):
    """Half the 95 % interval of each mean (M,), nan for a layer of unknown scatter; None where it is known of none."""
    mean, cv, tests = (np.broadcast_to(np.asarray(part, dtype=float), np.shape(sample.mean)) for part in sample)
    known = (mean > 0.0) & (cv >= 0.0) & (tests >= 2)
    if not known.any():
        return None
    half = np.full(mean.shape, np.nan)
    half[known] = mean[known] - statistics.confidence_interval(statistics.Sample(mean[known], cv[known], tests[known]))[0]
    return half


def grid_figure(panels):
    """One panel a grid side by side; panels: {title: [(label, Sample), ...]}. Returns the Figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2 * len(panels), 4.2), layout="constrained")
    axes = np.atleast_1d(figure.subplots(1, len(panels), sharey=True))
    for ax, (title, samples) in zip(axes, panels.items(), strict=True):
        layer_axes(samples, ax, title)
    for ax in axes[1:]:
        ax.set_ylabel("")
    return figure


def sensitivity_figure(rows):
    """eps_R of every parameter value of Table 1 as bars; returns the Figure.

    rows: dictionaries with parameter, value, mean_relative_error (nan where no test left a structure: said so, no bar).
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 0.28 * len(rows) + 1.2), layout="constrained")
    ax = figure.add_subplot()
    names = [f"{row['parameter'].replace('_', ' ')} = {row['value']:g}" for row in rows]
    errors = np.array([row["mean_relative_error"] for row in rows], dtype=float)  # None, as JSON has it, is nan
    ax.barh(names, 100 * np.nan_to_num(errors), color=STYLES["model"][0], height=0.6)
    for place in np.flatnonzero(np.isnan(errors)):
        ax.text(0.0, place, " no structure", va="center", fontsize=9)
    ax.axvspan(1.9, 7.6, color="#eeeae0", zorder=0, label="the paper's range, 1.9 to 7.6 %")
    ax.invert_yaxis()
    ax.set_xlabel("mean relative error of three layers, %")
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, fontsize=9)
    return figure


def canvas(width, height, columns=1, **settings):
    """(Figure, list of Axes side by side); sizes in inches, settings as for `Figure.subplots`."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = np.atleast_1d(figure.subplots(1, columns, **settings))
    return figure, list(axes)


def view_axes(ax, rows, view, nominal_diameter, title=None, width=1000):
    """A view without perspective of drawing rows onto Axes with scales in Dn and, beyond them, in metres; returns the Axes.

    view: "front" (along y), "side" (along x) or "top"; nominal_diameter: Dn [m].
    """
    (azimuth, elevation), (right, up) = VIEWS[view]
    image, extent = drawing.parallel_view(rows, azimuth, elevation, width=width)
    ax.imshow(image, extent=np.divide(extent, nominal_diameter), interpolation="lanczos", aspect="equal")
    ax.set_xlabel(f"{right} [Dn]")
    ax.set_ylabel(f"{up} [Dn]")
    for edge, add, label in (("top", ax.secondary_xaxis, "set_xlabel"), ("right", ax.secondary_yaxis, "set_ylabel")):
        scale = add(edge, functions=(lambda dn: dn * nominal_diameter, lambda metres: metres / nominal_diameter))
        getattr(scale, label)("m", fontsize=8)
        scale.tick_params(labelsize=8)
    if title:
        ax.set_title(title, fontsize=10)
    return ax


def picture_axes(ax, rows, title=None, azimuth=-60.0, elevation=28.0):
    """A view with perspective of drawing rows onto Axes; returns the Axes."""
    drawing.draw_scene(rows, ax=ax, azimuth=azimuth, elevation=elevation, width=900, height=640)
    if title:
        ax.set_title(title, fontsize=10)
    return ax


def gif_bytes(images, seconds):
    """An endless GIF of images (f, height, width, 4) from 0 to 1, on white; seconds (f,): how long each stands."""
    from PIL import Image

    frames = []
    for image in images:
        solid = image[..., :3] * image[..., 3:] + (1.0 - image[..., 3:])
        frames.append(Image.fromarray(np.round(255.0 * np.clip(solid, 0.0, 1.0)).astype(np.uint8)).quantize(48))
    buffer, last = io.BytesIO(), [max(20, round(1000.0 * one)) for one in seconds]
    frames[0].save(buffer, format="GIF", save_all=True, append_images=frames[1:], duration=last, loop=0, optimize=True)
    return buffer.getvalue()


def png_bytes(figure, dpi=150, tight=False):
    """The Figure as the bytes of a PNG file; tight: as large as what is drawn, such as scales beyond the Axes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None}, bbox_inches="tight" if tight else None)
    return buffer.getvalue()


def unit_rows(result, layers=None):
    """Drawing rows of the units of the first `layers` layers, all where left out, each in the colour of its layer."""
    shape = result.test.unit.shape(result.test.shape)
    return [(shape, pose[:3], pose[3:], layer) for layer, poses in enumerate(result.poses[:layers]) for pose in poses]


def scene_of(result):
    """What `minibullet.report.drawing` draws: every unit in the colour of its layer, and the bottom."""
    test, rows = result.test, unit_rows(result)
    bed = test.bed
    if isinstance(bed, Survey):
        level = (1.0, 0.0, 0.0, 0.0)
        return rows + [(piece, piece.centre_of_mass, level, drawing.FLOOR_COLOUR) for piece in bed.prisms]
    turned = rotations.between(np.array([0.0, 0.0, 1.0]), np.asarray(bed.normal(0.0, 0.0), dtype=float))
    return [*rows, (None, (0.0, 0.0, float(bed.height(0.0, 0.0))), turned, drawing.FLOOR_COLOUR)]
