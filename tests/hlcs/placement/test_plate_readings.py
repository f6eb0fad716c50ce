"""Measuring plates: what carries them is told, and only what stands in the layer makes a reading."""

import dataclasses

import numpy as np
import pytest

import hlcs
import minibullet as mb
from hlcs import PlacementResult, PlacementTest
from hlcs.files import folders
from hlcs.paper import reproduce
from hlcs.paper.reproduce_text import text_of
from hlcs.placement import plate_readings
from hlcs.placement.comparison import compare_layers, repeated
from hlcs.placement.grids import TPG
from hlcs.placement.printed_tables import laboratory
from hlcs.placement.sea_bottom import Flat
from hlcs.placement.single_run import layer_coefficients_of
from hlcs.placement.units import Cube
from minibullet.errors import InputError

CUBE = Cube(side=1.0)


def tower(*layers):
    """Fixed cubes at the given places, layer by layer: lists of handles."""
    world, built = mb.World(), []
    for number, places in enumerate(layers, start=1):
        built.append(
            [
                world.add(CUBE.pieces, density=1.0, position=place, fixed=True, name=f"{number}.{k}")
                for k, place in enumerate(places, start=1)
            ]
        )
    return built


def read(layers, centres, standing=None):
    standing = layers[-1] if standing is None else standing
    return plate_readings.read_plates(layers, standing, Flat(), np.array(centres, dtype=float), 1.0, mb.Settings(friction=0.6))


def square(x, y, z):
    return [(x + i, y + j, z) for i in (-0.6, 0.6) for j in (-0.6, 0.6)]


def test_a_plate_reads_the_layer_that_carries_it_and_no_other():
    """Four cubes on four cubes; beside them four cubes of the first layer alone, and bare ground: tops at 2, 1 and 0 Dn."""
    layers = tower(square(0, 0, 0.5) + square(6, 0, 0.5), square(0, 0, 1.5))
    found = read(layers, [(0, 0), (6, 0), (20, 0)])
    assert found.carried_by == ("layer 2", "layer 1", "the bed")
    assert found.heights[0] == pytest.approx(2.0, abs=1e-3)  # the engine's overlap
    assert np.isnan(found.heights[1:]).all()


def test_a_plate_that_falls_past_two_layers_names_the_one_it_lies_on():
    layers = tower(square(0, 0, 0.5) + square(6, 0, 0.5), square(0, 0, 1.5), square(0, 0, 2.5))
    assert read(layers, [(6, 0)]).carried_by == ("layer 1",)


def test_units_that_do_not_stand_in_the_layer_carry_no_reading():
    layers = tower(square(0, 0, 0.5), square(6, 0, 0.5))
    found = read(layers, [(6, 0)], standing=[])
    assert np.isnan(found.heights).all() and "units out of layer 2" in found.carried_by[0]


def test_a_plate_that_something_deeper_helps_to_carry_is_no_reading_of_the_layer():
    """Two cubes of layer 2 and two of layer 1 that happen to be as high: the plate lies flat, on both."""
    layers = tower([(-0.6, -0.6, 0.5), (-0.6, 0.6, 0.5)], [(0.6, -0.6, 0.5), (0.6, 0.6, 0.5)])
    found = read(layers, [(0, 0)])
    assert np.isnan(found.heights).all() and found.carried_by == ("layer 1 and layer 2",)


@pytest.fixture(scope="module")
def wide():
    """A grid so wide that no unit of the second layer finds a hollow: all lie on the bed, and plates fall past them."""
    return PlacementTest(grid="4.0,4.0", layers=3, rows=3, columns=3).run()


def test_a_layer_without_support_has_no_height_and_ends_no_run(wide, tmp_path):
    data = wide.to_dict()
    assert not wide.stands and data["structure"] is False
    for layer in data["layers"]:
        assert layer["readings"] + layer["unsupported_readings"] == 9
    assert list(wide.lost) == [0, 4, 1]  # on the bed beside the first layer, not in theirs
    assert np.isnan(wide.heights[1:]).all() and np.isnan(wide.layer_coefficients[1:]).all()
    assert '"k": null' in folders.to_json(data)
    assert "no structure" in wide.summary()
    assert any(" - " in line for line in wide.summary().splitlines()[2:5])
    loaded = PlacementResult.load(wide.save(tmp_path / "run"))
    assert folders.to_json(loaded.to_dict()) == folders.to_json(data)
    assert "no structure" in (tmp_path / "run" / "report.html").read_text().lower()
    assert "nan" not in (tmp_path / "run" / "report.html").read_text().split("<h2>The structure")[0].split("<img")[0].lower()


