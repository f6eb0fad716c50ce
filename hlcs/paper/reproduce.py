"""The paper's results again: Table 1, Table 2, Table 3, the blind placement, and the figures.

Every function takes a Plan and returns a dictionary that is the JSON of `hlcs reproduce`; `hlcs.paper.reproduce_text` prints it.
The same settings serve every table; what is varied is said in each.
"""

from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from hlcs.files.versions import versions
from hlcs.paper import sensitivity
from hlcs.placement import statistics
from hlcs.placement.comparison import compare_layers, repeated
from hlcs.placement.grids import RPG, TPG
from hlcs.placement.presets import preset
from hlcs.placement.printed_tables import laboratory, reference_runs, sensitivity_values
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.sea_bottom import Flat, Slope
from hlcs.placement.settings_table import placement_table
from hlcs.processes import parallel

FRICTIONS = (0.36, 0.6)  # what Bullet makes of 0.6 typed on both bodies, because it multiplies the two; the number as typed
MARGINS = (0.0, 0.008)  # none, as a real unit has; the paper's, on units and plates [Dn]
TABLES = ("table1", "table2", "table3", "blind", "figures")
REPEATS = {"table1": 3, "table2": 5, "table3": 5, "blind": 5, "figures": 5, "slope": 5, "set_back": 5, "workability": 3}
SIZE = ("layers", "rows", "columns")  # as chosen, or as the paper has it
VARIED = ("seed", "grid", "stacking", "bottom", "reference")


@dataclass(frozen=True)
class Plan:
    """What all runs of a reproduction share.

    settings: keys of PlacementTest that differ from its defaults; repeats: tests a case, None = the table's own; seed: of the
    first test, the others follow it; workers: processes, None = as many as processors; preset: name of settings that `settings`
    win over; results: of the tests run so far, so that no table runs another's again.
    """

    settings: dict
    repeats: int | None = None
    seed: int = 1
    workers: int | None = None
    preset: str | None = None
    results: dict = field(default_factory=dict, repr=False, compare=False)

    def seeds(self, table):
        """Seeds of the repeated tests of a table."""
        return list(range(self.seed, self.seed + (self.repeats or REPEATS[table])))

    def test(self, **changes):
        """A PlacementTest of this plan."""
        return PlacementTest(**{**preset(self.preset), **self.settings, **changes})

    @property
    def cells(self):
        """The settings of a table's runs: contact friction x margin, both readings of each unless one was chosen; the first cell
        is what this plan's tests have. The plates have the units' margin."""
        pairs = product(self._readings("friction", FRICTIONS), self._readings("margin", MARGINS))
        return [{"friction": friction, "margin": margin, "plate_margin": margin} for friction, margin in pairs]

    def _readings(self, name, values):
        """The value of a setting as chosen; where none was, the plan's own and then the other ones of `values`."""
        own = getattr(self.test(), name)
        return (own,) if name in self.settings else (own, *(value for value in values if value != own))


def table2(plan, progress=None):
    """Table 2: RPG and TPG on a horizontal bottom."""
    return _table("table2", {"RPG": {"grid": RPG}, "TPG": {"grid": TPG}}, plan, progress)


def table3(plan, progress=None):
    """Table 3: TPG on a 4 % slope, layer reference."""
    return _table("table3", {"TPG": {"grid": TPG, "bottom": Slope(0.04)}}, plan, progress)


def blind(plan, progress=None):
    """Section 4: layer reference against blind reference, on a horizontal bottom and on a 4 % slope."""
    cases = [(bottom, reference) for bottom in (Flat(), Slope(0.04)) for reference in ("layer", "blind")]
    tests = [plan.test(grid=TPG, bottom=bottom, reference=reference) for bottom, reference in cases]
    rows = []
    for (bottom, reference), own in zip(cases, _repeated_runs("blind", tests, plan, progress), strict=True):
        far = [misplaced(result) for result in own]
        rows.append(
            {
                "bottom_slope": getattr(bottom, "grade", 0.0),
                "reference": reference,
                "lost_by_test": [int(result.lost.sum()) for result in own],
                "misplaced_by_test": far,
                "drift_by_test": [[float(d) for d in result.drift] for result in own],
                "layers": [float(k) for k in _mean(own, lambda result: result.layer_coefficients).mean],
                "height_over_dn": float(_mean(own, lambda result: [result.height_over_dn]).mean[0]),
                "drift_over_dn": [float(d) for d in _mean(own, lambda result: result.drift).mean],
                "misplaced_units": sum(far),
                **_counts(own),
            }
        )
    pairs = [{"bottom_slope": rows[k]["bottom_slope"], **differences(rows[k], rows[k + 1])} for k in range(0, len(rows), 2)]
    return _document("blind", plan) | {"cases": rows, "differences": pairs}


