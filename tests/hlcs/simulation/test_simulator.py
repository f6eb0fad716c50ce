"""The simulator: extrapolation to a step of zero, shares of a batch."""

import numpy as np

from hlcs.simulation.simulator import partition, richardson


def test_two_steps_are_carried_on_to_zero():
    """An error of first order vanishes, that of a turn too."""

    def answer(step):
        half = (0.4 + 2 * step) / 2
        return [(np.array([[1.0 + 3 * step, 0.0, 0.0]]), np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]]))]

    ((position, turn),) = richardson(answer(0.02), answer(0.01))
    np.testing.assert_allclose(position, [[1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(turn, [[np.cos(0.2), 0.0, 0.0, np.sin(0.2)]], atol=1e-12)
    error = ValueError("no")
    assert richardson(error, answer(0.01)) is error


def test_a_batch_is_parted_so_that_each_part_is_held_at_once():
    """Length times the largest size stays within the limit; what fits together stays together, in its order."""
    sizes = np.array([5, 1, 4, 1, 3, 1])
    assert partition(range(6), sizes, 30) == [[0, 1, 2, 3, 4, 5]]
    parts = partition(range(6), sizes, 8)
    assert sorted(b for part in parts for b in part) == list(range(6))
    assert all(len(part) == 1 or len(part) * max(sizes[part]) <= 8 for part in parts)
    assert [list(sizes[part]) for part in parts] == [[1, 1, 1], [3, 4], [5]]
