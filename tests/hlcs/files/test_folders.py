"""Files appear whole or not at all, and other people's files are never touched."""

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from hlcs.files import folders
from minibullet.errors import InputError, RunError


def names(folder):
    return sorted(entry.name for entry in folder.iterdir())


def test_folder_appears_only_when_complete(tmp_path):
    with folders.result_folder(tmp_path / "deep" / "out") as folder:
        (folder / "result.json").write_text("{}")
        assert not (tmp_path / "deep" / "out").exists()
    assert names(tmp_path / "deep") == ["out"] and names(tmp_path / "deep" / "out") == [folders.CONTENTS, "result.json"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_failed_or_interrupted_run_leaves_the_old_result(tmp_path, error):
    with folders.result_folder(tmp_path / "out") as folder:
        (folder / "result.json").write_text("old")
    with pytest.raises(error), folders.result_folder(tmp_path / "out") as folder:
        (folder / "result.json").write_text("new")
        raise error
    assert names(tmp_path) == ["out"] and (tmp_path / "out" / "result.json").read_text() == "old"


def test_a_second_run_replaces_the_first_and_keeps_nothing_of_it(tmp_path):
    for name in ("first.csv", "second.csv"):
        with folders.result_folder(tmp_path / "out") as folder:
            (folder / name).write_text(name)
    assert names(tmp_path / "out") == [folders.CONTENTS, "second.csv"] and names(tmp_path) == ["out"]


def test_folder_of_others_is_refused_before_any_work(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match="'thesis.tex'"), folders.result_folder(tmp_path):
        pytest.fail("the work must not start")
    with folders.result_folder(tmp_path / "out") as folder:
        (folder / "result.json").write_text("{}")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="'notes.txt'"), folders.result_folder(tmp_path / "out"):
        pytest.fail("the work must not start")
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(InputError, match="is a file"), folders.result_folder(tmp_path / "out"):
        pytest.fail("the work must not start")
    with pytest.raises(InputError, match="cannot write"), folders.result_folder(tmp_path / "out" / "below"):
        pytest.fail("the work must not start")
    with pytest.raises(InputError, match="cannot write"):
        folders.write_text(tmp_path / "out" / "result.json", "")


def earlier(tmp_path):
    """A folder with an earlier result: two files, one in a folder of its own."""
    with folders.result_folder(tmp_path / "out") as folder:
        (folder / "layers.csv").write_text("k\n1.298\n")
        (folder / "more").mkdir()
        (folder / "more" / "result.json").write_text("{}")
    return tmp_path / "out"


def replaced(out):
    with folders.result_folder(out) as folder:
        (folder / "new.csv").write_text("new")


def everything(folder):
    """{name: what it is} of all that is in a folder, links not followed."""
    return {
        path.relative_to(folder).as_posix(): os.readlink(path)
        if path.is_symlink()
        else path.read_bytes()
        if path.is_file()
        else None
        for path in folder.rglob("*")
    }


def linked(out, name):
    """What was in the folder is now elsewhere, with a link to it in its place."""
    (out / name).rename(out.parent / "moved")
    (out / name).symlink_to(os.path.join("..", "moved"))


