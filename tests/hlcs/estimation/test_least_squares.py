"""Linear least squares: estimates, bases, cosines, and what is believed beforehand."""

import numpy as np
import pytest

from hlcs.effects import Free
from hlcs.estimation.least_squares import basis, belief, largest_cosine, least_squares, whitening_beside


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


def test_what_is_believed_are_rows_whose_squares_are_the_surprise():
    """Rows of -2 log of a Cauchy law: squares as `Free.surprise`, slopes as their differences; an angle has none."""
    frees = [Free("a", "1", -1.0, 3.0, 0.0, 0.0), Free("b", "rad", 0.0, np.pi, None, 0.0, period=np.pi)]
    for value in (0.0, 0.4, -2.0, 50.0):
        rows, slopes = belief(np.array([value, 1.0]), frees)
        after, _ = belief(np.array([value + 1e-6, 1.0]), frees)
        assert rows[0] ** 2 == pytest.approx(frees[0].surprise(value)) and (rows[1], slopes[1]) == (0.0, 0.0)
        assert slopes[0] == pytest.approx((after[0] - rows[0]) / 1e-6, rel=1e-4)


def test_what_is_left_unknown_widens_what_is_white(generator):
    """Rows of covariance 1 + J J^T: their squares are those of r^T (1 + J J^T)^-1 r, alone and many side by side."""
    unknown, rows = generator.standard_normal((6, 2)), generator.standard_normal((6, 3))
    white, logarithm = whitening_beside(unknown)
    covariance = np.eye(6) + unknown @ unknown.T
    np.testing.assert_allclose((white(rows) ** 2).sum(axis=0), np.diag(rows.T @ np.linalg.solve(covariance, rows)), rtol=1e-12)
    np.testing.assert_allclose(white(rows[:, 0]), white(rows)[:, 0], rtol=1e-12)
    assert logarithm == pytest.approx(np.linalg.slogdet(covariance)[1])
