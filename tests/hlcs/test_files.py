"""Files appear whole or not at all, other people's files are never touched, and what is written can be read back."""

import dataclasses
import json
import math
import os
import signal
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hlcs import files
from minibullet.errors import InputError


def names(folder):
    return sorted(entry.name for entry in folder.iterdir())


def test_folder_appears_only_when_complete(tmp_path):
    with files.result_folder(tmp_path / "deep" / "out") as folder:
        (folder / "result.json").write_text("{}")
        assert not (tmp_path / "deep" / "out").exists()
    assert names(tmp_path / "deep") == ["out"] and names(tmp_path / "deep" / "out") == [files.CONTENTS, "result.json"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_failed_or_interrupted_run_leaves_the_old_result(tmp_path, error):
    with files.result_folder(tmp_path / "out") as folder:
        (folder / "result.json").write_text("old")
    with pytest.raises(error), files.result_folder(tmp_path / "out") as folder:
        (folder / "result.json").write_text("new")
        raise error
    assert names(tmp_path) == ["out"] and (tmp_path / "out" / "result.json").read_text() == "old"


def test_a_second_run_replaces_the_first_and_keeps_nothing_of_it(tmp_path):
    for name in ("first.csv", "second.csv"):
        with files.result_folder(tmp_path / "out") as folder:
            (folder / name).write_text(name)
    assert names(tmp_path / "out") == [files.CONTENTS, "second.csv"] and names(tmp_path) == ["out"]


def test_folder_of_others_is_refused_before_any_work(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match="'thesis.tex'"), files.result_folder(tmp_path):
        pytest.fail("the work must not start")
    with files.result_folder(tmp_path / "out") as folder:
        (folder / "result.json").write_text("{}")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="'notes.txt'"), files.result_folder(tmp_path / "out"):
        pytest.fail("the work must not start")
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(InputError, match="is a file"), files.result_folder(tmp_path / "out"):
        pytest.fail("the work must not start")
    with pytest.raises(InputError, match="cannot write"), files.result_folder(tmp_path / "out" / "below"):
        pytest.fail("the work must not start")
    with pytest.raises(InputError, match="cannot write"):
        files.write_text(tmp_path / "out" / "result.json", "")


@pytest.mark.skipif(sys.platform != "linux", reason="needs a place where not even the superuser may write")
def test_place_that_takes_no_files_is_refused():
    with pytest.raises(InputError, match="cannot write '/proc/out'"), files.result_folder("/proc/out"):
        pytest.fail("the work must not start")


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_killed_process_leaves_no_result(tmp_path):
    """kill -9 in the middle of a run: no folder under the final name."""
    script = (
        "import os, signal\nfrom hlcs import files\nwith files.result_folder('out') as folder:\n"
        "    (folder / 'result.json').write_text('{')\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(files.__file__).parents[1])}
    finished = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment)
    assert finished.returncode == -signal.SIGKILL and not (tmp_path / "out").exists()


def test_json_of_numpy_and_records():
    class Pair(NamedTuple):
        low: float
        high: float

    @dataclasses.dataclass
    class Record:
        path: Path
        interval: Pair

    text = files.to_json(
        {"a": np.arange(3), "b": np.float32(0.5), "c": float("nan"), "d": Record(Path("x"), Pair(0.0, 1.0)), "e": np.bool_(True)}
    )
    assert json.loads(text) == {
        "a": [0, 1, 2],
        "b": 0.5,
        "c": None,
        "d": {"path": "x", "interval": {"low": 0.0, "high": 1.0}},
        "e": True,
    }
    assert "NaN" not in text


def test_json_refuses_by_key():
    with pytest.raises(ValueError, match=r"layers\[1\]\.t = inf"):
        files.to_json({"layers": [{"t": 0.0}, {"t": math.inf}]})
    with pytest.raises(TypeError, match="model is a set"):
        files.to_json({"model": {1}})


scalars = (
    st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False) | st.text(st.characters(exclude_categories=["Cs"]))
)
values = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text('ab-_ ."é'), inner, max_size=3), max_leaves=8
)


@given(st.dictionaries(st.text("abcxyz_-. \n"), values, max_size=5))
def test_toml_reads_back_equal(table):
    """Whatever nested settings are written, the standard library's reader gives them back."""
    assert tomllib.loads(files.to_toml(table)) == table


def test_toml_looks_like_an_experiment_file():
    text = files.to_toml(
        {
            "kind": "layers",
            "seed": None,
            "placement": {"side": 1.0, "start": [0, 1.5]},
            "trial": [{"file": "a.csv"}, {"file": "b.csv"}],
        }
    )
    assert text.splitlines() == [
        *('kind = "layers"', "", "[placement]", "side = 1.0", "start = [0, 1.5]", ""),
        *("[[trial]]", 'file = "a.csv"', "", "[[trial]]", 'file = "b.csv"'),
    ]


def test_versions_name_every_dependency():
    found = files.versions()
    assert found["numpy"] == np.__version__ and found["python"].startswith("3.") and "python-fcl" in found


@pytest.mark.skipif(os.name != "posix", reason="asks the system for processes by number")
def test_what_a_killed_run_left_is_cleared_by_the_next_one(tmp_path):
    """kill -9 cannot clean up; a run that still works keeps its folder."""
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    dead, alive = (tmp_path / f".out.{process}.0badcafe.partial" for process in (gone.pid, os.getpid()))
    others = tmp_path / f".thesis.{gone.pid}.0badcafe.partial"
    for folder in (dead, alive, others):
        folder.mkdir()
    with files.result_folder(tmp_path / "out"):
        assert not dead.exists() and alive.exists() and others.exists()
