"""What effects do to layers, from paired runs of a stand-in for the simulations."""

import numpy as np
import pytest
from layer_tables import experiment, measured

from hlcs.kinds.layers import observations
from hlcs.kinds.layers.candidates import named
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.model import LayerModel, PlacementSimulator
from hlcs.kinds.layers.responses import Responses
from minibullet.errors import InputError


@pytest.fixture
def responses(tmp_path, simulator):
    return responses_of(tmp_path, simulator)


def responses_of(folder, simulator, placement="margin = 0.0"):
    measurement = read_layers(experiment(folder, [measured("TPG", 1, "a"), measured("RPG", 2, "b")], placement))
    data = observations.observed(measurement.sets, measurement.group)
    return Responses(simulator, LayerModel(measurement.test), measurement.sets, data, list(range(1, 9)))


def effect(responses, name, step):
    """The model under test with an effect, its number a step from the null value."""
    candidate = named(name, responses.model.placement, responses.sets)
    return responses.model.with_effect(candidate, step), candidate


def test_a_response_goes_through_what_was_simulated_and_straight_on_beyond(responses):
    _, margin = effect(responses, "margin_offset", 0.0)
    responses.take([(margin, 0.008), (margin, 0.016)])
    layers = responses.data.layer > 0
    for step in (0.004, 0.008, 0.012, 0.016, 0.03):  # the stand-in has two margins a layer, and noise of its own above the first
        moved = responses.values(effect(responses, "margin_offset", step)[0]) - responses.base.value
        np.testing.assert_allclose(moved[responses.data.layer == 1], 2 * step, rtol=1e-9)
        np.testing.assert_allclose(moved[layers], 2 * step, atol=0.012)


def test_what_is_simulated_once_is_not_simulated_again(responses):
    before = responses.simulator.ran
    _, margin = effect(responses, "margin_offset", 0.0)
    responses.take([(margin, 0.008)], pairs=4)
    assert responses.simulator.ran - before == 2 * 4  # tests on each of two sets
    responses.take([(margin, 0.008)])
    responses.take([(margin, 0.008)])
    assert responses.simulator.ran - before == 2 * 8


def test_a_reading_needs_no_simulation_and_acts_on_the_whole(responses):
    ran = responses.simulator.ran
    model, _ = effect(responses, "length_scale", 0.02)
    layers = responses.data.layer > 0
    np.testing.assert_allclose(responses.values(model)[layers], 1.02 * responses.base.value[layers])
    assert responses.simulator.ran == ran


def test_the_next_simulation_is_near_to_the_number_that_was_found(responses):
    _, margin = effect(responses, "margin_offset", 0.0)
    responses.take([(margin, margin.step)])

    def missing(step):
        (term,) = effect(responses, "margin_offset", step)[0].terms
        return responses.missing(term)

    assert missing(1.1 * margin.step) is None  # it has been simulated at one step
    responses.take([(margin, margin.step)], pairs=4)
    assert missing(1.1 * margin.step) == margin.step  # a first look is not all
    assert missing(2.2 * margin.step) == pytest.approx(2 * margin.step)
    assert missing(40 * margin.step) == pytest.approx(4 * margin.step)
    assert missing(-margin.step) is None  # below a margin of zero there is nothing to simulate


def test_two_effects_add_up_until_both_are_simulated_together(tmp_path):
    """Hull and margin of this stand-in hinder each other: what the sum misses is known once the pair has been simulated."""

    def stand_in(test):
        wide, hull = test.margin > 0, test.shape == "hull"
        k = 1.0 + 2.0 * test.margin + 0.1 * hull - 0.05 * (wide and hull) + 0.001 * test.seed
        return {"k": [k] * test.layers, "lost": 0}

    responses = responses_of(tmp_path, PlacementSimulator(tmp_path / "s.sqlite", workers=1, function=stand_in))
    margin, hull = effect(responses, "margin_offset", 0.008)[1], effect(responses, "convex_hull_shape", 1.0)[1]
    responses.take([(margin, 0.008), (hull, 1.0)])
    both = responses.model.with_effect(margin, 0.008).with_effect(hull, 1.0)
    layers, start = responses.data.layer > 0, responses.base.value
    np.testing.assert_allclose((responses.values(both) - start)[layers], 0.116)
    responses.mend(both)
    np.testing.assert_allclose((responses.values(both) - start)[layers], 0.066)
    np.testing.assert_allclose(responses.runs_of(both)[0].mean(axis=0), 1.0 + 0.066 + 0.0045)


def test_beside_a_switch_effects_act_as_they_do_there(tmp_path):
    """A stand-in in which friction counts for the pieces alone: from the hull its response is zero, beside the pieces 0.3 a unit
    of friction, with and without what was simulated there nearer to the number."""

    def stand_in(test):
        pieces = test.shape == "pieces"
        return {"k": [1.0 - 0.1 * pieces + 0.3 * pieces * test.friction + 0.001 * test.seed] * test.layers, "lost": 0}

    simulator = PlacementSimulator(tmp_path / "s.sqlite", workers=1, function=stand_in)
    responses = responses_of(tmp_path, simulator, 'shape = "hull"\nfriction = 0.6\nmargin = 0.0')
    slid, friction = effect(responses, "friction", -0.2)
    hull = effect(responses, "convex_hull_shape", 1.0)[1]
    responses.take([(friction, friction.step), (hull, 1.0)], pairs=4)
    responses.take_beside(hull, [friction], pairs=4)
    layers, start = responses.data.layer > 0, responses.base.value
    both = slid.with_effect(hull, 1.0)
    np.testing.assert_allclose((responses.values(slid) - start)[layers], 0.0, atol=1e-12)
    np.testing.assert_allclose((responses.values(both) - start)[layers], -0.1 + 0.3 * 0.4)
    assert responses.complete([both]) and not responses.complete([both])
    np.testing.assert_allclose((responses.values(both) - start)[layers], -0.1 + 0.3 * 0.4)


def test_a_model_simulated_as_a_whole_keeps_its_values_when_its_responses_are_known_better(tmp_path):
    """Layers that rise with the square of the margin: at 0.012 the line from 0.008 says 0.0384, the one to 0.016 0.064."""

    def square(test):
        return {"k": [1.0 + 400.0 * test.margin**2 + 0.001 * test.seed] * test.layers, "lost": 0}

    responses = responses_of(tmp_path, PlacementSimulator(tmp_path / "s.sqlite", workers=1, function=square))
    model, margin = effect(responses, "margin_offset", 0.012)
    responses.take([(margin, 0.008)])
    responses.mend(model)
    layers = responses.data.layer > 0
    for _ in range(2):
        np.testing.assert_allclose((responses.values(model) - responses.base.value)[layers], 400.0 * 0.012**2)
        responses.take([(margin, 0.016)])


def test_where_no_placement_stands_there_is_no_answer(tmp_path):
    def falls(test):
        return {"error": "no plate found a place"} if test.margin > 0.01 else {"k": [1.0 + 0.001 * test.seed] * test.layers}

    responses = responses_of(tmp_path, PlacementSimulator(tmp_path / "s.sqlite", workers=1, function=falls))
    _, margin = effect(responses, "margin_offset", 0.0)
    responses.take([(margin, 0.008), (margin, 0.016)])
    responses.values(effect(responses, "margin_offset", 0.012)[0])
    with pytest.raises(InputError, match="no placement stands with margin_offset"):
        responses.values(effect(responses, "margin_offset", 0.016)[0])
