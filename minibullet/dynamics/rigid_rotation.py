"""Rotation of rigid bodies with unequal moments of inertia, where angular momentum is the datum and angular velocity follows."""

from math import sqrt

import numpy as np

from minibullet.kernels import kernel, leaf
from minibullet.rotations import quaternion
from minibullet.vectors import at, put


@leaf
def angular_velocity(q, inertia, momentum):
    """Angular velocity R I^-1 R^T l of a body with orientation q, which need not be unit, principal moments ``inertia`` and
    angular momentum l, world axes; with the moments inverted, the angular momentum of an angular velocity."""
    q0, q1, q2, q3 = q
    lx, ly, lz = momentum
    scale = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3
    r00, r01, r02 = q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3, 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)
    r10, r11, r12 = 2.0 * (q1 * q2 + q0 * q3), q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3, 2.0 * (q2 * q3 - q0 * q1)
    r20, r21, r22 = 2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3
    a = (r00 * lx + r10 * ly + r20 * lz) / (inertia[0] * scale * scale)
    b = (r01 * lx + r11 * ly + r21 * lz) / (inertia[1] * scale * scale)
    c = (r02 * lx + r12 * ly + r22 * lz) / (inertia[2] * scale * scale)
    return r00 * a + r01 * b + r02 * c, r10 * a + r11 * b + r12 * c, r20 * a + r21 * b + r22 * c


@leaf
def angular_momentum(q, inertia, rate):
    """Angular momentum R I R^T omega, world axes."""
    return angular_velocity(q, (1.0 / inertia[0], 1.0 / inertia[1], 1.0 / inertia[2]), rate)


@leaf
def turns_steadily(inertia, rate):
    """Whether the angular velocity stays what it is without torques: three equal moments, or no rotation."""
    equal = inertia[0] == inertia[1] and inertia[1] == inertia[2]
    return equal or (rate[0] == 0.0 and rate[1] == 0.0 and rate[2] == 0.0)


@leaf
def advance_orientation(q, inertia, momentum, time_step):
    """The unit quaternion after a step of q' = 1/2 omega(q) q at constant angular momentum: Runge-Kutta of order four."""
    q0, q1, q2, q3 = q
    k0 = k1 = k2 = k3 = 0.0
    s0 = s1 = s2 = s3 = 0.0
    for stage in range(4):
        h = 0.0 if stage == 0 else (time_step if stage == 3 else 0.5 * time_step)
        p0, p1, p2, p3 = q0 + h * k0, q1 + h * k1, q2 + h * k2, q3 + h * k3
        a, b, c = angular_velocity((p0, p1, p2, p3), inertia, momentum)
        k0, k1 = 0.5 * (-a * p1 - b * p2 - c * p3), 0.5 * (a * p0 + b * p3 - c * p2)
        k2, k3 = 0.5 * (b * p0 + c * p1 - a * p3), 0.5 * (c * p0 + a * p2 - b * p1)
        weight = 1.0 if stage == 0 or stage == 3 else 2.0
        s0, s1, s2, s3 = s0 + weight * k0, s1 + weight * k1, s2 + weight * k2, s3 + weight * k3
    sixth = time_step / 6.0
    e0, e1, e2, e3 = q0 + sixth * s0, q1 + sixth * s1, q2 + sixth * s2, q3 + sixth * s3
    size = sqrt(e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    return e0 / size, e1 / size, e2 / size, e3 / size


@leaf
def rotation_between(q, e):
    """Rotation vector of the turn e q^-1 from orientation q to orientation e, the shorter way round."""
    q0, q1, q2, q3 = q
    e0, e1, e2, e3 = e
    d0 = e0 * q0 + e1 * q1 + e2 * q2 + e3 * q3
    d1 = -e0 * q1 + e1 * q0 - e2 * q3 + e3 * q2
    d2 = -e0 * q2 + e2 * q0 - e3 * q1 + e1 * q3
    d3 = -e0 * q3 + e3 * q0 - e1 * q2 + e2 * q1
    if d0 < 0.0:
        d0, d1, d2, d3 = -d0, -d1, -d2, -d3
    sine = sqrt(d1 * d1 + d2 * d2 + d3 * d3)
    factor = 2.0 * np.arctan2(sine, d0) / sine if sine > 0.0 else 2.0
    return factor * d1, factor * d2, factor * d3


@kernel
def torque_free_rotation(orientation, rate, inertia, time_step):
    """Torque-free rotation over a step: rotation vector turned through (n, 3) and angular velocity at the end (n, 3), world
    axes.

    Euler's equations in the form q' = 1/2 omega(q) q with the angular momentum held exactly, so that the energy error is of
    order (omega dt)^5 a step. Bodies with three equal moments turn at constant rate, which is exact.
    """
    turned, final = np.empty_like(rate), np.empty_like(rate)
    for n in range(len(rate)):
        if turns_steadily(inertia[n], rate[n]):
            for k in range(3):
                turned[n, k], final[n, k] = rate[n, k] * time_step, rate[n, k]
            continue
        q, moments = quaternion(orientation, n), at(inertia, n)
        momentum = angular_momentum(q, moments, at(rate, n))
        end = advance_orientation(q, moments, momentum, time_step)
        put(final, n, angular_velocity(end, moments, momentum))
        put(turned, n, rotation_between(q, end))
    return turned, final


@kernel
def keep_angular_momentum(before, orientation, torque_free_rate, rate):
    """Change angular velocities ``rate`` (n, 3) after the turn to ``orientation`` (n, 4), in place, so that angular momentum is
    what torques made it. before: orientation, angular velocity and principal moments of the bodies when the step began.

    Impulses were found with the inertia at the old orientation: they change the momentum by I_old (rate - torque_free_rate).
    With that momentum and the new orientation the angular velocity is I_new^-1 I_old (rate before + rate - torque_free_rate).
    """
    old, rate_before, inertia = before
    for n in range(len(rate)):
        if turns_steadily(inertia[n], rate[n]):
            continue
        kept = (
            rate_before[n, 0] + rate[n, 0] - torque_free_rate[n, 0],
            rate_before[n, 1] + rate[n, 1] - torque_free_rate[n, 1],
            rate_before[n, 2] + rate[n, 2] - torque_free_rate[n, 2],
        )
        moments = at(inertia, n)
        momentum = angular_momentum(quaternion(old, n), moments, kept)
        put(rate, n, angular_velocity(quaternion(orientation, n), moments, momentum))
