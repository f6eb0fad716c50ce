"""How a Plan is shown and saved: printed, in a notebook, drawn, as files."""

import html as markup
import json

import numpy as np

from hlcs.files import folders
from hlcs.files.spreadsheets import as_columns, csv_text
from hlcs.report.figures import AFTER, BEFORE, INK, LINE, given_axes, legend, plain
from hlcs.report.page import png
from hlcs.report.words import DASH, note_lines, number

MOST = 1000  # recordings that a plan counts up to
EXPLAINED = (
    "needed: how many like that find it with the probability asked for. over the noise: the root of the sum of squares",
    "of what the effect changes, less what unknown starts take up, in units of the noise; of N alike it is sqrt(N) times",
    "as much. found with: the probability that so many as in the pilot find it, also called power.",
)


def line(plan):
    """The plan in a line: what is to be found, with how many recordings."""
    return f"{plan.effect}, {_numbers(plan)}, to be found with probability {plan.power:g}; {_advice(plan)}"


def _numbers(plan):
    return ", ".join(f"{name} = {value:g}" for name, value in plan.at.items())


def text(plan):
    """The printed report of a Plan."""
    many, count = plan.what, plan.now["recordings"]
    lines = [
        f"Plan: {plan.effect}, {_numbers(plan)}, to be found with probability {plan.power:g}",
        "",
        f"Pilot: {count} {many}; the effect stands {_over_noise(plan.noncentrality)} times over the noise in them, and would be",
        f"found with probability {plan.now['power']:.2f}.",
        "",
        f"  {'':16s} {'length':>9s} {'noise':>12s} {'needed':>7s}  over the noise, each  found with {count}",
    ]
    for row in plan.options:
        needed = _needed(row["recordings"])
        lines.append(
            f"  {row['change']:16s} {number(row['length_s'], 's'):>9s} {number(row['sigma'], row['unit']):>12s} {needed:>7s}  "
            f"{_over_noise(row['noncentrality']):>20s}  {row['power']:{len(f'found with {count}')}.2f}"
        )
    lines += [f"  {line}" for line in EXPLAINED]
    lines += ["", _advice(plan)]
    lines += _look_alike_lines(plan)
    return "\n".join(lines + note_lines(plan.notes))


def _over_noise(noncentrality):
    """The root of a noncentrality: how many standard deviations an effect stands out by."""
    return f"{np.sqrt(noncentrality):.3g}" if noncentrality >= 0 else DASH


def _advice(plan):
    """What to do, in a sentence."""
    if plan.needed["recordings"] is not None:
        length = plan.needed["length_s"]
        each = "" if length is None else f" of {length:.3g} s"
        sigma = number(plan.needed["sigma"], plan.needed["unit"])
        return f"Needed: {plan.needed['recordings']} {plan.what}{each}, with a noise of {sigma}."
    others = [row for row in plan.options[1:] if row["recordings"] is not None]
    told = "; or ".join(
        f"{row['recordings']} {plan.what}, {row['change']}, with a noise of {number(row['sigma'], row['unit'])}" for row in others
    )
    instead = f"Instead: {told}." if told else "Change the experiment."
    return f"Infeasible: more than {MOST:,} {plan.what} like these. {instead}"


def _look_alike_lines(plan):
    """Which look-alikes finding the effect would leave open, and what tells the others from it."""
    needed, left_open, apart = plan.needed["recordings"], [], []
    for other in plan.look_alikes:
        count = other["recordings"]
        if count is None or needed is None or count > needed:
            left_open.append(f"{other['effect']} ({f'over {MOST:,}' if count is None else count} tell them apart)")
        else:
            apart.append(other["effect"])
    lines = [f"Finding it would leave open, in experiments like these: {', '.join(left_open)}"] if left_open else []
    lines += [f"Alike, but told apart by as many: {', '.join(apart)}"] if apart else []
    return ["", *lines] if lines else []


def _needed(count):
    return f"> {MOST}" if count is None else str(count)


def html(plan):
    """A plan in a notebook."""
    return f"<p>{markup.escape(line(plan))}</p>{plan.to_dataframe().to_html(index=False)}"


def plot(plan, ax=None):
    """How many recordings each change of the experiment needs, beside those of the pilot; returns the Axes."""
    axes = given_axes(ax)
    names, needed = [row["change"] for row in plan.options], [row["recordings"] for row in plan.options]
    places = np.arange(len(names))
    for place, count in zip(places, needed, strict=True):
        more = {"hatch": "//", "facecolor": "white", "edgecolor": BEFORE} if count is None else {"color": AFTER}
        axes[0].barh(place, count or MOST, height=0.6, **more)
        axes[0].annotate(f" {_needed(count)}", (count or MOST, place), va="center", fontsize=9)
    axes[0].axvline(plan.now["recordings"], color=INK, ls=":", lw=LINE, label=f"the pilot: {plan.now['recordings']}")
    axes[0].set_xscale("log")
    axes[0].set_xlim(0.8, 4 * MOST)
    axes[0].set_yticks(places, names)
    axes[0].invert_yaxis()
    legend(axes[0], below=True)
    title = f"{plan.what.capitalize()} that find {plan.effect}, {_numbers(plan)}, with probability {plan.power:g}"
    plain(axes[0], title, f"{plan.what} needed", "")
    return axes[0] if ax is None else ax


def save(plan, folder):
    """Write plan.json, plan.txt, options.csv and plan.png."""
    found = {
        "options.csv": csv_text(as_columns(plan.options)).encode(),
        "plan.txt": (text(plan) + "\n").encode(),
        "plan.png": png([plot(plan)]),
        "plan.json": json.dumps(plan.to_json(), indent=1).encode(),
    }
    return folders.save_files(folder, found)
