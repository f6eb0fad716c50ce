"""The records that cross the engine's borders: bodies, contacts, and the law that holds at each contact.

Plain tuples of NumPy arrays in SI units, world frame, z up. Effects read them and never write them. There are no body types:
what cannot move has infinite mass.
"""

from typing import NamedTuple

import numpy as np


class Bodies(NamedTuple):
    """State and properties of n bodies."""

    position: np.ndarray  # centre of mass, world frame [m], (n, 3)
    orientation: np.ndarray  # unit quaternion (w, x, y, z) turning body axes into world axes [-], (n, 4)
    twist: np.ndarray  # velocity of the centre of mass [m/s], then angular velocity [rad/s], world frame, (n, 6)
    mass: np.ndarray  # mass, infinite for a fixed body [kg], (n,)
    inertia: np.ndarray  # principal moments of inertia about the centre of mass, body axes [kg m2], (n, 3)
    volume: np.ndarray  # volume of the solid [m3], (n,)
    area: np.ndarray  # mean projected area: over all directions of view [m2], (n,)
    radius: np.ndarray  # radius of the sphere of equal volume [m], (n,)


class Contacts(NamedTuple):
    """m contact points, as the laws of contact see them before the step is solved."""

    body_a: np.ndarray  # index into Bodies of the body the normal leaves, integer [-], (m,)
    body_b: np.ndarray  # index into Bodies of the body the normal enters, integer [-], (m,)
    point: np.ndarray  # contact point, world frame [m], (m, 3)
    normal: np.ndarray  # unit normal from a to b, world frame [-], (m, 3)
    gap: np.ndarray  # distance of the surfaces along the normal, negative = penetration [m], (m,)
    velocity: np.ndarray  # of b minus that of a: where a new contact touches in the step, else as it begins; world [m/s], (m, 3)
    load: np.ndarray  # normal force of the previous step, 0 for a new contact [N], (m,)


class ContactLaw(NamedTuple):
    """What holds at each of m contacts; effects return it changed by ``law._replace(...)``."""

    friction: np.ndarray  # coefficient of Coulomb friction: tangential / normal force [-], (m,)
    restitution: np.ndarray  # normal speed after / before the impact [-], (m,)
    rolling_arm: np.ndarray  # resisting moment about the tangent plane / normal force [m], (m,)
    spinning_arm: np.ndarray  # resisting moment about the normal / normal force [m], (m,)
    adhesion: np.ndarray  # pull that the contact bears before it opens (pull-off force) [N], (m,)


def velocity(bodies: Bodies) -> np.ndarray:
    """Velocity of each centre of mass, world frame [m/s], (n, 3)."""
    return bodies.twist[:, :3]


def angular_velocity(bodies: Bodies) -> np.ndarray:
    """Angular velocity of each body, world frame [rad/s], (n, 3)."""
    return bodies.twist[:, 3:]


def moving(bodies: Bodies) -> np.ndarray:
    """Which bodies can move, that is have finite mass, boolean (n,)."""
    return np.isfinite(bodies.mass)
