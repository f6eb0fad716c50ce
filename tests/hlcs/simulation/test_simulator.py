"""The simulator: shares of a batch."""

import numpy as np

from hlcs.simulation.simulator import partition


def test_a_batch_is_parted_so_that_each_part_is_held_at_once():
    """Length times the largest size stays within the limit; what fits together stays together, in its order."""
    sizes = np.array([5, 1, 4, 1, 3, 1])
    assert partition(range(6), sizes, 30) == [[0, 1, 2, 3, 4, 5]]
    parts = partition(range(6), sizes, 8)
    assert sorted(b for part in parts for b in part) == list(range(6))
    assert all(len(part) == 1 or len(part) * max(sizes[part]) <= 8 for part in parts)
    assert [list(sizes[part]) for part in parts] == [[1, 1, 1], [3, 4], [5]]
