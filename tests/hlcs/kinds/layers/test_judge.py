"""One candidate against the layers that a model misses."""

import numpy as np
import pytest
from layer_tables import experiment, measured

from hlcs.effects import Free
from hlcs.kinds.layers.candidates import LayerCandidate
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.judge import LayerFit, LayerJudge
from hlcs.kinds.layers.least_squares import Simulated
from hlcs.selection.reasons import Rule

CANDIDATE = LayerCandidate("thicker", Free("amount", "Dn", -0.5, 0.5, 0.0, 0.1))


@pytest.fixture
def judge(tmp_path):
    measurement = read_layers(experiment(tmp_path, [measured("TPG", 1, "a"), measured("RPG", 2, "b")]))
    return LayerJudge(measurement, measurement.sets)


def fit_that_misses(judge, residual):
    """The LayerFit of a model known without error."""
    size = len(judge.data.value)
    return LayerFit(None, [], Simulated(judge.data.value - residual, np.zeros(size), np.full(size, 8.0)), residual)


def broken(trial):
    return {explanation.reason for explanation in trial.fails}


def test_what_explains_the_misfit_everywhere_keeps_every_rule(judge):
    slope = 1.0 * judge.layers
    trial = judge.weigh(fit_that_misses(judge, 0.3 * slope), CANDIDATE, slope, np.zeros(len(slope)))
    assert not trial.fails and trial.amount == pytest.approx(0.3) and trial.error == pytest.approx(0.0, abs=1e-12)
    assert [held_out.amount for held_out in trial.held_out.values()] == pytest.approx([0.3, 0.3])
    assert trial.required_gain == pytest.approx(np.log(10) + 6.0) and trial.held_out_error == pytest.approx(0.0, abs=1e-12)


def test_a_number_stays_inside_its_bounds_and_what_moves_nothing_is_named(judge):
    slope = 1.0 * judge.layers
    fit = fit_that_misses(judge, 0.9 * slope)
    trial = judge.weigh(fit, CANDIDATE, slope, np.zeros(len(slope)))
    assert trial.amount == 0.5 and Rule.NUMBER_INSIDE_BOUNDS in broken(trial)
    assert Rule.MOVES_A_LAYER in broken(judge.weigh(fit, CANDIDATE, 0.0 * slope, np.zeros(len(slope))))


def test_what_mends_one_group_and_spoils_the_other_is_refused(judge):
    slope = 1.0 * judge.layers
    residual = np.where(judge.data.set == 0, 0.3, -0.1) * slope
    trial = judge.weigh(fit_that_misses(judge, residual), CANDIDATE, slope, np.zeros(len(slope)))
    assert Rule.EVERY_GROUP in broken(trial) and "b" in " ".join(explanation.why for explanation in trial.fails)


def test_a_small_misfit_pays_for_nothing(judge):
    slope = 1.0 * judge.layers
    trial = judge.weigh(fit_that_misses(judge, 0.001 * slope), CANDIDATE, slope, np.zeros(len(slope)))
    assert {Rule.PRICE_OF_LAYERS, Rule.RESOLUTION, Rule.NOT_ZERO} <= broken(trial) and trial.evidence < 0
