"""The contact problem u = W r + q in factored form, W = H^T M^-1 H: records and the algebra on them. It knows no shapes and
no world.

The rows of H for one contact are its normal and two tangents. W itself is never formed for a step: a sweep needs only H and
M^-1 H^T of each contact, which is linear in the number of contacts. ``delassus`` forms W, for the exact solver and for the
curious.
"""

from typing import NamedTuple

import numpy as np

from minibullet.kernels import kernel, leaf

AXES, ARM_A, ARM_B, ANSWER_A, ANSWER_B, BLOCK = 0, 9, 18, 27, 45, 63  # columns of ContactProblem.rows
WIDTH = 72


class ContactProblem(NamedTuple):
    """One step's contact problem: m contacts between n bodies, local order normal, tangent 1, tangent 2."""

    bodies: np.ndarray  # body a and body b of each contact (m, 2)
    rows: (
        np.ndarray
    )  # axes of the frame (3x3); arm x axis for a, for b (3x3 each) [m]; velocity answer M^-1 H^T of a, of b (3x6 each);
    #                   block of W (3x3) [1/kg]; (m, 72)
    target: np.ndarray  # least normal velocity allowed at the end of the step [m/s], (m,)
    friction: np.ndarray  # Coulomb coefficient [-], (m,)
    rolling: np.ndarray  # rolling arm, spinning arm [m], (m, 2)
    free_twist: np.ndarray  # twist of each body if nothing touched, world frame [m/s, rad/s], (n, 6)
    inverse_mass: np.ndarray  # inverse of mass and inertia, world frame [1/kg, 1/(kg m2)], (n, 6, 6)
    order: np.ndarray  # contacts sorted by island (m,)
    islands: np.ndarray  # first place of each island in order, and the end (i + 1,)
    rounding: float  # velocities below this are rounding errors of the velocities themselves [m/s]
    reference_mass: float  # median mass of the moving bodies: turns impulses into velocities in every residual [kg]


@leaf
def tangents(nx, ny, nz):
    """Two unit tangents that make a right-handed frame with the unit normal, smooth but at one point (Frisvad, J. Graphics
    Tools 16, 2012)."""
    if nz < -0.9999999:  # the same from the other pole, where the formula below divides by almost zero
        a = 1.0 / (1.0 - nz)
        b = nx * ny * a
        return b, ny * ny * a - 1.0, -ny, nx * nx * a - 1.0, b, -nx
    a = 1.0 / (1.0 + nz)
    b = -nx * ny * a
    return 1.0 - nx * nx * a, b, -nx, b, 1.0 - ny * ny * a, -ny


@leaf
def velocity_along(row, i, v, w):
    """Velocity of body b (twist w) against body a (twist v) along axis i of a contact (0 normal, 1 and 2 tangents) [m/s]."""
    k = 3 * i
    return (
        row[k] * (w[0] - v[0]) + row[k + 1] * (w[1] - v[1]) + row[k + 2] * (w[2] - v[2])
        + row[ARM_B + k] * w[3] + row[ARM_B + k + 1] * w[4] + row[ARM_B + k + 2] * w[5]
        - row[ARM_A + k] * v[3] - row[ARM_A + k + 1] * v[4] - row[ARM_A + k + 2] * v[5]
    )  # fmt: skip


@leaf
def normal_velocity(c, bodies, rows, twist):
    """Velocity of b against a along the normal of contact c [m/s]."""
    return velocity_along(rows[c], 0, twist[bodies[c, 0]], twist[bodies[c, 1]])


@kernel
def relative_velocity(bodies, rows, twist):
    """Velocity of b against a at each contact, contact axes (m, 3) [m/s]."""
    result = np.empty((len(bodies), 3))
    for c in range(len(bodies)):
        for i in range(3):
            result[c, i] = velocity_along(rows[c], i, twist[bodies[c, 0]], twist[bodies[c, 1]])
    return result


@leaf
def apply_impulses(bodies, rows, impulse, twist):
    """Add to ``twist`` (n, 6), in place, what the impulses (m, 3, contact axes) do to the bodies."""
    for c in range(len(bodies)):
        a, b = bodies[c, 0], bodies[c, 1]
        for i in range(3):
            for k in range(6):
                twist[a, k] -= rows[c, ANSWER_A + 6 * i + k] * impulse[c, i]
                twist[b, k] += rows[c, ANSWER_B + 6 * i + k] * impulse[c, i]


@kernel
def find_islands(bodies, moving):
    """Contacts sorted by island, stable, and where each island begins: bodies linked through contacts; fixed bodies do not
    link."""
    parent = np.arange(len(moving))
    for c in range(len(bodies)):
        a, b = bodies[c, 0], bodies[c, 1]
        if moving[a] and moving[b]:
            while parent[a] != a:
                parent[a] = parent[parent[a]]
                a = parent[a]
            while parent[b] != b:
                parent[b] = parent[parent[b]]
                b = parent[b]
            if a < b:
                parent[b] = a
            else:
                parent[a] = b
    label, count = np.empty(len(bodies), dtype=np.int64), np.zeros(len(moving) + 1, dtype=np.int64)
    for c in range(len(bodies)):
        a = bodies[c, 0] if moving[bodies[c, 0]] else bodies[c, 1]
        while parent[a] != a:
            a = parent[a]
        label[c] = a
        count[a + 1] += 1
    # sorted by counting: where each label's contacts begin, then every contact to its place
    islands, found = np.empty(len(bodies) + 1, dtype=np.int64), 0
    for a in range(len(moving)):
        if count[a + 1] > 0:
            islands[found] = count[a]
            found += 1
        count[a + 1] += count[a]
    islands[found] = len(bodies)
    order = np.empty(len(bodies), dtype=np.int64)
    for c in range(len(bodies)):
        order[count[label[c]]] = c
        count[label[c]] += 1
    return order, islands[: found + 1]


