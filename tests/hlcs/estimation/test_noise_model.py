"""The noise of a measurement: draws of it, isolated outliers, coordinates that tell nothing."""

import numpy as np
import pytest
from experiments import TOML, measured
from throws import correlated, flight
from throws import csv as recording

from hlcs.estimation.correlated_noise import CorrelatedNoise, lower_factor
from hlcs.estimation.linearization import Recording
from hlcs.estimation.noise_model import Noise, estimate_noise, isolated_outliers


def test_draws_of_noise_follow_its_covariance_to_the_last_bit():
    """L L^T is the covariance, exactly known numbers included; what changes it by rounding changes the draws by rounding.

    The tolerance is 1e-16 times the condition of the known part (about 1e4), and a factor of 100 for sums of some dozen terms.
    """
    covariance = np.array([[5.6e-4, 5.5e-5, -3.9e-6], [5.5e-5, 1.3e-3, 3.7e-3], [-3.9e-6, 3.7e-3, 9.0e-2]])
    for known in ([], [0], [2], [0, 1, 2]):
        matrix = covariance.copy()
        matrix[known], matrix[:, known] = 0.0, 0.0
        assert np.allclose(lower_factor(matrix) @ lower_factor(matrix).T, matrix, rtol=1e-12, atol=0)
    assert np.allclose(lower_factor(np.ones((3, 3))), np.eye(3)[:1].repeat(3, 0))  # numbers that say the same are drawn once
    channel, times = np.zeros(40, int), np.arange(40) / 60.0

    def draws(matrix):
        kind = CorrelatedNoise(0.002, 0.5, 0.1, matrix)
        noise = Noise(kind, None, 1 / 60, "stated")
        return noise.drawer([Recording(channel, np.arange(40), times, noise.whitening(channel, times), ())])(0, 250)

    bits = covariance * (1 + 2.0**-52 * np.array([[1, -1, 1], [-1, -1, 1], [1, 1, 1]]))
    assert np.any(bits != covariance) and np.allclose(draws(bits), draws(covariance), rtol=0, atol=1e-10)


def test_draws_made_some_at_a_time_take_every_set_of_noise_parameters():
    """With noise as good as certain of its sigma save for one very uncertain log sigma, every column has a size of its own."""
    kind = CorrelatedNoise(0.002, 0.0, 0.0, np.diag([1.0, 0.0, 0.0]))
    noise, channel, times = Noise(kind, None, 1 / 60, "stated"), np.zeros(4000, int), np.arange(4000) / 60.0
    draw = noise.drawer([Recording(channel, np.arange(4000), times, noise.whitening(channel, times), ())])
    sizes = np.concatenate([draw(0, 50) for _ in range(8)], axis=1).std(axis=0)
    first, again = sizes.reshape(2, 200)
    assert len(np.unique(np.round(first, 3))) > 150
    assert np.allclose(first, again, rtol=0.1)  # the scatter of a standard deviation of 4,000 numbers is 1.1 %


def test_a_coordinate_set_to_zero_tells_nothing_of_the_noise(tmp_path):
    """Eight throws in a plane, sigma stated, y written as zero: rho of x and z, 0.6 within three standard errors of 0.04."""
    text = TOML.replace("0.01", "0.003")
    generator, times = np.random.default_rng(4), np.arange(60) / 60
    for k in range(8):
        seen = flight(np.zeros(3), np.array([3.0, 0.0, 4.0]), times) + correlated(generator, (60, 3), 0.003, 0.6) * [1, 0, 1]
        (tmp_path / f"throw_{k}.csv").write_text(recording(times, seen))
        text += f'[[trial]]\nfile = "throw_{k}.csv"\n'
    (tmp_path / "throws.toml").write_text(text)
    noise = estimate_noise(measured(tmp_path / "throws.toml"))
    assert noise.position == 0.003 and noise.rho == pytest.approx(0.6, abs=0.12)


def test_an_isolated_outlier_is_found_and_smooth_misfit_is_not(generator):
    values = np.sin(np.linspace(0, 3, 60)) * 50 + generator.standard_normal(60)
    assert not isolated_outliers(values).any()
    values[20] += 15
    assert np.flatnonzero(isolated_outliers(values)).tolist() == [20]
