"""The arithmetic of layer data against closed forms."""

import numpy as np
import pytest

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.data import LayerSet
from hlcs.placement.grids import RPG, TPG
from hlcs.placement.statistics import Sample

MEAN = np.array([1.3, 1.08, 0.98])
SETS = [
    LayerSet(grid, 0.0, campaign, Sample(MEAN, np.array([0.0, 0.02, 0.02]), np.array([5.0, 5.0, 5.0])))
    for grid, campaign in ((TPG, "a"), (RPG, "b"), (TPG, "b"))
]
DATA = least_squares.observed(SETS, lambda measured_set: measured_set.campaign)


def runs_of(generator, seeds=8, shift=0.0):
    """Simulated tests (seeds, 3) of each set about the measured means, `shift` thicker."""
    return [MEAN + shift + 0.01 * generator.standard_normal((seeds, 3)) for _ in SETS]


def test_the_last_row_of_each_set_is_the_scatter_of_its_upper_layers():
    assert list(DATA.layer) == [1, 2, 3, 0] * 3 and list(DATA.set) == [0] * 4 + [1] * 4 + [2] * 4
    assert list(DATA.campaign[::4]) == [0, 1, 1] and list(DATA.group[::4]) == [0, 1, 1]
    pooled = np.sqrt(np.mean((0.02 * MEAN[1:]) ** 2))  # as many tests in each layer
    assert DATA.value[3] == pytest.approx(np.log(pooled)) and DATA.mean[3] == 0.0
    assert DATA.case[1] == DATA.case[9] != DATA.case[5]  # one grid and bottom, measured in two campaigns
    np.testing.assert_allclose(DATA.variance[1], (0.02 * 1.08) ** 2 / 5 + least_squares.ROUNDING**2)


def test_campaigns_differ_by_one_factor_or_layer_by_layer():
    common, individual = (least_squares.covariance(DATA, DATA.variance, form) for form in least_squares.FORMS)
    np.testing.assert_allclose(np.diag(common), np.diag(individual))
    assert common[0, 1] == pytest.approx(least_squares.CAMPAIGN**2 * 1.3 * 1.08) and individual[0, 1] == 0.0
    assert common[1, 9] == individual[1, 9] == pytest.approx((least_squares.MODEL * 1.08) ** 2)  # the model is one


def test_the_amount_of_a_signature_is_its_generalised_least_squares(generator):
    slope = generator.standard_normal(12)
    matrix = least_squares.covariance(DATA, DATA.variance, "common")
    amount, deviation = least_squares.amount(matrix, 0.7 * slope, slope)
    assert amount == pytest.approx(0.7) and deviation == pytest.approx((slope @ np.linalg.solve(matrix, slope)) ** -0.5)
    assert least_squares.amount(matrix, slope, np.zeros(12)) == (0.0, np.inf)
    assert least_squares.cosine(matrix, slope, -2.0 * slope) == pytest.approx(1.0)


def test_a_signature_is_the_change_per_unit_and_leaves_refused_runs_out(generator):
    without = runs_of(generator)
    changed = [runs + 0.05 for runs in without]
    changed[0][3] = np.nan
    slope, variance = least_squares.signature(DATA, without, changed, 0.5)
    np.testing.assert_allclose(slope[DATA.layer > 0], 0.1, rtol=1e-12)
    np.testing.assert_allclose(variance[DATA.layer > 0], 0.0, atol=1e-20)
    changed[1][1:] = np.nan
    assert least_squares.signature(DATA, without, changed, 0.5) is None


def test_a_model_that_agrees_is_adequate_and_one_far_away_is_not(generator):
    for shift, adequate in ((0.0, True), (0.2, False)):
        simulated = least_squares.simulated(DATA, runs_of(generator, shift=shift))
        judged = least_squares.adequacy(DATA, simulated, DATA.value - simulated.value, draws=300)
        assert all((p > 0.02) is adequate for _, p in judged.values())
