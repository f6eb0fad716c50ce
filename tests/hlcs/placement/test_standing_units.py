"""Repair: which places of a layer are empty, units added there, units that stand left as they are."""

import json

import numpy as np
import pytest

from hlcs import InputError, PlacementTest, StandingUnits
from hlcs.cli import commands
from hlcs.placement.placement_file import read_placement_file
from hlcs.placement.standing_units import covered, seats

SMALL = {"grid": "RPG", "layers": 3, "rows": 4, "columns": 4}  # 16 + 9 + 4 units; on RPG none falls


@pytest.fixture(scope="module")
def built():
    return PlacementTest(**SMALL).run()


@pytest.fixture(scope="module")
def damaged(built):
    """Two units of the third layer are gone, and the corner of the second that carried only the first of them."""
    standing = StandingUnits.of(built)
    number = np.arange(len(standing.layer))
    return standing.without(np.isin(number, (16 + 9, 16 + 9 + 3, 16)))


# --- which places are empty


def test_every_unit_fills_the_place_it_is_nearest_to_whatever_their_order(generator):
    """Units off their places by at most a quarter of a spacing: the only sensible seats are the true ones."""
    aims = np.array([(x, y) for x in range(5) for y in range(4)], dtype=float)
    order = generator.permutation(len(aims))[:15]
    places = aims[order] + generator.uniform(-0.25, 0.25, (15, 2))
    found = seats(aims, places, 1.0)
    np.testing.assert_array_equal(found[order], np.arange(15))
    assert (found < 0).sum() == 5


def test_a_unit_too_far_from_any_place_fills_none():
    """0.59 spacings off fills, 0.61 does not (FILLS = 0.6); of two at one place only one can fill it."""
    aims = np.array([(0.0, 0.0), (10.0, 0.0)])
    assert seats(aims, np.array([(0.59, 0.0)]), 1.0).tolist() == [0, -1]
    assert seats(aims, np.array([(0.61, 0.0)]), 1.0).tolist() == [-1, -1]
    assert sorted(seats(aims, np.array([(0.1, 0.0), (0.0, 0.1)]), 1.0).tolist())[0] == -1
    assert seats(aims, np.empty((0, 2)), 1.0).tolist() == [-1, -1]


def test_a_place_under_a_unit_is_covered():
    """A unit of the next layer of RPG lies half a spacing off in x and y, 0.955 Dn in plan, over the places it stands on."""
    above = np.array([(0.70, 0.65)])
    assert covered(np.array([(0.0, 0.0), (1.4, 1.3), (-1.4, 0.0)]), above, 1.0).tolist() == [True, True, False]
    assert not covered(np.zeros((3, 2)), np.empty((0, 2)), 1.0).any()


# --- the repair


def test_a_repair_fills_the_places_and_moves_nothing_that_stands(built, damaged):
    test = PlacementTest(**SMALL, standing=damaged, seed=2)
    result = test.run()
    assert [record.added for record in result.records] == [0, 1, 2] and [len(poses) for poses in result.poses] == [16, 9, 4]
    assert result.lost.sum() == 0 and [record.unsettled for record in result.records] == [0, 0, 0]
    for layer, (poses, before) in enumerate(zip(result.poses, damaged_layers(damaged), strict=True), start=1):
        assert all(np.isclose(poses, pose, rtol=0, atol=1e-12).all(axis=1).any() for pose in before), layer
    # other orientations of three units of thirteen: the height differs less than single plates scatter, 5 % of a layer
    assert result.height_over_dn == pytest.approx(built.height_over_dn, abs=0.1)
    assert "units added to layer 1: 0, layer 2: 1, layer 3: 2" in result.summary()


def damaged_layers(standing):
    return [standing.poses[standing.layer == layer] for layer in (1, 2, 3)]


def test_a_gap_under_standing_units_stays_and_is_told(built):
    """A unit of the middle of the second layer is taken out from under the third."""
    standing = StandingUnits.of(built)
    result = PlacementTest(**SMALL, standing=standing.without(np.arange(29) == 16 + 4)).run()
    assert [record.added for record in result.records] == [0, 0, 0] and result.records[1].covered == 1
    assert "1 empty places lie under units that stand" in result.summary()


def test_the_command_repairs_from_a_file(damaged, tmp_path, capsys):
    damaged.write(tmp_path / "damaged.csv")
    assert StandingUnits.read(tmp_path / "damaged.csv") == damaged
    words = ["--grid", "RPG", "--layers", "3", "--rows", "4", "--columns", "4", "--out", str(tmp_path / "out")]
    status = commands.main(["place", "--standing", str(tmp_path / "damaged.csv"), *words, "--json", str(tmp_path / "r.json")])
    assert status == 0, capsys.readouterr().err
    layers = json.loads((tmp_path / "r.json").read_text())["layers"]
    assert [row["added_units"] for row in layers] == [0, 1, 2] and [row["covered_places"] for row in layers] == [0, 0, 0]
    assert read_placement_file(tmp_path / "out" / "settings.toml").standing == damaged


# --- what cannot be

HEAD = "layer,x_m,y_m,z_m,qw,qx,qy,qz\n"


@pytest.mark.parametrize(
    "text, words",
    [
        (HEAD + "1.5,0,0,1,1,0,0,0\n", "row 2, column layer: 1.5; give the layer"),
        (HEAD + "1,0,0,1,1,1,0,0\n", "row 2, column qw: the quaternion has the length 1.414"),
        (HEAD + "1,0,0,high,1,0,0,0\n", "row 2, column z_m"),
        ("layer,x_m,y_m\n1,0,0\n", "z_m"),
    ],
)
def test_a_file_that_is_no_list_of_units_is_refused(text, words, tmp_path):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(InputError, match=rf"standing 'bad.csv'.*{words}"):
        PlacementTest(standing=str(tmp_path / "bad.csv"))


def test_units_of_another_size_are_told_by_their_overlap(damaged):
    with pytest.raises(InputError, match=r"units '\d\.\d+' and '\d\.\d+'.*overlap by .* Dn; give the armour, the side"):
        PlacementTest(**SMALL, side=1.3, standing=damaged).run()


def test_what_is_no_list_is_refused():
    with pytest.raises(InputError, match=r"standing = 'damaged'; it must be a CSV"):
        PlacementTest(standing="damaged")
