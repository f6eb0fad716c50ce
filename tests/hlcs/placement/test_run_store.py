"""The store: rows know their code, old files open, damage and refusals are one line, several processes share the work."""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hlcs import InputError
from hlcs.placement import code_hash, parameter_sweep, run_queue, run_store
from hlcs.placement.run_store import Store, default_store, key_of
from hlcs.placement.settings_table import settings_of
from minibullet.errors import RunError

FIRST_STORE = """
CREATE TABLE runs (key TEXT PRIMARY KEY, settings TEXT NOT NULL, result TEXT NOT NULL, versions TEXT NOT NULL,
                   finished TEXT NOT NULL) WITHOUT ROWID
"""  # as the first version wrote it
SWEEP = "[placement]\nlayers = 1\nrows = 2\ncolumns = 2\n[sweep]\nseed = [1, 2, 3, 4, 5, 6]\n"
TRACED = """
import json, os, sys
import hlcs, minibullet
from hlcs.placement import single_run
seen = set()
test = hlcs.PlacementTest(layers=2, rows=2, columns=2, time_step=1/60, settle_time=0.5, **json.loads(sys.argv[1]))
sys.setprofile(lambda frame, event, argument: seen.add(frame.f_globals.get("__name__", "")))
try:
    result = test.run()
    result.layer_coefficients, result.lost, result.cv, result.porosity
except hlcs.InputError:  # five units may not hold a plate; what was entered until then counts
    assert len(sys.argv[1]) > 2
sys.setprofile(None)
print(json.dumps(sorted(name for name in seen if name.partition(".")[0] in ("hlcs", "minibullet"))))
"""


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "sweep.toml"
    path.write_text(SWEEP)
    return parameter_sweep.read_sweep_file(path)


