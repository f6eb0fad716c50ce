"""A recording whose fit got stuck is fitted afresh: from its own samples, over a growing stretch."""

import numpy as np
import pytest
from experiments import measured
from throws import write_throws

from hlcs.estimation.multiple_shooting import around, chi2_over, improve, noise_leaves, refit_initial_states, searched
from hlcs.kinds.trajectories.preparation import prepare


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    return prepare(measured(write_throws(tmp_path_factory.mktemp("throws"), count=3)))


def test_a_fit_that_explains_its_recordings_is_left_alone(prepared):
    assert refit_initial_states(prepared.problem, prepared.base) is prepared.base


def test_one_step_finds_the_best_start_of_a_free_flight_and_moves_no_other(prepared):
    """Positions are linear in the start: the undamped step ends at the least chi2, which projecting the start out gives as well;
    1e-4 of it is far below a degree of freedom, and more than finite differences lose."""
    problem, good, keep = prepared.problem, prepared.base, {1: slice(None)}
    starts = good.initial_states.copy()
    starts[1, 3:6] += (4.0, -3.0, 6.0)  # m/s
    assert list(improve(problem, good.model, starts, keep, np.array([1]))) == [1]
    assert chi2_over(problem, good.model, starts[1:2], np.array([1]), keep) == pytest.approx(good.chi2_per_recording[1], rel=1e-4)
    np.testing.assert_array_equal(starts[[0, 2]], good.initial_states[[0, 2]])
    assert list(improve(problem, good.model, starts, keep, np.array([1]))) == []  # nothing is left to gain


def test_states_around_are_sought_where_noise_does_not_leave_as_much_and_only_there(prepared):
    """A start 5 cm and 0.4 m/s off is found again; one that noise explains stays the same bits, and so does what is not asked."""
    problem, good = prepared.problem, prepared.base
    starts = good.initial_states.copy()
    starts[1:, :3] += 0.05  # m
    starts[1:, 3:6] -= 0.4  # m/s
    found = searched(problem, good.model, starts, np.array([0, 1]))
    np.testing.assert_array_equal(found[[0, 2]], starts[[0, 2]])
    left = chi2_over(problem, good.model, found[1:2], np.array([1]), {1: slice(None)})[0]
    assert left < noise_leaves(problem.recordings[1])
    alone = searched(problem, good.model, starts, np.array([1]))
    np.testing.assert_array_equal(alone[1], found[1])  # the draws of one are not those that others leave


def test_states_are_drawn_as_far_around_one_as_its_columns_tell():
    """Of 4,000 draws of size 1 the spread of each move is its standard error, to four of its own: 1.1 %."""
    unknown, errors = [(0, axis) for axis in np.eye(3)], np.array([0.1, 0.2, 0.5])
    draws = np.random.default_rng(5).normal(size=(4000, 12))
    states = around(np.zeros(13), unknown, np.diag(1 / errors), draws)
    np.testing.assert_allclose(states[:, :3].std(axis=0), errors, rtol=0.045)
    assert not states[:, 3:6].any()