def jacobian(rows, side):
    """Rows of H for side 0 (a) or 1 (b): contact axes, then arm x axis, so that velocity = row . twist; (m, 3, 6)."""
    axes, arm = rows[:, AXES:ARM_A], rows[:, ARM_A + 9 * side : ARM_A + 9 * side + 9]
    return np.concatenate([axes.reshape(-1, 3, 3), arm.reshape(-1, 3, 3)], axis=2)


def delassus(problem, contacts=None):
    """Form W (3m, 3m) and q (3m,) of the chosen contacts (all by default), so that u = W r + q with the target taken off the
    normal row.

    W = H^T M^-1 H; q = H^T free twist - target n [1/kg, m/s].
    """
    chosen = np.arange(len(problem.bodies)) if contacts is None else np.asarray(contacts)
    bodies, rows = problem.bodies[chosen], problem.rows[chosen]
    count = len(chosen)
    used, place = np.unique(bodies, return_inverse=True)
    place = place.reshape(bodies.shape)
    rate, answer = np.zeros((count, 3, len(used), 6)), np.zeros((count, 3, len(used), 6))
    index = np.arange(count)
    for side, sign in ((0, -1.0), (1, 1.0)):
        rate[index, :, place[:, side]] += sign * jacobian(rows, side)
        answer[index, :, place[:, side]] += sign * rows[:, ANSWER_A + 18 * side : ANSWER_A + 18 * side + 18].reshape(count, 3, 6)
    q = relative_velocity(bodies, rows, problem.free_twist)
    q[:, 0] -= problem.target[chosen]
    return rate.reshape(3 * count, -1) @ answer.reshape(3 * count, -1).T, q.reshape(-1)


def block_rows(problem, contacts):
    """W of the chosen contacts as block rows (start, column, block), see ``cone``, and q (3m,): what ``delassus`` forms, without
    the zeros."""
    bodies, rows = problem.bodies[contacts], problem.rows[contacts]
    q = relative_velocity(bodies, rows, problem.free_twist)
    q[:, 0] -= problem.target[contacts]
    moving = problem.inverse_mass[:, 0, 0] > 0.0
    return coupled_blocks(bodies, rows, moving), q.reshape(-1)


@kernel
def coupled_blocks(bodies, rows, moving):
    """Blocks of W between contacts that share a moving body: start (m + 1,), column (b,) ascending in a row, block (b, 3, 3)."""
    m = len(bodies)
    first = np.zeros(len(moving) + 1, np.int64)  # contacts of each moving body, as a list of lists
    for c in range(m):
        for side in range(2):
            first[bodies[c, side] + 1] += moving[bodies[c, side]]
    first = np.cumsum(first)
    member, filled = np.empty(first[-1], np.int64), first.copy()
    for c in range(m):
        for side in range(2):
            body = bodies[c, side]
            if moving[body]:
                member[filled[body]] = c
                filled[body] += 1
    start, seen, capacity = np.zeros(m + 1, np.int64), np.full(m, -1), 0
    for c in range(m):
        for side in range(2):
            capacity += filled[bodies[c, side]] - first[bodies[c, side]]
    column, block, total = np.empty(capacity, np.int64), np.zeros((capacity, 3, 3)), 0
    for c in range(m):
        start[c] = total
        for side in range(2):
            for other in member[first[bodies[c, side]] : filled[bodies[c, side]]]:
                if seen[other] < start[c]:
                    seen[other], column[total], total = total, other, total + 1
        column[start[c] : total] = np.sort(column[start[c] : total])
        for k in range(start[c], total):
            seen[column[k]] = k
            for side in range(2):
                for other_side in range(2):
                    body = bodies[c, side]
                    if moving[body] and body == bodies[column[k], other_side]:
                        add_block(rows[c], side, rows[column[k]], other_side, block[k])
    start[m] = total
    return start, column[:total], block[:total]


@leaf
def add_block(row, side, other_row, other_side, block):
    """Add to ``block`` what impulses of another contact do, through one body, to the velocity at this one (3, 3) [1/kg]."""
    sign, arm, answer = (1.0 if side == other_side else -1.0), ARM_A + 9 * side, ANSWER_A + 18 * other_side
    for i in range(3):
        for k in range(3):
            value = 0.0
            for d in range(3):
                value += row[3 * i + d] * other_row[answer + 6 * k + d] + row[arm + 3 * i + d] * other_row[answer + 6 * k + 3 + d]
            block[i, k] += sign * value


@kernel
def into_axes(rows, vector):
    """World vectors (m, 3) in the axes of their contacts (m, 3)."""
    result = np.empty_like(vector)
    for c in range(len(rows)):
        for i in range(3):
            result[c, i] = rows[c, 3 * i] * vector[c, 0] + rows[c, 3 * i + 1] * vector[c, 1] + rows[c, 3 * i + 2] * vector[c, 2]
    return result


@kernel
def into_world(rows, vector):
    """Vectors in contact axes (m, 3) in world axes (m, 3)."""
    result = np.empty_like(vector)
    for c in range(len(rows)):
        for i in range(3):
            result[c, i] = rows[c, i] * vector[c, 0] + rows[c, 3 + i] * vector[c, 1] + rows[c, 6 + i] * vector[c, 2]
    return result
