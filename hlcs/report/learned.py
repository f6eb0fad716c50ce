"""How a Learned law is shown and saved: its sentence and numbers, in a notebook, drawn over its variable, as files."""

import json

import numpy as np

from hlcs.files import folders
from hlcs.report.document import Section, Table, as_text
from hlcs.report.figures import AFTER, BEFORE, CHANNEL, INK, NOISE, given_axes, legend, plain
from hlcs.report.page import fragment, png
from hlcs.report.words import interval, size, value

UNITS = {"speed": "m/s", "time": "s", "spin": "rad/s", "heading": "rad"}  # of a variable; of the others m
PERIODS, POINTS = 2, 200  # of an oscillation that is drawn


def line(learned):
    """The law in a sentence."""
    return learned.text


def text(learned):
    """The law, its numbers, and what it foretells."""
    return as_text(learned.text, [Section("The numbers", numbers_of(learned))])


def numbers_of(learned):
    """The numbers of the law with their intervals, those of a table with where they stand, and what it foretells: parts of a
    section."""
    unit, places = UNITS.get(learned.variable, "m"), learned.band.get("grid", ()) if learned.form == "table" else ()
    at = {f"value_{k}": f", at {learned.variable} {place:.3g} {unit}" for k, place in enumerate(places, start=1)}
    rows = tuple((name + at.get(name, ""), value(entry), interval(entry)) for name, entry in learned.numbers.items())
    errors = (
        f"Error of data that the numbers were not fitted to: {size(learned.held_out['before'], learned.unit)} before, "
        f"{size(learned.held_out['after'], learned.unit)} with it."
    )
    return (*((Table(("number", "value", "90 % interval"), rows, texts=1),) if rows else ()), errors)


def html(learned):
    """A learned law in a notebook."""
    return fragment(learned.text, [Section("The numbers", numbers_of(learned))], [])


def plot(learned, ax=None):
    """The force per mass, or the restitution, as a table of the variable, with its 90 % interval; of an oscillation the swing of
    each axis.

    Returns the Axes.
    """
    axes = given_axes(ax)
    if learned.band:
        _table(learned, axes[0])
    else:
        _swings(learned, axes[0])
    return axes[0] if ax is None else ax


def caption(learned):
    """What the marks of its picture mean."""
    if not learned.band:
        return "How far it moves what is seen, along each axis."
    return "As the data show it, place by place." + " The line is the law." * ("law" in learned.band)


def _table(learned, ax):
    band = learned.band
    ax.fill_between(band["grid"], band["low"], band["high"], color=NOISE, alpha=0.5, lw=0, label="90 % interval")
    ax.plot(band["grid"], band["value"], *(["o"] if "law" in band else ["-"]), color=AFTER, ms=4, lw=1.6, label="as a table")
    if "law" in band:
        ax.plot(band["places"], band["law"], "-", color=INK, lw=1.2, label="the law")
    if np.abs(band["value"]).min() < np.ptp(band["value"]):  # zero is near
        ax.axhline(0.0, color=BEFORE, ls=":", lw=1.0)
    legend(ax)
    variable = f"{learned.variable} [{UNITS.get(learned.variable, 'm')}]"
    plain(ax, learned.text, variable, learned.quantity)


def _swings(learned, ax):
    numbers = learned.numbers
    swings = {name.removeprefix("amplitude_"): entry for name, entry in numbers.items() if name.startswith("amplitude_")}
    frequency = numbers["frequency_hz"]["value"]
    times = np.linspace(0.0, PERIODS / frequency, POINTS)
    for (axis, entry), (_, colour) in zip(swings.items(), CHANNEL, strict=False):
        ax.plot(times, 1e3 * entry["value"] * np.sin(2.0 * np.pi * frequency * times), color=colour, label=axis)
    legend(ax)
    plain(ax, learned.text, "time [s], from a moment of its own", "swing [mm]")


def save(learned, folder):
    """Write learned.json, learned.txt, learned.png and, where there is one, its effect file."""
    found = {"learned.txt": (text(learned) + "\n").encode(), "learned.png": png([plot(learned)])}
    if learned.effect_file:
        found[learned.file_name] = learned.effect_file.encode()
    found["learned.json"] = json.dumps(learned.to_json(), indent=1).encode()
    return folders.save_files(folder, found)
