"""Rounded readings: what lies beneath them."""

from typing import NamedTuple

import numpy as np
import pytest

from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.rounding import before_rounding, lattice_of, noise_below_the_step, rounded


class Path(NamedTuple):
    """What `lattice_of` asks of a recording."""

    position: np.ndarray


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


def test_the_way_of_a_steady_cart_from_sample_to_sample_is_no_step_of_its_readings():
    """0.5 m/s at 20 frames a second, 25 mm a frame, and z = 2 m - 5.24 mm k^2 of a fall, read to a millimetre or not at all."""
    seconds, draw = np.arange(40) / 20, np.random.default_rng(1)
    cart = np.full((40, 3), np.nan)
    cart[:, 0] = np.round(0.5 * seconds + 5e-4 * draw.standard_normal(40), 3)
    assert lattice_of([Path(cart)], None)[0, 0] == pytest.approx(0.001)
    fall = np.full((20, 3), np.nan)
    fall[:, 2] = 2.0 - np.pi / 600 * np.arange(20) ** 2
    assert not lattice_of([Path(fall)], None).any()
    rolling = np.full((40, 3), np.nan)
    rolling[:, 0] = 0.004 * np.round((0.31 * seconds - 0.05 * seconds**2) / 0.004)  # in pixels of 4 mm
    assert lattice_of([Path(rolling)], None)[0, 0] == pytest.approx(0.004)
