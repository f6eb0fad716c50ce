"""The contact problem u = W r + q: records and the algebra on them. It knows no shapes and no world.

u are the velocities of b against a at the contacts at the end of the step, r the contact impulses, q the velocities without
these impulses. J turns the twists of all bodies into velocities at the contacts, M holds masses and inertias; then
W = J M^-1 J^T, the Delassus operator, says by how much impulses change velocities.

The rows of J for one contact are its normal and two tangents. W itself is never formed for a step: a sweep needs only J and
M^-1 J^T of each contact, which is linear in the number of contacts.
"""

from typing import NamedTuple

import numpy as np

from minibullet.kernels import kernel, leaf
from minibullet.vectors import at, put, turn, turn_back


class DelassusFactors(NamedTuple):
    """W = J M^-1 J^T of m contacts in factored form. Contact axes are the normal (from body a to body b) and two tangents."""

    bodies: np.ndarray  # body a and body b of each contact (m, 2)
    inverse_mass: np.ndarray  # inverse of mass and inertia of each body, world frame [1/kg, 1/(kg m2)], (n, 6, 6)
    jacobian: np.ndarray  # of a and of b, a row per contact axis: the axis, then arm x axis [-, m], world frame, (m, 2, 3, 6)
    inverse_mass_jacobian: np.ndarray  # M^-1 J^T of a and of b: twist by a unit impulse along each axis, (m, 2, 3, 6)
    block: np.ndarray  # block of W on the diagonal, contact axes [1/kg], (m, 3, 3)


class ContactProblem(NamedTuple):
    """One step's contact problem: m contacts between n bodies, order in a contact: normal, tangent 1, tangent 2."""

    factors: DelassusFactors
    target: np.ndarray  # least normal velocity allowed at the end of the step [m/s], (m,)
    friction: np.ndarray  # Coulomb coefficient [-], (m,)
    rolling: np.ndarray  # rolling arm, spinning arm [m], (m, 2)
    free_twist: np.ndarray  # twist of each body if nothing touched, world frame [m/s, rad/s], (n, 6)
    order: np.ndarray  # contacts sorted by island (m,)
    islands: np.ndarray  # first place of each island in order, and the end (i + 1,)
    rounding: float  # velocities below this are rounding errors of the velocities themselves [m/s]
    reference_mass: float  # median mass of the moving bodies: turns impulses into velocities in every residual [kg]


class Iterate(NamedTuple):
    """What a solver improves in place, and the twists that belong to it."""

    impulse: np.ndarray  # contact impulses on b, contact axes [N s], (m, 3)
    moment: np.ndarray  # spinning and two rolling impulsive moments on b, contact axes [N m s], (m, 3)
    twist: np.ndarray  # twist of each body with these impulses, world frame [m/s, rad/s], (n, 6)


@leaf
def velocity_along(c, factors, i, v, w):
    """Velocity of body b (twist w) against body a (twist v) along axis i of contact c [m/s]."""
    a, b = factors.jacobian[c, 0, i], factors.jacobian[c, 1, i]
    return (
        a[0] * (w[0] - v[0]) + a[1] * (w[1] - v[1]) + a[2] * (w[2] - v[2])
        + b[3] * w[3] + b[4] * w[4] + b[5] * w[5] - a[3] * v[3] - a[4] * v[4] - a[5] * v[5]
    )  # fmt: skip


@leaf
def normal_velocity(c, factors, twist):
    """Velocity of b against a along the normal of contact c [m/s]."""
    return velocity_along(c, factors, 0, twist[factors.bodies[c, 0]], twist[factors.bodies[c, 1]])


@leaf
def contact_velocity(c, factors, twist):
    """Velocity of b against a at contact c, contact axes [m/s]."""
    v, w = twist[factors.bodies[c, 0]], twist[factors.bodies[c, 1]]
    return velocity_along(c, factors, 0, v, w), velocity_along(c, factors, 1, v, w), velocity_along(c, factors, 2, v, w)


@kernel
def relative_velocity(factors, twist):
    """Velocity of b against a at each contact, contact axes (m, 3) [m/s]."""
    result = np.empty((len(factors.bodies), 3))
    for c in range(len(result)):
        result[c, 0], result[c, 1], result[c, 2] = contact_velocity(c, factors, twist)
    return result


def velocity_beyond_target(problem, twist):
    """The same less the target, which is what Coulomb's law is about: u at these twists, q at the free ones; (m, 3) [m/s]."""
    velocity = relative_velocity(problem.factors, twist)
    velocity[:, 0] -= problem.target
    return velocity


@leaf
def apply_impulses(factors, impulse, twist):
    """Add to ``twist`` (n, 6), in place, what the impulses (m, 3, contact axes) do to the bodies."""
    for c in range(len(impulse)):
        a, b = factors.bodies[c, 0], factors.bodies[c, 1]
        for i in range(3):
            for k in range(6):
                twist[a, k] -= factors.inverse_mass_jacobian[c, 0, i, k] * impulse[c, i]
                twist[b, k] += factors.inverse_mass_jacobian[c, 1, i, k] * impulse[c, i]


@kernel
def into_axes(jacobian, vector):
    """World vectors (m, 3) in the axes of their contacts (m, 3)."""
    result = np.empty_like(vector)
    for c in range(len(result)):
        put(result, c, turn(jacobian[c, 0, :, :3], at(vector, c)))
    return result


@kernel
def into_world(jacobian, vector):
    """Vectors in contact axes (m, 3) in world axes (m, 3)."""
    result = np.empty_like(vector)
    for c in range(len(result)):
        put(result, c, turn_back(jacobian[c, 0, :, :3], at(vector, c)))
    return result
