"""Turns beyond half a turn, against turns about a fixed axis."""

import numpy as np

from hlcs.data.turns import continued
from minibullet import rotations


def test_a_turn_that_goes_on_is_told_beyond_half_a_turn():
    """Of a turn by up to 20 rad about a fixed axis a quaternion shows the shorter way round; samples in order show all of it,
    also where one of them is a whole turn to the last digit."""
    axis = np.array([2.0, -1.0, 2.0]) / 3
    angles = np.array([0.0, 1.0, 2.9, 4.0, 2 * np.pi, 8.0, 10.9, 4 * np.pi, 15.0, 17.5, 20.0])
    seen = rotations.logarithm(rotations.exponential(np.outer(angles, axis)))
    assert np.linalg.norm(seen, axis=1).max() <= np.pi
    np.testing.assert_allclose(continued(seen), np.outer(angles, axis), atol=1e-12)
