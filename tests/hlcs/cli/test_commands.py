"""The command: exit statuses, one line for bad input, help with examples, files, no noise in a pipe."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import fields

import pytest

from hlcs import PlacementTest
from hlcs.cli import placement_options
from hlcs.cli.commands import COMMANDS
from hlcs.kinds.experiment import Experiment
from minibullet.errors import InputError

SMALL = ["--rows", "3", "--columns", "3", "--layers", "2", "--seed", "3"]


def said(errors):
    """Lines of standard error, but the one that is told once for a machine, by whichever command comes first."""
    return [line for line in errors.splitlines() if line and "compiling the engine" not in line]


@pytest.mark.parametrize(
    "command",
    [
        ["demo"],
        ["place"],
        ["design"],
        ["reproduce"],
        ["compare"],
        ["diagnose"],
        ["plan"],
        ["import"],
        ["sweep"],
        ["doctor"],
        ["course", "copy"],
        ["mystery", "list"],
        ["mystery", "copy"],
        ["mystery", "make"],
        ["mystery", "reveal"],
    ],
)
def test_every_command_has_help_with_a_real_example(hlcs, command):
    status, text, _ = hlcs(*command, "--help")
    assert status == 0
    assert f"\n    hlcs {' '.join(command)}" in text
    assert "--quiet" in text


def test_the_list_of_commands_tells_what_each_says_of_itself_and_loads_none():
    code = "import sys; from hlcs.cli.commands import run; run(['--help']); print('numpy' in sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert told.splitlines()[-1] == "False"
    for name in COMMANDS:
        assert COMMANDS[name].help.splitlines()[0] in " ".join(told.split())


def test_place_prints_the_layers_beside_the_laboratory_and_writes_its_files(hlcs, tmp_path):
    status, text, errors = hlcs("place", *SMALL, "--out", "out", "--json", "result.json")
    assert (status, said(errors)) == (0, [])  # no progress bar in a pipe
    assert "1.298" in text and "laboratory, TPG" in text and "written to out" in text
    names = {path.name for path in (tmp_path / "out").iterdir() if not path.name.startswith(".")}
    tables, pictures = {"layers.csv", "units.csv", "crest_profile.csv"}, {"scene.glb", "structure.png", "top_view.svg"}
    assert tables | pictures | {"result.json", "report.html", "poses.npz", "settings.toml"} == names
    result = json.loads((tmp_path / "result.json").read_text())
    assert [row["units"] for row in result["layers"]] == [9, 4]

    status, _, _ = hlcs("place", "out/settings.toml", "--quiet", "--json", "again.json")
    again = json.loads((tmp_path / "again.json").read_text())
    assert status == 0 and again["layers"] == result["layers"] and again["settings"] == result["settings"]


def test_options_win_over_the_file(hlcs, tmp_path):
    (tmp_path / "test.toml").write_text("[placement]\nlayers = 2\nrows = 2\ncolumns = 2\nfriction = 0.1\n")
    status, text, _ = hlcs("place", "test.toml", "--layers", "1", "--friction", "0.7", "--json", "result.json")
    settings = json.loads((tmp_path / "result.json").read_text())["settings"]
    assert (status, settings["layers"], settings["friction"], settings["rows"]) == (0, 1, 0.7, 2)


def test_place_has_an_option_for_every_setting():
    only_in_files = {"effects"}  # a list of tables
    settings = {field.name for field in fields(PlacementTest)} - only_in_files
    assert set(placement_options.HELP) == settings | {"nominal_diameter", "stacking"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["place", "--friction", "-1"], "friction = -1.0; it must be a finite number >= 0"),
        (["place", "--friction", "rough"], "not a valid float"),
        (["place", "--grid", "QPG"], "give TPG, RPG"),
        (["place", "missing.toml"], "missing.toml: cannot be read"),
        (["place", "--layers", "9"], "at most 8 layers"),
        (["place", "--bottom", "no.csv"], "no.csv"),
        (["demo", "--bogus"], "No such option '--bogus'"),
        (["plcae"], "'place'"),
        (["reproduce", "table9"], "table9"),
        (["reproduce", "table2", "--workers", "0"], "workers"),
        (["reproduce", "ladder", "--preset", "paper"], "it takes no --preset"),
        (["compare", "missing.toml"], "missing.toml"),
        (["diagnose", "missing.toml"], "missing.toml"),
        (["diagnose", "missing.toml", "--candidates", " ,"], "--candidates names no effect"),
        (["mystery", "reveal", "tower-dorp"], "did you mean 'tower-drop'?"),
        (["sweep", "missing.toml"], "missing.toml"),
        (["design", "--height", "5"], "no size of unit; give --nominal-diameter"),
        (["mystery", "reveal", "no-such"], "no-such"),
        (["mystery", "make", "--effect", "magnos", "--strength", "8", "--out", "case"], "did you mean 'magnus'?"),
        (["mystery", "make", "--effect", "magnus", "--strength", "-8", "--out", "case"], "strength = -8.0: must be"),
    ],
)
def test_bad_input_is_one_line_and_status_2(hlcs, arguments, words):
    status, text, errors = hlcs(*arguments)
    assert (status, text) == (2, "")
    assert errors.count("\n") == 1 and errors.startswith("hlcs: ") and words in errors


def test_a_folder_of_someone_else_is_refused_before_any_work(hlcs, tmp_path, monkeypatch):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "thesis.tex").write_text("x")
    monkeypatch.setattr("hlcs.placement.procedure.PlacementTest.run", lambda *_, **__: pytest.fail("it worked before it looked"))
    status, _, errors = hlcs("demo", "--out", "thesis")
    assert status == 2 and "thesis.tex" in errors


def test_a_copied_mystery_is_told_to_programs(hlcs, tmp_path):
    status, text, _ = hlcs("mystery", "copy", "gym-floor", "--out", "case", "--json", "c.json")
    told = json.loads((tmp_path / "c.json").read_text())
    assert status == 0 and f"hlcs diagnose {told['experiment']}" in text and told["format"] == 1


def test_a_file_in_the_place_of_a_folder_is_refused_before_any_work(hlcs, tmp_path):
    (tmp_path / "notes.txt").write_text("x")
    name = "gym-floor"
    hlcs("mystery", "copy", name)
    (tmp_path / name / "recording_01.csv").write_text("no recording")  # work would end here
    for command in (("diagnose", "--plots"), ("compare", "--out")):
        status, _, errors = hlcs(command[0], f"{name}/experiment.toml", command[1], "notes.txt")
        assert status == 2 and "notes.txt" in errors and errors.count("\n") == 1


def test_reproduce_writes_its_table_and_picture(hlcs, tmp_path):
    small = ["--rows", "2", "--columns", "2", "--layers", "1", "--repeats", "2", "--workers", "1"]
    status, text, _ = hlcs("reproduce", "table2", *small, "--out", "out", "--json", "t2.json")
    assert status == 0 and "paper, numerical" in text
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"table2.json", "table2.txt", "table2.png"}
    assert json.loads((tmp_path / "t2.json").read_text())["grids"]["TPG"]["layers"][0]["tests"] == 2

    status, text, _ = hlcs("reproduce", "figures", *small, "--friction", "0.5", "--out", "figures")
    assert status == 0 and "convex hull" not in text and "model, hull" in text
    assert {path.name for path in (tmp_path / "figures").iterdir()} >= {"layers.png", "structure.png", "figures.json"}


def test_sweep_goes_on_from_its_store(hlcs, tmp_path):
    (tmp_path / "sweep.toml").write_text("[placement]\nlayers = 1\nrows = 2\ncolumns = 2\n[sweep]\nseed = [1, 2]\n")
    assert "2 now, 0 found" in hlcs("sweep", "sweep.toml", "--workers", "1", "--out", "out")[1]
    status, text, _ = hlcs("sweep", "sweep.toml", "--workers", "1", "--out", "out", "--json", "sweep.json")
    assert status == 0 and "0 now, 2 found" in text
    assert json.loads((tmp_path / "sweep.json").read_text())["kept"] == 2


def test_doctor_finds_this_machine_well(hlcs, tmp_path):
    status, text, _ = hlcs("doctor", "--json", "doctor.json")
    assert status == 0 and "everything works" in text and "FAILED" not in text
    report = json.loads((tmp_path / "doctor.json").read_text())
    assert report["passed"] and len(report["checks"]) == 5


def test_a_mystery_is_listed_copied_and_told(hlcs, tmp_path):
    status, text, _ = hlcs("mystery", "list")
    assert status == 0 and len(text.splitlines()) >= 3
    name = text.split()[0]
    status, text, _ = hlcs("mystery", "copy", name, "--out", "case")
    assert status == 0 and (tmp_path / "case" / "experiment.toml").is_file() and "hlcs diagnose" in text
    status, text, _ = hlcs("mystery", "reveal", name, "--no-fit")
    assert status == 0 and "quadratic_drag" in text and "expected from the data" not in text


def test_a_reveal_shows_the_true_number_inside_what_the_data_give(hlcs, tmp_path):
    """tower-drop was made by another integration: its number lies in the interval of the fit; the error falls to the noise."""
    status, text, _ = hlcs("mystery", "reveal", "tower-drop", "--out", "answer", "--json", "a.json")
    told = json.loads((tmp_path / "a.json").read_text())
    number, error = told["found"]["parameters"]["quadratic_drag"]["drag_coefficient"], told["found"]["error"]["fitted"]
    assert status == 0 and "F = -(rho C A/2 + k m) |w| w" in text and "expected from the data" in text
    assert number["low"] < told["parameters"]["quadratic_drag"]["drag_coefficient"] < number["high"]
    assert error["after"] < 1.1 * error["noise"] < 0.1 * error["before"]
    assert {path.name for path in (tmp_path / "answer").iterdir()} == {
        ".hlcs",
        "reveal.json",
        "reveal.txt",
        "before_and_after.png",
    }


def test_a_mystery_is_made_and_told(hlcs, tmp_path):
    request = ["--effect", "rolling_friction", "--strength", "8", "--seed", "3"]
    status, text, _ = hlcs("mystery", "make", *request, "--out", "case", "--json", "made.json")
    assert status == 0 and "hlcs mystery copy case --out DIR" in text and "hlcs mystery reveal case" in text
    files = json.loads((tmp_path / "made.json").read_text())["files"]
    assert {"experiment.toml", "rest.csv", "recording_01.csv", "answer.sealed"} <= set(files)
    status, text, errors = hlcs("mystery", "make", *request, "--out", "made.json")
    assert status == 2 and "made.json" in errors and errors.count("\n") == 1


def test_the_course_is_copied_with_its_titles(hlcs, tmp_path):
    status, text, _ = hlcs("course", "copy", "--out", "class", "--json", "class.json")
    lessons = json.loads((tmp_path / "class.json").read_text())["lessons"]
    assert status == 0 and len(lessons) == 9 and all(title in text for title in lessons.values())
    assert {path.name for path in (tmp_path / "class").glob("*.ipynb")} == set(lessons)


def test_ctrl_c_ends_with_one_line_and_leaves_nothing(tmp_path):
    """The real command in a process of its own, interrupted while it works."""
    process = subprocess.Popen(
        [sys.executable, "-m", "hlcs", "demo", "--out", "out"],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.getcwd()},
    )
    for _ in range(600):
        if list(tmp_path.glob(".out.*.partial")):  # work has begun
            break
        time.sleep(0.1)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    text, errors = process.communicate(timeout=300)
    assert process.returncode == 1, errors
    (told,) = said(errors)
    assert "interrupted" in told
    assert list(tmp_path.iterdir()) == []


LOST = """
import ctypes, os, signal
from hlcs.processes import interrupts

@ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
def compare(a, b):
    os.kill(os.getpid(), signal.SIGINT)
    return 0

interrupts.listen()
interrupts.check()
ctypes.CDLL(None).qsort((ctypes.c_int * 2)(2, 1), 2, 4, compare)
print("the run went on")
try:
    ASKS
except KeyboardInterrupt:
    print("but not for long")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="asks the C library for its qsort")
@pytest.mark.parametrize("asks", ["interrupts.check()", "import time; time.sleep(60)"])
def test_ctrl_c_inside_a_callback_of_a_c_library_is_not_lost(asks):
    """What Python itself forgets: an exception in such a callback is printed, and the program goes on."""
    done = subprocess.run(
        [sys.executable, "-c", LOST.replace("ASKS", asks)],
        text=True,
        capture_output=True,
        timeout=300,
        env=os.environ | {"PYTHONPATH": os.getcwd()},
    )
    assert done.stdout.splitlines() == ["the run went on", "but not for long"], done.stderr
    assert done.stderr == ""


THROWN_AWAY = """
from hlcs.processes import interrupts

class Half:
    def __del__(self):
        raise AttributeError("half made")

interrupts.listen()
Half()
try:
    interrupts._interrupt(2, None)
except KeyboardInterrupt:
    Half()
"""


def test_what_ctrl_c_broke_off_is_thrown_away_without_a_word():
    """An error in a finaliser is printed, but not one of what was being made when Ctrl-C came."""
    command = [sys.executable, "-c", THROWN_AWAY]
    done = subprocess.run(command, text=True, capture_output=True, timeout=300, env=os.environ | {"PYTHONPATH": os.getcwd()})
    assert done.returncode == 0 and done.stderr.count("AttributeError: half made") == 1


