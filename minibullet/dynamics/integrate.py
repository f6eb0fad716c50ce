"""The move at the end of the step.

A body moves with the mean of its first and last velocity of the step, which is exact for constant forces, as long as that
keeps every gap open; otherwise with the last velocity, which the contact problem has made admissible.
"""

from math import sqrt

import numpy as np

from minibullet.dynamics.rigid_rotation import keep_angular_momentum
from minibullet.kernels import kernel, leaf
from minibullet.rotations import quaternion


@kernel
def admissible_motion(factors, gap, tolerance, mean, final, time_step):
    """Mean twist of each body over the step (n, 6): ``mean`` where that closes no gap beyond ``tolerance`` (m,), else
    ``final``."""
    motion = mean.copy()
    settled = np.zeros(len(mean), dtype=np.bool_)
    changed = True
    while changed:
        changed = False
        for c in range(len(gap)):
            a, b = factors.bodies[c, 0], factors.bodies[c, 1]
            if settled[a] and settled[b]:
                continue
            approach = 0.0
            for d in range(3):
                approach += (
                    factors.jacobian[c, 0, 0, d] * (motion[b, d] - motion[a, d])
                    + factors.jacobian[c, 1, 0, 3 + d] * motion[b, 3 + d]
                    - factors.jacobian[c, 0, 0, 3 + d] * motion[a, 3 + d]
                )
            if gap[c] + time_step * approach < -tolerance[c] and time_step * approach < 0.0:
                for body in (a, b):
                    if not settled[body]:
                        settled[body] = changed = True
                        motion[body] = final[body]
    return motion


@kernel
def moved(position, orientation, motion, time_step):
    """Positions (n, 3) and orientations (n, 4) after a step with the mean twist ``motion`` (n, 6): x + dt v, exp(dt omega) q."""
    position, orientation = position.copy(), orientation.copy()
    for n in range(len(position)):
        for k in range(3):
            position[n, k] += time_step * motion[n, k]
        x, y, z = 0.5 * time_step * motion[n, 3], 0.5 * time_step * motion[n, 4], 0.5 * time_step * motion[n, 5]
        half = sqrt(x * x + y * y + z * z)
        if half == 0.0:
            continue
        c, ratio = np.cos(half), np.sin(half) / half
        x, y, z = ratio * x, ratio * y, ratio * z
        q0, q1, q2, q3 = quaternion(orientation, n)
        r0, r1 = c * q0 - x * q1 - y * q2 - z * q3, c * q1 + x * q0 + y * q3 - z * q2
        r2, r3 = c * q2 - x * q3 + y * q0 + z * q1, c * q3 + x * q2 - y * q1 + z * q0
        size = sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
        orientation[n, 0], orientation[n, 1], orientation[n, 2], orientation[n, 3] = r0 / size, r1 / size, r2 / size, r3 / size
    return position, orientation


def integrate(bodies, motion, twist, torque_free_rate, time_step):
    """The bodies after the step: moved with the mean twist ``motion``, with velocities ``twist`` (n, 6). torque_free_rate:
    angular velocity that torque-free rotation alone would leave, from ``free_motion``."""
    position, orientation = moved(bodies.position, bodies.orientation, motion, time_step)
    twist = twist.copy()
    before = bodies.orientation, bodies.twist[:, 3:], bodies.inertia
    keep_angular_momentum(before, orientation, torque_free_rate, twist[:, 3:])
    return bodies._replace(position=position, orientation=orientation, twist=twist)


@leaf
def is_finite(position, twist):
    """Whether every body's place (n, 3) and velocity (n, 6) can be computed with: below 4e61, so that no product overflows."""
    total = 0.0  # stays zero only where fifth powers are finite: 0 inf and 0 NaN are NaN
    for n in range(len(twist)):
        for k in range(3):
            total += 0.0 * position[n, k] ** 5 + 0.0 * twist[n, k] ** 5 + 0.0 * twist[n, 3 + k] ** 5
    return total == 0.0
