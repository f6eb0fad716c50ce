"""Layer tables of the deck: their responses are those of pybullet, their readings exact, their imitators those of theory."""

import numpy as np
import pytest

from .generator import layers
from .generator.build import Deal


def test_readings_move_the_first_layer_alone():
    change, factor = layers.response("settlement", "TPG", 0.05)
    np.testing.assert_allclose(change, [-0.05 / 1.302, 0, 0, 0, 0])
    assert factor == 1.0 and np.all(layers.response("length_scale", "RPG", 0.02)[0] == 0.02)


@pytest.mark.parametrize("grid", ["TPG", "RPG"])
def test_responses_meet_the_runs_and_go_straight_between_and_beyond(grid):
    (_, low, _), (_, high, _) = layers.ANSWERS["margin_offset", grid][1:]
    np.testing.assert_allclose(layers.response("margin_offset", grid, 0.01)[0], low)
    np.testing.assert_allclose(layers.response("margin_offset", grid, 0.015)[0], (low + high) / 2)
    wider = layers.ANSWERS["grid_spacing", grid][0][1]
    np.testing.assert_allclose(layers.response("grid_spacing", grid, -0.03)[0], 1.5 * wider)


def test_a_margin_raises_the_first_layer_by_three():
    """One under the unit, one on it, one under the plate (geometry): 3 x 0.01 Dn of 1.2992; contacts give way by 0.001 Dn."""
    assert layers.response("margin_offset", "TPG", 0.01)[0][0] * 1.2992 == pytest.approx(0.03, abs=0.001)


def test_what_makes_the_same_table_is_an_imitator():
    """A plate that reads 0.03 Dn too low is a settlement of 0.03; what only physics of upper layers shows is neither."""
    assert layers.imitators("settlement", 0.03, 4) == ["plate_bias"]
    assert "settlement" in layers.imitators("plate_bias", -0.03, 4)
    assert not {"settlement", "plate_bias"} & set(layers.imitators("grid_spacing", 0.03, 4))


def test_families_are_those_of_all_that_would_do(generator):
    deal = Deal("layers", "single", ("settlement",), "table", (2.2,), "tests")
    _, answer = layers.case(deal, generator)
    assert answer["verdict_families"] == ["measurement", "physics"] and answer["possible"] == ["plate_bias"]
    assert answer["total_strength"] >= 2.2