def test_a_reader_that_goes_away_is_no_error_to_tell_about(tmp_path):
    """`hlcs mystery list | head -1` prints one line and no traceback."""
    process = subprocess.Popen(
        [sys.executable, "-m", "hlcs", "mystery", "list"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.getcwd()},
    )
    process.stdout.close()
    errors = process.stderr.read()
    process.wait(timeout=300)
    assert b"Traceback" not in errors


def test_what_a_diagnosis_finds_is_written_and_its_next_command_compares_it(hlcs, tmp_path):
    hlcs("mystery", "copy", "tower-drop", "--out", "case")
    diagnose = ["diagnose", "case/experiment.toml", "--candidates", "quadratic_drag"]
    status, text, _ = hlcs(*diagnose, "--apply", "mended/new.toml", "--json", "d.json")
    add = json.loads((tmp_path / "d.json").read_text())["add"]
    assert status == 0 and add["next"] == "hlcs compare mended/new.toml --allow-outside" and f"    {add['next']}\n" in text
    assert add["toml"].startswith('{ name = "quadratic_drag", drag_coefficient = 0.46')
    status, text, _ = hlcs(*add["next"].split()[1:])
    assert status == 0 and "With quadratic drag added the error goes from" in text and "  before " in text and "  after " in text

    status, text, errors = hlcs(*diagnose, "--apply", "case/experiment.toml")
    assert (status, text) == (2, "") and "is there already and was not written by this program" in errors


