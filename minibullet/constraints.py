"""From contacts to the contact problem u = W r + q, kept in factored form W = H^T M^-1 H.

The rows of H for one contact are its normal and two tangents. W itself is never formed for a step: a sweep needs only H and M^-1 H^T of each
contact, which is linear in the number of contacts. ``delassus`` forms W, for the exact solver and for the curious.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from minibullet.bodies import Contacts
from minibullet.manifolds import tangents

AXES, ARM_A, ARM_B, ANSWER_A, ANSWER_B, BLOCK = 0, 9, 18, 27, 45, 63  # columns of ContactProblem.rows
WIDTH = 72


class ContactProblem(NamedTuple):
    """One step's contact problem: m contacts between n bodies, local order normal, tangent 1, tangent 2."""

    bodies: np.ndarray  # body a and body b of each contact (m, 2)
    rows: np.ndarray  # axes of the frame (3x3); arm x axis for a, for b (3x3 each) [m]; velocity answer M^-1 H^T of a, of b (3x6 each);
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


@njit(cache=True)
def frames(bodies, vectors, inverse_mass):
    """Rows of the contact problem from body pairs (m, 2) and arm a, arm b, normal (m, 9): (m, 72)."""
    count = len(bodies)
    rows = np.zeros((count, WIDTH))
    axes = np.empty((3, 3))
    for c in range(count):
        nx, ny, nz = vectors[c, 6], vectors[c, 7], vectors[c, 8]
        axes[0, 0], axes[0, 1], axes[0, 2] = nx, ny, nz
        axes[1, 0], axes[1, 1], axes[1, 2], axes[2, 0], axes[2, 1], axes[2, 2] = tangents(nx, ny, nz)
        for side in range(2):
            body = bodies[c, side]
            x, y, z = vectors[c, 3 * side], vectors[c, 3 * side + 1], vectors[c, 3 * side + 2]
            mass = inverse_mass[body]
            fixed = mass[0, 0] == 0.0 and mass[3, 3] == 0.0
            arm, answer = ARM_A + 9 * side, ANSWER_A + 18 * side
            for i in range(3):
                e, f, g = axes[i, 0], axes[i, 1], axes[i, 2]
                p, q, r = y * g - z * f, z * e - x * g, x * f - y * e
                rows[c, arm + 3 * i], rows[c, arm + 3 * i + 1], rows[c, arm + 3 * i + 2] = p, q, r
                if not fixed:
                    for k in range(6):
                        rows[c, answer + 6 * i + k] = (mass[k, 0] * e + mass[k, 1] * f + mass[k, 2] * g
                                                       + mass[k, 3] * p + mass[k, 4] * q + mass[k, 5] * r)
        for i in range(3):
            for k in range(3):
                rows[c, AXES + 3 * i + k] = axes[i, k]
                value = 0.0
                for side in range(2):
                    arm, answer = ARM_A + 9 * side, ANSWER_A + 18 * side
                    for d in range(3):
                        value += axes[i, d] * rows[c, answer + 6 * k + d] + rows[c, arm + 3 * i + d] * rows[c, answer + 6 * k + 3 + d]
                rows[c, BLOCK + 3 * i + k] = value
    return rows


@njit(cache=True)
def relative_velocity(bodies, rows, twist):
    """Velocity of b against a at each contact, contact axes (m, 3) [m/s]."""
    result = np.empty((len(bodies), 3))
    for c in range(len(bodies)):
        a, b = bodies[c, 0], bodies[c, 1]
        for i in range(3):
            value = 0.0
            for d in range(3):
                value += rows[c, AXES + 3 * i + d] * (twist[b, d] - twist[a, d]) \
                    + rows[c, ARM_B + 3 * i + d] * twist[b, 3 + d] - rows[c, ARM_A + 3 * i + d] * twist[a, 3 + d]
            result[c, i] = value
    return result


@njit(cache=True)
def apply_impulses(bodies, rows, impulse, twist):
    """Add to ``twist`` (n, 6), in place, what the impulses (m, 3, contact axes) do to the bodies."""
    for c in range(len(bodies)):
        a, b = bodies[c, 0], bodies[c, 1]
        for i in range(3):
            for k in range(6):
                twist[a, k] -= rows[c, ANSWER_A + 6 * i + k] * impulse[c, i]
                twist[b, k] += rows[c, ANSWER_B + 6 * i + k] * impulse[c, i]


