"""The pictures of a Diagnosis: each a function that takes `ax=None` and returns Axes, one message in each, told by its title."""

import textwrap

import numpy as np

from hlcs.data.quantities import CHANNELS
from hlcs.report import learned
from hlcs.report.figures import (
    AFTER,
    BEFORE,
    INK,
    LINE,
    NOISE,
    RESIDUAL,
    SIZE,
    axis_label,
    given_axes,
    legend,
    letters_beside,
    marks_of,
    name_groups,
    parts_of,
    plain,
    residuals,
    root_mean_square,
    scaled,
    unpowered,
)
from hlcs.report.leftover import ALIKE, neighbours, spectrum, turns_missed
from hlcs.report.ranking import left_by_base, ranking, ranking_caption, ranking_title
from hlcs.report.sentences import NEAR_NOISE, error_of, foretold_worse
from hlcs.report.words import capital, joined, size, words

TALL = (4.5, 5.0)  # of two panels, one above the other [inch]
HEADROOM = 0.1  # of an axis, above what is largest in it
WIDEST = 16  # letters of a name below an axis
SEEN = 0.01  # of the height of a panel, from which a band in it can be seen
ROUNDING = 1e-3  # of a column, up to which its changes are none
NAMED = 27  # room for the names of sets, in two lines, between panel and title [points]


def diagnosis_panels(diagnosis, ax=None):
    """Fit, what is left, what remains with each candidate, and the error falling to the noise; returns the four Axes."""
    axes = given_axes(ax, 2, 2, (11, 8))
    if diagnosis.pictures:
        fit_panel(diagnosis, axes[0])
        left_panel(diagnosis, diagnosis.pictures.over, axes[1])
    ranking_panel(diagnosis, axes[2])
    error_panel(diagnosis, axes[3])
    found = f" ({joined(diagnosis.effects)})" if diagnosis.effects else ""
    axes[0].figure.suptitle(f"{diagnosis.title}: {diagnosis.verdict}{found}", fontsize=12, x=0.01, ha="left", parse_math=False)
    return axes


def pictures(diagnosis):
    """{name: (Axes, caption)} of all pictures that have something to show, each a figure of its own."""
    found = {}
    if diagnosis.pictures:
        shown = "The recording that the model missed most." if diagnosis.pictures.channels else "All rows of the table."
        found["fit"] = fit_panel(diagnosis), shown + _FITTED * bool(diagnosis.effects)
    if diagnosis.steps:
        told = _ERROR + _TURNS * bool(turns_missed(diagnosis.pictures)) + _STARTS * bool(_starts_can_be_seen(diagnosis))
        found["error"] = error_panel(diagnosis), told
    if diagnosis.learned is not None:
        found["law"] = np.atleast_1d(learned.plot(diagnosis.learned)), learned.caption(diagnosis.learned)
    if ranking(diagnosis):
        found["ranking"] = ranking_panel(diagnosis), ranking_caption(ranking(diagnosis))
    if diagnosis.pictures:
        for column in against(diagnosis.pictures):
            caption = _RESIDUALS + (_OWN_SCALE if diagnosis.effects else "")
            found[f"residuals_{column}"] = residual_panels(diagnosis, column), caption
        if len(np.unique(diagnosis.pictures.before["trial"])) > 1:
            caption = f"One mark for each {parts_of(diagnosis.pictures)[1]}. 1 is noise alone."
            found["residuals_by_recording"] = recording_panels(diagnosis), caption
        left = spectrum(diagnosis.pictures.after)
        if left and left.hides_a_period:
            found["spectrum"] = spectrum_panel(diagnosis), "What is left, split into frequencies. White noise would lie near 1."
    return found


_FITTED = " The numbers were fitted to all that was measured, this as well."
_ERROR = "Dotted: the noise."
_STARTS = " Hatched: the share of it that the fitted starts take up; a perfect model would end at its lower edge."
_TURNS = " Of positions alone: what goes wrong in rotations stands in the pictures of what is left."
_RESIDUALS = "Above zero the model is too low. Grey: two sigma of the noise."
_OWN_SCALE = " The lower panel has a scale of its own."


