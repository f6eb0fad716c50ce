"""The 4 % slope of Table 3: what the flume's geometry and the first layer's poses do to each layer, with intervals.

The paper gives no number of units. 1.2 m between the flume's walls over a = 1.58 x 38 mm are 20 columns; the plates of its
layers, 12, 9, 9, 6 and 3, fit 7 or 8 rows. Nothing here is chosen by how well it meets Table 3: every variant is shown, and what
none explains is said to be left.
"""

from dataclasses import replace

import numpy as np
from scipy import stats

from hlcs.paper import reproduce, sensitivity
from hlcs.placement import statistics
from hlcs.placement.comparison import repeated
from hlcs.placement.grids import TPG
from hlcs.placement.number_text import or_dash, percent
from hlcs.placement.printed_tables import laboratory
from hlcs.placement.sea_bottom import Flat, Slope
from hlcs.placement.statistics import Sample

FLUME = {"rows": 7, "columns": 20}
VARIANTS = {  # each beside the first one, which is that of Table 3
    "as Table 3 here": {},
    "20 columns x 7 rows": FLUME,
    "20 columns x 8 rows": FLUME | {"rows": 8},
    "20 x 7 between walls": FLUME | {"walls": True},
    "6 % on a tip": {"tip_share": 0.06},
    "17 % on a tip": {"tip_share": 0.17},
}
SHARES = (0.0, 0.06, 0.17)  # of first-layer units on a tip, tried on layer 1 of the tables of the triangular grid
LAYER_1_TESTS = 4  # seeds of a first layer alone for each seed of the table: it takes little time


def slope(plan, progress=None):
    """The variants on a 4 % slope, and the hypothesis of units on a tip on layer 1 of both tables of the triangular grid."""
    base, bottom = plan.test(grid=TPG, bottom=Slope(0.04)), laboratory("table3", grid=TPG)
    tests = [replace(base, **change) for change in VARIANTS.values()]
    runs = reproduce._repeated_runs("slope", tests, plan, progress)
    rows, first = [], _kept(runs[0])
    for name, own in zip(VARIANTS, runs, strict=True):
        kept = _kept(own)
        layers = [
            {"layer": j + 1, "k": reproduce.interval(kept[:, j]), "shift": _shift(first[:, j], kept[:, j])}
            for j in range(kept.shape[1])
        ]
        errors = reproduce.interval(sensitivity.errors_of(own, bottom))
        rows.append({"variant": name, **reproduce._summary(own, bottom), "layers": layers, "error": errors})
    return reproduce._document("slope", plan) | {"variants": rows, "layer_1": _on_layer_1(plan, progress)}


def _kept(results):
    """Layer coefficients (tests, M) of repeated tests; nan where one left no structure."""
    return np.array([np.where(result.stands, result.layer_coefficients, np.nan) for result in results])


def _shift(first, second):
    """Mean of the second minus that of the first with its 95 % interval; unequal variances (Welch), tests not paired."""
    first, second = (values[np.isfinite(values)] for values in (first, second))
    if min(len(first), len(second)) < 2:
        return {"mean": np.nan, "low": np.nan, "high": np.nan}
    shift, found = float(second.mean() - first.mean()), stats.ttest_ind(second, first, equal_var=False)
    if shift == 0.0 or not np.isfinite(found.statistic):  # without any scatter
        return {"mean": shift, "low": shift, "high": shift}
    low, high = found.confidence_interval(0.95)
    return {"mean": shift, "low": float(low), "high": float(high)}


def _on_layer_1(plan, progress):
    """Rows of share, bottom_slope, k1 (mean and interval), measured (the same), p of Welch's test, corrected by Holm over all."""
    cases = [(share, bottom) for share in SHARES for bottom in (Flat(), Slope(0.04))]
    tests = [plan.test(grid=TPG, bottom=bottom, layers=1, tip_share=share) for share, bottom in cases]
    many = reproduce.Plan(plan.settings, LAYER_1_TESTS * len(plan.seeds("slope")), plan.seed, plan.workers)
    rows = []
    for (share, bottom), own in zip(cases, reproduce._repeated_runs("slope", tests, many, progress), strict=True):
        grade = getattr(bottom, "grade", 0.0)
        table = laboratory("table3" if grade else "table2", grid=TPG)
        measured = Sample(
            *(np.atleast_1d(part)[:1] for part in (table.mean, table.cv, np.broadcast_to(table.tests, table.mean.shape)))
        )
        model = repeated(_kept(own))
        low, high = statistics.confidence_interval(measured)
        rows.append(
            {
                "share": share,
                "bottom_slope": grade,
                "k1": reproduce.interval(_kept(own)[:, 0]),
                "measured": {"mean": float(measured.mean[0]), "low": float(low[0]), "high": float(high[0])},
                "p": float(statistics.welch(measured, model).p[0]) if np.all(model.tests >= 2) else np.nan,
            }
        )
    known = [row for row in rows if np.isfinite(row["p"])]
    for row, p in zip(known, statistics.holm([row["p"] for row in known]), strict=True):
        row["p"] = float(p)
    return rows


