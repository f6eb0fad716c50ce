"""A recording whose fit got stuck is fitted afresh: from its own samples, over a growing stretch."""

import numpy as np
import pytest
from experiments import measured
from throws import write_throws

from hlcs.estimation.multiple_shooting import chi2_over, improve, refit_initial_states
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
