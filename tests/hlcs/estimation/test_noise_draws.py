"""Draws of noise: its covariance, its uncertain numbers, outliers that stayed, rounding as the model says it falls."""

from dataclasses import replace

import numpy as np

from hlcs.estimation.correlated_noise import CorrelatedNoise, lower_factor
from hlcs.estimation.linearization import Recording
from hlcs.estimation.noise_draws import NoiseDraws
from hlcs.estimation.noise_model import Noise
from hlcs.estimation.outliers import Tail
from hlcs.estimation.whitening import colour

CERTAIN = np.zeros((3, 3))


def recorded(noise, count):
    """One coordinate of one recording with this noise."""
    channel, times = np.zeros(count, int), np.arange(count) * noise.step
    return Recording(channel, np.arange(count), times, noise.whitening(channel, times), ())


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

    def draws(matrix):
        kind = CorrelatedNoise(0.002, 0.5, 0.1, matrix)
        noise = Noise(kind, None, 1 / 60, "stated")
        return NoiseDraws(noise, [recorded(noise, 40)])(0, 250)

    bits = covariance * (1 + 2.0**-52 * np.array([[1, -1, 1], [-1, -1, 1], [1, 1, 1]]))
    assert np.any(bits != covariance) and np.allclose(draws(bits), draws(covariance), rtol=0, atol=1e-10)


def test_draws_made_some_at_a_time_take_every_set_of_noise_parameters():
    """With noise as good as certain of its sigma save for one very uncertain log sigma, every column has a size of its own."""
    kind = CorrelatedNoise(0.002, 0.0, 0.0, np.diag([1.0, 0.0, 0.0]))
    noise = Noise(kind, None, 1 / 60, "stated")
    draw = NoiseDraws(noise, [recorded(noise, 4000)])
    sizes = np.concatenate([draw(0, 50) for _ in range(8)], axis=1).std(axis=0)
    first, again = sizes.reshape(2, 200)
    assert len(np.unique(np.round(first, 3))) > 150
    assert np.allclose(first, again, rtol=0.1)  # the scatter of a standard deviation of 4,000 numbers is 1.1 %


def test_rounded_readings_of_a_body_at_rest_are_drawn_where_it_rests():
    """0.3 steps above a reading, noise far below the step: every drawn reading lies 0.3 steps below the model, none scatters."""
    lattice = np.zeros((3, 2))
    lattice[0] = 0.001, 0.5
    noise = Noise(CorrelatedNoise(1e-5, 0.0, 0.0, CERTAIN), None, 1 / 60, "stated", lattice=lattice)
    recording = recorded(noise, 30)
    draws = NoiseDraws(noise, [recording], [np.full(30, 0.5073)])(0, 20)
    assert np.allclose(colour(recording.whitening, draws), -0.0003, rtol=0, atol=1e-12)


def test_rounding_of_a_moving_body_adds_a_twelfth_of_the_step_squared():
    """Steps of 2 sigma crossed five times a sample: variance 1 + 4/12 of sigma^2, five standard errors of 40,000 numbers."""
    lattice = np.zeros((3, 2))
    lattice[0] = 0.002, 0.0
    noise = Noise(CorrelatedNoise(0.001, 0.0, 0.0, CERTAIN), None, 1 / 60, "stated", lattice=lattice)
    recording = recorded(noise, 400)
    draws = NoiseDraws(noise, [recording], [0.01037 * np.arange(400)])(0, 100)
    spread = np.std(colour(recording.whitening, draws)) / 0.001
    assert abs(spread**2 - 4 / 3) < 5 * 4 / 3 * np.sqrt(2 / 40000)


def test_outliers_that_stayed_are_drawn_as_often_as_they_were_seen():
    """One in a hundred of 5 sigma: 400 of 40,000, within five standard errors."""
    noise = Noise(CorrelatedNoise(0.001, 0.0, 0.0, CERTAIN), None, 1 / 60, "stated", tail=Tail(0.01, np.array([-5.0, 5.0])))
    draws = NoiseDraws(noise, [recorded(noise, 400)])(0, 100)
    assert abs(np.sum(np.abs(draws) == 5.0) - 400) < 5 * 20


def test_readings_around_a_fitted_path_are_drawn_anywhere_among_their_steps():
    """A path 0.3 steps above a reading, its start fitted: what readings miss it by is uniform, q^2/12, and in a draw all the same
    while nothing moves. The scatter of the mean of 400 squares, each a twelfth with a deviation of 0.075: 0.0037, five of it."""
    lattice = np.zeros((3, 2))
    lattice[0] = 0.001, 0.5
    noise = Noise(CorrelatedNoise(1e-6, 0.0, 0.0, CERTAIN), None, 1 / 60, "stated", lattice=lattice)
    recording = replace(recorded(noise, 3), unknown=(("position", (1.0, 0.0, 0.0)),))
    draws = NoiseDraws(noise, [recording], [np.full(3, 0.5073)])(0, 400)
    missed = colour(recording.whitening, draws) / 0.001
    assert np.allclose(missed, missed[0], rtol=0, atol=0.02) and abs(np.mean(missed[0] ** 2) - 1 / 12) < 5 * 0.0037
