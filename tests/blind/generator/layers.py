"""Layer tables: published layer coefficients, what pybullet answers to a cause, and the scatter of five tests per table.

The baseline is Blender's seven-piece unit nearly without margin. What a cause changes was measured in pybullet, with the same
seeds as a model without it (make_layer_answers.py); readings of the first layer are exact. Single layers above the first are
known to 0.7 %, so their changes are taken from a straight line through the four. An engine differs from these two by 1-2 % in
layers 2-5 and answers a cause up to half differently, which is part of the test: this family tests the family of the verdict
(physics, placement, measurement, numerics), not a coefficient.
Strength here = largest shift of a layer / shift detectable with 80 % power among five layers, 3.42 standard errors.
"""

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np

from .again import GROUP, turns
from .build import Redraw
from .case import csv_text, toml_text

BASE = {"TPG": np.array([1.302, 1.068, 0.993, 0.955, 0.993]), "RPG": np.array([1.302, 1.051, 0.982, 0.931, 0.954])}
CV = {"TPG": np.array([0.008, 0.010, 0.018, 0.021, 0.021]), "RPG": np.array([0.006, 0.014, 0.019, 0.020, 0.030])}
SPACING = {"TPG": (1.58, 1.27), "RPG": (1.40, 1.30)}
CAMPAIGN, TESTS = 0.010, 5
# effect -> family of the verdict, lowest and highest amplitude (both 1: it is there or not)
EFFECTS = {
    "convex_hull_shape": ("numerics", 1.0, 1.0),
    "margin_offset": ("numerics", 0.0, 0.02),
    "plate_bias": ("measurement", -0.05, 0.05),
    "settlement": ("physics", 0.0, 0.10),
    "friction": ("physics", -0.20, 0.24),
    "grid_spacing": ("placement", -0.03, 0.03),
    "placement_scatter": ("placement", 0.0, 0.30),
    "loose_lower_layers": ("placement", 1.0, 1.0),
}
# not hidden here, but what is may look like it
ALSO = {"length_scale": ("measurement", -0.03, 0.03), "orientation_bias": ("placement", 0.0, 0.2)}
TIP = 1.404 - 1.298  # how much higher a unit stands on a tip than in its lowest pose [D_n]
FIRST = {"plate_bias": 1.0, "settlement": -1.0, "orientation_bias": TIP}  # change of the first layer alone, per unit amplitude
OUTSIDE = {"alternating_layers": np.array([0.6, -1.0, 1.0, -1.0, 1.0])}
MOST_OUTSIDE = 0.08
ALIKE = 6.0  # units of -2 log likelihood: what fits the expected table so closely cannot be told from what is hidden


