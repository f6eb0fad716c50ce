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
def accelerate(twist, rotation, inverse_mass, wrench, kept, time_step):
    """See ``free_motion``; rotation: rotation vector and angular velocity of torque-free rotation; kept: what damping leaves of a
    velocity and of an angular velocity in a step. The mean of a linear change is half of it; torque-free rotation is not
    linear, so its own mean is the angle turned over the time."""
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


def free_motion(bodies, inverse_mass, wrenches, settings):
    """Twist at the end of the step if nothing touched but these wrenches acted (a list of (n, 6)), the mean twist on the way
    there (n, 6), world axes, and the angular velocity that torque-free rotation alone would leave (n, 3).

    Eqs. (4)-(7): damping first, then acceleration times the step, as Bullet orders them.
    """
    dt, left = settings.time_step, DAMPING_LAWS[settings.damping_law]
    kept = left(settings.linear_damping, dt), left(settings.angular_damping, dt)
    rotation = torque_free_rotation(bodies.orientation, bodies.twist[:, 3:], bodies.inertia, dt)
    wrench = sum(wrenches, np.zeros(bodies.twist.shape))
    free_twist, mean_twist = accelerate(bodies.twist, rotation, inverse_mass, wrench, kept, dt)
    return free_twist, mean_twist, rotation[1]
