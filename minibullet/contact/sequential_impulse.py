"""Sequential impulse, Bullet's way: normal and friction rows clamped one after another, a fixed number of sweeps.

Side by side with ``gauss_seidel.solve``, same arguments and result: to compare, to teach, and to do what the paper's engine did.
Each friction row is clamped alone at mu times the normal impulse, which makes a friction pyramid: between the axes it is up
to sqrt(2) too strong, and its fixed point is not Coulomb's law. Source: E. Catto, GDC 2006; Bullet's
btSequentialImpulseConstraintSolver.
"""

import numpy as np

from minibullet.contact.gauss_seidel import UNINTERRUPTED, Solution
from minibullet.contact.problem import Iterate, apply_impulses, velocity_along
from minibullet.contact.residual import residual_of
from minibullet.kernels import kernel


@kernel
def clamped_sweeps(factors, target, friction, impulse, twist, iterations):
    """``iterations`` sweeps: all normal rows, then all friction rows; impulses and twists in place."""
    for _ in range(iterations):
        for tangential in range(2):
            for c in range(len(target)):
                v, w = twist[factors.bodies[c, 0]], twist[factors.bodies[c, 1]]
                for i in range(1 if tangential else 0, 3 if tangential else 1):
                    speed = velocity_along(c, factors, i, v, w) - (target[c] if i == 0 else 0.0)
                    wanted = impulse[c, i] - speed / factors.block[c, i, i]
                    if i == 0:
                        new = max(wanted, 0.0)
                    else:
                        limit = friction[c] * impulse[c, 0]
                        new = min(max(wanted, -limit), limit)
                    step = new - impulse[c, i]
                    impulse[c, i] = new
                    for k in range(6):
                        v[k] -= step * factors.inverse_mass_jacobian[c, 0, i, k]
                        w[k] += step * factors.inverse_mass_jacobian[c, 1, i, k]


def solve(problem, impulse, moment, *, iterations=50, tolerance=1e-6):
    """Solve a ContactProblem by sequential impulses from a starting ``impulse`` (m, 3, contact axes); rolling moments are not
    part of it, and ``tolerance`` stops no sweeps."""
    iterate = Iterate(impulse.copy(), np.zeros_like(impulse), problem.free_twist.copy())
    apply_impulses(problem.factors, impulse, iterate.twist)
    portion = 1 + UNINTERRUPTED // (1 + len(impulse))  # sweeps without a look at Ctrl-C
    for done in range(0, iterations, portion):
        sweeps = min(portion, iterations - done)
        clamped_sweeps(problem.factors, problem.target, problem.friction, iterate.impulse, iterate.twist, sweeps)
    unconverged = np.empty(0, dtype=np.int64)
    return Solution(*iterate, residual_of(problem, iterate), iterations, iterations * len(impulse), unconverged)
