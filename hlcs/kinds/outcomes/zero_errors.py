"""An input that is off by the same in all rows: no effect of the library, and it may do what effects do.

A height counted to the top of a body in place of its lower end, or along a ruler whose zero is not its end, is off by a constant
that no scatter of replicates shows; so are the speed of a launcher and the zero of a protractor. An effect that is found beside
it is not wrong about the data, so the report names both.
"""

from dataclasses import replace

import numpy as np
from scipy import optimize

from hlcs.data.bodies import bounding_radius
from hlcs.data.notes import AsItIs
from hlcs.estimation.fitting import chi2_of
from hlcs.kinds.outcomes.setting_errors import within
from hlcs.report.words import AS_IT_IS, size
from hlcs.selection.thresholds import TIED

END = "from which point of the body, and from which end of the ruler, it is counted"
ZEROS = {  # inputs with one zero -> their unit, what to check
    ("height_m",): ("m", END),
    ("distance_m",): ("m", END),
    ("mark_1_m", "mark_2_m"): ("m", END),
    ("speed_m_s",): ("m/s", "how the speed was measured, and where"),
    ("angle_deg",): ("degrees", "where the angle is counted from, with a level"),
}
FASTER, TURNED = 0.5, 5.0  # of the smallest speed, degrees: farther off than that nobody takes them for right


def zero_errors_told(problem, model, chi2, judge):
    """The notes on lengths with whose zero elsewhere the model under test leaves nothing but noise, () of none.

    chi2: of the best set, in the same problem; judge: (problem, fit) -> (Adequacy, table of observations). The zero of a length
    is looked for no farther off than the smallest body is long: it is counted from one of its points.
    """
    inputs, reaches = problem.table.inputs, [bounding_radius(setup.body) for setup in problem.setups]
    most = {
        "m": 0.0 if None in reaches else 2 * min(reaches),
        "m/s": FASTER * float(np.min(inputs.get("speed_m_s", 0.0))),
        "degrees": TURNED,
    }
    return tuple(
        note
        for names, (unit, _) in ZEROS.items()
        if most[unit] and all(name in inputs for name in names)
        for note in _told(problem, model, names, most[unit], chi2 + TIED, judge)
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
    unit, check = ZEROS[names]
    error = f" +- {size(np.sqrt(2 / bend), unit)}" if 0 < bend < np.inf else ""
    which, side = " and ".join(names) + (" is" if len(names) == 1 else " are"), "more" if found.x > 0 else "less"
    stated = f"{size(abs(found.x), unit)}{error} {side} than stated in all rows alike"
    return (AsItIs(f"if {which} {stated}, {AS_IT_IS}. Check {check}"),)


def with_zero_at(problem, names, offset):
    """The TableProblem with inputs of these names larger by an offset, as far as there are such."""
    table = problem.table
    inputs = table.inputs | {name: within(name, table.inputs[name] + offset) for name in names}
    return problem.with_inputs(replace(table, inputs=inputs))
