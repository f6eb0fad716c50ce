"""Sweeps: every combination once, kept as it ends, gone on with after a kill; bad files and stores refused."""

import json
import sqlite3

import numpy as np
import pytest

from hlcs import InputError
from hlcs.cli import commands
from hlcs.placement import parameter_sweep
from hlcs.placement.run_store import Store, key_of

TEXT = """
title = "friction"
[placement]
layers = 1
rows = 2
columns = 2
[sweep]
friction = [0.3, 0.6]
seed = [1, 2]
"""


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "sweep.toml"
    path.write_text(TEXT)
    return parameter_sweep.read_sweep_file(path)


def test_every_combination_stands_once_in_the_order_of_the_file(plan):
    assert plan.names == ("friction", "seed")
    assert plan.values == ((0.3, 1), (0.3, 2), (0.6, 1), (0.6, 2))
    assert [(test.friction, test.seed, test.rows) for test in plan.tests] == [(0.3, 1, 2), (0.3, 2, 2), (0.6, 1, 2), (0.6, 2, 2)]


def test_a_sweep_that_was_killed_goes_on_with_what_is_missing(plan, tmp_path, monkeypatch):
    whole = parameter_sweep.run_sweep(plan, tmp_path / "whole.sqlite", workers=1)
    run, count = parameter_sweep.result_of, []

    def killed_at_the_third(test):
        count.append(test)
        if len(count) == 3:
            raise KeyboardInterrupt
        return run(test)

    monkeypatch.setattr(parameter_sweep, "result_of", killed_at_the_third)
    with pytest.raises(KeyboardInterrupt):
        parameter_sweep.run_sweep(plan, tmp_path / "runs.sqlite", workers=1)
    monkeypatch.setattr(parameter_sweep, "result_of", run)
    again = parameter_sweep.run_sweep(plan, tmp_path / "runs.sqlite", workers=1)
    assert (again["ran"], again["kept"]) == (2, 2)
    numbers = [
        [{key: value for key, value in row.items() if key != "wall_seconds"} for row in outcome["rows"]]
        for outcome in (whole, again)
    ]
    assert numbers[0] == numbers[1]
    third = parameter_sweep.run_sweep(plan, tmp_path / "runs.sqlite", workers=1)
    assert (third["ran"], third["kept"]) == (0, 4)


def test_repeats_are_summarised_over_their_seeds(plan, tmp_path):
    outcome = parameter_sweep.run_sweep(plan, tmp_path / "runs.sqlite", workers=1)
    rows = parameter_sweep.summary_rows(plan, outcome["rows"])
    assert [(row["friction"], row["tests"]) for row in rows] == [(0.3, 2), (0.6, 2)]
    assert rows[0]["k1"] == pytest.approx(1.298, abs=1e-3)
    assert "0 found in the store" in parameter_sweep.summary_text(plan, outcome)
    parameter_sweep.write_sweep(plan, outcome, tmp_path)
    assert json.loads((tmp_path / "sweep.json").read_text())["ran"] == 4
    assert (tmp_path / "runs.csv").read_text().splitlines()[0].startswith("friction,seed,k1")


def test_a_run_that_physics_refuses_is_told_and_the_others_go_on(tmp_path):
    """At a spacing of 0.9 Dn units of 1.4 Dn have no room side by side."""
    path = tmp_path / "sweep.toml"
    path.write_text('[placement]\nlayers = 1\nrows = 2\ncolumns = 2\n[sweep]\ngrid = ["0.3,0.3", "1.5,1.5"]\n')
    plan = parameter_sweep.read_sweep_file(path)
    outcome = parameter_sweep.run_sweep(plan, tmp_path / "runs.sqlite", workers=1)
    good = [row for row in outcome["rows"] if "error" not in row]
    assert good and good[-1]["grid"] == "1.5,1.5"
    parameter_sweep.summary_text(plan, outcome)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[placement]\n", ("[sweep] is missing",)),
        ("[sweep]\nfrction = [1]\n", ("line 2", "frction", "'friction'")),
        ("[sweep]\nseed = [1, 2, 1]\n", ("line 2", "seed: 1 stands twice", "leave one of the two out")),
        ("[sweep]\nfriction = 0.6\n", ("line 2", "friction", "list")),
        ("[sweep]\nfriction = [0.6, -1]\n", ("line 2", "friction = -1", ">= 0")),
        ("[placement]\nfriction = 0.1\n[sweep]\nfriction = [0.6]\n", ("friction", "[placement] too")),
        ("[placement]\nrows = 2\n[sweep]\nlayers = [2, 3]\n", ("layers = 3", "at most 2 layers")),
        ("[sweep]\nseed = [1, 2]\nrows = []\n", ("line 3", "rows", "list")),
    ],
)
def test_complaints_name_file_key_and_remedy(tmp_path, text, words):
    path = tmp_path / "sweep.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refusal:
        parameter_sweep.read_sweep_file(path)
    for word in ("sweep.toml", *words):
        assert word in str(refusal.value)


def test_the_key_of_a_run_hangs_on_its_settings_alone():
    assert key_of({"a": 1, "b": 2.5}) == key_of({"b": 2.5, "a": 1}) != key_of({"a": 1, "b": 2.6})


