"""An input that is off alike in all rows: no effect of the library, and it may do what effects do.

A height counted to the top of a body in place of its lower end, or along a ruler whose zero is not its end, is off by a constant
that no scatter of replicates shows; so are the speed of a launcher and the zero of a protractor. What reads a speed or an angle
may also be off by a factor; that of a length or a time is an effect. And an outcome may hold more than the motion, in proportion
to an input: the way of a car before its driver brakes, the time that sound takes up a well. An effect that is found beside it is
not wrong about the data, so the report names both.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import optimize, special

from hlcs.data.bodies import bounding_radius
from hlcs.data.notes import AsItIs
from hlcs.estimation.fitting import chi2_of
from hlcs.kinds.outcomes.designs import ON_A_FLOOR
from hlcs.kinds.outcomes.setting_errors import within
from hlcs.report.words import AS_IT_IS, joined, size, words
from hlcs.selection.thresholds import INTERVAL, TIED

END = "from which point of the body, and from which end of the ruler, it is counted"
ZEROS = {  # what is read from one zero -> its unit, what to check
    ("height_m",): ("m", END),
    ("rebound_height_m",): ("m", END),
    ("height_m", "rebound_height_m"): ("m", END),
    ("distance_m",): ("m", END),
    ("range_m",): ("m", END),
    ("stop_distance_m",): ("m", END),
    ("mark_1_m", "mark_2_m"): ("m", END),
    ("speed_m_s",): ("m/s", "how the speed was measured, and where"),
    ("angle_deg",): ("degrees", "where the angle is counted from, with a level"),
}
SCALES = {  # what is read from one scale that no effect knows -> what to check
    ("speed_m_s",): "what measured the speed, beside another way to measure it",
    ("angle_deg",): "what measured the angle, against angles that are known",
    ("slope",): "how the slope was measured: rise over run, not over the length of the slope",
}
ALONG = 1.1  # of the length of a body: how far off a zero is looked for, which noise may move beyond its end
HOLDS = {  # outcome, in proportion to which input it may hold more -> unit of the ratio, the most that it may be, what to check
    ("stop_distance_m", "speed_m_s"): ("s", 2.0, "whether it is counted from the brake, or a reaction time earlier"),
    ("fall_time_s", "height_m"): ("s/m", 1 / 300, "whether the impact was heard at the top: sound takes 0.0029 s a metre"),
}
FASTER, TURNED = 0.5, 5.0  # of the smallest speed, degrees: farther off than that nobody takes them for right
ASIDE = 0.1  # of the shortest length its zero too, where that is many bodies' lengths: the edge of a bench
SCALED = 0.25  # as a part of what is stated: a ball that rolled down leaves with 0.77 to 0.85 of the speed of one that slid


class Zero(NamedTuple):
    """An input, or the outcome, that is off alike in all rows, and with which a model leaves nothing but noise."""

    chi2: float
    cost: float  # -2 log of the evidence, as `Fit.cost`: it is believed to be off by half as much as is looked for, or less
    note: AsItIs


def zeros_of(problem, model, judge):
    """The Zeros of a model, in the order of ZEROS and SCALES; judge: (problem, fit) -> (Adequacy, table of observations).

    The zero of a length is looked for about as far off as the smallest body is long, since it is counted from one of its points,
    or ASIDE of the shortest such length.
    """
    inputs, reaches = problem.table.inputs, [bounding_radius(setup.body) for setup in problem.setups]
    long = 0.0 if None in reaches else ALONG * 2 * min(reaches)
    known = inputs | {problem.table.outcome: problem.table.values}
    shortest = {name: float(np.min(known.get(name, 0.0))) for (name, *_) in ZEROS}
    most = {"m/s": FASTER * shortest["speed_m_s"], "degrees": TURNED}
    level = problem.table.outcome in ON_A_FLOOR and not {*inputs} & {"angle_deg", "slope"}  # then the floor may slope after all
    read = {*inputs, problem.table.outcome, *(["angle_deg"] if level else [])}
    ends = [
        (names, unit, most.get(unit, max(long, ASIDE * shortest[names[0]])), check, with_zero_at)
        for names, (unit, check) in ZEROS.items()
    ]
    asked = [each for each in ends if each[2] and read.issuperset(each[0])]
    asked += [(names, "%", SCALED, check, scaled) for names, check in SCALES.items() if np.ptp(inputs.get(names[0], 0.0)) > 0]
    asked += [
        (names, *each, holding) for names, each in HOLDS.items() if names[0] == problem.table.outcome and names[1] in inputs
    ]
    return tuple(filter(None, (_zero(problem, model, *each, judge) for each in asked)))


def zero_errors_told(found, chi2):
    """The notes on zeros; found: Zeros of each of some models, in the order in which they are asked, until one has a note; chi2:
    of the best set, in the same problem."""
    told = (tuple(zero.note for zero in zeros if zero.chi2 < chi2 + TIED) for zeros in found)
    return next(filter(None, told), ())


def _zero(problem, model, names, unit, most, check, changed, judge):
    """The Zero of what has these names, None where no common error of it up to `most`, in this unit or as a part of it where that
    is "%", leaves noise; changed: (problem, names, error) -> the problem with that error."""

    def misfit(offset):
        moved = changed(problem, names, offset)
        if model.terms:
            return moved.fit(model).chi2
        return float(sum(chi2_of(moved.white_residuals(model, moved.initial_guess()))))

    found = optimize.minimize_scalar(misfit, bounds=(-most, most), method="bounded", options={"xatol": 1e-4 * most})
    moved = changed(problem, names, found.x)
    fit = moved.fit(model)
    if not np.isfinite(found.fun) or not judge(moved, fit)[0].adequate:
        return None
    step, spread = 0.01 * most, 0.5 * most
    bend = (misfit(found.x + step) + misfit(found.x - step) - 2 * found.fun) / step**2
    known, at_end = 0 < bend < np.inf, abs(found.x) + step >= most
    cost = fit.cost + (found.x / spread) ** 2 + np.log1p(spread**2 * max(bend, 0.0) / 2)
    off, reach = abs(found.x), np.sqrt(2 * special.chdtri(1, 1 - INTERVAL) / bend) if known else 0.0
    off, error = (f"{100 * each:.2g} %" if unit == "%" else size(each, unit) for each in (off, reach))
    which, side = " and ".join(names) + (" is" if len(names) == 1 else " are"), "more" if found.x > 0 else "less"
    off = f"at least {off}" if at_end else f"{off} +- {error}" if known else off
    if changed is holding:
        wrong = f"{names[0]} holds {off} times {names[1]} {side} than the motion takes, in all rows alike"
    elif problem.table.outcome in names or names[0] in problem.table.inputs:
        wrong = f"{which} {off} {side} than stated in all rows alike"
    else:
        way, check = "down" if found.x > 0 else "up", "it with a level"
        wrong = f"the floor slopes {way} along the motion by {off} in all rows alike, which no column states"
    numbers = [f"{words(term.name)} {key} = {value:.4g}" for term in fit.model.terms for key, value in term.values]
    whose = AS_IT_IS.replace("as it is", f"with {joined(numbers)}") if numbers else AS_IT_IS
    return Zero(found.fun, float(cost), AsItIs(f"if {wrong}, {whose}. Check {check}"))


def with_zero_at(problem, names, offset):
    """The TableProblem with what has these names, inputs or the outcome, larger by an offset."""
    table = problem.table
    none = np.zeros(len(table.values))
    inputs = {name: within(name, table.inputs.get(name, none) + offset) for name in names if name != table.outcome}
    values = table.values + offset if table.outcome in names else table.values
    return problem.with_inputs(replace(table, inputs=table.inputs | inputs, values=values))


def holding(problem, names, ratio):
    """The TableProblem without what its outcome holds beside the motion: a ratio times an input; names: outcome, input."""
    table = problem.table
    return problem.with_inputs(replace(table, values=table.values - ratio * table.inputs[names[1]]))


def scaled(problem, names, part):
    """The TableProblem with the input that has this one name larger by a part of itself."""
    (name,) = names
    table = problem.table
    return problem.with_inputs(replace(table, inputs=table.inputs | {name: within(name, table.inputs[name] * (1 + part))}))
