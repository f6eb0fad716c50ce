"""Derivatives of a problem in closed form: a line through recordings with a constant each."""

from dataclasses import replace

import numpy as np
import pytest
from linear_models import RATE, Line, model

from hlcs.estimation.problem import difference_step

TIMES = [np.linspace(0.0, 2.0, 9), np.linspace(0.0, 1.0, 7)]


def test_a_derivative_of_a_linear_problem_is_its_column():
    problem = Line(TIMES, [2.0 * t for t in TIMES], 0.5)
    linear = problem.linearise(model(2.0), problem.initial_guess())
    columns, moves = problem.derivative("linear_drag", RATE.free[0], 2.0, model, lambda: linear, problem.initial_guess())
    for column, t in zip(columns, TIMES, strict=True):
        np.testing.assert_allclose(column, t / 0.5, rtol=1e-10, atol=1e-10)
    assert all((move == 0).all() for move in moves)


def test_a_derivative_may_be_taken_as_far_as_a_value_that_is_known():
    """The chord from 2 to 5 of a linear law is the same column; a value where the number stands is no way at all."""
    problem = Line(TIMES, [2.0 * t for t in TIMES], 0.5)
    linear = problem.linearise(model(2.0), problem.initial_guess())
    for to in (5.0, 2.0):
        columns, _ = problem.derivative("linear_drag", RATE.free[0], 2.0, model, lambda: linear, problem.initial_guess(), to=to)
        np.testing.assert_allclose(columns[0], TIMES[0] / 0.5, rtol=1e-10, atol=1e-10)


def test_where_nothing_touches_a_derivative_does_not_depend_on_those_that_were_taken_before():
    """log(1 + rate/k) t, k a ten-thousandth of the range: first at zero, as a candidate is screened, then at k, where it is
    t/(2 k) to 0.1 %. The difference for zero, k too, would give four fifths of it."""

    class Bent(Line):
        def residuals(self, model, initial_states):
            moved = np.log1p(1e3 * model.terms[0].numbers["rate"])
            return [y - moved * t - state[0] for t, y, state in zip(self.times, self.values, initial_states, strict=True)]

    problem = Bent(TIMES, [2.0 * t for t in TIMES], 0.5)
    for rate in (0.0, 1e-3):
        linear = problem.linearise(model(rate), problem.initial_guess())
        here = (lambda known=linear: known), problem.initial_guess()
        columns, _ = problem.derivative("linear_drag", RATE.free[0], rate, model, *here)
    np.testing.assert_allclose(columns[0], TIMES[0] / 2e-3 / 0.5, rtol=1e-3, atol=1e-9)


def test_a_difference_is_a_part_of_the_range_or_of_the_value():
    free = RATE.free[0]
    assert difference_step(free, 3.0) == pytest.approx(1e-3)
    assert difference_step(replace(free, high=np.inf), 50.0) == pytest.approx(5e-3)
    assert difference_step(free, 0.01) == pytest.approx(1e-5)  # of an amount far below its range: 0.1 % of it
    assert difference_step(free, 1e-12) == pytest.approx(1e-7)  # a change of 1e-15 would be lost in rounding
