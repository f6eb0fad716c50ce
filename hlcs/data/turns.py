"""Turns of a recorded body that go beyond half a turn."""

import numpy as np


def continued(turns):
    """Rotation vectors of successive samples (..., n, 3) [rad], each with as many whole turns about its axis as bring it nearest
    the one before: where a model loses more than half a turn the difference goes on growing."""
    if not (np.linalg.norm(np.diff(turns, axis=-2), axis=-1) > np.pi).any():
        return turns
    if turns.ndim > 2:
        return np.array([continued(each) for each in turns])
    angle = np.linalg.norm(turns, axis=1)
    axes, turns = turns / np.where(angle > 0, angle, 1.0)[:, None], turns.copy()
    for k in range(1, len(turns)):
        turns[k] += 2 * np.pi * np.round((axes[k] @ turns[k - 1] - angle[k]) / (2 * np.pi)) * axes[k]
    return turns
