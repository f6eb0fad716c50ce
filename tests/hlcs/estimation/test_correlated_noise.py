"""Correlated noise fitted to series, and factors of its covariance."""

import numpy as np
import pytest

from hlcs.estimation.correlated_noise import fit_correlated_noise
from hlcs.estimation.flexible_curves import polynomials


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.8])
def test_noise_is_estimated_without_bias_from_the_fitted_curve(generator, rho):
    """54 pieces of 30 samples, each with six fitted numbers: sigma and rho within four standard errors of the truth."""
    series = []
    for _ in range(54):
        noise = generator.standard_normal(30)
        for k in range(1, 30):
            noise[k] = rho * noise[k - 1] + np.sqrt(1 - rho**2) * noise[k]
        series.append((np.arange(30.0), noise, polynomials(np.arange(30.0), 5)))
    found = fit_correlated_noise(series, 1.0, white=0.0)
    assert abs(found.rho - rho) < max(4 * np.sqrt(found.covariance[1, 1]), 0.05)
    assert abs(np.log(found.sigma)) < 4 * np.sqrt(found.covariance[0, 0])
