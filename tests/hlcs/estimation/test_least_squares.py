"""Linear least squares: steps within bounds, bases, cosines."""

import numpy as np
import pytest

from hlcs.effects import Free
from hlcs.estimation.least_squares import bounded_least_squares


def test_a_step_that_meets_a_bound_is_the_best_within_the_bounds():
    """Two columns almost alike and a bound of 0.05 on both numbers: to stop one number and then the other ends at the corner
    (0.05, -0.05), worse than no step. Expected: the best point of a fine grid over the bounds."""
    one = np.array([1.0, 0.0, 0.0])
    columns = 1e4 * np.column_stack([one, 0.98 * one + 0.2 * np.array([0.0, 1.0, 0.0])])
    aim = 1e4 * np.array([0.01, -0.02, 0.1])
    frees = [Free(name, "1", -0.05, 0.05, 0.0, 0.0) for name in "ab"]
    step = bounded_least_squares([aim], [columns], np.zeros(2), frees)
    axis = np.linspace(-0.05, 0.05, 401)
    a, b = np.meshgrid(axis, axis, indexing="ij")
    loss = np.sum((aim[:, None, None] - columns[:, :1, None] * a - columns[:, 1:, None] * b) ** 2, axis=0)
    best = np.unravel_index(np.argmin(loss), loss.shape)
    assert step == pytest.approx([axis[best[0]], axis[best[1]]], abs=3e-4) and (np.abs(step) <= 0.05).all()