def slope_text(document):
    """What `hlcs reproduce slope` prints."""
    rows, measured = document["variants"], laboratory("table3", grid="TPG")
    layers = len(rows[0]["layers"])
    low, high = statistics.confidence_interval(Sample(measured.mean, measured.cv, measured.tests))
    lines = [f"TPG on a 4 % slope, {document['repeats']} tests each: k of each layer, +- half its 95 % interval (Student)"]
    lines.append(f"{'':>22}" + "".join(f"{f'k{j + 1}':>16}" for j in range(layers)) + f"{'eps_R %':>14}{'lost':>6}")
    cells = "".join(f"{f'{measured.mean[j]:.3f} +-{0.5 * (high - low)[j]:.3f}':>16}" for j in range(layers))
    lines.append(f"{'laboratory':>22}{cells}")
    for row in rows:
        cells = "".join(f"{_plus_minus(layer['k']):>16}" for layer in row["layers"])
        error = f"{percent(row['error']['mean'])} +-{percent(row['error']['high'] - row['error']['mean'])}"
        lines.append(f"{row['variant']:>22}{cells}{error:>14}{row['lost_units']:>6}")
    lines += ["", "What each does to a layer against the first variant, mean [95 % interval, Welch]; * excludes none:"]
    for row in rows[1:]:
        cells = (layer["shift"] for layer in row["layers"])
        lines.append(f"{row['variant']:>22}" + "".join(f"{_starred(found):>24}" for found in cells))
    lines += ["", *_left(rows, measured, low, high), "", *_layer_1_lines(document["layer_1"])]
    return "\n".join([*lines, "", "No setting is chosen by this table: the defaults stay what Table 2 and the unit give."])


def _plus_minus(found):
    return f"{or_dash(found['mean'], '.3f')} +-{or_dash(found['high'] - found['mean'], '.3f')}"


def _starred(found):
    star = "*" if found["low"] > 0.0 or found["high"] < 0.0 else " "
    return f"{or_dash(found['mean'], '+.3f')} [{or_dash(found['low'], '+.3f')},{or_dash(found['high'], '+.3f')}]{star}"


def _left(rows, measured, low, high):
    """Which layers no variant brings into the laboratory's interval."""
    left = []
    for j in range(len(rows[0]["layers"])):
        outside = [not low[j] <= row["layers"][j]["k"]["mean"] <= high[j] for row in rows]
        if all(outside):
            first = rows[0]["layers"][j]["k"]["mean"] / measured.mean[j] - 1.0
            left.append(f"layer {j + 1} ({100 * first:+.1f} %)")
    told = "no variant brings into the laboratory's 95 % interval: " + ", ".join(left) if left else "none"
    return [f"Left: {told}"]


def _layer_1_lines(rows):
    """The hypothesis of units on a tip on layer 1 of the tables."""
    lines = ["Units of the first layer on a tip, tested on layer 1 of the tables of the triangular grid (Welch, Holm):"]
    for row in rows:
        place = f"{row['bottom_slope']:.0%} slope" if row["bottom_slope"] else "flat"
        verdict = "-" if not np.isfinite(row["p"]) else f"p = {row['p']:.3f}, {'refused' if row['p'] < 0.05 else 'not refused'}"
        lines.append(
            f"{row['share']:>8.0%}, {place:>8}: k1 {_plus_minus(row['k1'])}, laboratory {_plus_minus(row['measured'])}: {verdict}"
        )
    return [*lines, "RPG is left out: units on a tip are as wide as 1.40 Dn both ways and do not fit its b = 1.30 Dn."]
