"""What the laws of contact see of the contacts of a step, before it is solved."""

from minibullet.bodies import Contacts
from minibullet.contact.problem import into_axes, into_world, relative_velocity


def describe(bodies, pair, arms, gap, factors, impulse, time_step):
    """The Contacts record of a step; ``impulse`` (m, 3) is last step's, world axes."""
    normal = arms[:, 6:9]
    return Contacts(
        pair[:, 0],
        pair[:, 1],
        bodies.position[pair[:, 0]] + arms[:, :3],
        normal,
        gap,
        into_world(factors.jacobian, relative_velocity(factors, bodies.twist)),
        into_axes(factors.jacobian, impulse)[:, 0] / time_step,
    )