def misplaced(result):
    """How many units of a structure are misplaced."""
    return sum(int(layer.sum()) for layer in result.misplaced)


def differences(first, second):
    """What a second case changes against a first one, test by test of the same seed: {"lost", "misplaced", "last_drift"}, each a
    mean with its 95 % interval over the structures [units of one structure; Dn]. The units of one structure hang together, so
    that structures are counted, not units."""
    drifts = [np.array(case["drift_by_test"], dtype=float)[:, -1] for case in (first, second)]
    found = {name: np.subtract(second[f"{name}_by_test"], first[f"{name}_by_test"]) for name in ("lost", "misplaced")}
    return {name: interval(values) for name, values in (found | {"last_drift": drifts[1] - drifts[0]}).items()}


def interval(values):
    """{"mean", "low", "high"} of numbers of repeated tests: 95 % interval (Student)."""
    return dict(zip(("mean", "low", "high"), statistics.mean_interval(values), strict=True))


def table1(plan, progress=None):
    """Table 1: three layers on RPG, one parameter at a time; 10 x 10 units in the first layer, 245 in all (the paper: 250).

    "errors" of a row are eps_R of its single tests, "error" their mean with its 95 % interval; the lowest and the highest error
    are of these means. A value that leaves no structure has none.
    """
    size = {"layers": 3, "rows": 10, "columns": 10} | {key: plan.settings[key] for key in SIZE if key in plan.settings}
    base = plan.test(grid=RPG, **size)
    values = sensitivity_values()
    values["side"] = (*values["side"], 2.0)  # the printed Dn = 2.14 m belongs to L = 2.0 m, the printed L = 1.5 m to 1.60 m
    values["margin"] = tuple(sorted({0.0, *values["margin"]}))
    values["friction"] = tuple(sorted({*values["friction"], *(round(friction**2, 4) for friction in values["friction"])}))
    cases = [(name, value) for name in values for value in values[name]]
    runs = _repeated_runs("table1", [replace(base, **{name: value}) for name, value in cases], plan, progress)
    measured = laboratory("table2", grid="RPG")
    rows = []
    for (name, value), own in zip(cases, runs, strict=True):
        errors = sensitivity.errors_of(own, measured)
        spread = {"errors": errors.tolist(), **sensitivity.spread(errors)}
        rows.append({"parameter": name, "value": value, **_summary(own, measured), **spread})
    known = [row["error"] for row in rows if np.isfinite(row["error"])] or [np.nan]
    return _document("table1", plan) | {
        "rows": rows,
        "parameters": sensitivity.parameters_of(rows),
        "lowest_error": min(known),
        "highest_error": max(known),
        "base": {name: getattr(base, name) for name in values},
        "units": sum(len(base.centres(layer)) for layer in range(1, base.layers + 1)),
    }


def figures(plan, progress=None):
    """Both grids with the true unit and with its convex hull: what the README's plot shows."""
    cases = [(grid, shape) for grid in (RPG, TPG) for shape in ("pieces", "hull")]
    runs = _repeated_runs("figures", [plan.test(grid=grid, shape=shape) for grid, shape in cases], plan, progress)
    shapes = {"pieces": {}, "hull": {}}
    for (grid, shape), own in zip(cases, runs, strict=True):
        shapes[shape][grid.name] = _summary(own, laboratory("table2", grid=grid))
    return _document("figures", plan) | {"shapes": shapes}


def drawn_results(plan, progress=None):
    """{name: PlacementResult} of the first seed that the drawings show: RPG, TPG, and on the 4 % slope, with the paper's rows of
    plates, "slope" by layer reference and, with ours, "blind"."""
    slope = {"grid": TPG, "bottom": Slope(0.04)}
    tests = {
        "RPG": plan.test(grid=RPG, seed=plan.seed),
        "TPG": plan.test(grid=TPG, seed=plan.seed),
        "slope": plan.test(**slope, seed=plan.seed, plate_rows=preset("paper")["plate_rows"]),
        "blind": plan.test(**slope, seed=plan.seed, reference="blind"),
    }
    found = _results(list(tests.values()), plan, progress)
    return {name: found[test] for name, test in tests.items()}


