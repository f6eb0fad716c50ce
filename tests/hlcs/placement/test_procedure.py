"""Placement tests: the first layer's height, no overlap, the same bits for the same seed, what is counted, what is refused."""

import dataclasses

import numpy as np
import pytest

import minibullet as mb
from hlcs import InputError, PlacementResult, PlacementTest
from hlcs.placement import hanging, layer_placement, procedure
from hlcs.placement.placement_file import make_placement
from hlcs.placement.sea_bottom import Slope, Survey
from hlcs.placement.settings_table import placement_table
from hlcs.placement.units import Cubipod


@pytest.mark.parametrize("nominal_diameter", [1.07, 0.038])
def test_the_first_layer_is_one_unit_on_its_edge_high_at_any_size(nominal_diameter):
    """k1 = 1.298: the unit's height in its low pose over Dn, facts of geometry; the plates may add the engine's overlap, 1e-3."""
    side = nominal_diameter / Cubipod(side=1.0).nominal_diameter
    result = PlacementTest(layers=1, rows=3, columns=3, side=side).run()
    assert result.test.unit.nominal_diameter == pytest.approx(nominal_diameter)
    assert result.layer_coefficients[0] == pytest.approx(1.298, abs=1e-3)
    assert np.isfinite(result.readings[0]).all()


def test_a_margin_lifts_the_first_layer_by_one_on_the_bed_and_one_under_the_plate():
    """Bed and plate have no margin of their own, the unit has one on either side: k1 = 1.298 + 2 x 0.008."""
    result = PlacementTest(layers=1, rows=3, columns=3, margin=0.008).run()
    assert result.layer_coefficients[0] == pytest.approx(1.298 + 0.016, abs=1e-3)


def test_the_same_seed_gives_the_same_bits_and_another_seed_another_test(small_test, small_result):
    again = small_test.run()
    for first, second in zip((*small_result.poses, *small_result.readings), (*again.poses, *again.readings), strict=True):
        np.testing.assert_array_equal(first, second)
    other = dataclasses.replace(small_test, seed=4).run()
    assert not np.array_equal(small_result.poses[1], other.poses[1])


@pytest.mark.parametrize("grid", ["TPG", "RPG"])
def test_nothing_starts_in_overlap(grid):
    """Before the first step no two units and no unit and bed overlap by more than a touch (1e-6 of a radius)."""
    test = PlacementTest(grid=grid, layers=2, rows=5, columns=5)
    unit, generator = test.unit, np.random.default_rng(5)
    dn = unit.nominal_diameter
    world = mb.World([mb.Gravity(9.81)], test.settings)
    test.bottom.add_to(world)
    load = layer_placement.load_of(unit, test)
    first = layer_placement.lay_first_layer(world, unit, load, test.grid.centres(5, 5, 1) * dn, test.bottom, test, generator)
    assert not world.overlaps(1e-6)
    world.freeze(first)
    centres = test.grid.centres(5, 5, 2) * dn
    hanging.hang_layer(world, 2, load, centres, np.full(len(centres), 1.55 * dn), generator)
    assert not world.overlaps(1e-6)


def test_layers_settle_without_sinking_into_each_other(small_result):
    """Everything at rest; deepest overlap in any step under 5e-3 Dn, the depth that an impact may reach within a step."""
    assert [record.unsettled for record in small_result.records] == [0, 0]
    assert all(record.reason == "at_rest" for record in small_result.records)
    assert max(record.penetration for record in small_result.records) < 5e-3 * small_result.test.unit.nominal_diameter


def test_units_that_fell_out_of_their_layer_are_counted_as_lost(small_result):
    poses = [layer.copy() for layer in small_result.poses]
    poses[1][0, 2] = 0.5  # one unit of the second layer lies on the bed
    fallen = dataclasses.replace(small_result, poses=tuple(poses))
    assert list(fallen.lost - small_result.lost) == [0, 1]
    assert [row["lost"] for row in fallen.to_dict()["layers"]] == list(fallen.lost)


def test_units_that_still_move_when_time_is_up_are_counted_as_unsettled():
    """In a hundredth of a second the second layer cannot even fall its falling distance: none of its units is at rest."""
    result = PlacementTest(layers=2, rows=3, columns=3, settle_time=0.01).run()
    assert result.records[1].unsettled == 4
    assert result.records[1].reason == "time_limit"
    assert result.to_dict()["layers"][1]["unsettled"] == 4


