"""The Delassus operator W formed: as a matrix for the curious, and as block rows without its zeros for the exact solver.

Beside the road: a step solved by Gauss-Seidel forms nothing of this. The kernels on block rows are the exact solver's.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from minibullet.contact.coulomb import project_cone, solve_coulomb
from minibullet.contact.problem import velocity_beyond_target
from minibullet.contact.residual import natural_map_error
from minibullet.kernels import kernel, leaf

MACHINE_EPSILON = 2.220446049250313e-16


class BlockProblem(NamedTuple):
    """The friction problem u = W r + q of m contacts, W as block rows: row i has the blocks block[start[i]:start[i + 1]]."""

    start: np.ndarray  # first block of each row, and the end, int64 (m + 1,)
    column: np.ndarray  # column of each block, ascending in a row, int64 (b,)
    block: np.ndarray  # contact axes [1/kg], (b, 3, 3)
    q: np.ndarray  # velocity without contact impulses, the target taken off the normal row [m/s], (3m,)
    friction: np.ndarray  # Coulomb coefficient [-], (m,)


def delassus(problem, contacts=slice(None)):
    """Form W (3m, 3m) and q (3m,) of the chosen contacts (all by default), so that u = W r + q with the target taken off the
    normal row.

    W = J M^-1 J^T; q = J free twist - target n [1/kg, m/s].
    """
    chosen, q = chosen_contacts(problem, contacts)
    count = len(chosen.bodies)
    used, place = np.unique(chosen.bodies, return_inverse=True)
    J, inverse_mass_J = np.zeros((2, count, 3, len(used), 6))
    for side, sign in ((0, -1.0), (1, 1.0)):
        at = np.arange(count), slice(None), place.reshape(count, 2)[:, side]
        J[at] += sign * chosen.jacobian[:, side]
        inverse_mass_J[at] += sign * chosen.inverse_mass_jacobian[:, side]
    return J.reshape(3 * count, -1) @ inverse_mass_J.reshape(3 * count, -1).T, q


def block_problem(problem, contacts):
    """The chosen contacts as a BlockProblem: what ``delassus`` forms, without the zeros."""
    chosen, q = chosen_contacts(problem, contacts)
    blocks = coupled_blocks(chosen, *contacts_of_bodies(chosen.bodies, chosen.inverse_mass[:, 0, 0] > 0.0))
    return BlockProblem(*blocks, q, problem.friction[contacts])


def chosen_contacts(problem, contacts):
    """The factors of W and q (3m,) of the chosen contacts."""
    whole, q = problem.factors, velocity_beyond_target(problem, problem.free_twist)
    chosen = whole._replace(
        bodies=whole.bodies[contacts],
        jacobian=whole.jacobian[contacts],
        inverse_mass_jacobian=whole.inverse_mass_jacobian[contacts],
        block=whole.block[contacts],
    )
    return chosen, q[contacts].reshape(-1)


@kernel
def contacts_of_bodies(bodies, moving):
    """Contacts of each moving body, as a list of lists: where each body's begin (n + 1,), and the contacts."""
    first = np.zeros(len(moving) + 1, np.int64)
    for c in range(len(bodies)):
        for side in range(2):
            first[bodies[c, side] + 1] += moving[bodies[c, side]]
    first = np.cumsum(first)
    member, filled = np.empty(first[-1], np.int64), first.copy()
    for c in range(len(bodies)):
        for side in range(2):
            body = bodies[c, side]
            if moving[body]:
                member[filled[body]] = c
                filled[body] += 1
    return first, member


