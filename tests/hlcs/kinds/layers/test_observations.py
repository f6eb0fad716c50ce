"""The arithmetic of layer data against closed forms."""

import numpy as np
import pytest

from hlcs.kinds.layers import observations
from hlcs.kinds.layers.data import LayerSet
from hlcs.placement.grids import RPG, TPG
from hlcs.placement.statistics import Sample

MEAN = np.array([1.3, 1.08, 0.98])
SETS = [
    LayerSet(grid, 0.0, campaign, Sample(MEAN, np.array([0.0, 0.02, 0.02]), np.array([5.0, 5.0, 5.0])))
    for grid, campaign in ((TPG, "a"), (RPG, "b"), (TPG, "b"))
]
DATA = observations.observed(SETS, lambda measured_set: measured_set.campaign)


def runs_of(generator, seeds=8, shift=0.0):
    """Simulated tests (seeds, 3) of each set about the measured means, `shift` thicker."""
    return [MEAN + shift + 0.01 * generator.standard_normal((seeds, 3)) for _ in SETS]


def test_the_last_row_of_each_set_is_the_scatter_of_its_upper_layers():
    assert list(DATA.layer) == [1, 2, 3, 0] * 3 and list(DATA.set) == [0] * 4 + [1] * 4 + [2] * 4
    assert list(DATA.campaign[::4]) == [0, 1, 1] and list(DATA.group[::4]) == [0, 1, 1]
    pooled = np.sqrt(np.mean((0.02 * MEAN[1:]) ** 2))  # as many tests in each layer
    assert DATA.value[3] == pytest.approx(np.log(pooled)) and DATA.mean[3] == 0.0
    assert DATA.case[1] == DATA.case[9] != DATA.case[5]  # one grid and bottom, measured in two campaigns
    np.testing.assert_allclose(DATA.variance[1], (0.02 * 1.08) ** 2 / 5 + observations.ROUNDING**2)


def test_campaigns_differ_by_one_factor_and_layer_by_layer():
    matrix = observations.covariance(DATA, DATA.variance, observations.doubt(DATA))
    campaign = observations.CAMPAIGN**2
    assert matrix[0, 1] == pytest.approx(campaign / 2 * 1.3 * 1.08)
    assert matrix[0, 0] == pytest.approx(DATA.variance[0] + campaign * 1.3**2)
    assert matrix[1, 9] == pytest.approx((observations.MODEL * 1.08) ** 2)  # the model is one, whoever measured


def test_what_an_effect_does_is_known_to_a_part_of_it():
    """An effect raises one layer by 0.1 in both campaigns: by 0.1 +- 0.03, and by the same amount in both."""
    second = DATA.case == DATA.case[1]
    unsure = observations.doubt(DATA, 0.1 * second)
    np.testing.assert_allclose(unsure[second], np.hypot(observations.MODEL * 1.08, observations.ANSWER * 0.1))
    assert unsure[0] == 0.0 and unsure[5] == pytest.approx(observations.MODEL * 1.08)
    matrix = observations.covariance(DATA, DATA.variance, unsure)
    assert matrix[1, 9] == pytest.approx(unsure[1] ** 2) and matrix[1, 5] == pytest.approx(0.0)


def test_a_change_is_that_of_pairs_where_seeds_decide_and_of_means_where_they_do_not(generator):
    without = runs_of(generator)
    changed = [runs[:5] + 0.05 for runs in without]
    changed[0][3] = np.nan
    paired, variance = observations.change(DATA, without, changed, np.ones(3))
    np.testing.assert_allclose(paired[DATA.layer > 0], 0.05, rtol=1e-12)  # refused runs left out
    np.testing.assert_allclose(variance[DATA.layer > 0], 0.0, atol=1e-30)  # what seeds decide has no scatter
    means, variance = observations.change(DATA, without, changed, np.zeros(3))
    np.testing.assert_allclose(variance[4], changed[1][:, 0].var(ddof=1) / 5)  # the first layer has its own
    np.testing.assert_allclose(means[4:7], changed[1].mean(axis=0) - without[1].mean(axis=0), rtol=1e-12)
    changed[1][1:] = np.nan
    assert observations.change(DATA, without, changed, np.ones(3)) is None


def test_what_seeds_decide_is_the_slope_of_runs_on_runs(generator):
    """Runs with an effect that repeat the scatter of a layer by 1, 0.5 and 0 times, among noise of their own."""
    parts, without = np.array([1.0, 0.5, 0.0]), runs_of(generator, seeds=8)
    many = [
        [MEAN + 0.1 + parts * (runs - MEAN) + 0.005 * generator.standard_normal((4, 3)) for runs in [r[:4] for r in without]]
        for _ in range(60)
    ]
    np.testing.assert_allclose(observations.shared_scatter(without, many), parts, atol=0.1)  # noise of 0.005 / 0.01 / sqrt(540)


def test_a_model_that_agrees_is_adequate_and_one_far_away_is_not(generator):
    for shift, adequate in ((0.0, True), (0.2, False)):
        simulated = observations.simulated(DATA, runs_of(generator, shift=shift))
        residual, none = DATA.value - simulated.value, np.zeros((len(DATA.value), 0))
        judged = DATA, simulated, residual
        chi2, p, threshold, draws = observations.adequacy(*judged, none, observations.doubt(DATA), draws=300)
        assert draws == 300
        assert (p > 0.02) is adequate and (chi2 < threshold) is adequate
        # a number that moves everything as the misfit goes explains it
        alike = observations.adequacy(*judged, residual[:, None], observations.doubt(DATA), draws=300)
        assert alike[0] == pytest.approx(0.0, abs=1e-6)
