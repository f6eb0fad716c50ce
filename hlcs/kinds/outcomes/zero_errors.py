"""A length of the inputs that is off by the same in all rows: no effect of the library, and it may do what effects do.

A height counted to the top of a body in place of its lower end, or along a ruler whose zero is not its end, is off by a constant
that no scatter of replicates shows. An effect that is found beside it is not wrong about the data, so the report names both.
"""

from dataclasses import replace

import numpy as np
from scipy import optimize

from hlcs.data.bodies import bounding_radius
from hlcs.estimation.fitting import chi2_of
from hlcs.kinds.outcomes.setting_errors import within
from hlcs.report.words import AS_IT_IS, size
from hlcs.selection.thresholds import TIED

LENGTHS = {"height_m": ("height_m",), "distance_m": ("distance_m",), "mark_2_m": ("mark_1_m", "mark_2_m")}  # with one zero


def zero_errors_told(problem, model, chi2, judge):
    """The notes on lengths with whose zero elsewhere the model under test leaves nothing but noise, () of none.

    chi2: of the best set, in the same problem; judge: (problem, fit) -> (Adequacy, table of observations). A zero is looked for
    no farther off than the smallest body is long: a length is counted from one of its points.
    """
    reaches = [bounding_radius(setup.body) for setup in problem.setups]
    most = 0.0 if None in reaches else 2 * min(reaches)
    return tuple(
        note
        for names in LENGTHS.values()
        if most and all(name in problem.table.inputs for name in names)
        for note in _told(problem, model, names, most, chi2 + TIED, judge)
    )


def _told(problem, model, names, most, worst, judge):
    """The note on inputs of these names, () where no common error of theirs up to `most` leaves chi2 below `worst` and noise."""

    def misfit(offset):
        moved = with_zero_at(problem, names, offset)
        return float(sum(chi2_of(moved.white_residuals(model, moved.initial_guess()))))

    found = optimize.minimize_scalar(misfit, bounds=(-most, most), method="bounded", options={"xatol": 1e-4 * most})
    moved = with_zero_at(problem, names, found.x)
    if not found.fun < worst or not judge(moved, moved.fit(model))[0].adequate:
        return ()
    step = 0.01 * most
    bend = (misfit(found.x + step) + misfit(found.x - step) - 2 * found.fun) / step**2
    error = f" +- {size(np.sqrt(2 / bend), 'm')}" if 0 < bend < np.inf else ""
    which, side = " and ".join(names), "more" if found.x > 0 else "less"
    return (
        f"if {which} {'is' if len(names) == 1 else 'are'} {size(abs(found.x), 'm')}{error} {side} than stated in all rows alike, "
        f"{AS_IT_IS}. Check from which point of the body, and from which end of the ruler, it is counted",
    )


def with_zero_at(problem, names, offset):
    """The TableProblem with inputs of these names larger by an offset [m], as far as there are such."""
    table = problem.table
    inputs = table.inputs | {name: within(name, table.inputs[name] + offset) for name in names}
    return problem.with_inputs(replace(table, inputs=inputs))
