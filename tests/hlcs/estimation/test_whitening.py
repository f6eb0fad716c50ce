"""Whitening: the Kalman filter is the inverse Cholesky factor of the covariance."""

import numpy as np
import pytest

from hlcs.estimation.whitening import colour, kalman_filter, whiten, whitening_of, whitening_of_settings


@pytest.mark.parametrize(("rho", "white"), [(0.0, 0.0), (0.6, 0.0), (0.6, 0.1), (0.9, 0.9), (0.95, 0.4)])
@pytest.mark.parametrize("jitter", [0.0, 0.9])
def test_the_filter_is_the_cholesky_factor(generator, rho, white, jitter):
    """The lower factor of a covariance is unique, so the filter must give that of LAPACK: to rounding, times the condition."""
    times = np.arange(80) + jitter * generator.uniform(0, 1, 80)
    covariance = (1 - white) * np.power(max(rho, 1e-12), np.abs(times[:, None] - times))
    covariance[np.diag_indices(80)] = 1.0
    lower, values = np.linalg.cholesky(covariance), generator.standard_normal((80, 3))
    tolerance = 1e-15 * 80 * np.linalg.cond(covariance)
    filter = kalman_filter(times, rho, white, 1.0)
    assert np.allclose(filter.colour(np.eye(80)), lower, atol=1e-13)
    assert np.allclose(filter.whiten(values), np.linalg.solve(lower, values), atol=tolerance)
    assert np.isclose(2 * np.sum(np.log(filter.deviation)), np.linalg.slogdet(covariance)[1], rtol=1e-12, atol=1e-12)


def test_whitening_undoes_the_correlation(generator):
    """Covariance of whitened AR(1) noise is the identity: checked by algebra, L^-1 C L^-T = 1 to rounding."""
    times = np.cumsum(generator.uniform(0.5, 1.5, 30))
    whitening = whitening_of(np.zeros(30, int), times, np.full(30, 0.2), {0: (0.7, 0.1)}, 1.0)
    covariance = 0.04 * (0.9 * 0.7 ** np.abs(times[:, None] - times[None]) + 0.1 * np.eye(30))
    white = whiten(whitening, whiten(whitening, covariance).T)
    assert np.allclose(white, np.eye(30), atol=1e-10)
    values = generator.standard_normal(30)
    assert np.allclose(colour(whitening, whiten(whitening, values)), values, atol=1e-10)


def test_observations_that_share_an_error_become_white_whatever_their_order():
    """W C W^T = 1 for the covariance C of own and shared errors, and W is symmetric: no order stands out."""
    setting, own = np.array([0, 0, 0, 1, 2, 2]), np.array([2.0, 2.0, 2.0, 1.0, 0.3, 0.3])
    common = np.array([3.0, 3.0, 3.0, 0.0, 0.5, 0.5])
    whitening = whitening_of_settings(setting, own, common)
    covariance = np.diag(own**2) + np.outer(common, common) * (setting[:, None] == setting)
    matrix = whiten(whitening, np.eye(6))
    np.testing.assert_allclose(matrix @ covariance @ matrix.T, np.eye(6), atol=1e-12)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12)
    np.testing.assert_allclose(colour(whitening, matrix), np.eye(6), atol=1e-12)