# -------------------------------------------------------------------------------------------------------------- pieces
def _table(name, grids, plan, progress):
    """The document of a table; beside its first cell of settings stands, under "other_settings", every other one, and under
    "reference" what other engines were measured to give (docs/errata.md)."""
    tests = [plan.test(**cell, **case) for cell in plan.cells for case in grids.values()]
    runs = iter(_repeated_runs(name, tests, plan, progress))
    first, *others = (
        {**cell, "grids": {grid: _summary(next(runs), laboratory(name, grid=grid)) for grid in grids}} for cell in plan.cells
    )
    reference = {grid: reference_runs(name, grid) for grid in grids}
    return _document(name, plan, **plan.cells[0]) | {"grids": first["grids"], "other_settings": others, "reference": reference}


def _document(name, plan, **changes):
    seeds = plan.seeds(name)
    settings = {key: value for key, value in placement_table(plan.test(**changes)).items() if key not in VARIED}
    return {"format": 1, "table": name, "repeats": len(seeds), "seeds": seeds, "settings": settings, "versions": versions()}


def _summary(results, measured):
    """What the contract says of one grid: layers, errors against the measurement, height, porosity, lost and unsettled units.

    "tests" of a layer are those that left a structure and read it; where none did, its numbers are nan.
    """
    model = _mean(results, lambda result: result.layer_coefficients)
    layers = len(model.mean)
    comparison = compare_layers(model, measured)
    rows = [
        {
            "layer": j + 1,
            "mean": float(model.mean[j]),
            "cv": float(model.cv[j]),
            "tests": int(model.tests[j]),
            "relative_error": float(abs(comparison.signed_errors[j])),
        }
        for j in range(layers)
    ]
    return {
        "layers": rows,
        "mean_relative_error": comparison.mean_relative_error,
        "signed_bias": comparison.signed_bias,
        "height_over_dn": float(model.mean.sum()),
        "height_error": comparison.height_error,
        "porosity": float(_mean(results, lambda result: [result.porosity]).mean[0]),
        **_counts(results),
    }


def _mean(results, numbers):
    """The Sample of some numbers of repeated tests, `numbers`(result) -> (n,), by those that left a structure.

    What a run that left none reads is no layer coefficient: its units move, hang in the air, or lie about. It stays out of
    every mean and range. Where no run is left the numbers are nan, of 0 tests.
    """
    return repeated([np.where(result.stands, numbers(result), np.nan) for result in results])


def _counts(results):
    """Units of one test; those lost and unsettled in all tests together; the deepest overlap; seconds a test."""
    return {
        "units": sum(len(poses) for poses in results[0].poses),
        "lost_units": int(sum(result.lost.sum() for result in results)),
        "unsettled_units": sum(record.unsettled for result in results for record in result.records),
        "max_penetration_over_dn": max(
            record.penetration / result.test.unit.nominal_diameter for result in results for record in result.records
        ),
        "wall_seconds_per_test": float(np.mean([result.wall_seconds for result in results])),
    }


def run_test(test):
    """The result of a test; a plain function that another process can be asked for."""
    return test.run()


def _repeated_runs(name, cases, plan, progress):
    """The results of each case, a PlacementTest, with all seeds of a table; ``progress(total)`` gives the function to be called
    as each run ends."""
    tests = [replace(case, seed=seed) for case in cases for seed in plan.seeds(name)]
    found = _results(tests, plan, progress)
    return [[found[replace(case, seed=seed)] for seed in plan.seeds(name)] for case in cases]


def _results(tests, plan, progress):
    """{test: result} of all tests of a plan so far, these among them: the calibrated values stand once in every parameter of
    Table 1, and in other tables too."""
    unique = [test for test in dict.fromkeys(tests) if test not in plan.results]
    results = parallel.in_order(run_test, unique, plan.workers, progress(len(unique)) if progress else None)
    plan.results.update(zip(unique, results, strict=True))
    return plan.results
