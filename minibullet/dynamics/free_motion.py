"""Free motion: the twist of each body at the end of the step if nothing touched (Eqs. 4-7 of the paper), and on the way there."""

import numpy as np

from minibullet.dynamics.rigid_rotation import torque_free_rotation
from minibullet.kernels import kernel

DAMPING_LAWS = {
    # name: factor by which a velocity v is multiplied in a step of length dt
    "bullet": lambda damping, dt: (1.0 - damping) ** dt,  # what Bullet does: d is the share lost in a second
    "per_step": lambda damping, dt: 1.0 - damping,  # Eqs. (6)-(7) as the paper prints them: d is the share lost in a step
}


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
def rigid_inverse_mass(mass, inertia, rotation):
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
    result = rigid_inverse_mass(bodies.mass, bodies.inertia, rotation)
    if added is not None:
        heavy = np.isfinite(bodies.mass) & added.any(axis=(1, 2))
        total = result[heavy]
        invert(total)
        total += added[heavy]
        invert(total)
        result[heavy] = total
    return result


@kernel
def accelerate(twist, rotation, inverse_mass, wrench, kept, time_step):
    """See ``free_motion``; rotation: rotation vector and angular velocity of torque-free rotation; kept: what damping leaves of a
    velocity and of an angular velocity in a step."""
    turned, rate = rotation
    end, mean = np.empty_like(twist), np.empty_like(twist)
    for n in range(len(twist)):
        if inverse_mass[n, 0, 0] == 0.0 and inverse_mass[n, 3, 3] == 0.0:  # fixed: nothing pulls, nothing moves
            for k in range(6):
                end[n, k], mean[n, k] = twist[n, k], twist[n, k]
            continue
        for k in range(6):
            value = kept[0] * twist[n, k] if k < 3 else kept[1] * rate[n, k - 3]
            for i in range(6):
                value += time_step * inverse_mass[n, k, i] * wrench[n, i]
            end[n, k] = value
            if k < 3:
                mean[n, k] = 0.5 * (twist[n, k] + value)
            else:
                mean[n, k] = turned[n, k - 3] / time_step + 0.5 * (value - rate[n, k - 3])
    return end, mean


def free_motion(bodies, inverse_mass, wrench, settings):
    """Twist at the end of the step if nothing touched, the mean twist on the way there (n, 6), world axes, and the angular
    velocity that torque-free rotation alone would leave (n, 3).

    Eqs. (4)-(7): damping first, then acceleration times the step, as Bullet orders them.
    """
    dt, left = settings.time_step, DAMPING_LAWS[settings.damping_law]
    kept = left(settings.linear_damping, dt), left(settings.angular_damping, dt)
    rotation = torque_free_rotation(bodies.orientation, bodies.twist[:, 3:], bodies.inertia, dt)
    free_twist, mean_twist = accelerate(bodies.twist, rotation, inverse_mass, wrench, kept, dt)
    return free_twist, mean_twist, rotation[1]