FOREIGN = {
    "another file": lambda out: (out / "notes.txt").write_text("mine"),
    "a file in a folder of ours": lambda out: (out / "more" / "notes.txt").write_text("mine"),
    "an edited file": lambda out: (out / "layers.csv").write_text("k\n1.300 my correction\n"),
    "an edit of the same length": lambda out: (out / "layers.csv").write_text("k\n1.299\n"),
    "a file of the same name": lambda out: (out / "more" / "result.json").write_text("my own"),
    "an empty folder": lambda out: (out / "mine").mkdir(),
    "a folder in a file's place": lambda out: ((out / "layers.csv").unlink(), (out / "layers.csv").mkdir()),
    "a link in a file's place": lambda out: linked(out, "layers.csv"),
    "a link to a folder": lambda out: (out / "link").symlink_to(out.parent),
    "a folder of ours moved and linked": lambda out: linked(out, "more"),
    "no list": lambda out: (out / folders.CONTENTS).unlink(),
    "somebody else's list": lambda out: (out / folders.CONTENTS).write_text("[settings]\ncolour = red\n"),
    "the list of an earlier version": lambda out: (out / folders.CONTENTS).write_text("layers.csv\nmore\n"),
    "a list that is a link": lambda out: linked(out, folders.CONTENTS),
    "a list that is a folder": lambda out: ((out / folders.CONTENTS).unlink(), (out / folders.CONTENTS).mkdir()),
}


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
@pytest.mark.parametrize("meddle", FOREIGN.values(), ids=FOREIGN)
def test_only_what_is_as_it_was_written_is_replaced(tmp_path, meddle):
    out = earlier(tmp_path)
    meddle(out)
    before = everything(tmp_path)
    with pytest.raises(InputError, match="no earlier result as this program wrote it"), folders.result_folder(out):
        pytest.fail("the work must not start")
    assert everything(tmp_path) == before


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
@pytest.mark.parametrize("meddle", FOREIGN.values(), ids=FOREIGN)
def test_what_comes_while_the_work_is_done_stays_and_the_result_goes_beside(tmp_path, meddle):
    out = earlier(tmp_path)
    with pytest.raises(InputError, match="the result is in '.*out-2'"), folders.result_folder(out) as folder:
        (folder / "new.csv").write_text("new")
        meddle(out)
        before = everything(out)
    assert everything(out) == before and names(tmp_path / "out-2") == [folders.CONTENTS, "new.csv"]
    assert not [name for name in names(tmp_path) if name.startswith(".")]


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_a_link_to_a_folder_stays_and_its_folder_is_replaced(tmp_path):
    out, link = earlier(tmp_path), tmp_path / "link"
    link.symlink_to("out")
    replaced(link)
    assert link.is_symlink() and names(out) == [folders.CONTENTS, "new.csv"] and names(tmp_path) == ["link", "out"]
    (tmp_path / "nothing").symlink_to("gone")
    for use in (replaced, folders.check_folder):
        with pytest.raises(InputError, match="is a link to 'gone', which is not there"):
            use(tmp_path / "nothing")


def test_files_saved_beside_others_replace_their_own_alone(tmp_path):
    (tmp_path / "drop.toml").write_text("mine")
    for round in ("first", "second"):
        folders.save_files(tmp_path, {"report.html": round.encode(), "result.json": b"{}"})
        assert (tmp_path / "report.html").read_text() == round and (tmp_path / "drop.toml").read_text() == "mine"
    (tmp_path / "report.html").write_text("my own report")
    before = everything(tmp_path)
    with pytest.raises(InputError, match="holds 'report.html', which is not as.*the result is in") as refusal:
        folders.save_files(tmp_path, {"report.html": b"third", "result.json": b"{}"})
    spare = Path(str(refusal.value).rsplit("'", 2)[1])
    assert everything(tmp_path) == before and (spare / "report.html").read_text() == "third"
    replaced(spare)  # what was kept elsewhere is a result as any other


@pytest.mark.parametrize("last", range(4))
def test_a_run_killed_while_it_replaces_files_knows_its_own_again(tmp_path, monkeypatch, last):
    folders.save_files(tmp_path, {"a": b"old", "b": b"old"})
    write, count = folders.write_bytes, []

    def killed(path, data):
        count.append(path)
        if len(count) == last + 1:
            raise KeyboardInterrupt
        write(path, data)

    monkeypatch.setattr(folders, "write_bytes", killed)
    with pytest.raises(KeyboardInterrupt):
        folders.save_files(tmp_path, {"a": b"newer", "b": b"newer"})
    monkeypatch.undo()
    folders.save_files(tmp_path, {"a": b"newest", "b": b"newest"})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes() == b"newest"