def test_a_store_keeps_the_first_result_of_a_run(tmp_path):
    with Store(tmp_path / "new" / "runs.sqlite") as store:
        store.add({"a": 1}, {"k": 1.0})
        store.add({"a": 1}, {"k": 2.0})
        assert len(store) == 1 and store.result(key_of({"a": 1})) == {"k": 1.0}
        assert key_of({"a": 1}) in store and key_of({"a": 2}) not in store and store.result("none") is None


def test_files_that_are_no_stores_are_refused_and_left_alone(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not a database, but long enough to be looked at by SQLite as if it were one" * 20)
    with pytest.raises(InputError, match="notes.txt"):
        Store(text)
    assert text.read_text().startswith("not a database")
    with pytest.raises(InputError, match="folder"):
        Store(tmp_path)
    other = tmp_path / "other.sqlite"
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE runs (name TEXT)")
    with pytest.raises(InputError, match="another program"):
        Store(other)


def test_without_dask_one_line_names_the_extra(plan, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(InputError, match=r"the extra 'sweep': python -m pip install -e '.\[sweep\]'"):
        parameter_sweep.run_sweep(plan, tmp_path / "runs.sqlite", dask="tcp://127.0.0.1:1")


def test_nothing_is_said_to_be_kept_in_a_store_that_cannot_be_used(tmp_path, capsys):
    file = tmp_path / "s.toml"
    file.write_text("[placement]\nlayers = 1\n[sweep]\nseed = [1]\n")
    assert commands.main(["sweep", str(file), "--store", str(file), "--quiet"]) == 2
    said = capsys.readouterr().err
    assert "s.toml" in said and "kept" not in said


def test_a_case_that_misses_a_layer_has_no_error_to_be_ranked_by(tmp_path):
    """Its first layer alone is nearer to the laboratory than two layers of a whole one can be."""
    path = tmp_path / "sweep.toml"
    path.write_text("[placement]\nlayers = 2\nrows = 3\ncolumns = 3\n[sweep]\nfriction = [0.0, 0.36]\n")
    plan = parameter_sweep.read_sweep_file(path)
    rows = [
        {"friction": friction, "k1": 1.298, "k2": k2, "structure": True, "lost": 0, "unsettled": 0}
        for friction, k2 in ((0.0, None), (0.36, 1.1))
    ]
    broken, whole = parameter_sweep.summary_rows(plan, rows)
    assert np.isnan(broken["mean_relative_error"]) and np.isnan(broken["signed_bias"]) and whole["mean_relative_error"] > 0


def sweep_of(tmp_path, text, heights):
    """A SweepResult whose runs have these heights [Dn], None for a run that left no structure."""
    (tmp_path / "sweep.toml").write_text("[placement]\nlayers = 1\nrows = 2\ncolumns = 2\n[sweep]\n" + text)
    plan = parameter_sweep.read_sweep_file(tmp_path / "sweep.toml")
    numbers = {"k1": 1.298, "porosity": 0.5, "lost": 0, "unsettled": 0, "max_penetration_over_dn": 0.0, "wall_seconds": 1.0}
    rows = [
        dict(zip(plan.names, values, strict=True)) | numbers | {"structure": height is not None, "height_over_dn": height}
        for values, height in zip(plan.values, heights, strict=True)
    ]
    return parameter_sweep.SweepResult(plan, {"rows": rows, "ran": len(rows), "kept": 0, "told": ""})


def test_a_sweep_draws_heights_over_what_varied_and_joins_their_means(tmp_path):
    """Two frictions, two seeds: four dots, and a line through (1.2 + 1.4)/2 and (1.5 + 1.7)/2."""
    found = sweep_of(tmp_path, "friction = [0.3, 0.6]\nseed = [1, 2]\n", [1.2, 1.4, 1.5, 1.7])
    ax = found.plot()
    dots, means = ax.get_lines()
    assert dots.get_ydata().tolist() == [1.2, 1.4, 1.5, 1.7] and means.get_xdata().tolist() == [0.3, 0.6]
    assert means.get_ydata() == pytest.approx([1.3, 1.6]) and (ax.get_xlabel(), ax.get_ylabel()) == (
        "friction [-]",
        "height [Dn]",
    )
    assert repr(found) == "<SweepResult: sweep; 4 runs over friction, seed; 4 run now, 0 found in the store, 0 failed>"
    assert found.to_dataframe("summary")["tests"].tolist() == [2, 2] and "<table" in found._repr_html_()
    names = {file.name for file in found.save(tmp_path / "out").iterdir() if not file.name.startswith(".")}
    assert names == {"runs.csv", "summary.csv", "sweep.json", "sweep.png"}


def test_a_sweep_of_words_is_drawn_run_by_run_without_those_that_left_nothing(tmp_path):
    found = sweep_of(tmp_path, 'shape = ["pieces", "hull"]\nseed = [1, 2]\n', [1.2, None, 1.3, 1.3])
    ax = found.plot()
    assert [line.get_xdata().tolist() for line in ax.get_lines()] == [[1.0], [3.0, 4.0]] and ax.get_xlabel() == "run"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["shape pieces", "shape hull"]
