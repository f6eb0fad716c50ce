"""Layer tables: published layer coefficients, published or expected responses, and the scatter of five tests per table.

Kept small on purpose: the response of k to a cause is known only for a few causes (Blender and pybullet runs of the paper's
procedure), so this family tests the family of the verdict (physics, placement, measurement, numerics), not a coefficient. The
baseline is Blender's seven-piece unit nearly without margin; another engine differs from it by 1-2 % in layers 2-5, which is
part of the test.
Strength here = largest shift of a layer / shift detectable with 80 % power among five layers, 3.42 standard errors.
"""

import numpy as np

from .again import GROUP, turns
from .build import Redraw
from .case import csv_text, toml_text

BASE = {"TPG": np.array([1.302, 1.068, 0.993, 0.955, 0.993]), "RPG": np.array([1.302, 1.051, 0.982, 0.931, 0.954])}
CV = {"TPG": np.array([0.008, 0.010, 0.018, 0.021, 0.021]), "RPG": np.array([0.006, 0.014, 0.019, 0.020, 0.030])}
SPACING = {"TPG": (1.58, 1.27), "RPG": (1.40, 1.30)}
HULL = {
    "TPG": np.array([0.0, 0.105, 0.060, 0.053, 0.045]),
    "RPG": np.array([0.0, 0.088, -0.004, 0.031, 0.006]),
}  # hull minus pieces
CAMPAIGN, TESTS = 0.010, 5
# effect -> family of the verdict, change of k [D_n] per unit amplitude, largest amplitude, factor on the CVs at the largest
EFFECTS = {
    "convex_hull_shape": ("numerics", None, 1.0, 1.0),
    "margin_offset": ("numerics", np.array([2.9, 2.0, 2.0, 2.0, 2.0]), 0.02, 1.0),
    "plate_bias": ("measurement", np.array([1.0, 0.0, 0.0, 0.0, 0.0]), 0.05, 1.0),
    "settlement": ("physics", np.array([-1.0, 0.0, 0.0, 0.0, 0.0]), 0.10, 1.0),
    "grid_spacing": ("placement", np.array([0.0, -2.0, -2.0, -2.0, -2.0]), 0.03, 1.0),
    "placement_scatter": ("placement", np.array([0.0, -0.20, -0.25, -0.30, -0.30]), 0.30, 2.5),
    "loose_lower_layers": ("placement", np.array([0.0, -0.07, -0.05, -0.05, -0.05]), 1.0, 2.0),
}
OUTSIDE = {"alternating_layers": np.array([0.6, -1.0, 1.0, -1.0, 1.0])}
IMITATORS = {
    "settlement": ("plate_bias", "measurement"),
    "plate_bias": ("margin_offset", "numerics"),
    "loose_lower_layers": (),
    "placement_scatter": (),
}


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
    shape, shift, widen, amplitude, strength = "pieces", np.zeros(5), 1.0, 0.0, 0.0
    change = {grid: np.zeros(5) for grid in grids}
    if deal.names:
        name = deal.names[0]
        if name == "convex_hull_shape":  # the model's unit is filled, the laboratory's is not
            shape, amplitude = "hull", 1.0
            change = {grid: np.zeros(5) for grid in grids}
            shift = -HULL["TPG"] / BASE["TPG"]
            strength = float(np.max(np.abs(shift) / detectable))
        else:
            profile = OUTSIDE[name] if deal.kind == "outside" else EFFECTS[name][1]
            relative = profile / (1.0 if deal.kind == "outside" else BASE["TPG"])
            amplitude = deal.strengths[0] / float(np.max(np.abs(relative) / detectable))
            limit = 0.08 if deal.kind == "outside" else EFFECTS[name][2]
            amplitude = min(amplitude, limit)
            shift = relative * amplitude
            strength = float(np.max(np.abs(shift) / detectable))
            if strength < 0.8 * deal.strengths[0]:
                raise Redraw("beyond the bounds of the effect")
            widen = 1.0 if deal.kind == "outside" else 1 + (EFFECTS[name][3] - 1) * amplitude / EFFECTS[name][2]
            change = {grid: shift for grid in grids}
    means = {grid: BASE[grid] * (1 + change[grid]) for grid in grids}
    cvs = {grid: CV[grid] * np.concatenate([[1.0], np.full(4, widen)]) for grid in grids}
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
    inside = [name for name in names if name in EFFECTS]
    families = sorted({EFFECTS[name][0] for name in inside} | {IMITATORS[name][1] for name in inside if IMITATORS.get(name)})
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
        "possible": sorted({IMITATORS[name][0] for name in inside if IMITATORS.get(name)}),
        "largest_cosine": 1.0,
        "total_strength": strength,
        "detectable": list(detectable),
        "shift": list(shift),
        "verdict_families": families,
        "numbers": len(rows),
        "noise": {"regime": "tests"},
        "nominal_errors": {},
        "oracle": None,
    }
    return files, answer
