"""Pictures of placement tests: layer coefficients against the layer, the structure itself."""

import io

import numpy as np

from hlcs.placement import statistics
from hlcs.placement.sea_bottom import Survey
from hlcs.rendering import counted
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


def grid_axes(panels, ax=None):
    """One panel a grid side by side; panels: {title: [(label, Sample), ...]}; ax: as many Axes. Returns them, (n,)."""
    axes = panel_axes(ax, len(panels), (5.2 * len(panels), 4.2), sharey=True)
    for one, (title, samples) in zip(axes, panels.items(), strict=True):
        layer_axes(samples, one, title)
    for one in axes[1:]:
        one.set_ylabel("")
    return axes


PAPER_RANGE = 1.9, 7.6  # eps_R of the paper's Table 1, section 3.2.4 [%]


def tornado_axes(rows, parameters, base, ax=None):
    """eps_R of every parameter of Table 1 as a tornado plot, the widest range on top; returns the Axes, (1,).

    rows: dictionaries with parameter, value and error, error_low, error_high [-] (nan or None where no test left a structure:
    said so, no point); parameters: dictionaries with parameter, lowest, highest, matters; base: {parameter: its value in all
    other rows}. Bars reach from the lowest to the highest mean; points are the values, with 95 % intervals.
    """
    axes = panel_axes(ax, 1, (8, 0.8 * len(parameters) + 1.6))
    ax = axes[0]
    ax.axvspan(*PAPER_RANGE, color="#eeeae0", zorder=0, label="the paper's range, {:g} to {:g} %".format(*PAPER_RANGE))
    for place, of_one in enumerate(parameters):
        own = [row for row in rows if row["parameter"] == of_one["parameter"]]
        _tornado_row(ax, place, of_one, own, base[of_one["parameter"]])
    ax.set_yticks(range(len(parameters)), [_tornado_label(of_one) for of_one in parameters])
    ax.invert_yaxis()
    ax.set_xlim(left=0.0)
    ax.set_xlabel("mean relative error of a test, %   (beside each point its value, the calibrated one in bold)")
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, fontsize=9, loc="lower right", bbox_to_anchor=(1.0, 1.0))
    return axes


def _tornado_label(of_one):
    """Name of a parameter, and whether it matters."""
    verdict = "beyond the scatter" if of_one["matters"] else "within the scatter"
    return f"{of_one['parameter'].replace('_', ' ')}\n({verdict})"


def _tornado_row(ax, place, of_one, rows, base):
    """One parameter: the bar, its values in order from top to bottom, and those that left no structure in words."""
    low, high = (float("nan" if of_one[end] is None else of_one[end]) for end in ("lowest", "highest"))
    ax.barh(place, 100 * np.nan_to_num(high - low), left=100 * np.nan_to_num(low), height=0.8, color="#c9d8ea", zorder=1)
    heights = place + np.linspace(-0.3, 0.3, len(rows)) if len(rows) > 1 else [place]
    for height, row in zip(heights, rows, strict=True):
        numbers = [row[name] for name in ("error", "error_low", "error_high")]
        error, *ends = (100 * float("nan" if number is None else number) for number in numbers)
        if np.isnan(error):
            ax.text(0.0, height, f" {row['value']:g}: no structure", va="center", fontsize=7)
            continue
        reach = np.nan_to_num(np.abs(np.array(ends) - error))[:, None]
        ax.errorbar(error, height, xerr=reach, color=STYLES["model"][0], marker="o", markersize=3, linewidth=0.8)
        weight = "bold" if row["value"] == base else "normal"
        ax.annotate(f"{row['value']:g}", (error + reach[1, 0], height), (4, 0), textcoords="offset points",
                    va="center", fontsize=7, weight=weight)  # fmt: skip


def workability_axes(cases, ax=None):
    """Lost and misplaced units of a structure, in percent, over grid spacing and placement error; returns the two Axes.

    cases: dictionaries with spacing_x, spacing_y, placement_scatter, units and lost, misplaced: {"mean", "low", "high"}.
    """
    axes = panel_axes(ax, 2, (9.5, 4.0))
    spacings = sorted({(case["spacing_x"], case["spacing_y"]) for case in cases})
    scatters = sorted({case["placement_scatter"] for case in cases})
    for ax, name in zip(axes, ("lost", "misplaced"), strict=True):
        share = np.full((len(scatters), len(spacings)), np.nan)
        for case in cases:
            place = scatters.index(case["placement_scatter"]), spacings.index((case["spacing_x"], case["spacing_y"]))
            share[place], ends = (
                100.0 * np.array(case[name]["mean"]) / case["units"],
                [case[name][end] for end in ("low", "high")],
            )
            words = f"{share[place]:.1f} %"
            if all(end is not None and np.isfinite(end) for end in ends):
                words += "\n[{:.1f}, {:.1f}]".format(*(max(100.0 * end / case["units"], 0.0) for end in ends))
            ax.text(place[1], place[0], words, ha="center", va="center", fontsize=9)
        ax.imshow(share, cmap="YlOrRd", vmin=0.0, vmax=max(10.0, 1.6 * np.nanmax(share)), aspect="auto", origin="lower")
        ax.set_xticks(range(len(spacings)), [f"{x:.2f} x {y:.2f}" for x, y in spacings])
        ax.set_yticks(range(len(scatters)), [f"{scatter:g}" for scatter in scatters])
        ax.set(xlabel="grid spacing a x b [Dn]", ylabel="placement error, one sigma [Dn]", title=f"{name} units, blind reference")
    return axes


def panel_axes(ax, count, size, **settings):
    """The Axes that were given, or `count` side by side in a new figure of that size [inch]; (count,). InputError for another
    number of them."""
    axes = canvas(*size, count, **settings)[1] if ax is None else ax
    return counted(np.array(axes, dtype=object).reshape(-1), count)


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
