"""Candidates for layers: each exactly absent at its null value, simulated through the public PlacementTest, in its family."""

import numpy as np
import pytest

from hlcs import PlacementTest
from hlcs.kinds.layers.candidates import library, named
from hlcs.kinds.layers.data import LayerSet
from hlcs.placement.placement_file import make_placement
from hlcs.placement.settings_table import placement_table
from hlcs.placement.statistics import Sample

SAMPLE = Sample(*(np.array([value] * 5) for value in (1.0, 0.01, 5.0)))
SETS = tuple(LayerSet(PlacementTest().grid, 0.0, campaign, SAMPLE) for campaign in ("a", "b"))
TEST = PlacementTest(layers=2, rows=3, columns=3, time_step=1 / 120, restitution=0.1, settle_time=6.0)
K = np.array([1.298, 1.08, 0.98, 0.97, 0.975])
FAMILIES = {  # the families of the candidate library that apply to layers
    "physics": {
        "friction",
        "restitution",
        "static_friction",
        "stribeck_friction",
        "viscous_friction",
        "load_dependent_friction",
        "anisotropic_friction",
        "rolling_friction",
        "spinning_friction",
        "adhesion",
        "velocity_dependent_restitution",
        "contact_compliance",
        "size_error",
        "inertia_error",
        "settlement",
        "ground_softness",
        "bottom_slope",
        "bottom_roughness",
    },
    "placement": {
        "falling_distance",
        "grid_spacing",
        "placement_scatter",
        "placement_offset",
        "orientation_bias",
        "yaw_constraint",
        "sequential_placement",
        "loose_lower_layers",
        "vibration",
        "lost_units",
    },
    "measurement": {"plate_bias", "length_scale", "campaign_offset"},
    "numerics": {
        "time_step",
        "iterations",
        "damping",
        "margin_offset",
        "convex_hull_shape",
        "friction_combination",
        "friction_pyramid",
    },
}


def entry(name):
    return named(name, TEST, SETS)[0]


def test_every_name_stands_in_its_family():
    found = {}
    for one in library(TEST, SETS):
        found.setdefault(one.family, set()).add(one.name)
    assert found == FAMILIES


@pytest.mark.parametrize("one", library(TEST, SETS), ids=lambda one: f"{one.name} {one.campaign}")
def test_a_candidate_is_exactly_absent_at_its_null_value_and_there_at_its_trial(one):
    low, high = min(one.number.low, one.number.null), max(one.number.high, one.number.null)
    assert low <= one.number.start <= high and one.number.start != one.number.null
    assert one.applied(TEST, one.number.null) == TEST
    np.testing.assert_array_equal(one.read(K, one.number.null, SETS[0]), K)
    moved = one.applied(TEST, one.number.start) != TEST or any(np.any(one.read(K, one.number.start, part) != K) for part in SETS)
    assert moved and one.simulated == (one.change is not None)


@pytest.mark.parametrize("one", [one for one in library(TEST, SETS) if one.simulated], ids=lambda one: one.name)
def test_what_a_candidate_changes_can_be_written_to_a_file_and_read_again(one):
    changed = one.applied(TEST, one.number.start)
    again = make_placement(placement_table(changed))
    assert (again.grid.spacing_x, again.grid.spacing_y) == (changed.grid.spacing_x, changed.grid.spacing_y)
    assert again == changed or one.name in ("grid_spacing", "size_error")  # these give the grid another name


def test_laws_of_layers_that_need_no_simulation():
    """Soft ground sinks by as much under every layer; soft contacts by one weight more at every layer above them."""
    weight, dn = 9.81 * TEST.unit.mass(), TEST.unit.nominal_diameter
    ground, contact = entry("ground_softness"), entry("contact_compliance")
    assert ground.number.high == pytest.approx(0.01 * TEST.side / weight)
    np.testing.assert_allclose(ground.read(K, ground.number.high, SETS[0]) - K, -0.01 * TEST.side / dn)
    np.testing.assert_allclose(contact.read(K, contact.number.high, SETS[0]) - K, -0.01 * TEST.side / dn / 3 * np.arange(1, 6))
