"""What Windows and macOS do differently, simulated: locked files, old consoles, what only POSIX has, names of folders."""

import io
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

from hlcs.cli import commands
from hlcs.files import folders
from minibullet import InputError, World

ROOT = Path(__file__).resolve().parents[2]
MISSING = ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty")  # modules that Windows does not have


def locked(name):
    """What Windows answers where another program holds the file open."""
    return PermissionError(13, "The process cannot access the file because it is being used by another process", str(name))


@pytest.mark.parametrize("call", ["rename", "replace"])
@pytest.mark.parametrize("first", [1, 2])
def test_a_locked_file_is_one_line_and_the_earlier_result_stays(tmp_path, monkeypatch, call, first):
    """The n-th rename is refused, once: a folder and a file are the earlier ones or the new ones, whole; a new folder that its
    place refused stands beside, and nothing else does; the complaint is an InputError of one line that names the place."""
    with folders.result_folder(tmp_path / "out") as partial:
        (partial / "a.txt").write_text("old")
    folders.write_text(tmp_path / "one.txt", "old")
    World().save(tmp_path / "world.npz")
    real, count = getattr(os, call), []

    def refuses(source, target, **options):
        count.append(1)
        if len(count) == first:
            raise locked(source)
        return real(source, target, **options)

    def folder():
        with folders.result_folder(tmp_path / "out") as partial:
            (partial / "a.txt").write_text("new")

    for write in (folder, lambda: folders.write_text(tmp_path / "one.txt", "new"), lambda: World().save(tmp_path / "world.npz")):
        with monkeypatch.context() as patch:
            count.clear()
            patch.setattr(os, call, refuses)
            try:
                write()
            except InputError as problem:
                assert "\n" not in str(problem) and tmp_path.name in str(problem)
                refused = True
            else:
                refused = False
            assert refused == (len(count) >= first)
    assert (tmp_path / "out" / "a.txt").read_text() in ("old", "new") and (tmp_path / "one.txt").read_text() in ("old", "new")
    assert World.load(tmp_path / "world.npz").steps == 0
    beside = sorted({entry.name for entry in tmp_path.iterdir()} - {"one.txt", "out", "world.npz"})
    assert beside in ([], ["out-2"]) and all((tmp_path / name / "a.txt").read_text() == "new" for name in beside)


def every_command(group=commands.commands, words=()):
    """The words of every command and group: (), ("demo",), ("mystery", "list"), ..."""
    yield words
    for name, command in getattr(group, "commands", {}).items():
        yield from every_command(command, (*words, name))


@pytest.mark.parametrize("encoding", ["cp1252", "cp437", "ascii"])
def test_every_help_and_list_can_be_shown_by_an_old_console(monkeypatch, tmp_path, encoding):
    """All help texts, the list of mysteries and a complaint, into a stream that refuses what its encoding lacks."""
    monkeypatch.chdir(tmp_path)
    lines = [(*words, "--help") for words in every_command()]
    lines += [("mystery", "list"), ("--version",), ("place", "--friction", "-1")]
    assert len(lines) > 12
    for arguments in lines:
        streams = [io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors="strict") for _ in range(2)]
        monkeypatch.setattr(sys, "stdout", streams[0])
        monkeypatch.setattr(sys, "stderr", streams[1])
        status = commands.main(list(arguments))
        for stream in streams:
            stream.flush()
        monkeypatch.undo()
        monkeypatch.chdir(tmp_path)
        assert status == (2 if "-1" in arguments else 0), arguments
        assert any(stream.buffer.getvalue() for stream in streams), arguments


SHORT = """
import builtins, os, signal, sys
def without(name, *rest, real=builtins.__import__):
    if name.split(".")[0] in {missing}:
        caller = sys._getframe(1).f_globals.get("__name__", "")
        if caller.split(".")[0] in ("hlcs", "minibullet"):
            raise ModuleNotFoundError(name)
    return real(name, *rest)
builtins.__import__ = without
# other packages look for themselves which system they are on; they did so long ago
import concurrent.futures.process, multiprocessing.process, tempfile, sqlite3
import click, fcl, matplotlib.figure, numba, numpy, pandas, scipy.optimize, scipy.sparse.linalg, scipy.stats, tqdm, trimesh
for module, names in ((os, ("sched_getaffinity", "getuid", "geteuid", "fork", "chown", "mkfifo", "nice", "statvfs", "uname")),
                      (signal, ("setitimer", "getitimer", "SIGALRM", "SIGPROF", "ITIMER_PROF", "ITIMER_REAL", "SIGKILL", "alarm",
                                "SIGUSR1", "SIGHUP", "pthread_sigmask"))):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
import pkgutil, importlib, hlcs, minibullet
for package in (hlcs, minibullet):
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
from hlcs.cli import commands as cli
from hlcs.placement import single_run
from hlcs.processes import parallel
assert parallel.cores() >= 1
with single_run.at_most(1.0):
    pass
sys.exit(cli.main(["place", "--layers", "1", "--rows", "2", "--columns", "2", "--out", "out"]))
"""


def test_without_what_only_posix_has(tmp_path):
    """No module of both packages needs `fcntl`, `resource`, timers or affinities: all are imported, and a test is placed."""
    finished = subprocess.run([sys.executable, "-c", SHORT.replace("{missing}", repr(MISSING))], cwd=tmp_path, text=True,
                              capture_output=True, env={**os.environ, "PYTHONPATH": str(ROOT)}, timeout=300)  # fmt: skip
    assert finished.returncode == 0, finished.stderr
    assert (tmp_path / "out" / "layers.csv").is_file()


def test_no_process_is_asked_after_where_asking_would_kill(monkeypatch):
    """`os.kill(pid, 0)` ends a process on Windows: there nobody asks, and what a run left half written counts as its own."""
    monkeypatch.setattr(folders, "os", SimpleNamespace(name="nt", kill=lambda *_: pytest.fail("a process was asked")))
    assert folders.runs(4711)


@pytest.mark.parametrize("name", ["with spaces", "Übergröße", "a'b", "100 %"])
def test_names_with_spaces_and_umlauts(tmp_path, monkeypatch, name):
    """From a folder of such a name into another: the settings that a run wrote repeat it."""
    (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / name)
    size = ["--layers", "1", "--rows", "2", "--columns", "2", "--quiet"]
    assert commands.main(["place", *size, "--out", f"{name} 1"]) == 0
    assert commands.main(["place", str(Path(f"{name} 1") / "settings.toml"), "--quiet", "--out", f"{name} 2"]) == 0
    poses = [(Path(f"{name} {k}") / "layers.csv").read_bytes() for k in (1, 2)]
    assert poses[0] == poses[1]
    assert tomllib.loads((Path(f"{name} 1") / "settings.toml").read_text(encoding="utf-8"))