def against(pictures):
    """The columns that residuals are drawn against: those that vary, as the height of what slides on a level floor does not."""
    known = {name: pictures.before[name] for name in ("time", "height", "speed") if name in pictures.before}
    return [name for name, each in known.items() if np.ptp(each) > ROUNDING * np.max(np.abs(each))] or [pictures.over]


# --- measured and modelled --------------------------------------------------------------------------------------------------


def fit_panel(diagnosis, ax=None):
    """Measured and modelled, before and after: of the channel of a recording where the model misses most, or of all rows."""
    axes = given_axes(ax)
    pictures = diagnosis.pictures
    if pictures.channels:
        _fit_of_recording(axes[0], diagnosis)
    else:
        _fit_of_table(axes[0], diagnosis)
    return axes


def _fit_of_recording(ax, diagnosis):
    pictures = diagnosis.pictures
    before, after = pictures.before, pictures.after
    trial, channel = _worst(before)
    inside = (before["trial"] == trial) & (before["channel"] == channel)
    unit, x = pictures.units[channel], before[pictures.over][inside]
    ax.plot(x, before["measured"][inside], ".", color=INK, ms=5, label="measured")
    line = _unjoined(before["model"][inside], unit)
    ax.plot(x, line, "--", color=BEFORE, lw=1.6, label="model as it is")
    told = f"missed by {size(_largest(before, inside), unit)} at most"
    if diagnosis.effects:
        ax.plot(x, _unjoined(after["model"][inside], unit), "-", color=AFTER, lw=1.6, label="with what was found")
        told += f", now by {size(_largest(after, inside), unit)}"
    legend(ax, below=bool(np.isnan(line).any()))  # an angle that goes round fills its panel
    plain(ax, f"{pictures.trials[trial]}: {told}", pictures.label, f"{_spelled(pictures.channels[channel])} [{unit}]")


def _spelled(channel):
    """A channel as an axis tells it."""
    return f"rotation about {channel[1:]}" if channel in CHANNELS[3:6] else channel


def _unjoined(values, unit):
    """Angles with a gap where they jump by a turn, so that no line is drawn there; else the values themselves."""
    if unit != "rad":
        return values
    return np.where(np.abs(np.diff(values, prepend=values[:1])) > np.pi, np.nan, values)


def _largest(table, inside):
    return float(np.max(np.abs(table["residual"][inside])))


def _worst(table):
    """Recording and channel with the largest misfit in sigma."""
    pairs = table["trial"] * len(CHANNELS) + table["channel"]
    names, index = np.unique(pairs, return_inverse=True)
    pair = names[np.argmax(np.bincount(index, table["sigmas"] ** 2) / np.bincount(index))]
    trial, channel = divmod(int(pair), len(CHANNELS))
    return trial, channel


def _fit_of_table(ax, diagnosis):
    """Marks alone where rows are experiments of their own; of layers a line through those of one set, never from set to set."""
    pictures = diagnosis.pictures
    before, after, layers = pictures.before, pictures.after, "layer" in pictures.before
    styles = [("measured", before, "measured", ".", INK), ("model as it is", before, "model", "s", BEFORE)]
    if diagnosis.effects:
        styles.append(("with what was found", after, "model", "^", AFTER))
    for name, table, column, mark, colour in styles:
        hollow = {} if column == "measured" else {"mfc": "none"}
        if not layers:
            ax.plot(table[pictures.over], table[column], mark, color=colour, ms=6, label=name, **hollow)
            continue
        for first, inside in enumerate(sets_of(table)):
            label = name if not first else None
            ax.plot(
                table[pictures.over][inside], table[column][inside], f"{mark}-", color=colour, lw=1, ms=6, label=label, **hollow
            )
    if layers:
        _name_sets(ax, before, pictures)
    legend(ax, below=layers)
    unit = diagnosis.error.get("unit") or ""
    outcome = axis_label(diagnosis.where[0]["channel"]) if diagnosis.where and "channel" in diagnosis.where[0] else f"[{unit}]"
    told = f"{'layer coefficients' if layers else 'all rows'}: fitted error {_fall(diagnosis)}"
    y, pad = ("layer coefficient [Dn]", NAMED) if layers else (outcome, None)
    plain(ax, capital(told), _label(pictures, pictures.over), y, pad)