def copied(tmp_path):
    """A copy of both packages, to be edited; returns the function that tells their hash."""
    root = Path(code_hash.__file__).resolve().parents[2]
    for package in code_hash.OURS:
        shutil.copytree(root / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__", "*.csv"))

    def told():
        line = "from hlcs.placement.code_hash import code_hash; print(code_hash())"
        done = subprocess.run(
            [sys.executable, "-c", line],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
            env=os.environ | {"PYTHONPATH": str(tmp_path)},
        )
        return done.stdout.strip()

    return told


# ------------------------------------------------------------------------------------------------------- which code made it
@pytest.mark.parametrize(
    ("compiled", "settings"),
    [
        ("1", {}),  # kernels as plain Python, so that they are seen too
        ("0", {"bottom": "slope:0.04", "bottom_roughness": 0.05, "sequential_placement": True, "yaw_constraint": 2.0}),
        ("0", {"vibration": 0.01, "loose_lower_layers": True, "shape": "hull", "margin": 0.01}),
        ("0", {"solver": "sequential_impulse", "armour": "cube", "grid": "RPG", "reference": "blind", "inertia_factor": 2.0}),
    ],
)
def test_no_code_runs_in_a_simulation_that_its_hash_does_not_know(compiled, settings):
    """Every function that Python enters is seen by the interpreter's own hook: an oracle that reads no imports."""
    done = subprocess.run(
        [sys.executable, "-c", TRACED, json.dumps(settings)],
        capture_output=True,
        text=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": compiled, "PYTHONPATH": os.getcwd()},
    )
    assert done.returncode == 0, done.stderr
    entered = set(json.loads(done.stdout))
    assert {
        "hlcs.placement.layer_placement",
        "hlcs.placement.sea_bottom",
        "minibullet.collision.narrow_phase",
        "minibullet.report.step_report",
    } <= entered
    assert (
        settings
        or {"hlcs.placement.placement_result", "minibullet.contact.gauss_seidel", "minibullet.dynamics.integrate"} <= entered
    )
    assert entered <= set(code_hash.closure("hlcs.placement.single_run")[0])


def test_what_only_draws_reports_or_saves_is_not_in_the_hash():
    modules, libraries = code_hash.closure("hlcs.placement.single_run")
    assert not {
        "minibullet.report.drawing",
        "minibullet.report.rendering",
        "minibullet.scene.saving",
        "minibullet.files.writing",
        "hlcs.files.folders",
        "hlcs.placement.result_files",
        "hlcs.placement.report",
        "hlcs.placement.figures",
        "hlcs.cli.commands",
        "hlcs.placement.run_store",
        "hlcs.diagnose",
    } & set(modules)
    assert libraries == ["fcl", "numba", "numpy", "scipy"]


def test_the_hash_follows_the_code_and_nothing_else(tmp_path):
    told = copied(tmp_path)
    first = told()
    assert first == code_hash.code_hash()  # the same text in another place
    for name in (
        "minibullet/report/drawing.py",
        "hlcs/report/diagnosis.py",
        "hlcs/placement/run_store.py",
        "hlcs/cli/commands.py",
    ):
        with open(tmp_path / name, "a") as file:
            file.write("\nADDED = 1\n")
    path = tmp_path / "hlcs" / "placement" / "layer_equations.py"
    text = path.read_bytes()
    path.write_bytes(text.replace(b"\n", b"\r\n"))  # a checkout on Windows
    assert told() == first
    path.write_bytes(text.replace(b"dtype=float), prepend=0.0)", b"dtype=float), prepend=0.1)"))
    assert told() != first
    path.write_bytes(text)
    (tmp_path / "minibullet" / "new_law.py").write_text("FACTOR = 2.0\n")
    with open(tmp_path / "minibullet" / "contact" / "gauss_seidel.py", "a") as file:
        file.write("\nfrom minibullet import new_law\n")
    second = told()
    (tmp_path / "minibullet" / "new_law.py").write_text("FACTOR = 3.0\n")
    assert len({first, second, told()}) == 3  # a new module counts as soon as it is imported


def test_rows_of_other_code_are_told_computed_again_and_stay(plan, tmp_path, monkeypatch):
    path = tmp_path / "runs.sqlite"
    parameter_sweep.run_sweep(plan, path, workers=1)
    for module in (run_store, run_queue):
        monkeypatch.setattr(module, "code_hash", lambda: "f" * 16)
    again = parameter_sweep.run_sweep(plan, path, workers=1)
    assert (again["ran"], again["kept"]) == (6, 0) and "6 runs" in again["told"] and "other code" in again["told"]
    assert again["told"] in parameter_sweep.summary_text(plan, again)
    with sqlite3.connect(path) as connection:
        counts = dict(connection.execute("SELECT code, count(*) FROM runs GROUP BY code"))
    assert counts == {"f" * 16: 6, code_hash.code_hash(): 6}
    monkeypatch.undo()
    back = parameter_sweep.run_sweep(plan, path, workers=1)  # both are still known
    assert (back["ran"], back["kept"], back["told"]) == (0, 6, "")


def test_a_store_from_before_the_hash_opens_and_its_rows_stay(plan, tmp_path):
    path = tmp_path / "old.sqlite"
    with sqlite3.connect(path) as connection:
        connection.execute(FIRST_STORE)
        for test in plan.tests:
            settings = settings_of(test)
            row = (key_of(settings), json.dumps(settings, sort_keys=True), '{"layers": [{"layer": 1, "k": 9.9}]}', "{}", "2025")
            connection.execute("INSERT INTO runs VALUES (?, ?, ?, ?, ?)", row)
    connection.close()
    outcome = parameter_sweep.run_sweep(plan, path, workers=1)
    assert outcome["ran"] == 6 and "6 runs in the store made by other code" in outcome["told"]
    assert all(row["k1"] < 2 for row in outcome["rows"])
    with sqlite3.connect(path) as connection:
        rows = connection.execute("SELECT code, result, finished FROM runs WHERE code = ''").fetchall()
    assert len(rows) == 6 and all("9.9" in result and finished == "2025" for _, result, finished in rows)


# ------------------------------------------------------------------------------------------------------- damage and refusals
@pytest.mark.parametrize("damage", ["{", "[]", "null", '{"layers": 3}', '{"layers": [{}]}', "[" * 100_000, b"\xff\xfe{", 7])
def test_a_damaged_row_is_told_and_computed_again(plan, tmp_path, damage):
    path = tmp_path / "runs.sqlite"
    whole = parameter_sweep.run_sweep(plan, path, workers=1)
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE runs SET result = ? WHERE key = ?", (damage, key_of(settings_of(plan.tests[2]))))
    connection.close()
    again = parameter_sweep.run_sweep(plan, path, workers=1)
    assert (again["ran"], again["kept"]) == (1, 5) and "1 damaged row of the store: computed again" in again["told"]
    assert [row["k1"] for row in again["rows"]] == [row["k1"] for row in whole["rows"]]
    assert parameter_sweep.run_sweep(plan, path, workers=1)["ran"] == 0


def test_a_damaged_page_is_one_line(plan, tmp_path):
    """Every page of the file in turn is overwritten: each time the rows are right, or one complaint names the file."""
    path, told = tmp_path / "runs.sqlite", 0
    whole = parameter_sweep.run_sweep(plan, path, workers=1)
    data = path.read_bytes()
    for start in range(0, len(data), 4096):
        path.write_bytes(data[:start] + b"\xa5" * 4096 + data[start + 4096 :])
        try:
            assert [row["k1"] for row in parameter_sweep.run_sweep(plan, path, workers=1)["rows"]] == [
                row["k1"] for row in whole["rows"]
            ]
        except (InputError, RunError) as problem:
            told += 1
            assert "runs.sqlite" in str(problem) and "\n" not in str(problem)
    assert told > 0


def test_a_locked_store_is_not_the_inputs_fault(tmp_path, monkeypatch):
    monkeypatch.setattr(run_store, "BUSY", 0.1)
    path = tmp_path / "runs.sqlite"
    with Store(path) as ours:
        other = sqlite3.connect(path, isolation_level=None)
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(RunError, match=r"runs.sqlite' cannot be written \(database is locked\)|read \(database is locked\)"):
            ours.add({"a": 1}, {"k": 1.0})
        other.execute("ROLLBACK")
        other.close()
        ours.add({"a": 1}, {"k": 1.0})
        assert key_of({"a": 1}) in ours


def test_a_full_disk_while_a_row_is_written_prints_the_run_and_keeps_the_others(plan, tmp_path):
    """SQLite itself says that the disk is full when a file may have no more pages."""
    path = tmp_path / "runs.sqlite"
    with Store(path, parameter_sweep._row) as ours:
        ours._connection.execute("PRAGMA max_page_count = 5")  # of 4 kB: room for the tables and a run or two
        tests = {key_of(settings_of(test)): test for test in plan.tests}
        with pytest.raises(RunError, match="full.*of 6 runs are kept in .*runs.sqlite") as refusal:
            run_queue.finish(ours, tests, parameter_sweep.result_of, settings_of, workers=1)
    assert json.loads(refusal.value.result)["layers"][0]["k"] == pytest.approx(1.298, abs=1e-3)
    again = parameter_sweep.run_sweep(plan, path, workers=1)
    assert again["kept"] >= 1 and again["ran"] + again["kept"] == 6


@pytest.mark.parametrize("name", ["folder", "pipe", "/dev/null", "/dev/full", "a\0b", "x" * 300, "text/below", ""])
@pytest.mark.skipif(os.name != "posix", reason="needs devices and pipes")
def test_places_that_can_be_no_store_are_refused_at_once(tmp_path, name, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "text").write_text("a file")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="store"):
        Store(name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "pipe", "text"]


