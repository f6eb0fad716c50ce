"""The exact solver inside a step: islands on which Gauss-Seidel ended above the tolerance are solved by Newton's method."""

import numpy as np

from minibullet.contact.block_rows import block_problem
from minibullet.contact.exact import STEP_EFFORT, VAIN_EFFORT, solve_blocks
from minibullet.contact.problem import Iterate, apply_impulses
from minibullet.contact.residual import residual_of

MOST_CONTACTS = 2000  # of an island: a larger one keeps what Gauss-Seidel found [-]


def solve_unconverged(problem, solution, tolerance):
    """Solve the unconverged islands of a Solution from where Gauss-Seidel ended, those of at most ``MOST_CONTACTS``."""
    impulse, outer = solution.impulse.copy(), 0
    for island in solution.unconverged:
        contacts = problem.order[problem.islands[island] : problem.islands[island + 1]]
        if problem.rolling[contacts].any() or len(contacts) > MOST_CONTACTS:
            continue  # rolling moments are solved by Gauss-Seidel alone
        # what a light body does is a small difference of impulses that heavy ones hand it: their rounding over its mass
        light = problem.factors.inverse_mass[np.unique(problem.factors.bodies[contacts]), 0, 0]
        light = light[light > 0.0]
        effort = VAIN_EFFORT if np.finfo(float).eps * light.max() > 0.5 * tolerance * light.min() else STEP_EFFORT
        blocks, start = block_problem(problem, contacts), impulse[contacts].reshape(-1)
        solved, _, used, _ = solve_blocks(blocks, start, 0.5 * tolerance, problem.reference_mass, effort, sweeps=0)
        impulse[contacts], outer = solved.reshape(-1, 3), outer + used
    iterate = Iterate(impulse, solution.moment, solution.twist.copy())
    apply_impulses(problem.factors, impulse - solution.impulse, iterate.twist)
    return solution._replace(**iterate._asdict(), residual=residual_of(problem, iterate), outer=outer)
