"""What a force does to the observations: closed forms."""

import numpy as np

from hlcs.learning.flights import double_integral, flights_of, rows_with_force


def test_the_double_integral_of_straight_lines_is_exact():
    """a = 1 moves by t^2/2, a = t by t^3/6: straight lines between the nodes are both, so only rounding is left."""
    nodes, times = np.linspace(0.0, 1.0, 11), np.array([0.0, 0.013, 0.5, 0.77, 1.0])
    moved = double_integral(times, nodes)
    np.testing.assert_allclose(moved @ np.ones(11), times**2 / 2, atol=1e-14)
    np.testing.assert_allclose(moved @ nodes, times**3 / 6, atol=1e-14)


def test_the_residuals_are_the_response_to_the_force(throw):
    """Without noise, a force that depends on time alone: 1e-6 is what Runge-Kutta and finite differences leave, in sigma."""
    problem, fit = throw(lambda x, v, t: np.tile([0.3, -0.2 * t, 0.1], (len(x), 1)), sigma=0.0)
    for flight in flights_of(problem, fit):
        force = np.column_stack([0.3 + 0 * flight.times, -0.2 * flight.times, 0.1 + 0 * flight.times])
        expected = np.tensordot(flight.response, force, 2)
        np.testing.assert_allclose(flight.residual, expected, atol=1e-5 * np.abs(expected).max())


def test_rows_are_white_and_the_path_is_where_the_body_was(throw):
    """Rows are orthonormal, so noise stays white; the path, corrected by the force, is the true one within the noise."""
    problem, fit = throw(lambda x, v, t: -0.3 * v * np.linalg.norm(v, axis=1, keepdims=True) ** 0.5, sigma=0.0)
    for k, flight in enumerate(flights_of(problem, fit)):
        np.testing.assert_allclose(flight.rows.T @ flight.rows, np.eye(len(flight.residual)), atol=1e-9)
        seen = problem.trials[k]
        there = np.column_stack([np.interp(seen.times, flight.times, axis) for axis in flight.position.T])
        sag = 9.81 * (flight.times[1] / 2) ** 2 / 2  # of the parabola from the straight lines that this test draws
        assert np.abs(there - seen.position).max() < sag + 0.002


def test_noise_alone_shows_no_force(throw):
    """Three standard deviations in none of ten octaves."""
    problem, fit = throw(lambda x, v, t: 0.0 * x)
    assert not rows_with_force(flights_of(problem, fit)).any()


def test_between_impacts_the_residuals_are_the_response_to_the_force(bounce):
    """Each stretch has a start of its own and holds no impact; 2 % is what a path that is off by the force itself leaves."""
    problem, fit = bounce(lambda x, v, t: -0.02 * v, sigma=0.0)
    flights = flights_of(problem, fit)
    assert len(flights) >= 3
    for flight in flights:
        expected = np.tensordot(flight.response, -0.02 * flight.velocity, 2)
        assert np.abs(flight.residual - expected).max() < 0.02 * np.abs(expected).max()
        assert (np.diff(flight.velocity[:, 2]) < 0).all() and flight.position[:, 2].min() > 0.03
