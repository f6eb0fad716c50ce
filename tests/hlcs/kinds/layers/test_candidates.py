"""Candidates for layers: each exactly absent at its null value, simulated through the public PlacementTest, in its family."""

import numpy as np
import pytest

from hlcs import PlacementTest
from hlcs.kinds.layers.candidates import library, named
from hlcs.kinds.layers.data import LayerSet
from hlcs.placement.placement_file import make_placement
from hlcs.placement.settings_table import placement_table
from hlcs.placement.statistics import Sample
from minibullet.errors import InputError

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
    return named(name, TEST, SETS)


def first(one):
    """Numbers of a candidate where it is first simulated, or halfway to the end of what is plausible."""
    if one.simulated:
        return [free.null + one.step for free in one.free]
    return [free.null + 0.5 * ((free.high if free.high > free.null else free.low) - free.null) for free in one.free]


def test_every_name_stands_in_its_family():
    found = {}
    for one in library(TEST, SETS):
        found.setdefault(one.family, set()).add(one.name)
    assert found == FAMILIES


@pytest.mark.parametrize("one", library(TEST, SETS), ids=lambda one: one.name)
def test_a_candidate_is_exactly_absent_at_its_null_value_and_there_a_step_from_it(one):
    nulls, numbers = [free.null for free in one.free], first(one)
    for free, number in zip(one.free, numbers, strict=True):
        assert free.inside(number) == number != free.null
    if one.free:
        assert one.applied(TEST, *nulls) == TEST
        np.testing.assert_array_equal(one.read(K, SETS[0], *nulls), K)
    moved = one.applied(TEST, *numbers) != TEST or any(np.any(one.read(K, part, *numbers) != K) for part in SETS)
    assert moved and one.simulated == (one.change is not None) and bool(one.free) != bool(one.constants)


@pytest.mark.parametrize("one", [one for one in library(TEST, SETS) if one.simulated], ids=lambda one: one.name)
def test_what_a_candidate_changes_can_be_written_to_a_file_and_read_again(one):
    changed = one.applied(TEST, *first(one))
    again = make_placement(placement_table(changed))
    assert (again.grid.spacing_x, again.grid.spacing_y) == (changed.grid.spacing_x, changed.grid.spacing_y)
    assert again == changed or one.name in ("grid_spacing", "size_error")  # these give the grid another name


def test_laws_of_layers_that_need_no_simulation():
    """Soft ground sinks by as much under every layer; soft contacts by one weight more at every layer above them."""
    weight, dn = 9.81 * TEST.unit.mass(), TEST.unit.nominal_diameter
    ground, contact = entry("ground_softness"), entry("contact_compliance")
    softest = ground.free[0].high
    assert softest == pytest.approx(0.01 * TEST.side / weight)
    np.testing.assert_allclose(ground.read(K, SETS[0], softest) - K, -0.01 * TEST.side / dn)
    np.testing.assert_allclose(contact.read(K, SETS[0], softest) - K, -0.01 * TEST.side / dn / 3 * np.arange(1, 6))


def test_campaigns_have_an_offset_each():
    offset = entry("campaign_offset")
    assert [free.name for free in offset.free] == ["offset a", "offset b"]
    np.testing.assert_allclose(offset.read(K, SETS[1], 0.0, 0.02), 1.02 * K)
    assert "campaign_offset" not in {one.name for one in library(TEST, SETS[:1])}  # of one campaign it is the length scale


def test_an_unknown_name_is_refused_with_the_nearest_one():
    with pytest.raises(InputError, match="'margin_offse'.*'margin_offset'"):
        entry("margin_offse")