def test_k_is_known_again_two_layers_above_an_absent_one(small_result):
    """k is a difference: without h2 neither k2 nor k3 is known, k4 = h4 - h3 is."""
    dn = small_result.test.unit.nominal_diameter
    heights = [np.full(9, h * dn) for h in (1.3, np.nan, 3.3, 4.3)]
    poses = tuple(small_result.poses[0] for _ in heights)
    result = dataclasses.replace(small_result, readings=tuple(heights), poses=poses, records=4 * small_result.records[:1])
    np.testing.assert_allclose(result.layer_coefficients, [1.3, np.nan, np.nan, 1.0], rtol=1e-12)
    assert result.height_over_dn == pytest.approx(4.3)


def test_a_comparison_says_what_it_leaves_out(wide):
    comparison = compare_layers(wide, laboratory("table2", grid="TPG"))
    assert comparison.mean_relative_error == pytest.approx(abs(wide.layer_coefficients[0] / 1.294 - 1), rel=1e-12)
    assert np.isnan(comparison.height_error) and "layer 2, 3" in str(comparison)
    folders.to_json(comparison.to_dict())
    comparison.plot()


def test_a_layer_that_sinks_below_the_one_under_it_is_compared_all_the_same():
    comparison = hlcs.compare(
        hlcs.placement.statistics.Sample([1.3, -0.1], [np.nan, np.nan], 1), laboratory("table2", grid="TPG")
    )
    assert comparison.signed_errors[1] == pytest.approx(-0.1 / 1.076 - 1.0, rel=1e-12)
    comparison.plot()


def test_repeats_are_averaged_layer_by_layer_over_the_tests_that_have_it():
    sample = repeated([[1.3, 1.0], [1.3, np.nan], [1.3, 1.2], [1.3, np.nan]])
    np.testing.assert_allclose(sample.mean, [1.3, 1.1])
    assert list(sample.tests) == [4, 2] and sample.cv[1] == pytest.approx(np.sqrt(0.02) / 1.1)
    assert np.isnan(repeated([[1.0, np.nan]]).mean[1]) and repeated([[1.0, np.nan]]).tests[1] == 0


HANGING = {"linear_damping": 1.0, "rows": 3, "columns": 3, "settle_time": 0.5}


@pytest.mark.parametrize(
    "more", [{}, {"time_step": 0.001}, {"linear_damping": 0.0, "effects": (mb.Buoyancy(fluid_density=2300.0),)}]
)
def test_units_that_hang_in_the_air_are_unsettled_and_no_structure(more):
    """Damping 1 leaves every unit the speed g dt, at a small step too slow to be called moving; in a fluid of its own density a
    unit is at rest without anything under it. In each case all four units of layer 2 hang where they were put."""
    result = PlacementTest(layers=2, **{**HANGING, **more}).run()
    assert result.records[1].unsettled == 4 and result.records[1].standing == ()
    assert not result.stands and np.isnan(result.heights[1])


def without_second_layer(result):
    """The same result, but that no plate found support on layer 2 and none of its units had come to rest."""
    records = (result.records[0], dataclasses.replace(result.records[1], unsettled=len(result.poses[1])))
    return dataclasses.replace(result, readings=(result.readings[0], np.full(9, np.nan)), records=records)


def test_a_layer_that_stands_without_a_plate_is_not_read_and_yet_a_structure(small_result):
    """Its units are all in place: the other layers count, this one is of no test."""
    unread = dataclasses.replace(small_result, readings=(small_result.readings[0], np.full(9, np.nan)))
    assert unread.stands and np.isnan(unread.heights[1]) and "no height of layer 2" in unread.summary()
    summary = reproduce._summary([small_result, unread], laboratory("table2", grid="TPG"))
    assert [row["tests"] for row in summary["layers"]] == [2, 1]
    assert summary["layers"][1]["mean"] == small_result.layer_coefficients[1]


def test_a_run_without_structure_stays_out_of_means_and_ranges(small_result):
    failed = without_second_layer(small_result)
    measured = laboratory("table2", grid="TPG")
    both, alone = reproduce._summary([small_result, failed], measured), reproduce._summary([small_result], measured)
    assert [row["mean"] for row in both["layers"]] == [row["mean"] for row in alone["layers"]]
    assert [row["tests"] for row in both["layers"]] == [1, 1] and both["mean_relative_error"] == alone["mean_relative_error"]
    assert np.isnan(reproduce._summary([failed], measured)["mean_relative_error"])


def test_table_1_shows_no_structure_and_keeps_it_out_of_its_range(monkeypatch, small_result):
    failed = without_second_layer(small_result)
    monkeypatch.setattr(
        reproduce.parallel,
        "in_order",
        lambda function, tests, workers, done: [failed if test.linear_damping == 1.0 else small_result for test in tests],
    )
    document = reproduce.table1(reproduce.Plan({}, workers=1))
    error = reproduce._summary([small_result], laboratory("table2", grid="RPG"))["mean_relative_error"]
    assert document["lowest_error"] == document["highest_error"] == pytest.approx(error)
    text = text_of(document)
    of_value, of_parameter = (line for line in text.splitlines() if "no structure" in line and "linear" in line)
    assert of_value.split()[:3] == ["linear", "damping", "1"] and of_parameter.endswith("no structure at 1")
    assert "no structure: a layer carries no plate" in text
    folders.to_json(document)