def test_units_are_counted_and_heights_add_up(small_result):
    assert [len(poses) for poses in small_result.poses] == [9, 4]
    assert small_result.layer_coefficients.sum() == pytest.approx(small_result.height_over_dn, rel=1e-12)
    phi = 1 / (1.58 * 1.27)
    assert small_result.porosity == pytest.approx(1 - 2 * phi / small_result.height_over_dn, rel=1e-12)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("layers", 0),
        ("layers", 2.5),
        ("layers", True),
        ("layers", 9),
        ("rows", 0),
        ("columns", "8"),
        ("seed", -1),
        ("plates", 0),
        ("friction", -0.1),
        ("friction", float("nan")),
        ("friction", "0.6"),
        ("side", 0.0),
        ("side", float("inf")),
        ("margin", -0.01),
        ("friction", 10**400),
        ("margin", 1.0),
        ("falling_distance", -1.0),
        ("density", 0.0),
        ("restitution", 1.5),
        ("linear_damping", -1.0),
        ("time_step", 0.0),
        ("settle_time", 0.0),
        ("reference", "deaf"),
        ("shape", "sphere"),
        ("solver", "magic"),
        ("grid", "QPG"),
        ("bottom", "slope:steep"),
        ("tolerance", 0.0),
        ("iterations", 0),
    ],
)
def test_settings_that_cannot_be_are_refused_by_name(field, value):
    with pytest.raises(InputError) as refusal:
        PlacementTest(**{field: value})
    words = {"bottom": "slope", "rows": "rows", "columns": "columns"}.get(field, field)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_result_is_a_value_with_the_fields_of_the_contract(small_result):
    data = small_result.to_dict()
    assert {
        "format",
        "grid",
        "spacing_x",
        "spacing_y",
        "seed",
        "shape",
        "nominal_diameter_m",
        "layers",
        "height_over_dn",
        "porosity",
        "packing_density",
        "max_penetration_over_dn",
        "wall_seconds",
        "settings",
        "versions",
    } <= set(data)
    assert set(data["layers"][0]) == {
        "layer",
        "k",
        "readings",
        "cv",
        "units",
        "lost",
        "unsettled",
        "unsupported_readings",
        "lifted_units",
        "mean_lift_over_dn",
        "redrawn_units",
        "drift_over_dn",
        "level_m",
    }
    assert {"achieved_packing_density", "achieved_porosity"} <= set(data)
    assert data["settings"]["seed"] == 3 and data["settings"]["grid"] == "TPG"
    assert list(small_result.to_dataframe()["layer"]) == [1, 2]
    assert "1.298" in small_result.summary() and "<table" in small_result._repr_html_()
    with pytest.raises(dataclasses.FrozenInstanceError):
        small_result.poses = ()
    assert isinstance(small_result, PlacementResult)


def test_a_rough_bed_is_the_bottom_plus_heights_of_the_stated_scatter():
    test = PlacementTest(bottom=Slope(0.04), bottom_roughness=0.05)
    bed = test.bed
    assert isinstance(bed, Survey) and PlacementTest().bed == PlacementTest().bottom
    off = bed.z - test.bottom.height(*np.meshgrid(bed.x, bed.y))
    # some 400 points: standard deviation known to 1 / sqrt(2 x 400) = 3.5 %, four times that allowed
    assert off.std() == pytest.approx(0.05 * test.unit.nominal_diameter, rel=0.14)
    np.testing.assert_array_equal(bed.z, test.bed.z)
    half = 0.5 * 9 * test.grid.spacing_x * test.unit.nominal_diameter
    assert bed.x[0] < -half - 5 and bed.x[-1] > half + 5


@pytest.mark.parametrize(
    "change",
    [
        {"sequential_placement": True},
        {"unit_by_unit": True},
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


def test_units_on_a_tip_stay_on_it():
    """Their centres rest half the height from tip to tip up, 0.75 L, to the overlap that the engine leaves (1e-3 L). Of a share
    as many are on a tip as a binomial law allows (4 standard deviations)."""
    result = PlacementTest(layers=1, rows=3, columns=3, tip_share=1.0, grid="1.9,1.6,triangular").run()
    np.testing.assert_allclose(result.poses[0][:, 2], 0.75, atol=1e-3)
    some = PlacementTest(rows=20, columns=20, tip_share=0.17)
    count = layer_placement.on_tip(some.centres(1), some).sum()
    assert abs(count - 0.17 * 400) < 4 * np.sqrt(400 * 0.17 * 0.83)


def test_nothing_passes_the_walls():
    """A ball that rolls towards either wall stays between them."""
    test = PlacementTest(walls=True, layers=1, rows=2, columns=2)
    site = procedure._Site(test)
    inner = test.grid.wall_distance(2) * test.unit.nominal_diameter - 0.3
    for side in (-1.0, 1.0):
        ball = site.world.add(mb.Sphere(0.3), density=1000.0, position=(0.0, side, 0.3), velocity=(8.0 * side, 0.0, 0.0))
        reached = []
        site.world.run(1.0, watch=lambda world, ball=ball, reached=reached: reached.append(abs(ball.position[0])))
        assert max(reached) == pytest.approx(inner, abs=5e-3)  # it reaches the wall; an impact may sink in by so much


@pytest.mark.parametrize(
    ("change", "words"), [({"walls": True, "grid": "RPG"}, "triangular"), ({"set_back": 1.0}, "layer 5 of 8 rows")]
)
def test_layers_that_cannot_be_placed_so_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        PlacementTest(**change)
