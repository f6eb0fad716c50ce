"""Results in metres: levels above datum, units per metre, the list of units, the profile of the crest, the drawing to scale."""

import dataclasses
import re
import xml.etree.ElementTree as xml

import numpy as np
import pytest

from hlcs import TPG, PlacementTest
from hlcs.placement import metres
from hlcs.placement.placement_result import PlacementResult
from hlcs.placement.sea_bottom import Survey
from hlcs.placement.top_view import svg
from minibullet import rotations
from minibullet.shapes.primitives import Box

SVG = "{http://www.w3.org/2000/svg}"


def level_bed(level):
    ends = np.array([-6.0, 6.0])
    return Survey(ends, ends, np.full((2, 2), level))


def test_on_a_flat_bed_the_crest_is_the_height(small_result):
    dn = small_result.test.unit.nominal_diameter
    assert small_result.crest_level == pytest.approx(small_result.height_over_dn * dn, rel=1e-12)
    assert small_result.crest_level_sd == pytest.approx(np.nanstd(small_result.readings[-1], ddof=1), rel=1e-12)


def test_levels_count_from_the_datum_of_the_survey_and_heights_from_the_bed():
    """One layer on a level bed 2 m above datum: its height is that of a unit at rest, 1.38675 L (facts of the unit), its level
    2 m more. 1e-5 of a unit is what the collision library is good to on touching faces."""
    result = PlacementTest(layers=1, rows=3, columns=3, bottom=level_bed(2.0)).run()
    assert result.crest_level == pytest.approx(2.0 + 1.38675, abs=2e-5)
    assert result.height_over_dn == pytest.approx(1.29826, abs=2e-5)
    assert result.to_dict()["layers"][0]["level_m"] == result.crest_level


def test_units_per_metre_are_those_of_a_cross_section(small_result):
    """3 + 2 rows, each with a unit every 1.58 Dn; per m2 of plan a wide structure of M layers has M / (a b Dn^2)."""
    dn = small_result.test.unit.nominal_diameter
    assert small_result.units_per_metre == pytest.approx(5 / (1.58 * dn))
    wide = dataclasses.replace(small_result.test, rows=1000)
    per_square_metre = dataclasses.replace(small_result, test=wide).units_per_metre / (1000 * TPG.spacing_y * dn)
    assert per_square_metre == pytest.approx(2 * TPG.packing_density / dn**2, rel=1e-3)  # one row in 1000 less in layer 2
    data = small_result.to_dict()
    assert data["concrete_m3"] == pytest.approx(13 * dn**3)
    assert data["concrete_m3_per_m"] == pytest.approx(data["units_per_m"] * dn**3)


def test_a_heading_is_that_of_the_flattest_axis():
    """Turned about the vertical by 30 or 210 degrees the x axis shows at 30; with x upright, one of the others at 120."""
    turns = [rotations.exponential([0.0, 0.0, np.radians(angle)]) for angle in (30.0, 210.0)]
    tilted = rotations.product(turns[0], rotations.exponential([0.3, 0.0, 0.0]))  # about its own x axis, which stays level
    upright = rotations.product(turns[0], rotations.exponential([0.0, -0.5 * np.pi, 0.0]))
    np.testing.assert_allclose(metres.headings([*turns, tilted, upright]), [30.0, 30.0, 30.0, 120.0], atol=1e-9)


def test_every_unit_is_listed_with_its_state(small_result):
    rows = metres.unit_rows(small_result)
    assert [row["number"] for row in rows] == [f"1.{k}" for k in range(1, 10)] + [f"2.{k}" for k in range(1, 5)]
    np.testing.assert_array_equal([[row[f"{axis}_m"] for axis in "xyz"] for row in rows[:9]], small_result.poses[0][:, :3])
    for layer, record in enumerate(small_result.records, start=1):
        words = [row["state"] for row in rows if row["layer"] == layer]
        assert words.count("lost") == small_result.lost[layer - 1]
        assert words.count("moves or hangs") == record.unsettled