def _fall(diagnosis):
    """The fitted error before and after, in words."""
    error, unit = diagnosis.error.get("fitted"), diagnosis.error.get("unit", "")
    if not error:
        return "unknown"
    return f"{size(error['before'], unit)}" + (f" -> {size(error['after'], unit)}" if diagnosis.effects else "")


def sets_of(table):
    """Where each set of layers stands in a table, list of index arrays."""
    return [np.flatnonzero(table["trial"] == trial) for trial in np.unique(table["trial"])]


def _name_sets(ax, table, pictures):
    """Numbers of the layers at the axis, and the name of each set above its own."""
    ax.set_xticks(table[pictures.over], [str(layer) for layer in table["layer"]])
    for inside in sets_of(table):
        middle = float(np.mean(table[pictures.over][inside]))
        name = pictures.trials[int(table["trial"][inside[0]])].replace(", ", "\n")  # grid and campaign: in one line they touch
        ax.annotate(name, (middle, 1.0), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=8)
        if inside[0]:
            ax.axvline(table[pictures.over][inside[0]] - 0.5, color=NOISE, lw=LINE)


# --- residuals --------------------------------------------------------------------------------------------------------------


def residual_panels(diagnosis, column, ax=None):
    """Residuals before and, at a scale of its own, what is left, against one column; two Axes, or one where nothing was found."""
    axes = given_axes(ax, 2, 1, TALL) if diagnosis.effects else given_axes(ax)
    label = _label(diagnosis.pictures, column)
    name = label.split(" [")[0].split(":")[0]
    tables = [("before", diagnosis.pictures.before), ("after", diagnosis.pictures.after)]
    for ax, (when, table) in zip(axes, tables, strict=False):
        _residuals(ax, diagnosis, table, column)
        told = f"{when.capitalize()}: " if diagnosis.effects else ""
        told += f"{root_mean_square(table['sigmas']):.2g} sigma, against {name}"
        plain(ax, told, label, RESIDUAL, NAMED if "layer" in table else None)
    if len(np.unique(diagnosis.pictures.before["channel"])) > 1:
        legend(axes[0], ncols=3)
    return axes


def left_panel(diagnosis, column, ax=None):
    """What is left after what was found, against one column; one Axes."""
    axes = given_axes(ax)
    pictures = diagnosis.pictures
    _residuals(axes[0], diagnosis, pictures.after, column)
    if len(np.unique(pictures.after["channel"])) > 1:
        legend(axes[0], ncols=3)
    now, then = (root_mean_square(table["sigmas"]) for table in (pictures.after, pictures.before))
    told = f"What is left: {now:.2g} sigma" + (f" ({then:.2g} before)" if diagnosis.effects else "")
    plain(axes[0], told, _label(pictures, column), RESIDUAL, NAMED if "layer" in pictures.after else None)
    return axes


def _label(pictures, column):
    """Label of the axis that residuals are drawn over."""
    return "layer" if "layer" in pictures.before else axis_label(pictures.label if column == pictures.over else column)


def _residuals(ax, diagnosis, table, column):
    pictures = diagnosis.pictures
    channels = pictures.channels if len(np.unique(table["channel"])) > 1 else ()
    joined_up = "layer" in table or column == "time" and neighbours(table) > ALIKE  # of noise alone lines show nothing
    residuals(ax, table, column, channels, lines=joined_up)
    if "layer" in table:
        _name_sets(ax, table, pictures)


