"""Cross-validation: each half is predicted by the number of the other half, in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest
from linear_models import LAWS, Line, model

from hlcs.estimation.cross_validation import FEW_RECORDINGS, CrossValidation
from hlcs.estimation.least_squares import belief
from hlcs.estimation.linearization import free_numbers
from hlcs.simulation.model import Model, Term

TIMES = [np.linspace(0.0, 1.0 + k, 6) for k in range(4)]
SLOPES = (1.0, 2.0, 3.0, 4.0)


def test_a_half_is_predicted_by_the_slope_of_the_other():
    """Noiseless lines of other slopes: held-out residuals are (slope - slope of the other half) times the centred times.

    What is believed of the number counts 0.05 beside Sxx / sigma^2 of 2e6: the slope of a half moves by so little.
    """
    groups = ["a", "b", "a", "b"]
    problem = Line(TIMES, [slope * t for slope, t in zip(SLOPES, TIMES, strict=True)], 1e-3, groups)
    halves = CrossValidation(problem.trials, "group")
    fit = problem.fit(model(1.0))
    assert halves.possible and [half.tolist() for half in halves.halves] == [[0, 2], [1, 3]]
    centred = [t - t.mean() for t in TIMES]
    weight = [t @ t for t in centred]
    other = {half: np.average(SLOPES[1 - half :: 2], weights=weight[1 - half :: 2]) for half in (0, 1)}
    for k, held_out in enumerate(halves.residuals(fit)):
        expected = (SLOPES[k] - other[k % 2]) * centred[k] / 1e-3
        np.testing.assert_allclose(held_out, expected, rtol=1e-6, atol=1e-3)


def test_every_second_group_of_a_session_is_held_out_with_those_of_the_others():
    """Sessions A and B in turn: by the order of all groups one half would hold all of A."""
    trials = [SimpleNamespace(group=f"g{k}", session="AB"[k % 2], body=None, whole=str(k)) for k in range(6)]
    halves = CrossValidation(trials, "group").halves
    assert [set(half % 2) for half in halves] == [{0, 1}, {0, 1}]
    assert [half.tolist() for half in CrossValidation(trials[:2], "group").halves] == [[0], [1]]


def test_a_half_takes_no_number_beyond_the_end_of_its_law():
    """Lines that fall: the other half would have a rate below zero, and foretells a level line."""
    problem = Line(TIMES, [-t for t in TIMES], 1e-3, ["a", "b", "a", "b"])
    fit = problem.fit(model(1.0))
    assert fit.estimate == pytest.approx([0.0], abs=1e-6) and fit.held.tolist() == [True]
    for t, held_out in zip(TIMES, CrossValidation(problem.trials, "group").residuals(fit), strict=True):
        np.testing.assert_allclose(held_out, -(t - t.mean()) / 1e-3, atol=1e-2)


def test_a_number_that_acts_on_no_recording_of_the_other_half_is_fitted_where_it_acts():
    """A slope of 2 in all recordings and a bend of 5 in those of group b alone, a clock of their session: both halves are
    foretold, the slope by the other one. What is believed of the numbers counts 1e-6 beside columns of a thousand sigmas."""
    times = np.linspace(-1.0, 1.0, 8)
    columns = [1e3 * np.column_stack([times, (times**2 - np.mean(times**2)) * own]) for own in (0, 1, 0, 1)]
    residuals = [part @ [2.0, 5.0] for part in columns]
    trials = Line([times] * 4, [times] * 4, groups=["a", "b", "a", "b"]).trials
    laws = Model(tuple(Term(law, (("rate", 0.0),)) for law in LAWS.values()))
    fit = SimpleNamespace(
        linearization=SimpleNamespace(projected=(residuals, columns)),
        estimate=np.zeros(2),
        ends=np.array([[-np.inf] * 2, [np.inf] * 2]),
        belief=belief(np.zeros(2), free_numbers(laws)),
    )
    for left, before in zip(CrossValidation(trials, "group").residuals(fit), residuals, strict=True):
        assert np.abs(left).max() < 1e-4 * np.abs(before).max()


def test_what_a_half_foretells_is_a_normal_density_that_knows_how_well_the_number_is_known(generator):
    """-2 log of it, from the full covariance 1 + j j^T / (sum of the squares of the other half's columns + belief)."""
    problem = Line(TIMES, [3.0 * t + 0.5 * generator.standard_normal(6) for t in TIMES], 0.5, ["a", "b", "a", "b"])
    halves, fit = CrossValidation(problem.trials, "group"), problem.fit(model(1.0))
    left, logarithm = halves.foretold(fit)
    columns, (_, (slope,)) = fit.linearization.projected[1], belief(fit.estimate, free_numbers(fit.model))
    expected = 0.0
    for half in (0, 1):
        told = sum(np.sum(columns[k] ** 2) for k in (1 - half, 3 - half)) + slope**2
        column = np.concatenate([columns[half], columns[half + 2]])
        residual = np.concatenate([halves.residuals(fit)[k] for k in (half, half + 2)])
        covariance = np.eye(12) + column @ column.T / told
        expected += residual @ np.linalg.solve(covariance, residual) + np.linalg.slogdet(covariance)[1]
    assert left @ left + logarithm == pytest.approx(expected, rel=1e-9)


def test_one_group_or_none_held_out_leaves_nothing_to_predict():
    trials = Line(TIMES, TIMES, groups=["a"] * 4).trials
    assert not CrossValidation(trials, "group").possible
    assert not CrossValidation(Line(TIMES, TIMES).trials, "none").possible


@pytest.mark.parametrize("count", [FEW_RECORDINGS - 1, FEW_RECORDINGS])
def test_recordings_are_few_by_the_body_that_has_fewest(count):
    trials = Line([TIMES[0]] * count, [TIMES[0]] * count).trials
    assert CrossValidation(trials, "group").few == (count < FEW_RECORDINGS)
