"""Fits of a problem in closed form: a line through recordings with a constant each."""

from dataclasses import replace

import numpy as np
import pytest
from linear_models import RATE, Line, model

from hlcs.estimation.problem import difference_step, values_of, with_values

TIMES = [np.linspace(0.0, 2.0, 9), np.linspace(0.0, 1.0, 7)]


def test_a_linear_problem_is_solved_in_one_step_with_the_covariance_of_the_textbook(generator):
    """Slope and variance of the pooled regression with a constant for each recording: Sxy / Sxx and sigma^2 / Sxx.

    The prior that keeps the number within its bounds counts as one observation of width 10: 1e-2 beside Sxx / sigma^2 of 5e4.
    """
    values = [3.0 * t + c + 0.01 * generator.standard_normal(len(t)) for t, c in zip(TIMES, (5.0, -2.0), strict=True)]
    fit = Line(TIMES, values, 0.01).fit(model(1.0))
    centred = [t - t.mean() for t in TIMES]
    sxx = sum(t @ t for t in centred)
    slope = sum(t @ y for t, y in zip(centred, values, strict=True)) / sxx
    assert fit.estimate[0] == pytest.approx(slope, rel=1e-6)
    assert fit.covariance[0, 0] == pytest.approx(0.01**2 / sxx, rel=1e-6)
    assert fit.initial_states[:, 0] == pytest.approx(
        [y.mean() - slope * t.mean() for t, y in zip(TIMES, values, strict=True)], rel=1e-5
    )
    assert fit.freedom == 16 - 3 and fit.at_bound == (False,)


def test_a_number_stops_at_its_bound():
    values = [-1.0 * t for t in TIMES]  # a negative rate, which cannot be
    fit = Line(TIMES, values).fit(model(1.0))
    assert fit.estimate.tolist() == [0.0] and fit.at_bound == (False,)  # its null value is no bound that it was driven to
    fit = Line(TIMES, [30.0 * t for t in TIMES]).fit(model(1.0))
    assert fit.estimate.tolist() == [10.0] and fit.at_bound == (True,)


def test_a_derivative_of_a_linear_problem_is_its_column():
    problem = Line(TIMES, [2.0 * t for t in TIMES], 0.5)
    linear = problem.linearise(model(2.0), problem.initial_guess())
    columns, moves = problem.derivative("linear_drag", RATE.free[0], 2.0, model, linear, problem.initial_guess())
    for column, t in zip(columns, TIMES, strict=True):
        np.testing.assert_allclose(column, t / 0.5, rtol=1e-10, atol=1e-10)
    assert all((move == 0).all() for move in moves)


def test_numbers_of_a_model_go_out_and_in():
    assert values_of(model(4.0)).tolist() == [4.0]
    assert values_of(with_values(model(4.0), np.array([7.0]))).tolist() == [7.0]
    assert values_of(with_values(model(4.0), np.array([-7.0]))).tolist() == [0.0]  # kept within its bounds


def test_a_difference_is_a_part_of_the_range_or_of_the_value():
    free = RATE.free[0]
    assert difference_step(free, 3.0) == pytest.approx(1e-3)
    assert difference_step(replace(free, high=np.inf), 50.0) == pytest.approx(5e-3)