def recording_panels(diagnosis, ax=None):
    """Misfit of each recording and channel, before and after at a scale of its own; two Axes, one where nothing was found."""
    axes = given_axes(ax, 2, 1, TALL) if diagnosis.effects else given_axes(ax)
    pictures = diagnosis.pictures
    for ax, (when, table) in zip(axes, [("Before", pictures.before), ("After", pictures.after)], strict=False):
        for channel, (mark, colour) in marks_of(table).items():
            trials = np.unique(table["trial"])
            size_of = [root_mean_square(table["sigmas"][(table["trial"] == k) & (table["channel"] == channel)]) for k in trials]
            label = pictures.channels[int(channel)] if pictures.channels else None
            ax.plot(trials + 1, size_of, mark, color=colour, ms=5, alpha=0.8, label=label)
        ax.axhline(1.0, color=INK, ls=":", lw=LINE)
        _from_zero(ax, max([1.0, *(max(line.get_ydata()) for line in ax.lines)]))
        what = parts_of(pictures)[0]
        told = f"{when + ': ' if diagnosis.effects else ''}how far the {what} are missed"
        plain(ax, capital(told), name_groups(ax, table, pictures) or what[:-1], "rms [sigma of the noise]")
    if len(np.unique(pictures.before["channel"])) > 1:
        legend(axes[0], ncols=3)
    return axes


def _from_zero(ax, largest):
    """The upright axis from zero on, with room above the largest value, whose mark would be cut at the edge."""
    ax.set_ylim(0, (1 + HEADROOM) * largest if largest else 1.0)


def spectrum_panel(diagnosis, ax=None):
    """The periodogram of what is left, its peak marked; one Axes."""
    axes = given_axes(ax)
    found = spectrum(diagnosis.pictures.after)
    channel = diagnosis.pictures.channels[found.channel]
    axes[0].plot(found.frequency, found.power, "-", color=AFTER, lw=1.2)
    axes[0].axhline(1.0, color=INK, ls=":", lw=LINE, label="white noise")
    axes[0].plot([found.peak], [found.power.max()], "v", color=BEFORE, ms=8)
    legend(axes[0])
    told = f"What is left swings in {channel}: {found.peak:.2g} Hz, a period of {1 / found.peak:.2g} s"
    plain(axes[0], told, "frequency [Hz]", "power [that of white noise]")
    return axes


# --- ranking and error ------------------------------------------------------------------------------------------------------


def ranking_panel(diagnosis, ax=None, most=9):
    """Chi-square per degree of freedom that remains with each set of effects that was tried, the model as it is among them."""
    found = ranking(diagnosis)
    shown = [row for place, row in enumerate(found) if place < most or not row["effects"]][::-1]
    heights = np.array([max(len(row["effects"]), 1) for row in shown], float)  # lines of a name
    places = np.cumsum(heights) - heights / 2
    axes = given_axes(ax, size=(SIZE[0], 1.0 + 0.25 * heights.sum()))
    base = left_by_base(found) or 1.0
    values = [max(row["chi2_per_freedom"], 1e-3) for row in shown]
    for place, row, here in zip(places, shown, values, strict=True):
        colour = AFTER if row["accepted"] else INK if not row["effects"] else BEFORE
        axes[0].plot([base, here], [place, place], "-", color=NOISE, lw=1.5, zorder=1)
        axes[0].plot([here], [place], "o", color=colour, ms=8, zorder=2, **({"mfc": "white"} if row["foreseen"] else {}))
    axes[0].set_yticks(places, ["\n+ ".join(row["effects"]) or "as it is" for row in shown], fontsize=9)
    axes[0].set_ylim(0, max(heights.sum(), 1.0))  # half a line of a name beyond the first and the last mark
    axes[0].axvline(1.0, color=INK, ls=":", lw=LINE)
    if values and max(values) > 5 * min(values):
        axes[0].set_xscale("log")
        unpowered(axes[0].xaxis, values)
    else:  # differences in the third digit are no differences
        axes[0].set_xlim(0, 1.08 * max([1.0, *values]))
    plain(axes[0], ranking_title(diagnosis), "chi-square per degree of freedom", "", letters=letters_beside(axes[0]))
    return axes