@pytest.mark.parametrize("elsewhere", [True, False])
@pytest.mark.parametrize(
    ("number", "kind"),
    [
        (errno.ENOSPC, RunError),
        (errno.EIO, RunError),
        (errno.EMFILE, RunError),
        (errno.EROFS, InputError),
        (errno.EACCES, InputError),
    ],
)
def test_a_disk_that_refuses_at_the_end_loses_nothing(tmp_path, monkeypatch, number, kind, elsewhere):
    """Whether the name or the system is at fault: what was computed stands in another place, or is handed over to be printed."""

    def refuse(source, target):
        if not elsewhere or "hlcs-" not in str(source):
            raise OSError(number, os.strerror(number), str(source))
        rename(source, target)

    rename = os.replace
    monkeypatch.setattr(os, "replace", refuse)
    (tmp_path / "spare").mkdir()
    monkeypatch.setattr(folders.tempfile, "tempdir", str(tmp_path / "spare"))
    with pytest.raises(kind if elsewhere else RunError, match="cannot write '.*x.json': .*; the result is") as refusal:
        folders.write_json(tmp_path / "x.json", {"k": 1.0})
    if elsewhere:
        (found,) = (tmp_path / "spare").glob("*/x.json")
        assert str(found.parent) in str(refusal.value) and json.loads(found.read_text()) == {"k": 1.0}
    else:
        assert json.loads(refusal.value.result) == {"k": 1.0}
    assert names(tmp_path) == ["spare"] and len(names(tmp_path / "spare")) == elsewhere


@pytest.mark.skipif(os.name != "posix", reason="asks the system for processes by number")
def test_a_run_killed_between_its_two_renames_gives_the_old_result_back(tmp_path):
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    before = everything(earlier(tmp_path))
    (tmp_path / "out").rename(tmp_path / f".out.{gone.pid}.0badcafe.old")
    with pytest.raises(RuntimeError), folders.result_folder(tmp_path / "out"):
        raise RuntimeError
    assert names(tmp_path) == ["out"] and everything(tmp_path / "out") == before


@pytest.mark.skipif(sys.platform != "linux", reason="needs a place where not even the superuser may write")
def test_place_that_takes_no_files_is_refused():
    with pytest.raises(InputError, match="cannot write '/proc/out'"), folders.result_folder("/proc/out"):
        pytest.fail("the work must not start")


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_killed_process_leaves_no_result(tmp_path):
    """kill -9 in the middle of a run: no folder under the final name."""
    script = (
        "import os, signal\nfrom hlcs.files import folders\nwith folders.result_folder('out') as folder:\n"
        "    (folder / 'result.json').write_text('{')\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(folders.__file__).parents[2])}
    finished = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment)
    assert finished.returncode == -signal.SIGKILL and not (tmp_path / "out").exists()


@pytest.mark.skipif(os.name != "posix", reason="asks the system for processes by number")
def test_what_a_killed_run_left_is_cleared_by_the_next_one(tmp_path):
    """kill -9 cannot clean up; a run that still works keeps its folder."""
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    dead, alive = (tmp_path / f".out.{process}.0badcafe.partial" for process in (gone.pid, os.getpid()))
    others = tmp_path / f".thesis.{gone.pid}.0badcafe.partial"
    for folder in (dead, alive, others):
        folder.mkdir()
    with folders.result_folder(tmp_path / "out"):
        assert not dead.exists() and alive.exists() and others.exists()


@pytest.mark.parametrize("name", [".", "..", "../../out"])
def test_the_current_folder_is_not_replaced_under_who_stands_in_it(tmp_path, monkeypatch, name):
    """What is replaced is another folder of the same name: a shell in the old one sees nothing of the result."""
    here = tmp_path / "out" / "below"
    here.mkdir(parents=True)
    monkeypatch.chdir(here)
    with pytest.raises(InputError, match="the current folder"), folders.result_folder(name):
        pytest.fail("the work began")
    assert here.samefile(".")
