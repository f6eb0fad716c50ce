"""Results on disk: what is written, that it loads to the same numbers, that it repeats the run."""

import dataclasses
import html
import json
import re

import numpy as np
import pytest

from hlcs import InputError, PlacementResult, PlacementTest
from hlcs.placement.placement_file import read_placement_file


@pytest.fixture(scope="module")
def folder(small_result, tmp_path_factory):
    return small_result.save(tmp_path_factory.mktemp("results") / "run")


def test_a_folder_holds_everything_and_no_half_files(folder):
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    tables, pictures = {"layers.csv", "units.csv", "crest_profile.csv"}, {"scene.glb", "structure.png", "top_view.svg"}
    assert names == tables | pictures | {"result.json", "report.html", "poses.npz", "settings.toml"}
    assert not list(folder.parent.glob("*.partial"))


def test_what_the_engine_had_to_tell_is_shown_and_kept(small_result, tmp_path):
    told = dataclasses.replace(small_result, notices=("step 1: bodies overlap",))
    assert "step 1: bodies overlap" in told.summary()
    assert PlacementResult.load(told.save(tmp_path / "told")).notices == told.notices


def test_a_loaded_result_is_the_saved_one(folder, small_result):
    loaded = PlacementResult.load(folder)
    assert loaded.test == small_result.test
    assert loaded.to_dict() == small_result.to_dict()
    for first, second in zip((*loaded.poses, *loaded.readings), (*small_result.poses, *small_result.readings), strict=True):
        np.testing.assert_array_equal(first, second)


def test_the_settings_repeat_the_run(folder, small_test):
    assert read_placement_file(folder / "settings.toml") == small_test


def test_the_json_is_strict_and_the_report_needs_no_network(folder):
    json.loads((folder / "result.json").read_text(), parse_constant=pytest.fail)
    page = (folder / "report.html").read_text()
    assert 'src="http' not in page and 'href="http' not in page
    assert "1.298" in page and "1.294" in page  # the model's first layer beside the laboratory's


def test_the_report_colours_every_unit_by_how_far_it_is_from_its_aim(folder, small_result):
    """One value a unit in the order of the scene: the length of position minus aim, in plan, over Dn."""
    scene = re.search(r"const scene = (\{.*\});", html.unescape((folder / "report.html").read_text()))[1]
    (shade,) = json.loads(scene)["shades"]
    aims, poses = np.concatenate(small_result.aims), np.concatenate(small_result.poses)
    away = np.hypot(*(poses[:, :2] - aims).T) / small_result.test.unit.nominal_diameter
    assert shade["unit"] == "Dn" and shade["values"] == pytest.approx(away, rel=1e-3)  # written with four digits


def test_a_surveyed_bed_travels_with_the_result(tmp_path):
    points = [f"{x},{y},{0.01 * x}" for x in (-4, 0, 4) for y in (-4, 0, 4)]
    (tmp_path / "bed.csv").write_text("\n".join(["x_m,y_m,z_m", *points]))
    (tmp_path / "test.toml").write_text('[placement]\nbottom = "bed.csv"\nlayers = 1\nrows = 2\ncolumns = 2\n')
    result = read_placement_file(tmp_path / "test.toml").run()
    loaded = PlacementResult.load(result.save(tmp_path / "run"))
    np.testing.assert_array_equal(loaded.test.bottom.z, result.test.bottom.z)
    assert loaded.to_dict() == result.to_dict() | {"settings": loaded.to_dict()["settings"]}


def test_folders_that_are_no_results_are_refused(tmp_path, folder):
    with pytest.raises(InputError, match="settings.toml"):
        PlacementResult.load(tmp_path)
    broken = tmp_path / "broken"
    broken.mkdir()
    for name in ("settings.toml", "result.json", "poses.npz"):
        (broken / name).write_bytes((folder / name).read_bytes())
    (broken / "poses.npz").write_bytes(b"nothing")
    with pytest.raises(InputError, match="not a whole placement result"):
        PlacementResult.load(broken)


def test_a_folder_of_someone_else_is_left_alone(tmp_path, small_result):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match="thesis.tex"):
        small_result.save(tmp_path)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


def test_a_test_with_bed_of_its_own_cannot_be_written(small_result):
    class Mud:
        pass

    from hlcs.placement.settings_table import bottom_words

    with pytest.raises(InputError, match="Mud"):
        bottom_words(Mud())
    assert isinstance(small_result.test, PlacementTest)
