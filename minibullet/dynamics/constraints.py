"""From contacts to the contact problem: the frame and lever arms of each contact, the least velocity it allows, the pull of
adhesion."""

import numpy as np

from minibullet.contact.faces import FLAT, attainable
from minibullet.contact.problem import ContactProblem, DelassusFactors, apply_impulses
from minibullet.kernels import kernel, leaf
from minibullet.vectors import cross


@leaf
def tangents(normal):
    """Two unit tangents that make a right-handed frame with the unit normal, smooth but at one point (Frisvad, J. Graphics
    Tools 16, 2012)."""
    x, y, z = normal
    if z < -0.9999999:  # the same from the other pole, where the formula below divides by almost zero
        a = 1.0 / (1.0 - z)
        b = x * y * a
        return (b, y * y * a - 1.0, -y), (x * x * a - 1.0, b, -x)
    a = 1.0 / (1.0 + z)
    b = -x * y * a
    return (1.0 - x * x * a, b, -x), (b, 1.0 - y * y * a, -y)


@leaf
def row_product(row, other):
    """Scalar product of two rows of six numbers."""
    return row[0] * other[0] + row[1] * other[1] + row[2] * other[2] + row[3] * other[3] + row[4] * other[4] + row[5] * other[5]


@kernel
def contact_factors(bodies, arms, inverse_mass):
    """The DelassusFactors of contacts between body pairs (m, 2) with arm a, arm b, normal (m, 9)."""
    count = len(bodies)
    jacobian, inverse_mass_jacobian = np.empty((count, 2, 3, 6)), np.zeros((count, 2, 3, 6))
    block = np.empty((count, 3, 3))
    for c in range(count):
        normal = arms[c, 6], arms[c, 7], arms[c, 8]
        first, second = tangents(normal)
        for side in range(2):
            arm, mass, rows = arms[c, 3 * side : 3 * side + 3], inverse_mass[bodies[c, side]], jacobian[c, side]
            for d in range(3):
                rows[0, d], rows[1, d], rows[2, d] = normal[d], first[d], second[d]
            for i in range(3):
                rows[i, 3], rows[i, 4], rows[i, 5] = cross(arm, rows[i])
                if mass[0, 0] != 0.0 or mass[3, 3] != 0.0:
                    for k in range(6):
                        inverse_mass_jacobian[c, side, i, k] = row_product(mass[k], rows[i])
        for i in range(3):
            for k in range(3):
                value = 0.0
                for side in range(2):
                    row, twist = jacobian[c, side, i], inverse_mass_jacobian[c, side, k]
                    for d in range(3):
                        value += row[d] * twist[d] + row[3 + d] * twist[3 + d]
                block[c, i, k] = value
    return DelassusFactors(bodies, inverse_mass, jacobian, inverse_mass_jacobian, block)


def assemble(contacts, law, free_twist, room, rounding, reference_mass, time_step):
    """The contact problem of the step: contacts may close by the room they have (m,) and no more, u_N+ >= -room/dt (the target),
    which is their gap where nothing was or will be struck; an overlap asks for no velocity, and the corners of a face for what a
    rigid body can do at all of them. contacts: ImpactContacts; rounding: of velocities [m/s]; reference_mass: as in
    ContactProblem.

    Adhesion is a pull along the normal that acts while the surfaces touch, so it belongs to the free twist.
    """
    if np.count_nonzero(law.adhesion):
        free_twist = free_twist.copy()
        pull = np.zeros((len(room), 3))
        pull[:, 0] = np.where(contacts.gap <= 1e-4 * contacts.size, -time_step * law.adhesion, 0.0)
        apply_impulses(contacts.factors, pull, free_twist)
    rolling = np.empty((len(room), 2))
    rolling[:, 0], rolling[:, 1] = law.rolling_arm, law.spinning_arm
    return ContactProblem(
        factors=contacts.factors,
        target=attainable(-np.maximum(room, 0.0) / time_step, contacts.factors, rolling, FLAT * contacts.size / time_step),
        friction=law.friction,
        rolling=rolling,
        free_twist=free_twist,
        order=contacts.order,
        islands=contacts.islands,
        rounding=rounding,
        reference_mass=reference_mass,
    )
