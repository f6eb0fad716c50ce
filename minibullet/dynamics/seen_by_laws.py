"""What the laws of contact see of the contacts of a step, before it is solved."""

import numpy as np

from minibullet.bodies import Contacts
from minibullet.contact.problem import into_axes, into_world, relative_velocity
from minibullet.dynamics.impacts import first_touch
from minibullet.kernels import kernel


def describe(bodies, free_twist, points, factors, time_step):
    """The Contacts record of a step. ``free_twist`` (n, 6) is the twist at its end if nothing touched: laws of impact hold with
    the velocity of the moment of contact, not with that of the step before it. What bore a load when the step begins is held."""
    begin, end = relative_velocity(factors, bodies.twist), relative_velocity(factors, free_twist)
    load = into_axes(factors.jacobian, points.impulse)[:, 0] / time_step
    moment = touch_moments(points.gap, load, begin[:, 0], (end[:, 0] - begin[:, 0]) / time_step, time_step)
    return Contacts(
        points.bodies[:, 0],
        points.bodies[:, 1],
        bodies.position[points.bodies[:, 0]] + points.arms[:, :3],
        points.arms[:, 6:9],
        points.gap,
        into_world(factors.jacobian, begin + (moment / time_step)[:, None] * (end - begin)),
        load,
    )


@kernel
def touch_moments(gap, load, rate, acceleration, time_step):
    """Time of the step at which each contact without a load first touches, 0 where it does not [s], (m,)."""
    moments = np.zeros(len(gap))
    for c in range(len(gap)):
        moment = first_touch(gap[c], rate[c], acceleration[c], 0.0, time_step) if load[c] == 0.0 else np.inf
        moments[c] = moment if moment < np.inf else 0.0
    return moments