def error_panel(diagnosis, ax=None):
    """The error after each effect, down to the noise; hatched is what the fitted starts take up of the noise."""
    axes = given_axes(ax)
    ax, unit = axes[0], diagnosis.error.get("unit") or ""
    steps = [step for step in diagnosis.steps if step.get("held_out") is not None or step.get("fitted") is not None]
    entry = diagnosis.error.get("fitted") or diagnosis.error.get("held_out") or {}
    noise = entry.get("noise")
    values = {key: [step.get(key) for step in steps] for key in ("fitted", "held_out")}
    values = {key: each for key, each in values.items() if each and all(value is not None for value in each)}
    factor, shown = scaled([*values.values(), [noise or 0.0]], unit)
    styles = {"fitted": ("o--", BEFORE, "on the fitted data", "none"), "held_out": ("o-", AFTER, "on data left out", AFTER)}
    for key, each in values.items():
        style, colour, label, fill = styles[key]
        ax.plot(
            range(len(each)), factor * np.array(each), style, color=colour, mfc=fill, ms=8 if fill == "none" else 5, label=label
        )
    if noise:
        _noise_floor(ax, factor * noise, (entry.get("starts") or 0.0) if _starts_can_be_seen(diagnosis) else 0.0)
    names = _new_in_each(diagnosis, steps)
    ax.set_xticks(range(len(names)), names, fontsize=9)
    ax.set_xlim(-0.4, max(len(steps) - 0.6, 0.6))
    largest = max((max(each) for each in values.values()), default=0.0)
    if _needs_logarithm(noise, largest):
        ax.set_yscale("log")
        unpowered(ax.yaxis, [noise, largest])
        ax.set_ylim(bottom=0.5 * factor * noise)
    else:
        _from_zero(ax, factor * max(largest, noise or 0.0))
    if ax.get_legend_handles_labels()[0]:
        legend(ax, **({"loc": "lower right"} if len(steps) == 1 else {}))  # below the one mark there is room
    measure = "rms error" if diagnosis.error.get("measure") != "mean relative error" else "mean relative error"
    of = " of positions" if turns_missed(diagnosis.pictures) else ""
    plain(ax, _error_title(diagnosis), "", f"{measure}{of} [{shown}]")
    return axes


def _needs_logarithm(noise, largest):
    """Are an error and the noise so far apart that one scale of equal steps hides the noise?"""
    return bool(noise) and largest > 15 * noise


def _starts_can_be_seen(diagnosis):
    """Is the share of the noise that fitted starts take up wide enough to be drawn?"""
    fitted = diagnosis.error.get("fitted") or {}
    noise, starts = fitted.get("noise"), fitted.get("starts")
    if not noise or not starts:
        return False
    errors = (step.get(key) for step in diagnosis.steps for key in ("fitted", "held_out"))
    largest = max((error for error in errors if error is not None), default=0.0)
    return not _needs_logarithm(noise, largest) and noise * (1 - np.sqrt(1 - starts)) > SEEN * max(largest, noise)


def _noise_floor(ax, noise, starts):
    """The noise, and below it the share that fitted starts take up."""
    ax.axhline(noise, color=INK, ls=":", lw=1.2, label="noise")
    if starts:
        low = noise * np.sqrt(1 - starts)
        ax.axhspan(low, noise, facecolor="none", edgecolor=NOISE, hatch="////", lw=0, label="taken up by the fitted starts")


def _new_in_each(diagnosis, steps):
    """What is new in each step, a line for each effect: what is added, and which number that the model states is another."""
    names, known = ["as it is"] if steps else [], set()
    wrong = {name for name, its in diagnosis.parameters.items() if any("stated" in entry for entry in its.values())}
    for step in steps[1:]:
        new = [effect for effect in step["effects"] if effect not in known]
        new = [f"{words(effect)} corrected" if effect in wrong else f"+ {words(effect)}" for effect in new]
        names.append("\n".join(textwrap.fill(name, WIDEST) for name in new))
        known.update(step["effects"])
    return names


def _error_title(diagnosis):
    error, unit = error_of(diagnosis), diagnosis.error.get("unit", "")
    if not error:
        return "No error is known"
    if not diagnosis.effects:
        return f"The error of the model: {size(error['before'], unit)}"
    if foretold_worse(diagnosis):
        ends = "on data left out"
    elif not diagnosis.adequate.get("after"):
        ends = "not down to the noise"
    else:
        ends = "down to the noise" if error["after"] <= NEAR_NOISE * error["noise"] else "to what noise may be"
    return f"The error falls, {ends}: {size(error['before'], unit)} -> {size(error['after'], unit)}"
