"""The steps from the naive model to the paper's tables, on a stand-in for the simulations."""

import pytest
from layer_tables import compare_layers, emulate

from hlcs.data.experiment_file import read_experiment_file
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.model import PlacementSimulator
from hlcs.paper import ladder, reproduce_files
from hlcs.paper.reproduce import Plan


def test_the_ladder_leads_from_the_naive_model_and_holds_the_slope_out(tmp_path):
    simulator = PlacementSimulator(tmp_path / "store" / "runs.sqlite", workers=1, function=emulate)
    document, diagnosis = ladder.ladder(Plan({}, repeats=4), tmp_path, simulator=simulator)
    steps = document["steps"]
    assert diagnosis.title == "Table 2 against the naive model" and set(steps[0]["by_table"]) == {"RPG flat", "TPG flat"}
    assert "convex_hull_shape" in steps[-1]["effects"]
    assert all(later["fitted"] < earlier["fitted"] for earlier, later in zip(steps, steps[1:], strict=False))
    assert steps[-1]["held_out"] < steps[0]["held_out"]  # the stand-in is 10 % too thick on the slope as well
    # the files it leaves are a case of their own: naive model, three tables
    assert [one.name for one in read_layers(read_experiment_file(tmp_path / "all.toml")).sets][-1] == "TPG 4 % slope"
    diagnosis.save(tmp_path / "moved")
    (tmp_path / "moved" / "flat.csv").write_text((tmp_path / "flat.csv").read_text())
    again = compare_layers(read_experiment_file(tmp_path / "moved" / "model.toml"), simulator=simulator, seeds=4)
    # numbers are written to a hundredth of their intervals, and a friction a little off draws other scatter: 0.6 % of a layer
    assert again.error["rms"] == pytest.approx(steps[-1]["fitted"], abs=1e-3)
    text = ladder.ladder_text(document)
    assert "the naive model" in text and "+ convex_hull_shape" in text and "a perfect model" in text


def test_the_report_names_the_folder_that_its_files_end_in(tmp_path, monkeypatch):
    """They are written elsewhere first, and moved when all are whole: the command to type next must find them there."""
    simulator = PlacementSimulator(tmp_path / "runs.sqlite", workers=1, function=emulate)
    monkeypatch.setattr(ladder, "PlacementSimulator", lambda **_: simulator)
    written, end = tmp_path / "written", tmp_path / "end"
    written.mkdir()
    _, text = reproduce_files.run("ladder", Plan({}, repeats=4), written, out=end)
    assert f"hlcs compare {end / 'model.toml'}" in text
    for name in ("ladder.txt", "report.txt", "report.html", "result.json"):
        assert str(written) not in (written / name).read_text(), name
    _, text = reproduce_files.run("ladder", Plan({}, repeats=4))
    assert "To add it:" in text and ".toml" not in text.split("To add it:")[1]  # nothing is left of its files
