"""Motion: the twist if nothing touched (Eqs. 4-7 of the paper), torque-free rotation, and the move at the end of the step.

A body moves with the mean of its first and last velocity of the step, which is exact for constant forces, as long as that keeps every
gap open; otherwise with the last velocity, which the contact problem has made admissible.
"""

from math import sqrt

import numpy as np
from numba import njit

from minibullet import rotations

DAMPING_LAWS = {
    # name: factor by which a velocity v is multiplied in a step of length dt
    "bullet": lambda damping, dt: (1.0 - damping) ** dt,  # what Bullet does: d is the share lost in a second
    "per_step": lambda damping, dt: 1.0 - damping,  # Eqs. (6)-(7) as the paper prints them: d is the share lost in a step
}


@njit(cache=True)
def principal_rate(q0, q1, q2, q3, inertia, lx, ly, lz):
    """Angular velocity (world axes) of a body with angular momentum l (world) and orientation q: R I^-1 R^T l; q need not be unit."""
    scale = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3
    r00, r01, r02 = q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3, 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)
    r10, r11, r12 = 2.0 * (q1 * q2 + q0 * q3), q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3, 2.0 * (q2 * q3 - q0 * q1)
    r20, r21, r22 = 2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3
    a = (r00 * lx + r10 * ly + r20 * lz) / (inertia[0] * scale * scale)
    b = (r01 * lx + r11 * ly + r21 * lz) / (inertia[1] * scale * scale)
    c = (r02 * lx + r12 * ly + r22 * lz) / (inertia[2] * scale * scale)
    return r00 * a + r01 * b + r02 * c, r10 * a + r11 * b + r12 * c, r20 * a + r21 * b + r22 * c


