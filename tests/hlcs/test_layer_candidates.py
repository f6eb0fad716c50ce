"""Candidates for layers: each exactly absent at its null value, simulated through the public PlacementTest, in its family."""

import numpy as np
import pytest

import minibullet as mb
from hlcs import InputError, PlacementTest
from hlcs.kinds.layers.candidates import library, named
from hlcs.kinds.layers.data import LayerSet
from hlcs.placement.layer_placement import shake
from hlcs.placement.placement_file import make_placement, read_placement_file
from hlcs.placement.sea_bottom import Slope, Survey
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
    low, high = min(one.low, one.null), max(one.high, one.null)
    assert low <= one.trial <= high and one.trial != one.null
    assert one.applied(TEST, one.null) == TEST
    np.testing.assert_array_equal(one.read(K, one.null, SETS[0]), K)
    moved = one.applied(TEST, one.trial) != TEST or any(np.any(one.read(K, one.trial, part) != K) for part in SETS)
    assert moved and one.simulated == (one.change is not None)


@pytest.mark.parametrize("one", [one for one in library(TEST, SETS) if one.simulated], ids=lambda one: one.name)
def test_what_a_candidate_changes_can_be_written_to_a_file_and_read_again(one):
    changed = one.applied(TEST, one.trial)
    again = make_placement(placement_table(changed))
    assert (again.grid.spacing_x, again.grid.spacing_y) == (changed.grid.spacing_x, changed.grid.spacing_y)
    assert again == changed or one.name in ("grid_spacing", "size_error")  # these give the grid another name


def test_laws_of_layers_that_need_no_simulation():
    """Soft ground sinks by as much under every layer; soft contacts by one weight more at every layer above them."""
    weight, dn = 9.81 * TEST.unit.mass(), TEST.unit.nominal_diameter
    ground, contact = entry("ground_softness"), entry("contact_compliance")
    assert ground.high == pytest.approx(0.01 * TEST.side / weight)
    np.testing.assert_allclose(ground.read(K, ground.high, SETS[0]) - K, -0.01 * TEST.side / dn)
    np.testing.assert_allclose(contact.read(K, contact.high, SETS[0]) - K, -0.01 * TEST.side / dn / 3 * np.arange(1, 6))


def test_a_rough_bed_is_the_bottom_plus_heights_of_the_stated_scatter():
    test = PlacementTest(bottom=Slope(0.04), bottom_roughness=0.05)
    bed = test.bed
    assert isinstance(bed, Survey) and TEST.bed is TEST.bottom
    off = bed.z - test.bottom.height(*np.meshgrid(bed.x, bed.y))
    # some 400 points: standard deviation known to 1 / sqrt(2 x 400) = 3.5 %, four times that allowed
    assert off.std() == pytest.approx(0.05 * test.unit.nominal_diameter, rel=0.14)
    np.testing.assert_array_equal(bed.z, test.bed.z)
    half = 0.5 * 9 * test.grid.spacing_x * test.unit.nominal_diameter
    assert bed.x[0] < -half - 5 and bed.x[-1] > half + 5


def test_shaking_leaves_no_speed_of_its_own():
    """Blows in turn, the first and the last of half the size: without friction a body ends as slow as it was, where it was."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.0))
    world.add_plane()
    box = world.add(mb.Box(1.0, 1.0, 1.0), density=2300.0, position=(0.0, 0.0, 0.5))
    farthest = []
    shake(world, [box], 0.3, 1.0)
    farthest.append(abs(box.position[0]))
    assert np.linalg.norm(box.velocity) < 1e-9
    # a blow of a / (pi f) for half a period: 0.3 g / (pi f) / (2 f) = 12 mm is the farthest it ever goes
    assert max(farthest) < 0.3 * 9.81 / (np.pi * 39.24) / 2 + 1e-6


@pytest.mark.parametrize(
    "change",
    [
        {"sequential_placement": True},
        {"loose_lower_layers": True},
        {"vibration": 0.3},
        {"inertia_factor": 2.06},
        {"bottom_roughness": 0.05},
        {"effects": [{"name": "rolling_friction", "arm": 0.03}]},
        {"armour": "cube"},
    ],
)
def test_each_way_of_placing_runs_and_tells_from_the_nominal_one(change):
    plain = PlacementTest(layers=2, rows=4, columns=4, time_step=1 / 120, settle_time=6.0)
    test = make_placement(placement_table(plain) | change)
    result = test.run()
    assert [len(poses) for poses in result.poses] == [16, 9] and np.isfinite(result.layer_coefficients).all()
    assert not np.array_equal(result.layer_coefficients, plain.run().layer_coefficients)
    if change == {"armour": "cube"}:  # a cube lies on its face: k1 = 1
        assert result.layer_coefficients[0] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('effects = [{ name = "roling_friction" }]', ("roling_friction", "'rolling_friction'")),
        ('effects = [{ name = "rolling_friction", arms = 1 }]', ("arms", "'arm'")),
        ("effects = [{ arm = 1.0 }]", ("no name",)),
        ('effects = "rolling_friction"', ("must be a list",)),
        ('effects = [{ name = "rolling_friction", arm = "big" }]', ("arm must be a finite number",)),
        ("vibration = -1", ("vibration = -1", ">= 0")),
        ("loose_lower_layers = 1", ("loose_lower_layers = 1", "true or false")),
        ('armour = "tetrapod"', ("tetrapod", "cubipod, cube")),
    ],
)
def test_bad_values_are_refused_by_line_and_name(tmp_path, line, words):
    (tmp_path / "test.toml").write_text(f"[placement]\n{line}\n")
    with pytest.raises(InputError) as refusal:
        read_placement_file(tmp_path / "test.toml")
    for word in ("line 2", *words):
        assert word in str(refusal.value)
