"""Laws fitted to residuals, where the answer is known."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.learning.flights import flights_of
from hlcs.learning.laws import one_law
from hlcs.learning.missing_law import _ranges
from hlcs.learning.regression import Regression


@pytest.fixture(scope="module")
def drag(throw):
    """Throws against which a force of 0.05 v^1.5 acts, without noise, and the law that says so."""
    problem, fit = throw(lambda x, v, t: -0.05 * v * np.linalg.norm(v, axis=1, keepdims=True) ** 0.5, sigma=0.0)
    flights = flights_of(problem, fit)
    regression = Regression(flights, 1.0)
    ranges = _ranges(problem, regression)
    return regression, one_law("speed", "power", "velocity", ranges[0]["speed"], ranges[1])


def test_a_law_is_found_with_its_numbers(drag):
    """Without noise: 2 % is what the path, an estimate itself, leaves."""
    regression, law = drag
    searched = regression.search(law, law.kind(), law.begins)
    (strength,), spread = regression.estimate(law, searched)
    reference = law.given[0].value
    assert searched[0] == pytest.approx(1.5, abs=0.03)
    assert strength == pytest.approx(-0.05 * reference**1.5, rel=0.02)
    assert len(spread) == 2 and (spread > 0).all()


@pytest.mark.parametrize("own_phases", [False, True])
def test_first_looks_are_what_least_squares_leaves(drag, own_phases):
    """Of the data and of what is expected, beside two columns of other numbers, at values that say nothing of each other.

    Normal equations lose half of the digits: 1e-9 of the whole.
    """
    regression, law = copy(drag[0]), replace(drag[1], own_phases=own_phases)
    regression.nuisance = np.random.default_rng(1).standard_normal((len(regression.residual), 2))
    values = [[0.5], [1.5], [2.5]]
    left = []
    for value in values:
        found, columns = regression.solve(law, law.kind(), value)
        missed = regression.residual - columns @ found.estimate
        beside = regression.expected(law, columns.shape[1] - 2) @ found.estimate[:-2]
        left.append(missed @ missed + beside @ beside)
    whole = regression.residual @ regression.residual
    np.testing.assert_allclose(regression.first_looks(law, law.kind(), values), left, rtol=0, atol=1e-9 * whole)
    assert np.ptp(left) > 1e-3 * whole


def test_slopes_are_derivatives(drag):
    """Of the change with respect to the exponent; central differences of 1e-3 err by 1e-6, one-sided ones of 1.2e-4 by 1e-4."""
    regression, law = drag
    columns, estimate = regression.columns(law, law.kind(), [1.5]), np.array([-0.4])
    slopes = regression.slopes(law, law.kind(), np.array([1.5]), columns, estimate)
    ends = [regression.columns(law, law.kind(), [1.5 + step]) @ estimate for step in (1e-3, -1e-3)]
    np.testing.assert_allclose(slopes[:, 0], (ends[0] - ends[1]) / 2e-3, atol=1e-3 * np.abs(slopes).max())


def test_what_is_held_out_is_foretold_where_the_law_is_right(drag):
    """Every recording by the five others; what is missed is small against what is there without the law."""
    regression, law = drag
    (found,) = regression.fits([law], lambda law, left, without: True, 0.0)
    assert found.missed @ found.missed < 0.01 * found.unforetold @ found.unforetold
    assert found.score >= found.missed @ found.missed


def test_no_law_goes_by_a_place_that_nobody_measured(throw):
    """Where heights alone were measured, x, y and the heading are those of a fit."""
    problem, fit = throw(lambda x, v, t: 0.0 * x)
    assert {"x", "y", "height", "heading"} <= _ranges(problem, Regression(flights_of(problem, fit), 1.0))[0].keys()
    for trial in problem.trials:
        trial.position[:, :2] = np.nan
    heights = TrajectoryProblem(problem.trials, problem.noise, problem.simulator)
    known = _ranges(heights, Regression(flights_of(heights, heights.fit(fit.model)), 1.0))[0]
    assert "height" in known and known.keys().isdisjoint({"x", "y", "heading"})