def test_a_simulated_layer_that_is_absent_is_null_in_the_store(monkeypatch):
    result = layer_coefficients_of(PlacementTest(layers=2, **HANGING))
    assert "error" not in result and np.isnan(result["k"][1])
    assert folders.to_json(result).count("null") == 1


def test_a_layer_that_lost_all_its_units_is_one_without_height():
    """Half of the units left out by chance: some seeds leave the single unit of the top layer out."""
    runs = [PlacementTest(layers=2, rows=2, columns=2, lost_units=0.5, seed=seed).run() for seed in range(1, 7)]
    assert {len(run.poses[1]) for run in runs} == {0, 1}
    assert all(np.isnan(run.heights[1]) for run in runs if not len(run.poses[1]))


def test_the_grid_of_the_next_layer_is_referred_to_a_unit_that_stands():
    """A middle unit that rolled ten metres away passes nothing on: the nearest that stands does."""

    class Handle:
        def __init__(self, place):
            self.position = np.array(place)

    aims = np.array([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)])
    handles = tuple(Handle(place) for place in ((0.1, 0.0, 2.0), (11.0, 0.0, 0.6), (2.3, 0.0, 2.0)))
    record = hlcs.placement.layer_placement.LayerRecord(2, handles, "at_rest", 0, 0.0, 0.0, 1, 0, standing=handles[::2])
    np.testing.assert_allclose(hlcs.placement.layer_placement.reference_shift(record, aims), [0.1, 0.0])
    lost = dataclasses.replace(record, standing=())
    assert not hlcs.placement.layer_placement.reference_shift(lost, aims).any()


def test_lifts_and_drift_are_told(small_result):
    """Where overlaps are parted by lifting, RPG lifts most units. A drift is a length, of the middle of a layer."""
    rpg = PlacementTest(grid="RPG", layers=2, rows=4, columns=4, crowding="lift").run()
    rows = rpg.to_dict()["layers"]
    assert rows[0]["lifted_units"] == 0 and rows[0]["mean_lift_over_dn"] == 0.0
    assert rows[1]["lifted_units"] > 0 and rows[1]["mean_lift_over_dn"] > 0.04  # a twentieth of a radius at a time
    mean = (small_result.poses[1][:, :2] - small_result.aims[1]).mean(axis=0) / small_result.test.unit.nominal_diameter
    assert small_result.to_dict()["layers"][1]["drift_over_dn"] == pytest.approx(np.hypot(*mean), rel=1e-12)


def test_plates_lie_in_rows_evenly_and_a_single_row_in_the_middle():
    """The paper's plates of section 4: rows of three, 12, 9, 9, 6 and 3 of them; the outermost lie 0.75 Dn inside."""
    centres = TPG.centres(8, 8, 1)
    low, high = centres.min(axis=0), centres.max(axis=0)
    for rows, count in zip((4, 3, 3, 2, 1), (12, 9, 9, 6, 3), strict=True):
        places = plate_readings.plate_centres(centres, 1.0, 3, rows)
        assert len(places) == count and len(np.unique(places[:, 1])) == rows
        np.testing.assert_allclose(places.mean(axis=0), 0.5 * (low + high), atol=1e-12)
        assert np.abs(places - places.mean(axis=0)).max() <= np.abs(centres - centres.mean(axis=0)).max() - 0.75 + 1e-12
    np.testing.assert_allclose(plate_readings.plate_centres(centres, 1.0, 1), [0.5 * (low + high)])


def test_a_margin_on_the_plates_raises_every_reading_by_itself():
    """Contacts keep the margin open: a plate on units without one rests that much higher; 1e-3 is the engine's overlap."""
    layers = tower(square(0, 0, 0.5))
    settings = mb.Settings(friction=0.6)
    found = plate_readings.read_plates(layers, layers[-1], Flat(), np.zeros((1, 2)), 1.0, settings, margin=0.05)
    assert found.heights[0] == pytest.approx(1.05, abs=1e-3)


def test_a_test_lays_the_rows_of_plates_that_it_was_given():
    test = PlacementTest(plate_rows="4,3", rows=3, columns=3, layers=3)
    assert test.plate_rows == (4, 3)
    assert [len(test.plate_places(layer, TPG.centres(3, 3, 1))) for layer in (1, 2, 3)] == [12, 9, 9]
    for wrong in ("4,x", "0", (2.5,), (True,), 7):
        with pytest.raises(InputError, match="plate_rows.*such as 4,3,3,2,1"):
            PlacementTest(plate_rows=wrong)