@njit(cache=True)
def find_islands(bodies, moving):
    """Contacts sorted by island, stable, and where each island begins: bodies linked through contacts; fixed bodies do not link."""
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
    label = np.empty(len(bodies), dtype=np.int64)
    for c in range(len(bodies)):
        a = bodies[c, 0] if moving[bodies[c, 0]] else bodies[c, 1]
        while parent[a] != a:
            a = parent[a]
        label[c] = a
    order = np.argsort(label, kind="mergesort")
    starts = np.empty(len(bodies) + 1, dtype=np.int64)
    count = 0
    for place in range(len(order)):
        if place == 0 or label[order[place]] != label[order[place - 1]]:
            starts[count] = place
            count += 1
    starts[count] = len(order)
    return order, starts[:count + 1]


def delassus(problem, contacts=None):
    """Form W (3m, 3m) and q (3m,) of the chosen contacts (all by default), so that u = W r + q with the target taken off the normal row.

    W = H^T M^-1 H; q = H^T free twist - target n [1/kg, m/s].
    """
    chosen = np.arange(len(problem.bodies)) if contacts is None else np.asarray(contacts)
    bodies, rows = problem.bodies[chosen], problem.rows[chosen]
    count = len(chosen)
    used, place = np.unique(bodies, return_inverse=True)
    place = place.reshape(bodies.shape)
    jacobian, answer = np.zeros((count, 3, len(used), 6)), np.zeros((count, 3, len(used), 6))
    index = np.arange(count)
    axes = rows[:, AXES:ARM_A].reshape(count, 3, 3)
    for side, sign in ((0, -1.0), (1, 1.0)):
        arm = rows[:, ARM_A + 9 * side:ARM_A + 9 * side + 9].reshape(count, 3, 3)
        jacobian[index, :, place[:, side]] += sign * np.concatenate([axes, arm], axis=2)
        answer[index, :, place[:, side]] += sign * rows[:, ANSWER_A + 18 * side:ANSWER_A + 18 * side + 18].reshape(count, 3, 6)
    q = relative_velocity(bodies, rows, problem.free_twist)
    q[:, 0] -= problem.target[chosen]
    return jacobian.reshape(3 * count, -1) @ answer.reshape(3 * count, -1).T, q.reshape(-1)


@njit(cache=True)
def into_axes(rows, vector):
    """World vectors (m, 3) in the axes of their contacts (m, 3)."""
    result = np.empty_like(vector)
    for c in range(len(rows)):
        for i in range(3):
            result[c, i] = rows[c, 3 * i] * vector[c, 0] + rows[c, 3 * i + 1] * vector[c, 1] + rows[c, 3 * i + 2] * vector[c, 2]
    return result


@njit(cache=True)
def into_world(rows, vector):
    """Vectors in contact axes (m, 3) in world axes (m, 3)."""
    result = np.empty_like(vector)
    for c in range(len(rows)):
        for i in range(3):
            result[c, i] = rows[c, i] * vector[c, 0] + rows[c, 3 + i] * vector[c, 1] + rows[c, 6 + i] * vector[c, 2]
    return result


def describe(bodies, pair, arms, gap, rows, impulse, time_step):
    """The Contacts record of a step; ``impulse`` (m, 3) is last step's, world axes."""
    normal = arms[:, 6:9]
    return Contacts(pair[:, 0], pair[:, 1], bodies.position[pair[:, 0]] + arms[:, :3], normal, gap,
                    into_world(rows, relative_velocity(pair, rows, bodies.twist)), into_axes(rows, impulse)[:, 0] / time_step)


def assemble(scene, pair, rows, gap, law, free_twist, lag, inverse_mass, rounding, time_step):
    """The contact problem of the step: contacts may close by their gap and no more, u_N+ >= -gap/dt; an overlap asks for no velocity.

    Adhesion is a pull along the normal that acts while the surfaces touch, so it belongs to the free twist.
    """
    left = gap - relative_velocity(pair, rows, lag)[:, 0]
    if law.adhesion.any():
        free_twist = free_twist.copy()
        pull = np.zeros((len(pair), 3))
        touching = gap <= 1e-4 * scene.contact_size(pair)
        pull[:, 0] = np.where(touching, -time_step * law.adhesion, 0.0)
        apply_impulses(pair, rows, pull, free_twist)
    order, islands = find_islands(pair, np.isfinite(scene.bodies.mass))
    return ContactProblem(pair, rows, -np.maximum(left, 0.0) / time_step, law.friction, np.stack([law.rolling_arm, law.spinning_arm], axis=1),
                          free_twist, inverse_mass, order, islands, rounding, scene.reference_mass)
