"""A ball on a slope rolls where friction is large enough; where the stated one is not, its slide may stand in for rolling.

So may that of a cylinder or a disc, which stand on an end here. A body that rolls without slipping goes as one without friction
whose weight accelerates 1 + I / (m r^2) times its mass. A slide with a friction of 2/7 of the slope does the same as a solid
ball: the report names both.
"""

from dataclasses import replace

import numpy as np

from hlcs.data.notes import AsItIs
from hlcs.data.rigid_body import known_body
from hlcs.kinds.outcomes.designs import ON_A_FLOOR
from hlcs.report.words import AS_IT_IS, size
from hlcs.simulation import outcome_motion

TURNS_ABOUT = {"sphere": 1, "cylinder": 2, "disc": 2}  # what may roll -> the axis of the body about which it then turns
GRIPS = "With a friction stated that makes it grip its slope (2/7 of the slope, of a solid ball) it rolls here too"
AS_A_BALL = "Stated as a sphere of its radius, mass and inertia, with a friction that makes it grip, it rolls here too"


def held_told(problem, model):
    """The note on balls that roll, since they grip their slope with the friction of the model under test; () of none."""
    if problem.table.outcome != "slide_time_s" or "distance_m" not in problem.distinct:
        return ()
    friction = np.array([setup.surroundings.friction for setup in problem.setups])
    friction = next((entry["coefficient"] for entry in model.entries if entry["name"] == "friction"), friction)
    held = outcome_motion.rolling(problem.setups, problem.distinct, friction)[problem.back]
    if not held.any():
        return ()
    rows = "all rows" if held.all() else f"{int(held.sum())} of {len(held)} rows"
    return (f"{rows}: in the model as it is the ball grips its slope, so it rolls without slipping",)


def rolling_told(problem, model, judge):
    """The note on round bodies with whose rolling the model under test leaves nothing but noise, () of none.

    judge: (problem, fit) -> (Adequacy, table of observations). What was found need not do worse: rolling is what they do, and
    needs no number. The drag of the air slows what rolls by as much less, which is left out: it is small where one rolls.
    """
    shape, inputs = problem.file.body.shape, problem.table.inputs
    if problem.table.outcome not in ON_A_FLOOR or shape not in TURNS_ABOUT or not known_body(problem.file.body):
        return ()
    rolls = that_rolls(problem)
    if not judge(rolls, rolls.fit(model))[0].adequate:
        return ()
    rolling = f"if the body rolls without slipping, in place of sliding as the stated friction lets it, {AS_IT_IS}"
    let_go = problem.table.outcome == "slide_time_s" and "distance_m" in inputs and not np.any(inputs.get("speed_m_s", 0.0))
    here = f". {GRIPS if shape == 'sphere' else AS_A_BALL}, and its times tell the resistance to rolling" if let_go else ""
    return (AsItIs(f"{rolling}{here}"),)


def rolled_told(problem, fit):
    """The note on balls that may have rolled to their stop, where a friction in a Fit stops them; () of none.

    Rolling resistance of an arm b slows a ball by g (b/r) / (1 + k), k = I/(m r^2), sliding by mu g: the same path.
    """
    body, found = problem.file.body, fit.model.numbers.get("friction")
    if problem.table.outcome != "stop_distance_m" or body.shape != "sphere" or not known_body(body) or not found:
        return ()
    arm = found["coefficient"] * body.radius * (1 + outcome_motion.turning(body))
    stops = "in place of sliding, it is stopped by its resistance to rolling, not by friction"
    return (AsItIs(f"if the ball rolls to its stop, {stops}: an arm of {size(arm, 'm')} (rolling_friction) does the same"),)


def that_rolls(problem):
    """The TableProblem of bodies that roll without slipping."""
    heavier = 1 + outcome_motion.turning(problem.file.body, TURNS_ABOUT[problem.file.body.shape])
    around, inputs = problem.file.surroundings, dict(problem.table.inputs)
    inputs.pop("friction", None)
    if "gravity_m_s2" in inputs:
        inputs["gravity_m_s2"] = inputs["gravity_m_s2"] / heavier
    file = replace(problem.file, surroundings=replace(around, friction=0.0, gravity=around.gravity / heavier))
    table = replace(problem.table, inputs=inputs)
    never = np.zeros(len(table.values), bool)
    return type(problem)(file, table, problem.scatter, problem.trials, problem.errors, never, problem.own)
