"""The error of the time step: extrapolation to a step of zero."""

import numpy as np

from hlcs.kinds.trajectories.time_step import richardson
from hlcs.simulation.simulator import Motion


def test_two_steps_are_carried_on_to_zero():
    """An error of first order vanishes, that of a turn and of a reading too."""

    def answer(step):
        half = (0.4 + 2 * step) / 2
        turn = np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]])
        return [Motion(np.array([[1.0 + 3 * step, 0.0, 0.0]]), turn, np.array([[0.0, 0.0, 9.81 - 5 * step]]))]

    ((position, turn, force),) = richardson(answer(0.02), answer(0.01))
    np.testing.assert_allclose(position, [[1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(turn, [[np.cos(0.2), 0.0, 0.0, np.sin(0.2)]], atol=1e-12)
    np.testing.assert_allclose(force, [[0.0, 0.0, 9.81]], atol=1e-12)
