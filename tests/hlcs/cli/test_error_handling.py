"""Whatever happens in the command ends in one line and an exit status; nothing that a file says steers the terminal."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hlcs.cli import error_handling
from hlcs.files import limits
from hlcs.files.spreadsheets import csv_text
from minibullet.errors import InputError

ROOT = Path(__file__).resolve().parents[3]
LIST = f"'{sys.executable}' -m hlcs mystery list"
SMALL = ["place", "--layers", "1", "--rows", "2", "--columns", "2"]
THROW = (
    'kind = "trajectory"\ntitle = {title}\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[measurement]\n'
    "noise = {{ position = 0.002 }}\n[[trial]]\nfile = {file}\n"
)


def fall(g=9.81):
    return "t_s,z_m\n" + "".join(f"{t / 50:.2f},{2 - g / 2 * (t / 50) ** 2:.4f}\n" for t in range(20))


def experiment(folder, title='"x"', file='"a.csv"', recording=None):
    (folder / "a.csv").write_text(recording or fall())
    (folder / "e.toml").write_text(THROW.format(title=title, file=file), encoding="utf-8")
    return "e.toml"


def shell(line, folder, **environment):
    return subprocess.run(
        ["sh", "-c", line],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
    )


# -------------------------------------------------------------------------------------------------------- streams, folders
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("line", [f"{LIST} > /dev/full", f"{LIST} >&-", f"'{sys.executable}' -m hlcs --help > /dev/full"])
def test_output_that_cannot_be_written_is_one_line_and_status_1(tmp_path, line):
    done = shell(line, tmp_path)
    assert done.returncode == 1, done.stderr
    assert re.fullmatch(r"hlcs: standard output cannot be written \(.+\); .+\n", done.stderr)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_what_was_done_before_the_output_failed_is_kept_and_said(tmp_path):
    words = " ".join(SMALL)
    done = shell(f"'{sys.executable}' -m hlcs {words} --json k.json --out out > /dev/full", tmp_path)
    assert done.returncode == 1 and "out is written; k.json is written" in done.stderr
    assert json.loads((tmp_path / "k.json").read_text())["layers"] and (tmp_path / "out" / "layers.csv").is_file()


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use cannot be removed there")
def test_a_folder_that_was_deleted_is_told(tmp_path):
    done = shell(f"mkdir gone && cd gone && rmdir ../gone && {LIST}", tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch("hlcs: the current folder is not there any more.+\n", done.stderr)


def test_an_error_stream_that_is_closed_or_full_leaves_the_status(tmp_path):
    assert shell(f"'{sys.executable}' -m hlcs nonsense 2>&-", tmp_path).returncode == 2


def test_letters_that_the_terminal_does_not_have_are_shown_by_their_numbers(tmp_path):
    experiment(tmp_path, '"Fallh\u00f6he 2 \u20ac"')
    done = shell(f"'{sys.executable}' -m hlcs compare e.toml", tmp_path, PYTHONIOENCODING="ascii")
    assert done.returncode == 0 and "Fallh\\xf6he 2 \\u20ac" in done.stdout


# ----------------------------------------------------------------------------------------------------------------- Ctrl-C
@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="looks in /proc for what is loaded")
@pytest.mark.parametrize("library", ["_multiarray_umath", "libllvmlite"])
def test_ctrl_c_while_python_imports_is_one_line(tmp_path, library):
    """Just as a library of NumPy, or the compiler, is loaded; the commands' own work is a second away."""
    process = subprocess.Popen(
        [sys.executable, "-m", "hlcs", *SMALL, "--out", "out"],
        cwd=tmp_path,
        text=True,
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    while library not in Path(f"/proc/{process.pid}/maps").read_text():
        assert process.poll() is None, "it ended without that library"
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    text, errors = process.communicate(timeout=300)
    assert process.returncode == 1, errors
    assert text == "" and re.fullmatch(r"hlcs: interrupted[^\n]*", errors.strip())
    assert list(tmp_path.iterdir()) == []


# ------------------------------------------------------------------------------------------------------------- unforeseen
@pytest.mark.parametrize("fault", [RuntimeError("a\nb"), SystemExit(0), RecursionError(), OSError(5, "I/O error"), EOFError()])
def test_what_nobody_foresaw_is_one_line_and_a_report(hlcs, tmp_path, monkeypatch, fault):
    def fail():
        raise fault

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("hlcs.mystery.names", fail)
    status, text, errors = hlcs("mystery", "list")
    errors = errors.strip()  # click puts a line break before what may be Ctrl-C, an EOFError too
    assert (status, text, errors.count("\n")) == (1, "", 0) and type(fault).__name__ in errors and "nothing was written" in errors
    report = Path(re.search(r"traceback: (\S+\.txt)", errors)[1]).read_text()
    assert "Traceback" in report and "in fail" in report and "Python 3" in report


def test_where_no_report_can_be_written_that_is_said(hlcs, monkeypatch):
    monkeypatch.setattr("hlcs.mystery.names", lambda: 1 / 0)
    monkeypatch.setattr("tempfile.mkstemp", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    status, _, errors = hlcs("mystery", "list")
    assert status == 1 and "no report could be written" in errors and "ZeroDivisionError" in errors and errors.count("\n") == 1


def test_too_little_memory_is_told_without_a_report(hlcs, monkeypatch):
    def fail():
        raise MemoryError

    monkeypatch.setattr("hlcs.mystery.names", fail)
    status, _, errors = hlcs("mystery", "list")
    assert status == 1 and errors.startswith("hlcs: not enough memory") and "report" not in errors


def test_a_complaint_is_one_line_of_bounded_length(hlcs, monkeypatch):
    def fail():
        raise InputError("x" * 5000 + "\nend")

    monkeypatch.setattr("hlcs.mystery.names", fail)
    status, _, errors = hlcs("mystery", "list")
    assert status == 2 and len(errors) < error_handling.LONGEST + 20 and errors.count("\n") == 1 and errors.endswith("end\n")


@pytest.mark.parametrize("name", ["a" * 300, "~nobody-of-this-name/x", "", " "])
@pytest.mark.parametrize("option", [["mystery", "list", "--json"], [*SMALL, "--out"], ["sweep", "s.toml", "--store"]])
def test_names_that_no_system_takes_are_refused_before_any_work(hlcs, option, name):
    status, text, errors = hlcs(*option, name)
    assert (status, text, errors.count("\n")) == (2, "", 1) and option[-1] in errors


# ------------------------------------------------------------------------------------------------------------------ words
def test_words_of_a_file_do_not_steer_the_terminal(hlcs, tmp_path):
    experiment(tmp_path, r'"\u001b[31mred \u009b1m \u202eback \u0007\nVerdict: complete"')
    status, text, errors = hlcs("compare", "e.toml")
    assert status == 0 and "\\x1b[31mred \\x9b1m \\u202eback \\x07 Verdict: complete (trajectory)" in text.splitlines()[0]
    assert not error_handling.STEERING.search(text + errors)
    assert hlcs("compare", "\x1b[31m.toml")[2].startswith("hlcs: \\x1b[31m.toml: cannot be read")


def test_what_is_written_as_csv_is_no_formula():
    import pandas as pd

    names = ["=1+1", "+x", "-cmd", "@a", "\ttab", "-1.5", "+2", "plain", ""]
    frame = pd.DataFrame({"name": names, "=k": [-1.0, 2, 3, 4, 5, 6, 7, 8, None]})
    lines = csv_text(frame.to_dict("list")).splitlines()
    assert lines[0] == "name,'=k" and lines[1:6] == ["'=1+1,-1.0", "'+x,2.0", "'-cmd,3.0", "'@a,4.0", "'\ttab,5.0"]
    assert lines[6:] == ["-1.5,6.0", "+2,7.0", "plain,8.0", ","]


def test_json_on_standard_output_stands_there_alone(hlcs, tmp_path):
    experiment(tmp_path, '"Fallh\u00f6he \\u007f"')
    status, text, errors = hlcs("compare", "e.toml", "--json", "-")
    assert status == 0 and json.loads(text)["title"] == "Fallh\u00f6he \x7f" and text.isascii() and "The model agrees" in errors
    status, text, errors = hlcs("compare", "e.toml", "--json", "-", "--quiet")
    assert status == 0 and json.loads(text) and errors == ""
    assert hlcs("mystery", "list")[1].splitlines()  # and only for that command


def test_a_title_that_looks_like_a_formula_is_drawn_as_it_stands(hlcs, tmp_path):
    experiment(tmp_path, r"'$\frac{$'")
    assert hlcs("compare", "e.toml", "--out", "out")[0] == 0 and (tmp_path / "out" / "comparison.png").is_file()


def test_a_thread_that_an_effects_file_starts_does_not_keep_the_command(tmp_path):
    """shell() waits a minute; the thread sleeps for an hour."""
    (tmp_path / "own.py").write_text("import threading, time\nthreading.Thread(target=time.sleep, args=(3600,)).start()\n")
    experiment(tmp_path)
    done = shell(f"'{sys.executable}' -m hlcs compare e.toml --effects own.py", tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "defines no effect" in done.stderr


# --------------------------------------------------------------------------------------------------------- unlikely input
@pytest.mark.parametrize(("option", "value"), [("side", "1000"), ("density", "2.3"), ("friction", "60")])
def test_settings_that_are_hardly_meant_are_told_in_one_line(hlcs, option, value):
    status, text, errors = hlcs(*SMALL, "--time-step", "0.01", f"--{option}", value)
    assert status == 0 and text
    assert re.fullmatch(rf"hlcs: warning: placement: {option} = {value}.* usual is .+\n", errors)


def test_recordings_in_feet_are_told(hlcs, tmp_path):
    experiment(tmp_path, recording=fall(9.81 / 0.3048))
    status, _, errors = hlcs("compare", "e.toml")
    assert status == 0 and re.fullmatch(r"hlcs: warning: a.csv, column z_m: a fall of 32.2 m/s2 .+ in feet\?\n", errors)
    experiment(tmp_path)
    assert hlcs("compare", "e.toml")[2] == ""


def test_fall_times_over_heights_in_feet_are_told(hlcs, tmp_path):
    (tmp_path / "e.toml").write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[measurement]\nfile = "t.csv"\n'
    )
    for unit, words in ((0.3048, r"hlcs: warning: t.csv, columns .+ a fall of 32.2 m/s2 .+ in feet\?\n"), (1.0, "")):
        rows = [f"{h / unit},{(2 * h / 9.81) ** 0.5 + e}" for h in (0.5, 1.0, 2.0) for e in (0.0, 0.001, -0.001)]
        (tmp_path / "t.csv").write_text("\n".join(["height_m,fall_time_s", *rows, ""]))
        status, _, errors = hlcs("compare", "e.toml")
        assert status == 0 and re.fullmatch(words, errors)


def test_every_usual_range_has_a_unit_and_a_reason_and_holds_the_default():
    from hlcs import PlacementTest

    for name, (low, high, unit, why) in limits.USUAL.items():
        assert low < high and unit and len(why.split()) > 3
        assert limits.unlikely(name, getattr(PlacementTest(), name, high)) == ""
        assert why in limits.unlikely(name, 2 * high) and f"{2 * high:g}" in limits.unlikely(name, 2 * high)


def test_unlikely_settings_warn_in_python():
    from hlcs import InputWarning, PlacementTest

    with pytest.warns(InputWarning, match="friction = 60"):
        PlacementTest(friction=60.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--time-step", "1e-12"], "time_step >= 3e-06 s"),
        (["--settle-time", "1e300"], "shorter settle_time"),
        (["--rows", "1000", "--columns", "1000"], "1000000 units"),
        (["--side", "1e-6"], "would pass through others"),
    ],
)
def test_settings_that_would_never_end_or_mean_nothing_are_refused_with_the_remedy(hlcs, options, words):
    status, text, errors = hlcs("place", "--layers", "1", *options)
    assert (status, text) == (2, "") and words in errors.splitlines()[-1]


# ------------------------------------------------------------------------------------------------------- files and folders
@pytest.mark.parametrize("file", ['"/etc/passwd"', '"../secret.csv"', '"link.csv"', '"down/../../secret.csv"'])
def test_files_outside_the_folder_are_refused_and_not_shown(hlcs, tmp_path, file):
    inside = tmp_path / "inside"
    (inside / "down").mkdir(parents=True)
    (tmp_path / "secret.csv").write_text("root:x:0:0\n")
    (inside / "link.csv").symlink_to(tmp_path / "secret.csv")
    experiment(inside, file=file)
    status, text, errors = hlcs("compare", "inside/e.toml")
    assert (status, text, errors.count("\n")) == (2, "", 1) and "root" not in errors
    assert "inside/e.toml, line 10" in errors and "--allow-outside" in errors


def test_files_outside_are_read_where_that_is_allowed(hlcs, tmp_path):
    from hlcs import compare

    (tmp_path / "inside").mkdir()
    experiment(tmp_path / "inside", file='"../a.csv"')
    (tmp_path / "a.csv").write_text(fall())
    assert hlcs("compare", "inside/e.toml", "--allow-outside")[0] == 0
    assert compare(tmp_path / "inside" / "e.toml", allow_outside=True).title == "x"
    with pytest.raises(InputError, match="outside the folder"):
        compare(tmp_path / "inside" / "e.toml")


def test_a_survey_outside_the_folder_is_refused_in_a_file_and_read_from_the_command_line(hlcs, tmp_path):
    bed = "x_m,y_m,z_m\n" + "".join(f"{x},{y},0\n" for x in (-9, 0, 9) for y in (-9, 0, 9))
    (tmp_path / "bed.csv").write_text(bed)
    (tmp_path / "inside").mkdir()
    file = tmp_path / "inside" / "t.toml"
    for text, command in (
        ("[placement]\nlayers = 1\nrows = 2\ncolumns = 2\nbottom = '../bed.csv'\n", "place"),
        ("[placement]\nlayers = 1\nrows = 2\ncolumns = 2\n[sweep]\nbottom = ['../bed.csv']\n", "sweep"),
    ):
        file.write_text(text)
        status, _, errors = hlcs(command, "inside/t.toml")
        assert status == 2 and "outside the folder" in errors and errors.count("\n") == 1
        assert hlcs(command, "inside/t.toml", "--allow-outside")[0] == 0
    assert hlcs(*SMALL, "--bottom", "bed.csv")[0] == 0


def test_help_says_that_effects_files_are_run(hlcs):
    for command in ("compare", "diagnose"):
        assert "run as code" in " ".join(hlcs(command, "--help")[1].split())


def test_a_number_that_runs_over_inside_a_library_is_no_second_line_of_a_refusal(hlcs, tmp_path):
    rows = "".join(f"{k / 50:.2f},{1e285 * (1 + k) ** 2:.6e}\n" for k in range(30))
    experiment(tmp_path, recording=f"t_s,z_m\n{rows}")
    status, _, errors = hlcs("compare", "e.toml")
    assert status == 2 and errors.count("\n") == 1 and "column z_m" in errors and "overflow" not in errors