def _answers():
    """{(effect, grid): [(amplitude, relative change of k (5,), factor on the scatter)]}, amplitude 0 among them."""
    rows, answers = defaultdict(list), defaultdict(list)
    with open(Path(__file__).resolve().parent / "layer_answers.csv", newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            values = tuple(float(row[name]) for name in ("mean", "cv", "change"))
            rows[row["grid"], row["cause"], float(row["amplitude"])].append(values)
    for (grid, name, amplitude), layers in rows.items():
        _, cv, change = np.transpose(layers)
        mean, scatter, _ = np.transpose(rows[grid, "none", 0.0])
        relative = change / mean
        relative[1:] = np.polyval(np.polyfit(np.arange(4), relative[1:], 1), np.arange(4))
        answers[name, grid].append((amplitude, relative, np.sqrt(np.mean(cv[1:] ** 2) / np.mean(scatter[1:] ** 2))))
    nothing = 0.0, np.zeros(5), 1.0
    return {pair: sorted([nothing, *known], key=lambda entry: entry[0]) for pair, known in answers.items() if pair[0] != "none"}


ANSWERS = _answers()


def response(name, grid, amplitude):
    """(relative change of k (5,), factor on the scatter of the layers above the first) that an effect makes."""
    if name in FIRST:
        return FIRST[name] * amplitude * (np.arange(5) == 0) / BASE[grid], 1.0
    if name == "length_scale":
        return np.full(5, amplitude), 1.0
    amplitudes, changes, factors = zip(*ANSWERS[name, grid], strict=True)
    inside = float(np.clip(amplitude, amplitudes[0], amplitudes[-1]))
    beyond = amplitude / inside if inside else 1.0  # the last line goes on
    change = [np.interp(inside, amplitudes, layer) for layer in np.transpose(changes)]
    return beyond * np.array(change), float(np.interp(inside, amplitudes, factors))


def amplitudes_of(name, count=101):
    """All amplitudes at which an effect is tried, of both signs where it has both."""
    _, low, high = {**EFFECTS, **ALSO}[name]
    return np.linspace(low, high, count) if low < high else np.array([1.0])


def imitators(name, amplitude, campaigns):
    """Effects that would make the same tables as one that is hidden: their best amplitude leaves less than ALIKE, whether hands
    differ by one factor or layer by layer, which no table tells."""
    grids, tests = tuple(BASE), TESTS * campaigns

    def seen(name, amplitude):
        parts = [response(name, grid, amplitude) for grid in grids]
        return np.concatenate([*(change for change, _ in parts), [np.log(factor) for _, factor in parts]])

    variance = np.concatenate([*(CV[grid] ** 2 / tests for grid in grids), np.full(len(grids), 0.5 / (4 * tests))])
    layer = np.arange(len(variance)) < 5 * len(grids)
    forms = np.outer(layer, layer), np.diag(layer)  # of what a campaign adds: one factor, or a number of its own for each layer
    weights = [np.linalg.inv(np.diag(variance) + CAMPAIGN**2 / campaigns * form) for form in forms]
    hidden = seen(name, amplitude)

    def left(other):
        misses = [hidden - seen(other, value) for value in amplitudes_of(other)]
        return min(miss @ weight @ miss for miss in misses for weight in weights)

    return sorted(other for other in {**EFFECTS, **ALSO} if other != name and left(other) < ALIKE)


def standard_error(grids, campaigns):
    """Relative standard error (5,) of a layer averaged over all tables, campaign term included."""
    scatter = sum(CV[grid] ** 2 for grid in grids) / len(grids) ** 2 / (TESTS * campaigns)
    return np.sqrt(scatter + CAMPAIGN**2 / campaigns)


class Laboratory:
    """Tests of layers by hands of their own in every campaign.

    means, cvs: of each grid (5,). rng: of the campaigns made first."""

    def __init__(self, rng, means, cvs, campaigns):
        self.means, self.cvs, self.common, self.tests = means, cvs, {}, {}
        for campaign in range(campaigns):
            self.campaign(rng, f"campaign {campaign + 1}")
            for grid in means:
                self.test(rng, f"campaign {campaign + 1}", grid, TESTS)

    def campaign(self, rng, name):
        """Begin a campaign: what its hands do to every layer."""
        self.common[name] = 1 + CAMPAIGN * rng.normal()

    def test(self, rng, campaign, grid, count):
        """`count` more tests on a grid in a campaign."""
        seen = self.means[grid] * self.common[campaign] * (1 + self.cvs[grid] * rng.normal(size=(count, 5)))
        self.tests[campaign, grid] = np.concatenate([self.tests.get((campaign, grid), np.empty((0, 5))), seen])

    def follow(self, rng, design, count):
        """The tests that a verdict asks for. Those that name no campaign, or one that there is, add to the rows of the grid, the
        campaigns in turn; others are a campaign of their own. KeyError for a grid that nobody here has placed."""
        for test in turns({"bottom_slope": 0.0, **design}, count):
            grid, own = test["grid"], test.get("campaign")
            if grid not in self.means or test["bottom_slope"] != 0.0:
                raise KeyError(f"{grid} on a bottom of {test['bottom_slope']:g}")
            if own is not None and own not in self.common:
                own = GROUP
                if own not in self.common:
                    self.campaign(rng, own)
                if (own, grid) not in self.tests:
                    self.test(rng, own, grid, 1)  # one test alone has no scatter
            fewest = min((name for name, place in self.tests if place == grid), key=lambda name: len(self.tests[name, grid]))
            self.test(rng, own or fewest, grid, 1)

    def rows(self):
        """Rows of the file, one a layer."""
        rows = []
        for (campaign, grid), tests in self.tests.items():
            mean, cv = tests.mean(axis=0), tests.std(axis=0, ddof=1) / tests.mean(axis=0)
            place = (grid, f"{SPACING[grid][0]}", f"{SPACING[grid][1]}", "0")
            for layer in range(5):
                rows.append((*place, str(layer + 1), f"{mean[layer]:.4f}", f"{cv[layer]:.4f}", str(len(tests)), campaign))
        return rows


def case(deal, rng, then=None):
    """One layer case: ({file name: text}, answer). deal.strengths in detectable shifts; then = (design, number of tests): these
    are made too, after all others. Raises Redraw."""
    grids, campaigns = ("TPG", "RPG"), int(rng.integers(3, 5))
    detectable = 3.42 * standard_error(grids, campaigns)
    name, shape, amplitude, strength, alike = next(iter(deal.names), None), "pieces", 0.0, 0.0, []
    change, widen = dict.fromkeys(grids, np.zeros(5)), dict.fromkeys(grids, 1.0)

    def strength_of(changes):
        return float(np.max(np.abs(np.mean(list(changes.values()), axis=0)) / detectable))

    if deal.kind == "outside":
        amplitude = min(deal.strengths[0] / float(np.max(np.abs(OUTSIDE[name]) / detectable)), MOST_OUTSIDE)
        change = dict.fromkeys(grids, OUTSIDE[name] * amplitude)
        strength = strength_of(change)
    elif name:
        tried = amplitudes_of(name)
        if tried[0] < 0 < tried[-1]:
            tried = tried[tried * rng.choice((-1, 1)) >= 0]
        for amplitude in sorted(tried, key=abs):
            change = {grid: response(name, grid, amplitude)[0] for grid in grids}
            widen = {grid: response(name, grid, amplitude)[1] for grid in grids}
            strength = strength_of(change)
            if strength >= deal.strengths[0]:
                break
        alike = imitators(name, amplitude, campaigns)
        if name == "convex_hull_shape":  # the model's unit is filled, the laboratory's is not
            shape, change, widen = "hull", dict.fromkeys(grids, np.zeros(5)), dict.fromkeys(grids, 1.0)
    if name and strength < 0.8 * deal.strengths[0]:
        raise Redraw("beyond the bounds of the effect")
    means = {grid: BASE[grid] * (1 + change[grid]) for grid in grids}
    cvs = {grid: CV[grid] * np.concatenate([[1.0], np.full(4, widen[grid])]) for grid in grids}
    laboratory = Laboratory(rng, means, cvs, campaigns)
    if then:
        laboratory.follow(rng, *then)
    rows = laboratory.rows()
    header = ["grid", "spacing_x", "spacing_y", "bottom_slope", "layer", "mean", "cv", "tests", "campaign"]
    files = {
        "layers.csv": csv_text(header, rows),
        "experiment.toml": toml_text(
            {
                "": {"kind": "layers", "title": "layer coefficients, two grids"},
                "placement": {
                    "shape": shape,
                    "side": 1.0,
                    "friction": 0.36,
                    "restitution": 0.0,
                    "margin": 0.0,
                    "falling_distance": 0.25,
                    "reference": "layer",
                    "layers": 5,
                    "rows": 8,
                    "columns": 8,
                },
                "measurement": {"file": "layers.csv"},
                "diagnose": {"hold_out": "campaign"},
            }
        ),
    }
    names = list(deal.names)
    families = sorted({{**EFFECTS, **ALSO}[one][0] for one in (*names, *alike) if deal.kind == "single"})
    answer = {
        "kind": deal.kind,
        "family": "layers",
        "style": "table",
        "effects": names,
        "hidden_laws": {name: {"amplitude": amplitude} for name in names},
        "parameters": {},
        "strengths": dict.fromkeys(names, strength),
        "outside": deal.kind == "outside",
        "tied": [],
        "beyond": [],
        "nearest": None,
        "possible": alike,
        "largest_cosine": 1.0,
        "total_strength": strength,
        "detectable": list(detectable),
        "shift": {grid: list(change[grid]) for grid in grids},
        "verdict_families": families,
        "numbers": len(rows),
        "noise": {"regime": "tests"},
        "nominal_errors": {},
        "oracle": None,
    }
    return files, answer