# ------------------------------------------------------------------------------------------------------- several at once
def start(tmp_path, *options):
    return subprocess.Popen(
        [sys.executable, "-m", "hlcs", "sweep", "sweep.toml", "--workers", "1", *options],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.getcwd()},
    )


def test_two_sweeps_on_one_store_do_every_run_once(plan, tmp_path):
    both = [start(tmp_path, "--json", f"{number}.json") for number in (1, 2)]
    texts = [process.communicate(timeout=300) for process in both]
    assert [process.returncode for process in both] == [0, 0], texts
    found = [json.loads((tmp_path / f"{number}.json").read_text()) for number in (1, 2)]
    assert found[0]["ran"] + found[1]["ran"] == 6 and all(one["ran"] + one["kept"] == 6 for one in found)
    assert found[0]["runs"] == found[1]["runs"]


def test_a_claim_holds_while_its_owner_lives_and_no_longer(tmp_path):
    path, key = tmp_path / "runs.sqlite", key_of({"a": 1})
    with Store(path) as first, Store(path) as second:
        assert first.claim(key) and first.claim(key) and not second.claim(key)
        first.add({"a": 1}, {"k": 1.0})
        assert not second.claim(key) and key in second
        assert second.claim(key_of({"a": 2})) and not first.claim(key_of({"a": 2}))
    with Store(path) as third:  # the second one has gone and let go
        assert third.claim(key_of({"a": 2}))


