"""A recording whose fit got stuck is fitted afresh: from its own samples, over a growing stretch."""

import numpy as np
import pytest
from throws import write_throws

from hlcs.data.measurement import read_measurement
from hlcs.estimation.multiple_shooting import _losses, _step, shot_again
from hlcs.kinds.trajectories.preparation import prepare


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    return prepare(read_measurement(write_throws(tmp_path_factory.mktemp("throws"), count=3)))


def test_a_fit_that_explains_its_recordings_is_left_alone(prepared):
    assert shot_again(prepared.problem, prepared.base) is prepared.base


def test_one_step_finds_the_best_start_of_a_free_flight_and_moves_no_other(prepared):
    """Positions are linear in the start: the undamped step ends at the least chi2, which projecting the start out gives as well;
    1e-4 of it is far below a degree of freedom, and more than finite differences lose."""
    problem, good, keep = prepared.problem, prepared.base, {1: slice(None)}
    starts = good.starts.copy()
    starts[1, 3:6] += (4.0, -3.0, 6.0)  # m/s
    assert list(_step(problem, good.model, starts, keep, np.array([1]))) == [1]
    assert _losses(problem, good.model, starts[1:2], np.array([1]), keep) == pytest.approx(good.losses[1], rel=1e-4)
    np.testing.assert_array_equal(starts[[0, 2]], good.starts[[0, 2]])
    assert list(_step(problem, good.model, starts, keep, np.array([1]))) == []  # nothing is left to gain
