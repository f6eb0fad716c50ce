"""Recordings as a problem: residuals and derivatives of a free flight in closed form."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.noise_model import Noise
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.simulation.model import Model
from hlcs.simulation.simulator import Simulator

SIGMA, STEP = 0.01, 0.05
TIMES = STEP * np.arange(12)
NOISE = Noise(CorrelatedNoise(SIGMA, 0.0, 0.0, np.zeros((3, 3))), None, STEP, "stated")


def problem_of(position, **changes):
    """One throw of a ball, unknown where it began and how fast."""
    body, around = Body(radius=0.05, mass=0.1), Surroundings()
    trial = Trial("throw", "1", TIMES, position, np.full((12, 4), np.nan), {}, body, around, **changes)
    return TrajectoryProblem((trial,), NOISE, Simulator(Model(), (trial,), [0.0]))


def parabola(velocity):
    return np.outer(TIMES, velocity) - np.outer(9.81 * TIMES**2 / 2, [0, 0, 1])


def test_a_parabola_is_guessed_and_leaves_nothing():
    problem = problem_of(parabola([1.0, -2.0, 5.0]))
    fit = problem.fit(Model())
    assert fit.initial_states[0, :6] == pytest.approx([0, 0, 0, 1, -2, 5], abs=1e-8) and fit.chi2 < 1e-10
    assert fit.freedom == 36 - 6 and problem.unit == "m"


def test_derivatives_of_a_free_flight_are_one_and_the_time():
    """Per metre of the start every sample of that axis moves by 1, per m/s by t; in units of sigma. Differences lose 1e-9."""
    problem = problem_of(parabola([1.0, -2.0, 5.0]))
    linear = problem.linearise(Model(), problem.initial_guess())
    (columns,) = linear.state_columns
    expected = np.zeros((36, 6))
    for axis in range(3):
        inside = slice(12 * axis, 12 * axis + 12)
        expected[inside, axis], expected[inside, 3 + axis] = 1 / SIGMA, TIMES / SIGMA
    np.testing.assert_allclose(columns, expected, atol=1e-6 / SIGMA)
    alone = problem.linearise(Model(), problem.initial_guess(), only=[0])
    np.testing.assert_array_equal(alone.state_columns[0], columns)


def test_what_is_dropped_or_missing_is_no_observation():
    seen = parabola([1.0, 0.0, 5.0])
    seen[3, 0], seen[:, 1] = np.nan, np.nan
    problem = problem_of(seen)
    flags = np.zeros((12, 9), bool)
    flags[7, 2] = True
    problem.leave_out([flags])
    (recording,) = problem.recordings
    assert np.bincount(recording.channel).tolist() == [11, 0, 11]
    assert 3 not in recording.sample[recording.channel == 0] and 7 not in recording.sample[recording.channel == 2]
    assert len(recording.unknown) == 4  # nothing is known, or asked, of an axis that nobody measured
