"""Motion: the twist if nothing touched (Eqs. 4-7 of the paper), torque-free rotation, and the move at the end of the step.

A body moves with the mean of its first and last velocity of the step, which is exact for constant forces, as long as that
keeps every gap open; otherwise with the last velocity, which the contact problem has made admissible.
"""

from math import sqrt

import numpy as np

from minibullet.kernels import kernel, leaf
from minibullet.vectors import length

DAMPING_LAWS = {
    # name: factor by which a velocity v is multiplied in a step of length dt
    "bullet": lambda damping, dt: (1.0 - damping) ** dt,  # what Bullet does: d is the share lost in a second
    "per_step": lambda damping, dt: 1.0 - damping,  # Eqs. (6)-(7) as the paper prints them: d is the share lost in a step
}


@leaf
def principal_rate(q0, q1, q2, q3, i0, i1, i2, lx, ly, lz):
    """Angular velocity (world axes) of a body with angular momentum l (world) and orientation q: R I^-1 R^T l; q need not be
    unit."""
    scale = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3
    r00, r01, r02 = q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3, 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)
    r10, r11, r12 = 2.0 * (q1 * q2 + q0 * q3), q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3, 2.0 * (q2 * q3 - q0 * q1)
    r20, r21, r22 = 2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3
    a = (r00 * lx + r10 * ly + r20 * lz) / (i0 * scale * scale)
    b = (r01 * lx + r11 * ly + r21 * lz) / (i1 * scale * scale)
    c = (r02 * lx + r12 * ly + r22 * lz) / (i2 * scale * scale)
    return r00 * a + r01 * b + r02 * c, r10 * a + r11 * b + r12 * c, r20 * a + r21 * b + r22 * c