@pytest.mark.parametrize(
    ("host", "process", "age", "free"),
    [
        ("ours", "gone", 0.0, os.name == "posix"),
        ("ours", "alive", 0.0, False),
        ("another", 1, 0.0, False),
        ("another", 1, run_store.LATE + 1.0, True),
        ("ours", "alive", run_store.LATE + 1.0, True),
        ("another", 1, -run_store.LATE - 1.0, True),
    ],
)
def test_the_claim_of_a_dead_owner_is_taken_over(tmp_path, host, process, age, free):
    """Dead: its process is no more on this computer, or it has been silent for too long (or its clock is wrong)."""
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    number = {"gone": gone.pid, "alive": os.getpid()}.get(process, process)
    with Store(tmp_path / "runs.sqlite") as ours:
        name = run_store.platform.node() if host == "ours" else "elsewhere"
        ours._connection.execute(
            "INSERT INTO claims VALUES (?, ?, ?, ?, ?, ?)", ("key", ours.code, name, number, "somebody", time.time() - age)
        )
        assert ours.claim("key") is free


def test_an_owner_at_work_says_that_it_lives(tmp_path, monkeypatch):
    monkeypatch.setattr(run_store, "BEAT", 0.05)
    with Store(tmp_path / "runs.sqlite") as ours:
        ours.claim("key")
        ours._connection.execute("UPDATE claims SET seen = 0")
        end = time.monotonic() + 20.0
        while ours._connection.execute("SELECT seen FROM claims").fetchone()[0] == 0:
            assert time.monotonic() < end, "no beat"
            time.sleep(0.05)


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
def test_a_sweep_killed_at_its_work_is_gone_on_with_at_once(plan, tmp_path):
    """The claims of the dead do not hold up: the next sweep does not wait for them to grow old."""
    process = start(tmp_path)
    end = time.monotonic() + 120.0
    while not ((tmp_path / "runs.sqlite").exists() and len(Store(tmp_path / "runs.sqlite")) > 0):
        assert time.monotonic() < end and process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    with Store(tmp_path / "runs.sqlite") as ours:
        assert all(not ours._taken(key_of(settings_of(test))) for test in plan.tests)
    again = parameter_sweep.run_sweep(plan, tmp_path / "runs.sqlite", workers=1)
    assert again["kept"] >= 1 and again["ran"] + again["kept"] == 6


def test_the_store_lies_where_the_user_says_or_in_a_folder_that_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setenv("HLCS_CACHE", str(tmp_path / "mine"))
    assert default_store("layers.sqlite") == tmp_path / "mine" / "layers.sqlite"
    monkeypatch.delenv("HLCS_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert default_store("layers.sqlite") == tmp_path / "cache" / "hlcs" / "layers.sqlite"