@njit(cache=True)
def spin_freely(orientation, rate, inertia, time_step):
    """Torque-free rotation over a step: rotation vector turned through (n, 3) and angular velocity at the end (n, 3), world axes.

    Euler's equations in the form q' = 1/2 omega(q) q with the angular momentum held exactly; classical Runge-Kutta of order four on q, so that
    the energy error is of order (omega dt)^5 a step. Bodies with three equal moments turn at constant rate, which is exact.
    """
    turned, final = np.empty_like(rate), np.empty_like(rate)
    for n in range(len(rate)):
        i0, i1, i2 = inertia[n]
        w0, w1, w2 = rate[n]
        if (i0 == i1 and i1 == i2) or (w0 == 0.0 and w1 == 0.0 and w2 == 0.0):
            turned[n] = rate[n] * time_step
            final[n] = rate[n]
            continue
        q0, q1, q2, q3 = orientation[n]
        # l = R I R^T omega, by the same formula with the moments inverted
        lx, ly, lz = principal_rate(q0, q1, q2, q3, 1.0 / inertia[n], w0, w1, w2)
        k0 = k1 = k2 = k3 = 0.0
        s0 = s1 = s2 = s3 = 0.0
        for stage in range(4):
            h = 0.0 if stage == 0 else (time_step if stage == 3 else 0.5 * time_step)
            p0, p1, p2, p3 = q0 + h * k0, q1 + h * k1, q2 + h * k2, q3 + h * k3
            a, b, c = principal_rate(p0, p1, p2, p3, inertia[n], lx, ly, lz)
            k0, k1 = 0.5 * (-a * p1 - b * p2 - c * p3), 0.5 * (a * p0 + b * p3 - c * p2)
            k2, k3 = 0.5 * (b * p0 + c * p1 - a * p3), 0.5 * (c * p0 + a * p2 - b * p1)
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            s0, s1, s2, s3 = s0 + weight * k0, s1 + weight * k1, s2 + weight * k2, s3 + weight * k3
        e0, e1, e2, e3 = q0 + time_step / 6.0 * s0, q1 + time_step / 6.0 * s1, q2 + time_step / 6.0 * s2, q3 + time_step / 6.0 * s3
        size = sqrt(e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
        e0, e1, e2, e3 = e0 / size, e1 / size, e2 / size, e3 / size
        final[n] = principal_rate(e0, e1, e2, e3, inertia[n], lx, ly, lz)
        # the turn between: e q^-1
        d0 = e0 * q0 + e1 * q1 + e2 * q2 + e3 * q3
        d1 = -e0 * q1 + e1 * q0 - e2 * q3 + e3 * q2
        d2 = -e0 * q2 + e2 * q0 - e3 * q1 + e1 * q3
        d3 = -e0 * q3 + e3 * q0 - e1 * q2 + e2 * q1
        if d0 < 0.0:
            d0, d1, d2, d3 = -d0, -d1, -d2, -d3
        sine = sqrt(d1 * d1 + d2 * d2 + d3 * d3)
        factor = 2.0 * np.arctan2(sine, d0) / sine if sine > 0.0 else 2.0
        turned[n] = (factor * d1, factor * d2, factor * d3)
    return turned, final


def free(bodies, inverse_mass, wrench, settings):
    """Twist at the end of the step if nothing touched, the mean twist on the way there (n, 6), world frame, and the angular velocity
    that torque-free rotation alone would leave (n, 3).

    Eqs. (4)-(7): damping first, then acceleration times the step, as Bullet orders them.
    """
    dt = settings.time_step
    turned, rate = spin_freely(bodies.orientation, bodies.twist[:, 3:], bodies.inertia, dt)
    end = np.concatenate([bodies.twist[:, :3], rate], axis=1)
    damping = DAMPING_LAWS[settings.damping_law]
    if settings.linear_damping or settings.angular_damping:
        end[:, :3] *= damping(settings.linear_damping, dt)
        end[:, 3:] *= damping(settings.angular_damping, dt)
    change = dt * (inverse_mass @ wrench[:, :, None])[:, :, 0]
    end += change
    mean = 0.5 * (bodies.twist + end)
    mean[:, 3:] = turned / dt + 0.5 * (end[:, 3:] - rate)
    return end, mean, rate


@njit(cache=True)
def admissible_motion(contact_bodies, rows, gap, tolerance, mean, final, time_step):
    """Mean twist of each body over the step (n, 6): ``mean`` where that closes no gap beyond ``tolerance`` (m,), else ``final``."""
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
                approach += (rows[c, d] * (motion[b, d] - motion[a, d]) + rows[c, 18 + d] * motion[b, 3 + d]
                             - rows[c, 9 + d] * motion[a, 3 + d])
            if gap[c] + time_step * approach < -tolerance[c] and time_step * approach < 0.0:
                for body in (a, b):
                    if not settled[body]:
                        motion[body] = final[body]
                        settled[body] = True
                        changed = True
    return motion


@njit(cache=True)
def keep_angular_momentum(old, new, inertia, rate, spun, final):
    """Angular velocities ``final`` (n, 3) after the turn from orientation old to new, in place, so that angular momentum is what torques made it.

    Impulses were found with the inertia at the old orientation: they change the momentum by I_old (final - spun). With that momentum and
    the new orientation the angular velocity is I_new^-1 (I_old rate + I_old (final - spun)).
    """
    for n in range(len(rate)):
        i0, i1, i2 = inertia[n]
        if (i0 == i1 and i1 == i2) or (final[n, 0] == 0.0 and final[n, 1] == 0.0 and final[n, 2] == 0.0):
            continue
        x, y, z = rate[n, 0] + final[n, 0] - spun[n, 0], rate[n, 1] + final[n, 1] - spun[n, 1], rate[n, 2] + final[n, 2] - spun[n, 2]
        lx, ly, lz = principal_rate(old[n, 0], old[n, 1], old[n, 2], old[n, 3], 1.0 / inertia[n], x, y, z)
        final[n] = principal_rate(new[n, 0], new[n, 1], new[n, 2], new[n, 3], inertia[n], lx, ly, lz)


def move(bodies, motion, twist, spun, time_step):
    """The bodies after the step: moved with the mean twist ``motion``, with velocities ``twist`` (n, 6); ``spun`` is from ``free``."""
    position = bodies.position + time_step * motion[:, :3]
    orientation = rotations.normalised(rotations.product(rotations.exponential(time_step * motion[:, 3:]), bodies.orientation))
    rate = twist[:, 3:].copy()
    keep_angular_momentum(bodies.orientation, orientation, bodies.inertia, bodies.twist[:, 3:], spun, rate)
    return bodies._replace(position=position, orientation=orientation, twist=np.concatenate([twist[:, :3], rate], axis=1))


def inverse_mass(bodies, rotation, added):
    """Inverse of each body's mass and inertia, world frame, with the mass that effects add, (n, 6, 6) [1/kg, 1/(kg m2)]; zero if fixed."""
    result = np.zeros((len(bodies.mass), 6, 6))
    moving = np.isfinite(bodies.mass)
    diagonal = np.where(moving, 1.0 / bodies.mass, 0.0)
    result[:, 0, 0] = result[:, 1, 1] = result[:, 2, 2] = diagonal
    moments = np.where(moving[:, None], 1.0 / bodies.inertia, 0.0)
    result[:, 3:, 3:] = (rotation * moments[:, None, :]) @ rotation.transpose(0, 2, 1)
    if added is not None:
        heavy = moving & added.any(axis=(1, 2))
        result[heavy] = np.linalg.inv(np.linalg.inv(result[heavy]) + added[heavy])
    return result


def stride(twist, free_twist, reach, time_step):
    """Bound on how far any point of each body may go in this step [m], (n,).

    Twice the distance by its twist before or its free twist: a blow on one end can double the speed of the other end within the step.
    """
    speed = np.maximum((twist[:, :3] ** 2).sum(axis=1), (free_twist[:, :3] ** 2).sum(axis=1))
    spin = np.maximum((twist[:, 3:] ** 2).sum(axis=1), (free_twist[:, 3:] ** 2).sum(axis=1))
    return 2.0 * time_step * (np.sqrt(speed) + np.sqrt(spin) * reach)