def test_states_tell_lost_from_hanging_units(small_result):
    """Of the four units of layer 2 one is put on the bed beside the structure, and one is marked as not standing."""
    poses = small_result.poses[1].copy()
    poses[0, :3] = 5.0, 5.0, 0.7
    standing = (small_result.standing[0], np.array([False, False, True, True]))
    changed = dataclasses.replace(small_result, poses=(small_result.poses[0], poses), standing=standing)
    assert metres.states(changed, 2) == ["lost", "moves or hangs", "stands", "stands"]
    assert metres.states(dataclasses.replace(changed, standing=()), 2) == ["lost", "", "", ""]
    assert "2 units not standing" in svg(changed)


def test_the_upper_surface_of_a_turned_box_has_its_volume():
    """The integral of the surface over the plan: a box on the level z = 0 whose upright sides hide nothing, turned by 20 degrees.

    Sampled every 1 cm the rim of 8 m is off by half a cell at most: 1 % of 4 m3."""
    box = Box(2.0, 2.0, 1.0).pieces[0].moved((0.0, 0.0, 0.5), rotations.exponential([0.0, 0.0, np.radians(20.0)]))
    x = np.arange(-2.0, 2.0, 0.01)
    surface = metres.upper_surface([box], x, x, np.zeros((len(x), len(x))))
    assert set(np.unique(surface.round(9))) == {0.0, 1.0}
    assert surface.sum() * 1e-4 == pytest.approx(4.0, rel=0.01)


def test_the_upper_surface_of_a_tilted_box_is_its_upper_faces():
    """A long box tilted by 0.2 about y: over the middle its top is half its thickness / cos above its centre."""
    box = Box(10.0, 2.0, 1.0).pieces[0].moved((0.0, 0.0, 3.0), rotations.exponential([0.0, 0.2, 0.0]))
    surface = metres.upper_surface([box], np.array([0.0, 1.0]), np.array([0.0, 5.0]), np.full((2, 2), -1.0))
    np.testing.assert_allclose(surface[0], [3.0 + 0.5 / np.cos(0.2), 3.0 + 0.5 / np.cos(0.2) - np.tan(0.2)], rtol=1e-12)
    np.testing.assert_array_equal(surface[1], -1.0)


def test_the_profile_reaches_the_top_of_the_highest_unit(small_result):
    """Sampled every tenth of Dn; the steepest faces that are not vertical rise by 2, so a tip is missed by 0.1 Dn at most."""
    profile = metres.crest_profile(small_result)
    tops = max(piece.vertices[:, 2].max() for piece in metres.placed_pieces(small_result))
    assert 0.0 <= tops - profile["highest_m"].max() < 0.11
    assert np.all(profile["mean_m"] <= profile["highest_m"] + 1e-12) and np.all(profile["mean_m"] >= profile["bed_m"] - 1e-12)
    assert profile["highest_m"][0] == profile["highest_m"][-1] == 0.0  # a rim of bare bed on both sides


def test_the_drawing_is_to_scale_and_holds_every_unit_once(small_result):
    text = svg(small_result)
    drawing = xml.fromstring(text)
    scale = int(re.search(r"1:(\d+)", text).group(1))
    box = [float(word) for word in drawing.get("viewBox").split()]
    for name, length in (("width", box[2]), ("height", box[3])):
        assert float(drawing.get(name).removesuffix("mm")) * scale == pytest.approx(1e3 * length, abs=0.01 * scale)
    layers = drawing.findall(f"{SVG}g/{SVG}g")
    assert [(layer.get("id"), len(layer)) for layer in layers] == [("layer-1", 9), ("layer-2", 4)]
    corners = np.array([pair.split(",") for one in layers[0].iter(f"{SVG}polygon") for pair in one.get("points").split()], float)
    first = np.concatenate([piece.vertices for piece in metres.placed_pieces(small_result)[: 9 * 7]])
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [first[:, :2].min(0), first[:, :2].max(0)], atol=1e-4)


def test_results_of_earlier_versions_have_no_level(small_result):
    early = dataclasses.replace(small_result, plates=(), standing=())
    assert np.isnan(early.crest_level) and early.to_dict()["crest_level_m"] is None
    assert "crest - m above datum" in early.summary()


def test_levels_and_states_are_kept_in_the_folder(small_result, tmp_path):
    loaded = PlacementResult.load(small_result.save(tmp_path / "run"))
    assert metres.unit_rows(loaded) == metres.unit_rows(small_result)
    np.testing.assert_array_equal(loaded.levels, small_result.levels)
