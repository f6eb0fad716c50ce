"""The error of the time step: extrapolation to a step of zero."""

from types import SimpleNamespace

import numpy as np

from hlcs.kinds.trajectories import time_step
from hlcs.kinds.trajectories.time_step import richardson, settling
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


def test_a_recording_that_finds_no_rest_with_shorter_steps_is_not_corrected(monkeypatch):
    """Halving moves one by 0.4, 0.2 and 0.1 sigma; another by 0.1, then by 3, where its body goes another way; one by nothing."""
    monkeypatch.setattr(time_step, "recording_scale", lambda recording: 1.0)
    problem = SimpleNamespace(recordings=[None, None, None], segmented=False)
    problem.changes = lambda before, after: [np.array([b - a]) for a, b in zip(before, after, strict=True)]
    runs = {1: [0.0, 0.0, 5.0], 1 / 2: [0.4, 0.1, 5.0], 1 / 4: [0.6, 3.1, 5.0], 1 / 8: [0.7, 3.3, 5.001]}
    kept = settling(problem, runs)
    assert [kept[share] for share in runs] == [[0.0, 0.0, 5.0], [0.4, 0.0, 5.0], [0.6, 0.0, 5.0], [0.7, 0.0, 5.001]]
