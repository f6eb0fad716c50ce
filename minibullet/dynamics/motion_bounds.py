"""Bounds on how far and how fast any point of a body moves, from its twist and its bounding radius R: |v| + |omega| R."""

import numpy as np

from minibullet.kernels import kernel, leaf
from minibullet.vectors import length


@leaf
def top_speed(twist, radius):
    """Bound on the speed of any point of a body at this twist (6,) [m/s]."""
    return length(twist) + radius * length(twist[3:])


@kernel
def path_bound(twist, radius, duration):
    """Bound on how far any point of each body goes in ``duration`` seconds at this twist [m], (n,)."""
    result = np.empty(len(twist))
    for n in range(len(twist)):
        result[n] = duration * top_speed(twist[n], radius[n])
    return result


def motion_bound(twist, free_twist, radius, time_step):
    """Bound on how far any point of each body may go in this step [m], (n,).

    Twice the distance by its twist before or its free twist: an impact on one end can double the speed of the other end within
    the step.
    """
    return np.maximum(path_bound(twist, radius, 2.0 * time_step), path_bound(free_twist, radius, 2.0 * time_step))
