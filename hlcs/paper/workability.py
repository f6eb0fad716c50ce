"""Can a grid be built without sight? Lost and misplaced units with blind reference: by the set-back of the layers, and by grid
spacing and placement error. Units are counted by structure: those of one structure hang together."""

import numpy as np

from hlcs.paper import reproduce
from hlcs.placement.grids import TPG, Grid
from hlcs.placement.number_text import or_dash
from hlcs.placement.placement_result import MISPLACED
from hlcs.placement.sea_bottom import Flat, Slope

SET_BACKS = (0.0, 0.5, 1.0)  # [spacings]
ROOM = {"rows": 10, "columns": 10, "layers": 4}  # so that four layers are left with a set-back of a spacing
WIDER = (1.0, 1.05, 1.1)  # grid spacing over that of the TPG, both ways; below 1 the first layer does not fit
SCATTERS = (0.0, 0.1, 0.2)  # standard deviation of the aims [Dn]


def set_back(plan, progress=None):
    """Both references and bottoms with the layers set back by half a spacing and one; every case beside that without, by seed."""
    cases = [
        (bottom, reference, back) for bottom in (Flat(), Slope(0.04)) for reference in ("layer", "blind") for back in SET_BACKS
    ]
    size = ROOM | {key: plan.settings[key] for key in ROOM if key in plan.settings}
    tests = [plan.test(**size, grid=TPG, bottom=bottom, reference=reference, set_back=back) for bottom, reference, back in cases]
    rows = []
    for (bottom, reference, back), own in zip(cases, reproduce._repeated_runs("set_back", tests, plan, progress), strict=True):
        rows.append({"bottom_slope": getattr(bottom, "grade", 0.0), "reference": reference, "set_back": back, **counts(own)})
    for row in rows:
        alike = [other for other in rows if all(other[key] == row[key] for key in ("bottom_slope", "reference"))]
        row["change"] = reproduce.differences(alike[0], row)
    return reproduce._document("set_back", plan) | {"cases": rows}


def workability(plan, progress=None):
    """Blind reference on the flat bottom over grid spacing and placement error."""
    cases = [(wider, scatter) for wider in WIDER for scatter in SCATTERS]
    tests = [plan.test(grid=widened(TPG, wider), reference="blind", placement_scatter=scatter) for wider, scatter in cases]
    rows = []
    for test, own in zip(tests, reproduce._repeated_runs("workability", tests, plan, progress), strict=True):
        spacings = {"spacing_x": test.grid.spacing_x, "spacing_y": test.grid.spacing_y}
        height = reproduce.interval([result.height_over_dn if result.stands else np.nan for result in own])
        rows.append({**spacings, "placement_scatter": test.placement_scatter, **counts(own), "height": height})
    return reproduce._document("workability", plan) | {"cases": rows}


def widened(grid, factor):
    """A triangular grid with both spacings so many times as wide."""
    x, y = round(grid.spacing_x * factor, 4), round(grid.spacing_y * factor, 4)
    return grid if factor == 1.0 else Grid.parse(f"{x},{y},triangular").stacked(grid.stacking)


def counts(results):
    """Lost and misplaced units of repeated tests: of each structure, and their mean with its 95 % interval (Student)."""
    found = {
        "lost_by_test": [int(result.lost.sum()) for result in results],
        "misplaced_by_test": [reproduce.misplaced(result) for result in results],
        "drift_by_test": [[float(d) for d in result.drift] for result in results],
    }
    intervals = {name: reproduce.interval(found[f"{name}_by_test"]) for name in ("lost", "misplaced")}
    return {**found, **intervals, "units": sum(len(poses) for poses in results[0].poses)}


def set_back_text(document):
    """What `hlcs reproduce set_back` prints."""
    lines = [
        f"Set-back of the layers on TPG, {document['repeats']} structures a case",
        "units of a structure: mean [95 % interval, Student]",
        f"{'bottom':>8}{'reference':>11}{'set-back':>10}{'units':>7}{'lost':>20}{'misplaced':>20}{'change of lost':>22}",
    ]
    for row in document["cases"]:
        bottom = f"{row['bottom_slope']:.0%}" if row["bottom_slope"] else "flat"
        change = with_interval(row["change"]["lost"], "+.1f") if row["set_back"] else ""
        lines.append(
            f"{bottom:>8}{row['reference']:>11}{row['set_back']:>10g}{row['units']:>7}{with_interval(row['lost']):>20}"
            f"{with_interval(row['misplaced']):>20}{change:>22}"
        )
    return "\n".join([*lines, SET_BACK_NOTE])


SET_BACK_NOTE = """\
set-back: every layer keeps at least so many spacings back from the edge of the one below; 0: as far as the hollows do, 1/3 at
the steep flank. The change is that of structures of the same seed; a structure set back has fewer units."""


def workability_text(document):
    """What `hlcs reproduce workability` prints."""
    lines = [
        f"Blind reference, {document['repeats']} structures a case: units of a structure, mean [95 % interval, Student]",
        f"{'a x b [Dn]':>14}{'scatter [Dn]':>14}{'lost':>20}{'misplaced':>20}{'height/Dn':>11}",
    ]
    for row in document["cases"]:
        grid = f"{row['spacing_x']:.3f} x {row['spacing_y']:.3f}"
        lines.append(
            f"{grid:>14}{row['placement_scatter']:>14g}{with_interval(row['lost']):>20}{with_interval(row['misplaced']):>20}"
            f"{or_dash(row['height']['mean'], '.3f'):>11}"
        )
    return "\n".join([*lines, f"misplaced: farther than {MISPLACED:g} Dn from the aim, in plan; of {row['units']} units."])


def with_interval(found, form=".1f"):
    """Text of {"mean", "low", "high"}: mean [low, high]."""
    return f"{or_dash(found['mean'], form)} [{or_dash(found['low'], form)}, {or_dash(found['high'], form)}]"
