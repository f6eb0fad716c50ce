"""What a fit tells: chi2 with the initial states projected out, the place of a term's numbers, the best of several views."""

from dataclasses import replace

import numpy as np
import pytest
from linear_models import Line, model

from hlcs.estimation.linearization import best_view, free_numbers

TIMES = [np.arange(5.0)]


def test_chi2_is_that_of_the_residuals_about_the_state_that_was_fitted():
    """Residuals y - rate t about their own mean: the constant of the recording is free."""
    values = [np.array([1.0, 4.0, 2.0, 8.0, 5.0])]
    problem = Line(TIMES, values, 2.0)
    base = model(0.0).without(0)
    linear = problem.linearise(base, problem.initial_guess())
    fit = problem.fit_at(base, problem.initial_guess(), linear)
    assert fit.chi2 == pytest.approx(np.sum((values[0] - values[0].mean()) ** 2) / 4)
    assert fit.count == 5 and fit.freedom == 4 and free_numbers(base) == []


def test_numbers_of_a_term_are_found_by_its_place_and_from_the_end():
    fit = Line(TIMES, [2.0 * TIMES[0]]).fit(model(1.0))
    two = replace(fit, model=fit.model.with_term(fit.model.terms[0]))
    assert (two.numbers_of(0), two.numbers_of(1), two.numbers_of(-1)) == (slice(0, 1), slice(1, 2), slice(1, 2))


def test_the_residual_is_what_states_and_numbers_leave():
    problem = Line(TIMES, [TIMES[0] ** 2])
    left, q = problem.linearise(model(0.0), problem.initial_guess()).residual
    assert left @ np.ones(5) == pytest.approx(0, abs=1e-10) and left @ TIMES[0] == pytest.approx(0, abs=1e-10)
    assert q.shape == (5, 1)


def test_the_view_that_explains_more_is_chosen():
    """Along x the aim has 3, along y 4: of the two views the second one, with a step of 4 / 2."""
    views = [({"a": 1}, [np.array([[1.0], [0.0]])]), ({"a": 2}, [np.array([[0.0], [2.0]])])]
    view, signature, step = best_view(views, np.zeros((2, 0)), np.array([3.0, 4.0]))
    assert view == {"a": 2} and signature is views[1][1] and step == pytest.approx([2.0])
