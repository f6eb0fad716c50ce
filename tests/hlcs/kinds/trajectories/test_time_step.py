"""The error of the time step: extrapolation to a step of zero."""

import numpy as np

from hlcs.kinds.trajectories.time_step import richardson


def test_two_steps_are_carried_on_to_zero():
    """An error of first order vanishes, that of a turn too."""

    def answer(step):
        half = (0.4 + 2 * step) / 2
        return [(np.array([[1.0 + 3 * step, 0.0, 0.0]]), np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]]))]

    ((position, turn),) = richardson(answer(0.02), answer(0.01))
    np.testing.assert_allclose(position, [[1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(turn, [[np.cos(0.2), 0.0, 0.0, np.sin(0.2)]], atol=1e-12)