@pytest.mark.parametrize(
    "line",
    [
        ["compare", "case/experiment.toml"],
        ["diagnose", "case/experiment.toml"],
        ["place", "test.toml"],
        ["effects", "magnus"],
        ["mystery", "list"],
    ],
)
@pytest.mark.parametrize("name", ["case/experiment.toml", "case/recording_01.csv", "test.toml", "notes.json", "case"])
def test_no_result_is_written_over_a_file_of_the_user(hlcs, tmp_path, line, name):
    """--json refuses it before the work begins; the file keeps its bytes."""
    hlcs("mystery", "copy", "tower-drop", "--out", "case")
    (tmp_path / "test.toml").write_text("[placement]\nlayers = 1\n")
    (tmp_path / "notes.json").write_text('{"name": "drop", "format": 1}')
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    status, text, errors = hlcs(*line, "--json", name)
    assert (
        (status, text, errors.count("\n")) == (2, "", 1) and f"'{name}' is" in errors and "give a" in errors.replace("the", "a")
    )
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


def test_an_earlier_result_and_an_empty_file_are_written_over(hlcs, tmp_path):
    """Every command marks its JSON; a program that sets its spaces otherwise takes nothing from that."""
    (tmp_path / "r.json").touch()
    lines = [
        ["mystery", "list"],
        ["mystery", "reveal", "tower-drop", "--no-fit"],
        ["effects"],
        ["course", "copy", "--out", "class"],
    ]
    for line in lines:
        status, _, errors = hlcs(*line, "--json", "r.json")
        told = json.loads((tmp_path / "r.json").read_text())
        assert (status, errors) == (0, "") and next(iter(told)) == "format"
        (tmp_path / "r.json").write_text(json.dumps(told, indent=4))


def test_what_cannot_be_written_costs_no_finished_diagnosis(hlcs, monkeypatch):
    def full(experiment, path):
        raise InputError(f"'{path}': no space is left")

    hlcs("mystery", "copy", "tower-drop", "--out", "case")
    monkeypatch.setattr(Experiment, "save", full)
    status, text, errors = hlcs("diagnose", "case/experiment.toml", "--candidates", "quadratic_drag", "--apply", "new.toml")
    assert status == 2 and "Air resistance is missing" in text and "'new.toml': no space is left" in errors


def test_where_nothing_is_found_no_experiment_is_written(hlcs, tmp_path):
    hlcs("mystery", "copy", "empty-gallery", "--out", "case")
    status, text, _ = hlcs("diagnose", "case/experiment.toml", "--candidates", "magnus", "--apply", "new.toml")
    assert status == 0 and "Nothing was found that could be added: new.toml is not written." in text
    assert not (tmp_path / "new.toml").exists()
