"""Turns of a recorded body that go beyond half a turn."""

from math import pi, sqrt

import numpy as np

from minibullet import rotations
from minibullet.kernels import leaf
from minibullet.vectors import dot


def turned_since_first(orientation):
    """Rotation of every sample since the first one, turn by turn (n, 3) [rad], of orientations (n, 4)."""
    steps = rotations.logarithm(rotations.product(orientation[1:], rotations.conjugate(orientation[:-1])))
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def continued(turns):
    """Rotation vectors of successive samples (..., n, 3) [rad], each with as many whole turns about its axis as bring it nearest
    the one before: where a model loses more than half a turn the difference goes on growing."""
    found = np.array(turns, dtype=float, order="C")
    add_whole_turns(found.reshape(-1, *found.shape[-2:]))
    return found


@leaf
def add_whole_turns(turns):
    """`continued` of several recordings (runs, n, 3), in place."""
    for run in range(turns.shape[0]):
        for k in range(1, turns.shape[1]):
            turn = turns[run, k, 0], turns[run, k, 1], turns[run, k, 2]
            angle = sqrt(dot(turn, turn))
            if angle > 0.0:
                along = dot(turn, turns[run, k - 1]) / angle  # the angle about this axis of the turn before
                whole = 2.0 * pi * np.round((along - angle) / (2.0 * pi)) / angle
                for axis in range(3):
                    turns[run, k, axis] += whole * turn[axis]