@kernel
def spin_freely(orientation, rate, inertia, time_step):
    """Torque-free rotation over a step: rotation vector turned through (n, 3) and angular velocity at the end (n, 3), world
    axes.

    Euler's equations in the form q' = 1/2 omega(q) q with the angular momentum held exactly; classical Runge-Kutta of order
    four on q, so that the energy error is of order (omega dt)^5 a step. Bodies with three equal moments turn at constant
    rate, which is exact.
    """
    turned, final = np.empty_like(rate), np.empty_like(rate)
    for n in range(len(rate)):
        i0, i1, i2 = inertia[n, 0], inertia[n, 1], inertia[n, 2]
        w0, w1, w2 = rate[n, 0], rate[n, 1], rate[n, 2]
        if (i0 == i1 and i1 == i2) or (w0 == 0.0 and w1 == 0.0 and w2 == 0.0):
            turned[n, 0], turned[n, 1], turned[n, 2] = w0 * time_step, w1 * time_step, w2 * time_step
            final[n, 0], final[n, 1], final[n, 2] = w0, w1, w2
            continue
        q0, q1, q2, q3 = orientation[n, 0], orientation[n, 1], orientation[n, 2], orientation[n, 3]
        # l = R I R^T omega, by the same formula with the moments inverted
        lx, ly, lz = principal_rate(q0, q1, q2, q3, 1.0 / i0, 1.0 / i1, 1.0 / i2, w0, w1, w2)
        k0 = k1 = k2 = k3 = 0.0
        s0 = s1 = s2 = s3 = 0.0
        for stage in range(4):
            h = 0.0 if stage == 0 else (time_step if stage == 3 else 0.5 * time_step)
            p0, p1, p2, p3 = q0 + h * k0, q1 + h * k1, q2 + h * k2, q3 + h * k3
            a, b, c = principal_rate(p0, p1, p2, p3, i0, i1, i2, lx, ly, lz)
            k0, k1 = 0.5 * (-a * p1 - b * p2 - c * p3), 0.5 * (a * p0 + b * p3 - c * p2)
            k2, k3 = 0.5 * (b * p0 + c * p1 - a * p3), 0.5 * (c * p0 + a * p2 - b * p1)
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            s0, s1, s2, s3 = s0 + weight * k0, s1 + weight * k1, s2 + weight * k2, s3 + weight * k3
        e0, e1, e2, e3 = (
            q0 + time_step / 6.0 * s0,
            q1 + time_step / 6.0 * s1,
            q2 + time_step / 6.0 * s2,
            q3 + time_step / 6.0 * s3,
        )
        size = sqrt(e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
        e0, e1, e2, e3 = e0 / size, e1 / size, e2 / size, e3 / size
        final[n, 0], final[n, 1], final[n, 2] = principal_rate(e0, e1, e2, e3, i0, i1, i2, lx, ly, lz)
        # the turn between: e q^-1
        d0 = e0 * q0 + e1 * q1 + e2 * q2 + e3 * q3
        d1 = -e0 * q1 + e1 * q0 - e2 * q3 + e3 * q2
        d2 = -e0 * q2 + e2 * q0 - e3 * q1 + e1 * q3
        d3 = -e0 * q3 + e3 * q0 - e1 * q2 + e2 * q1
        if d0 < 0.0:
            d0, d1, d2, d3 = -d0, -d1, -d2, -d3
        sine = sqrt(d1 * d1 + d2 * d2 + d3 * d3)
        factor = 2.0 * np.arctan2(sine, d0) / sine if sine > 0.0 else 2.0
        turned[n, 0], turned[n, 1], turned[n, 2] = factor * d1, factor * d2, factor * d3
    return turned, final


@kernel
def posture(orientation):
    """Rotation matrices, body axes to world axes, of unit quaternions (n, 4): (n, 3, 3)."""
    rotation = np.empty((len(orientation), 3, 3))
    for n in range(len(orientation)):
        w, x, y, z = orientation[n]
        rotation[n, 0, 0], rotation[n, 0, 1], rotation[n, 0, 2] = (
            1 - 2 * (y * y + z * z),
            2 * (x * y - w * z),
            2 * (x * z + w * y),
        )
        rotation[n, 1, 0], rotation[n, 1, 1], rotation[n, 1, 2] = (
            2 * (x * y + w * z),
            1 - 2 * (x * x + z * z),
            2 * (y * z - w * x),
        )
        rotation[n, 2, 0], rotation[n, 2, 1], rotation[n, 2, 2] = (
            2 * (x * z - w * y),
            2 * (y * z + w * x),
            1 - 2 * (x * x + y * y),
        )
    return rotation


@kernel
def invert(matrices):
    """Replace symmetric positive definite matrices (n, 6, 6) by their inverses: Gauss-Jordan, which needs no pivots for these."""
    for matrix in matrices:
        for k in range(6):
            pivot = 1.0 / matrix[k, k]
            matrix[k, k] = 1.0
            for j in range(6):
                matrix[k, j] *= pivot
            for i in range(6):
                if i == k:
                    continue
                factor = matrix[i, k]
                matrix[i, k] = 0.0
                for j in range(6):
                    matrix[i, j] -= factor * matrix[k, j]


@kernel
def rigid_inverse(mass, inertia, rotation):
    """Inverse mass and inertia of each body in world axes, (n, 6, 6) [1/kg, 1/(kg m2)]; zero if fixed."""
    result = np.zeros((len(mass), 6, 6))
    for n in range(len(mass)):
        if mass[n] == np.inf:
            continue
        for i in range(3):
            result[n, i, i] = 1.0 / mass[n]
            for j in range(3):
                value = 0.0
                for k in range(3):
                    value += rotation[n, i, k] * rotation[n, j, k] / inertia[n, k]
                result[n, 3 + i, 3 + j] = value
    return result


def inverse_mass(bodies, rotation, added):
    """Inverse of each body's mass and inertia, world axes, with the mass that effects add, (n, 6, 6); zero if fixed."""
    result = rigid_inverse(bodies.mass, bodies.inertia, rotation)
    if added is not None:
        heavy = np.isfinite(bodies.mass) & added.any(axis=(1, 2))
        total = result[heavy]
        invert(total)
        total += added[heavy]
        invert(total)
        result[heavy] = total
    return result


@kernel
def free_motion(orientation, twist, inertia, inverse_mass, wrench, time_step, keep_linear, keep_angular):
    """See ``free``; keep_linear and keep_angular are what damping leaves of a velocity in a step."""
    turned, rate = spin_freely(orientation, twist[:, 3:], inertia, time_step)
    end, mean = np.empty_like(twist), np.empty_like(twist)
    for n in range(len(twist)):
        if inverse_mass[n, 0, 0] == 0.0 and inverse_mass[n, 3, 3] == 0.0:  # fixed: nothing pulls, nothing moves
            end[n], mean[n] = twist[n], twist[n]
            continue
        for k in range(6):
            value = keep_linear * twist[n, k] if k < 3 else keep_angular * rate[n, k - 3]
            for i in range(6):
                value += time_step * inverse_mass[n, k, i] * wrench[n, i]
            end[n, k] = value
            if k < 3:
                mean[n, k] = 0.5 * (twist[n, k] + value)
            else:
                mean[n, k] = turned[n, k - 3] / time_step + 0.5 * (value - rate[n, k - 3])
    return end, mean, rate


def free(bodies, inverse_mass, wrench, settings):
    """Twist at the end of the step if nothing touched, the mean twist on the way there (n, 6), world axes, and the angular
    velocity that torque-free rotation alone would leave (n, 3).

    Eqs. (4)-(7): damping first, then acceleration times the step, as Bullet orders them.
    """
    left = DAMPING_LAWS[settings.damping_law]
    return free_motion(
        bodies.orientation,
        bodies.twist,
        bodies.inertia,
        inverse_mass,
        wrench,
        settings.time_step,
        left(settings.linear_damping, settings.time_step),
        left(settings.angular_damping, settings.time_step),
    )


@kernel
def admissible_motion(contact_bodies, rows, gap, tolerance, mean, final, time_step):
    """Mean twist of each body over the step (n, 6): ``mean`` where that closes no gap beyond ``tolerance`` (m,), else
    ``final``."""
    motion = mean.copy()
    settled = np.zeros(len(mean), dtype=np.bool_)
    changed = True
    while changed:
        changed = False
        for c in range(len(contact_bodies)):
            a, b = contact_bodies[c, 0], contact_bodies[c, 1]
            if settled[a] and settled[b]:
                continue
            approach = 0.0
            for d in range(3):
                approach += (
                    rows[c, d] * (motion[b, d] - motion[a, d])
                    + rows[c, 18 + d] * motion[b, 3 + d]
                    - rows[c, 9 + d] * motion[a, 3 + d]
                )
            if gap[c] + time_step * approach < -tolerance[c] and time_step * approach < 0.0:
                for body in (a, b):
                    if not settled[body]:
                        motion[body] = final[body]
                        settled[body] = True
                        changed = True
    return motion


@kernel
def keep_angular_momentum(old, new, inertia, rate, spun, final):
    """Angular velocities ``final`` (n, 3) after the turn from orientation old to new, in place, so that angular momentum is
    what torques made it.

    Impulses were found with the inertia at the old orientation: they change the momentum by I_old (final - spun). With that
    momentum and the new orientation the angular velocity is I_new^-1 (I_old rate + I_old (final - spun)).
    """
    for n in range(len(rate)):
        i0, i1, i2 = inertia[n, 0], inertia[n, 1], inertia[n, 2]
        if (i0 == i1 and i1 == i2) or (final[n, 0] == 0.0 and final[n, 1] == 0.0 and final[n, 2] == 0.0):
            continue
        x, y, z = (
            rate[n, 0] + final[n, 0] - spun[n, 0],
            rate[n, 1] + final[n, 1] - spun[n, 1],
            rate[n, 2] + final[n, 2] - spun[n, 2],
        )
        lx, ly, lz = principal_rate(old[n, 0], old[n, 1], old[n, 2], old[n, 3], 1.0 / i0, 1.0 / i1, 1.0 / i2, x, y, z)
        final[n, 0], final[n, 1], final[n, 2] = principal_rate(new[n, 0], new[n, 1], new[n, 2], new[n, 3], i0, i1, i2, lx, ly, lz)


@kernel
def moved(position, orientation, motion, time_step):
    """Positions (n, 3) and orientations (n, 4) after a step with the mean twist ``motion`` (n, 6): x + dt v, exp(dt omega) q."""
    place, pose = position.copy(), orientation.copy()
    for n in range(len(position)):
        for k in range(3):
            place[n, k] += time_step * motion[n, k]
        x, y, z = 0.5 * time_step * motion[n, 3], 0.5 * time_step * motion[n, 4], 0.5 * time_step * motion[n, 5]
        half = sqrt(x * x + y * y + z * z)
        if half == 0.0:
            continue
        c, ratio = np.cos(half), np.sin(half) / half
        x, y, z = ratio * x, ratio * y, ratio * z
        q0, q1, q2, q3 = orientation[n]
        r0, r1 = c * q0 - x * q1 - y * q2 - z * q3, c * q1 + x * q0 + y * q3 - z * q2
        r2, r3 = c * q2 - x * q3 + y * q0 + z * q1, c * q3 + x * q2 - y * q1 + z * q0
        size = sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
        pose[n, 0], pose[n, 1], pose[n, 2], pose[n, 3] = r0 / size, r1 / size, r2 / size, r3 / size
    return place, pose


def move(bodies, motion, twist, spun, time_step):
    """The bodies after the step: moved with the mean twist ``motion``, with velocities ``twist`` (n, 6); ``spun`` is from
    ``free``."""
    position, orientation = moved(bodies.position, bodies.orientation, motion, time_step)
    twist = twist.copy()
    keep_angular_momentum(bodies.orientation, orientation, bodies.inertia, bodies.twist[:, 3:], spun, twist[:, 3:])
    return bodies._replace(position=position, orientation=orientation, twist=twist)


@leaf
def top_speed(twist, reach):
    """Bound on the speed of any point of a body at this twist (6,): |v| + |omega| R [m/s]."""
    return length(twist[:3]) + reach * length(twist[3:])


@kernel
def path_bound(twist, reach, duration):
    """Bound on how far any point of each body goes in ``duration`` seconds at this twist [m], (n,)."""
    result = np.empty(len(twist))
    for n in range(len(twist)):
        result[n] = duration * top_speed(twist[n], reach[n])
    return result


@kernel
def stride(twist, free_twist, reach, time_step):
    """Bound on how far any point of each body may go in this step [m], (n,).

    Twice the distance by its twist before or its free twist: a blow on one end can double the speed of the other end within
    the step.
    """
    result = np.empty(len(twist))
    for n in range(len(twist)):
        result[n] = 2.0 * time_step * max(top_speed(twist[n], reach[n]), top_speed(free_twist[n], reach[n]))
    return result


@leaf
def finite(position, twist):
    """Whether every body's place and velocity are numbers."""
    total = 0.0  # stays zero only with finite numbers: 0 inf and 0 NaN are NaN
    for n in range(len(twist)):
        for k in range(3):
            total += 0.0 * position[n, k] + 0.0 * twist[n, k] + 0.0 * twist[n, 3 + k]
    return total == 0.0


@leaf
def slow(twist, wrench, mass, reach, chosen):
    """Whether no point of a chosen body (n,) is faster than 2e-3 sqrt(a R), R its radius and a what accelerates it, and the
    longest time that a free fall over the radius takes, sqrt(2 R/a) [s]; 0 where nothing pulls."""
    still, wait = True, 0.0
    for n in range(len(mass)):
        if not chosen[n]:
            continue
        acceleration = length(wrench[n, :3]) / mass[n]
        still = still and top_speed(twist[n], reach[n]) <= 2e-3 * sqrt(acceleration * reach[n])
        if acceleration > 0.0:
            wait = max(wait, sqrt(2.0 * reach[n] / acceleration))
    return still, wait
