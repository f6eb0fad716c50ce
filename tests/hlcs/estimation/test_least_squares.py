"""Linear least squares: steps within bounds, bases, cosines."""

import numpy as np
import pytest

from hlcs.effects import Free
from hlcs.estimation.least_squares import basis, bounded_least_squares, largest_cosine, least_squares, null_prior


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


def test_columns_that_say_the_same_share_the_estimate():
    """Twice the same column: minimum norm, half each; units do not matter; what is explained is that of one of them."""
    column = np.array([1.0, 2.0, 2.0])
    fit = least_squares(np.column_stack([column, column]), 6 * column)
    assert fit.estimate == pytest.approx([3.0, 3.0]) and fit.gain == pytest.approx(36 * 9)
    assert least_squares(1e6 * column[:, None], 6 * column).estimate == pytest.approx([6e-6])
    assert basis(np.column_stack([column, 1e9 * column])).shape == (3, 1)


def test_the_largest_cosine_is_that_of_the_smallest_principal_angle():
    x, y, z = np.eye(3)
    plane, leaning = np.column_stack([x, y]), (np.cos(0.3) * x + np.sin(0.3) * z)[:, None]
    assert largest_cosine(plane, leaning) == pytest.approx(np.cos(0.3))
    assert largest_cosine(x[:, None], z[:, None]) == 0.0 and largest_cosine(plane, np.zeros((3, 1))) == 0.0


def test_what_data_do_not_show_keeps_near_its_null_value():
    """A number within a width of 0.1 about 0, with data that say nothing: the prior alone, weight 1 / 0.1 and aim 0."""
    (free,) = [Free("a", "1", -0.05, 0.05, 0.0, 0.0)]
    rows, aims = null_prior(np.array([0.02]), [free])
    assert rows.tolist() == [[pytest.approx(10.0)]] and aims == pytest.approx([-0.2])
    step = bounded_least_squares([np.zeros(1)], [np.zeros((1, 1))], np.array([0.02]), [free])
    assert step == pytest.approx([-0.02])