@kernel
def coupled_blocks(factors, first, member):
    """Start, column, block of the blocks of W between contacts that share a moving body; first, member: see
    ``contacts_of_bodies``."""
    bodies = factors.bodies
    m, capacity = len(bodies), 0
    start, seen = np.zeros(m + 1, np.int64), np.full(m, -1)
    for c in range(m):
        for side in range(2):
            capacity += first[bodies[c, side] + 1] - first[bodies[c, side]]
    column, block, total = np.empty(capacity, np.int64), np.zeros((capacity, 3, 3)), 0
    for c in range(m):
        start[c] = total
        for side in range(2):
            for other in member[first[bodies[c, side]] : first[bodies[c, side] + 1]]:
                if seen[other] < start[c]:
                    seen[other], column[total], total = total, other, total + 1
        column[start[c] : total] = np.sort(column[start[c] : total])
        for k in range(start[c], total):
            seen[column[k]] = k
            for side in range(2):
                for other_side in range(2):
                    body = bodies[c, side]
                    if first[body + 1] > first[body] and body == bodies[column[k], other_side]:
                        add_block(factors, (c, side), (column[k], other_side), block[k])
    start[m] = total
    return start, column[:total], block[:total]


@leaf
def add_block(factors, here, there, block):
    """Add to ``block`` what impulses of another contact do, through one body, to the velocity at this one (3, 3) [1/kg]. here,
    there: contact and side of the body."""
    rows, twists = factors.jacobian[here[0], here[1]], factors.inverse_mass_jacobian[there[0], there[1]]
    sign = 1.0 if here[1] == there[1] else -1.0
    for i in range(3):
        for k in range(3):
            value = 0.0
            for d in range(3):
                value += rows[i, d] * twists[k, d] + rows[i, 3 + d] * twists[k, 3 + d]
            block[i, k] += sign * value


@kernel
def velocity(problem, impulse):
    """u = W r + q, all (3m,)."""
    u = problem.q.copy()
    for i in range(len(problem.friction)):
        for k in range(problem.start[i], problem.start[i + 1]):
            j, W = 3 * problem.column[k], problem.block[k]
            for a in range(3):
                u[3 * i + a] += W[a, 0] * impulse[j] + W[a, 1] * impulse[j + 1] + W[a, 2] * impulse[j + 2]
    return u


@kernel
def natural_map_residual(problem, impulse, reference_mass):
    """E / max(|q|, |r|, |u|) with E = |r - P_K(r - u~)| and r in units of the reference mass; E itself if all of them vanish."""
    q, u, r = problem.q, velocity(problem, impulse), impulse / reference_mass
    error = 0.0
    for i in range(0, len(q), 3):
        error += natural_map_error((r[i], r[i + 1], r[i + 2]), (u[i], u[i + 1], u[i + 2]), problem.friction[i // 3])
    size = sqrt(max((q * q).sum(), (r * r).sum(), (u * u).sum()))
    return sqrt(error) / size if size > MACHINE_EPSILON else sqrt(error)


@kernel
def into_cone(friction, impulse):
    """A copy of impulse (3m,) with every contact projected on its friction cone."""
    inside = np.empty_like(impulse)
    for i in range(0, len(impulse), 3):
        r = impulse[i], impulse[i + 1], impulse[i + 2]
        inside[i], inside[i + 1], inside[i + 2] = project_cone(r, friction[i // 3])
    return inside


@kernel
def gauss_seidel(problem, impulse, sweeps):
    """Solve every contact exactly with the others held, in order, `sweeps` times; changes impulse (3m,) in place."""
    for _ in range(sweeps):
        for i in range(len(problem.friction)):
            b_n, b_1, b_2 = problem.q[3 * i], problem.q[3 * i + 1], problem.q[3 * i + 2]
            own = problem.start[i]
            for k in range(problem.start[i], problem.start[i + 1]):
                if problem.column[k] == i:
                    own = k
                    continue
                j, W = 3 * problem.column[k], problem.block[k]
                b_n += W[0, 0] * impulse[j] + W[0, 1] * impulse[j + 1] + W[0, 2] * impulse[j + 2]
                b_1 += W[1, 0] * impulse[j] + W[1, 1] * impulse[j + 1] + W[1, 2] * impulse[j + 2]
                b_2 += W[2, 0] * impulse[j] + W[2, 1] * impulse[j + 1] + W[2, 2] * impulse[j + 2]
            r = solve_coulomb(problem.block[own], (b_n, b_1, b_2), problem.friction[i])
            impulse[3 * i], impulse[3 * i + 1], impulse[3 * i + 2] = r
