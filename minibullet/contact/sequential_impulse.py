"""Sequential impulse, Bullet's way: normal and friction rows clamped one after another, a fixed number of sweeps.

Side by side with ``solver.solve``, same arguments and result: to compare, to teach, and to do what the paper's engine did.
Each friction row is clamped alone at mu times the normal impulse, which makes a friction pyramid: between the axes it is up
to sqrt(2) too strong, and its fixed point is not Coulomb's law. Source: E. Catto, GDC 2006; Bullet's
btSequentialImpulseConstraintSolver.
"""

import numpy as np

from minibullet.contact.gauss_seidel import BREATH, certify, free_size
from minibullet.contact.problem import ANSWER_A, ANSWER_B, BLOCK, apply_impulses, velocity_along
from minibullet.kernels import kernel


@kernel
def sweep_rows(bodies, rows, target, friction, impulse, twist, iterations):
    """``iterations`` sweeps: all normal rows, then all friction rows; impulses and twists in place."""
    for _ in range(iterations):
        for tangential in range(2):
            for c in range(len(bodies)):
                for i in range(1 if tangential else 0, 3 if tangential else 1):
                    speed = velocity_along(rows[c], i, twist[bodies[c, 0]], twist[bodies[c, 1]]) - (target[c] if i == 0 else 0.0)
                    wanted = impulse[c, i] - speed / rows[c, BLOCK + 4 * i]
                    if i == 0:
                        new = max(wanted, 0.0)
                    else:
                        limit = friction[c] * impulse[c, 0]
                        new = min(max(wanted, -limit), limit)
                    step = new - impulse[c, i]
                    impulse[c, i] = new
                    for k in range(6):
                        twist[bodies[c, 0], k] -= step * rows[c, ANSWER_A + 6 * i + k]
                        twist[bodies[c, 1], k] += step * rows[c, ANSWER_B + 6 * i + k]


def solve(problem, impulse, moment, *, iterations=50, tolerance=1e-6, stop=False):
    """Solve a ContactProblem by sequential impulses from a starting ``impulse`` (m, 3, contact axes); rolling moments are not
    part of it."""
    impulse, twist = impulse.copy(), problem.free_twist.copy()
    apply_impulses(problem.bodies, problem.rows, impulse, twist)
    portion = 1 + BREATH // (1 + len(problem.bodies))  # sweeps without a look at Ctrl-C
    for done in range(0, iterations, portion):
        sweeps = min(portion, iterations - done)
        sweep_rows(problem.bodies, problem.rows, problem.target, problem.friction, impulse, twist, sweeps)
    stalled = np.empty(0, dtype=np.int64)
    return certify(
        problem, impulse, np.zeros_like(impulse), twist, free_size(problem), iterations, iterations * len(problem.bodies), stalled
    )
