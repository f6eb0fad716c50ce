"""A yard where armour units are laid layer by layer: the table that its people write down, with something hidden in it.

How units come to rest on each other is what pybullet made of the same procedure (`layers_in_pybullet.csv`, which says how); no
module of the engine is imported. Its people add their own: a scatter from test to test, and a factor from week to week.
"""

import csv
from collections import defaultdict
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

PYBULLET = Path(__file__).resolve().parent / "layers_in_pybullet.csv"
TITLE = "Cubipods laid in three layers on a yard, in four weeks"
GRID, SPACING = "TPG", (1.58, 1.27)  # the triangular grid, its spacings along and across [Dn]
LAYERS = 3  # set here: causes differ in the first layer and in those above it
WEEKS = 4  # campaigns (set here)
HANDS = 0.008  # scatter of a layer from test to test, over its mean; first layers of the laboratory's Table 2: 0.006 and 0.008
WEEK = 0.005  # scatter of the factor of a week, one crew and one plate (set here); between the laboratory's campaigns it is 0.017
FEWEST, MOST, USUAL = 4, 12, 8  # tests in a week; usual: where nothing is hidden
COLUMNS = ("grid", "spacing_x", "spacing_y", "bottom_slope", "layer", "mean", "cv", "tests", "campaign")
PLACEMENT = {  # the model under test: pybullet's settings, on a smaller first layer, which takes half the time
    "shape": "pieces",
    "side": 1.0,  # m
    "friction": 0.36,
    "restitution": 0.0,
    "margin": 0.0,  # Dn
    "falling_distance": 0.25,  # Dn
    "reference": "layer",
    "layers": LAYERS,
    "rows": 6,
    "columns": 6,
}


class Offer(NamedTuple):
    """An effect that can be hidden in a table."""

    parameter: str  # its one number, as the library calls it
    change: Callable  # amplitude -> change of the layer coefficients (LAYERS,) [Dn]
    low: float  # the amplitude lies between these
    high: float
    tied: tuple[str, ...]  # what makes the same table
    story: str  # what `reveal` says


@cache
def pybullet(cause):
    """Amplitudes (n,) of a cause that were run in pybullet, and of each the means, the coefficients of variation and the changes
    against no cause with the same seeds: three arrays (n, LAYERS), lengths in Dn."""
    found = defaultdict(list)
    with open(PYBULLET, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            if (row["cause"], row["grid"]) == (cause, GRID) and int(row["layer"]) <= LAYERS:
                found[float(row["amplitude"])].append([float(row[name]) for name in ("mean", "cv", "change")])
    return np.array(list(found)), *np.moveaxis(np.array(list(found.values())), -1, 0)


def first_layer(sign):
    """The first layer alone is read thicker (1) or thinner (-1): the layers above are differences of two readings."""
    return lambda amplitude: sign * amplitude * (np.arange(LAYERS) == 0)


def between_runs(cause):
    """The change that pybullet gave, on straight lines between the amplitudes that were run and none."""

    def change(amplitude):
        amplitudes, _, _, changes = pybullet(cause)
        order = np.argsort([0.0, *amplitudes])
        known, changes = np.array([0.0, *amplitudes])[order], np.vstack([np.zeros(LAYERS), changes])[order]
        return np.array([np.interp(amplitude, known, layer) for layer in changes.T])

    return change


OFFERS = {
    "plate_bias": Offer(
        "offset",
        first_layer(1),
        0.01,
        0.05,
        ("orientation_bias",),
        "The thickness of the plate that the staff stands on was not taken off. It cancels where one layer is taken from the "
        "next, so the first layer alone reads too thick. Units of the first layer that stand on a tip would look the same; "
        "photographs of the first layer tell.",
    ),
    "settlement": Offer(
        "instant",
        first_layer(-1),
        0.01,
        0.1,
        ("plate_bias",),
        "The ground gave way under the first units, by the same in all tests. A plate that reads too low would look the same.",
    ),
    "margin_offset": Offer(
        "offset",
        between_runs("margin_offset"),
        0.004,
        0.02,
        ("length_scale", "size_error"),
        "A coat on the units, and on the plate, keeps every contact open, so all layers are thicker by nearly the same length. A "
        "ruler that is too short, or larger units, look much the same.",
    ),
}


def unaltered():
    """Layer coefficients of the heap with nothing hidden, and their standard deviations from test to test: of the heap itself,
    and of hands and plates; both (LAYERS,) [Dn]."""
    _, (mean,), (cv,), _ = pybullet("none")
    return mean, mean * np.hypot(cv, HANDS)


def strength(offer, amplitude, tests):
    """What an effect changes in the means of so many tests, over their standard errors: root mean square of the layers."""
    return float(np.sqrt(tests * np.mean((offer.change(amplitude) / unaltered()[1]) ** 2)))


def drawn(offer, wanted, rng):
    """(tests in a week, amplitude) that make a strength, the number of tests drawn from all that allow it; where none does
    (None, (least, greatest strength))."""

    def reaches(tests):
        return strength(offer, offer.low, tests) <= wanted <= strength(offer, offer.high, tests)

    allowed = [tests for tests in range(FEWEST, MOST + 1) if reaches(tests)]
    if not allowed:
        return None, (strength(offer, offer.low, FEWEST), strength(offer, offer.high, MOST))
    tests = int(rng.choice(allowed))
    return tests, brentq(lambda tried: strength(offer, tried, tests) - wanted, offer.low, offer.high, rtol=1e-9)


def table(offer, amplitude, tests, rng):
    """Text of the CSV of all weeks. amplitude: of what is hidden; tests: in each week."""
    mean, deviation = unaltered()
    lines, place = [",".join(COLUMNS)], f"{GRID},{SPACING[0]:g},{SPACING[1]:g},0"
    for week in range(1, WEEKS + 1):
        factor = 1.0 + WEEK * rng.normal()
        read = factor * (mean + offer.change(amplitude) + deviation * rng.normal(size=(tests, LAYERS)))
        rows = zip(read.mean(axis=0), read.std(axis=0, ddof=1) / read.mean(axis=0), strict=True)
        for layer, (of_week, cv) in enumerate(rows, start=1):
            lines.append(f"{place},{layer},{of_week:.4f},{cv:.4f},{tests},week {week}")
    return "\n".join(lines) + "\n"


def experiment(title):
    """The experiment file as a dictionary; nothing in it depends on what is hidden, so all sets share their simulations."""
    return {
        "kind": "layers",
        "title": title,
        "placement": PLACEMENT,
        "measurement": {"file": "layers.csv"},
        "diagnose": {"hold_out": "campaign"},
    }
