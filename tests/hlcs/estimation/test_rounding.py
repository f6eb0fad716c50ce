"""Rounded readings: what lies beneath them."""

import numpy as np
import pytest

from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.rounding import before_rounding, noise_below_the_step, rounded


def test_rounding_taken_off_and_added_again_leaves_the_noise():
    noise = CorrelatedNoise(0.002, 0.6, 0.3, np.diag([0.01, 0.02, 0.03]))
    again = rounded(before_rounding(noise, 0.003), 0.003)
    assert again[:3] == pytest.approx(noise[:3], rel=1e-12)
    assert rounded(noise, 0.0)[:3] == noise[:3]


@pytest.mark.parametrize("sigma", [0.1, 0.2, 0.3, 0.5])
def test_the_noise_below_the_step_is_known_as_well_as_it_says(generator, sigma):
    """Of 60 bodies at rest somewhere between two steps, 600 readings each of three coordinates: the true log sigma lies within
    two of its standard deviations in at least 80 % (95 % less four standard errors), where it is not all one reading."""
    inside = []
    for _ in range(60):
        readings = [np.round(generator.uniform(0, 1) + sigma * generator.standard_normal(600)) for _ in range(3)]
        found, variance = noise_below_the_step(readings, 1.0, 0.0)
        inside.append(abs(np.log(found / sigma)) < 2 * np.sqrt(variance))
    assert np.mean(inside) >= 0.8


def test_readings_that_are_all_the_same_tell_an_upper_limit():
    """In the middle of a step 600 readings within half of it are as likely as not at 0.5 / 3.2 = 0.16 steps: three deviations."""
    sigma, variance = noise_below_the_step([np.zeros(600)], 1.0, 0.0)
    assert sigma < 0.16 < sigma * np.exp(3 * np.sqrt(variance))
