"""Overlaps taken away by moving bodies, without giving them any velocity.

What the contact problem leaves of overlap comes from its linearisation and its tolerance; a velocity that undid it would be
energy from nowhere.
"""

import numpy as np

from minibullet.contact.problem import velocity_along
from minibullet.kernels import leaf


def separation_displacement(factors, gap, tolerance, share=0.3, sweeps=10):
    """Displacement of the bodies (n, 6) that takes away ``share`` of every overlap deeper than its tolerance (m,).

    A frictionless problem of its own, solved by at most so many sweeps of Gauss-Seidel, until one moves nothing by more than a
    hundredth of the tolerance: overlaps open, gaps stay gaps.
    """
    displacement = np.zeros((len(factors.inverse_mass), 6))
    wanted = np.where(gap < -tolerance, -share * (gap + tolerance), -np.maximum(gap, 0.0))
    push_apart(factors, wanted, 0.01 * tolerance, sweeps, np.zeros(len(gap)), displacement)
    return displacement


@leaf
def push_apart(factors, wanted, negligible, sweeps, push, displacement):
    """The sweeps: each contact opens by at least ``wanted`` (m,). push (m,), how hard each contact pushes, and displacement
    (n, 6) are brought up to date in place."""
    for _ in range(sweeps):
        settled = True
        for c in range(len(wanted)):
            v, w = displacement[factors.bodies[c, 0]], displacement[factors.bodies[c, 1]]
            by_unit = factors.block[c, 0, 0]
            if by_unit == 0.0:
                continue  # neither of the two may be moved
            step = max(push[c] + (wanted[c] - velocity_along(c, factors, 0, v, w)) / by_unit, 0.0) - push[c]
            if step == 0.0:
                continue
            push[c] += step
            for k in range(6):
                v[k] -= step * factors.inverse_mass_jacobian[c, 0, 0, k]
                w[k] += step * factors.inverse_mass_jacobian[c, 1, 0, k]
            settled = settled and abs(step) * by_unit <= negligible[c]
        if settled:
            return


def undo_overlap(problem, gap, size, time_step):
    """Extra mean twist (n, 6) for this step's move that takes away a share of every overlap beyond 1e-9 of the contact's size
    (m,)."""
    tolerance = 1e-9 * size
    if not np.count_nonzero(gap < -tolerance):
        return 0.0
    return separation_displacement(problem.factors, gap, tolerance) / time_step
