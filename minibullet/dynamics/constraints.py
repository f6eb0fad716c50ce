"""From contacts to the contact problem: the frame and lever arms of each contact, the least velocity it allows, the pull of
adhesion."""

import numpy as np

from minibullet.bodies import Contacts
from minibullet.contact.problem import (
    ANSWER_A,
    ARM_A,
    AXES,
    BLOCK,
    WIDTH,
    ContactProblem,
    apply_impulses,
    find_islands,
    into_axes,
    into_world,
    relative_velocity,
    tangents,
)
from minibullet.kernels import kernel


@kernel
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
                        rows[c, answer + 6 * i + k] = (
                            mass[k, 0] * e + mass[k, 1] * f + mass[k, 2] * g + mass[k, 3] * p + mass[k, 4] * q + mass[k, 5] * r
                        )
        for i in range(3):
            for k in range(3):
                rows[c, AXES + 3 * i + k] = axes[i, k]
                value = 0.0
                for side in range(2):
                    arm, answer = ARM_A + 9 * side, ANSWER_A + 18 * side
                    for d in range(3):
                        value += (
                            axes[i, d] * rows[c, answer + 6 * k + d] + rows[c, arm + 3 * i + d] * rows[c, answer + 6 * k + 3 + d]
                        )
                rows[c, BLOCK + 3 * i + k] = value
    return rows


def describe(bodies, pair, arms, gap, rows, impulse, time_step):
    """The Contacts record of a step; ``impulse`` (m, 3) is last step's, world axes."""
    normal = arms[:, 6:9]
    return Contacts(
        pair[:, 0],
        pair[:, 1],
        bodies.position[pair[:, 0]] + arms[:, :3],
        normal,
        gap,
        into_world(rows, relative_velocity(pair, rows, bodies.twist)),
        into_axes(rows, impulse)[:, 0] / time_step,
    )


def assemble(scene, pair, rows, gap, law, free_twist, lag, inverse_mass, rounding, time_step):
    """The contact problem of the step: contacts may close by their gap and no more, u_N+ >= -gap/dt; an overlap asks for no
    velocity. ``lag``: how much farther apart impacts have left the bodies, (n, 6), or 0.0.

    Adhesion is a pull along the normal that acts while the surfaces touch, so it belongs to the free twist.
    """
    left = gap if isinstance(lag, float) else gap - relative_velocity(pair, rows, lag)[:, 0]
    if np.count_nonzero(law.adhesion):
        free_twist = free_twist.copy()
        pull = np.zeros((len(pair), 3))
        pull[:, 0] = np.where(gap <= 1e-4 * scene.contact_size(pair), -time_step * law.adhesion, 0.0)
        apply_impulses(pair, rows, pull, free_twist)
    rolling = np.empty((len(pair), 2))
    rolling[:, 0], rolling[:, 1] = law.rolling_arm, law.spinning_arm
    order, islands = find_islands(pair, scene.moving)
    return ContactProblem(
        pair,
        rows,
        -np.maximum(left, 0.0) / time_step,
        law.friction,
        rolling,
        free_twist,
        inverse_mass,
        order,
        islands,
        rounding,
        scene.reference_mass,
    )
