"""Tables of layers as a problem for the search."""

import numpy as np
import pytest
from layer_tables import experiment, measured
from scipy import optimize, stats

from hlcs.data.experiment_file import read_experiment_file
from hlcs.kinds.layers import Layers, observations
from hlcs.kinds.layers.candidates import named
from hlcs.kinds.protocol import Options


@pytest.fixture
def problem(tmp_path, simulator):
    file = experiment(tmp_path, [measured("TPG", 1, "a"), measured("RPG", 2, "b")], "margin = 0.0")
    return Layers(read_experiment_file(file.path), Options(), simulator, seeds=8)._problem()


def test_white_residuals_have_the_covariance_of_the_table(problem):
    """whitened(e) = L^-1 e with L L' the covariance: its square is e' V^-1 e, and colouring brings the residuals back."""
    matrix = observations.covariance(problem.data, problem.variance, observations.doubt(problem.data))
    residual = np.linspace(-0.02, 0.03, len(problem.values))
    white = problem.whitened([residual[group.rows] for group in problem.trials])
    assert sum(part @ part for part in white) == pytest.approx(residual @ np.linalg.solve(matrix, residual))
    np.testing.assert_allclose(problem.coloured(white), residual, atol=1e-14)


def test_the_error_is_the_mean_relative_one_of_the_layers(problem):
    layers = problem.data.layer > 0
    residual = np.where(layers, 0.01 * problem.values, 5.0)  # the rows of the scatter do not count
    white = problem.whitened([residual[group.rows] for group in problem.trials])
    assert problem.error(white) == pytest.approx(0.01)


def test_a_number_is_found_by_generalised_least_squares(problem):
    """length_scale is linear: beside readings 3 % larger than the model's its number is the least of a parabola and a belief."""
    candidate = named("length_scale", problem.responses.model.placement, problem.responses.sets)
    model = problem.responses.model.with_effect(candidate, 0.03)
    problem.values = problem.predict(model)
    found, (free,) = problem.fit(problem.responses.model.with_effect(candidate, 0.0)), candidate.free
    layers = np.where(problem.data.layer > 0, problem.responses.base.value, 0.0)
    white = np.concatenate(problem.whitened([layers[group.rows] for group in problem.trials]))
    cost = optimize.minimize_scalar(lambda x: (white @ white) * (x - 1.03) ** 2 + free.surprise(x), (1.0, 1.03))
    assert found.estimate[0] == pytest.approx(cost.x, abs=1e-3) and 1.01 < cost.x < 1.03


def test_the_cost_of_a_simulated_effect_is_its_likelihood_where_its_answer_is_uncertain(problem):
    """-2 log of the normal density of the residuals under V(model), less that of no residuals under V(no effect)."""
    candidate = named("convex_hull_shape", problem.responses.model.placement, problem.responses.sets)
    problem.responses.take([(candidate, candidate.step)])
    model = problem.responses.model.with_effect(candidate, candidate.step)
    found, (change, variance) = problem.fit(model), problem.responses.change(model)
    assert np.abs(change).max() > 0 and variance.max() > 0
    doubts = observations.doubt(problem.data), observations.doubt(problem.data, change, variance)
    matrices = [observations.covariance(problem.data, problem.variance, doubt) for doubt in doubts]
    plain, unsure = (stats.multivariate_normal(np.zeros(len(change)), matrix) for matrix in matrices)
    expected = -2 * (unsure.logpdf(problem.values - problem.predict(model)) - plain.logpdf(np.zeros(len(change))))
    assert found.chi2 + found.doubt == pytest.approx(expected)
    assert problem.fit(problem.responses.model).doubt == pytest.approx(0.0, abs=1e-9)


def test_more_tests_of_one_campaign_do_not_tell_apart_what_a_campaign_may_change(problem):
    """A plate that reads 1 % low differs from nothing by less than campaigns differ: however many tests, lambda stays small."""
    from hlcs.selection.experiment_design import parts

    candidate = named("length_scale", problem.responses.model.placement, problem.responses.sets)
    fits = [problem.fit(problem.responses.model), problem.fit(problem.responses.model.with_effect(candidate, 0.01))]
    new = problem.designs(*fits)
    assert [design.what["grid"] for design in new.options] == ["TPG", "RPG"]
    small = [min(part.separation()(1000) for part in both) for both in parts(new, *fits)]
    assert max(small) < 2 * (0.01 / observations.CAMPAIGN) ** 2
