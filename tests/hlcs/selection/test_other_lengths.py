"""Recordings of other lengths: same rate, same start, the missing channels missing, and the motion of the closed form."""

import numpy as np
import pytest
from throws import G, write_throws

from hlcs.kinds.experiment import Experiment
from hlcs.kinds.protocol import Options
from hlcs.selection.other_lengths import lasting, length_of


@pytest.fixture
def prepared(tmp_path):
    path = write_throws(tmp_path, count=2, static=False, noise="noise = { position = 0.004 }")
    return Experiment.read(path).opened(Options()).pilot("linear_drag").prepare()


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_throw_of_another_length_follows_its_parabola(prepared, factor):
    """60 samples at 60 Hz become 30 and 120; the model under test has gravity alone."""
    problem, base = prepared.problem, prepared.base
    other = lasting(problem, base, factor)
    assert length_of(problem) == pytest.approx(59 / 60, abs=1e-5)
    for trial, state in zip(other.trials, base.initial_states, strict=True):
        assert len(trial.times) == 60 * factor and np.allclose(np.diff(trial.times), 1 / 60, atol=2e-6)  # times of six decimals
        fall = state[:3] + np.outer(trial.times, state[3:6]) - G / 2 * np.outer(trial.times**2, [0, 0, 1])
        assert np.allclose(trial.position, fall, atol=1e-6) and np.isnan(trial.orientation).all()


def test_a_recording_keeps_the_few_samples_that_a_start_needs(prepared):
    assert lasting(prepared.problem, prepared.base, 3 / 60) is None and lasting(prepared.problem, prepared.base, 0.1) is not None
