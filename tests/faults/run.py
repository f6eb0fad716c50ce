"""Fault injection into whole commands: `python -m tests.faults.run [--scene NAME] [--mode MODE] [--every N]`.

Every trial starts from an earlier result in the folders it writes to, runs the command with one fault, and is then judged: the
exit status and one line; the old or a whole new result under every name; nothing half done left behind; what was computed is
somewhere, and the message says where; the store opens; the same command, run again without a fault, ends well.
"""

import argparse
import contextlib
import importlib
import io
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from hlcs import PlacementTest
from hlcs.cli import commands
from hlcs.files import folders
from hlcs.placement import run_store
from hlcs.placement.run_store import key_of
from hlcs.placement.settings_table import settings_of
from tests.faults.injection import MODES, REMOVALS, Faults

SMALL = {"layers": 2, "rows": 3, "columns": 3}
INPUTS = {
    "sweep.toml": "[placement]\nlayers = 2\nrows = 3\ncolumns = 3\n[sweep]\nseed = [1, 2]\n",
    "layers.toml": 'kind = "layers"\n[placement]\nrows = 3\ncolumns = 3\n[measurement]\nfile = "layers.csv"\n',
    "layers.csv": "grid,spacing_x,spacing_y,bottom_slope,layer,mean,cv,tests,campaign\n"
    "TPG,1.5,1.3,0.0,1,1.298,0.004,5,a\nTPG,1.5,1.3,0.0,2,1.080,0.02,5,a\n",
    "drop.toml": 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[[trial]]\nfile = "drop.csv"\n',
    "drop.csv": "t_s,z_m\n" + "".join(f"{t:.2f},{2 - 4.9 * t * t + 0.001 * np.sin(1e4 * t):.5f}\n" for t in np.arange(40) / 100),
}
SCENES = {
    "demo": ["demo", "--out", "out", "--json", "result.json"],
    "sweep": ["sweep", "sweep.toml", "--workers", "1", "--store", "runs.sqlite", "--out", "out", "--json", "result.json"],
    "diagnosis": [
        "diagnose",
        "drop.toml",
        "--candidates",
        "quadratic_drag",
        "--out",
        "out",
        "--plots",
        "plots",
        "--json",
        "result.json",
    ],
    "layers": ["compare", "layers.toml", "--workers", "1", "--out", "out", "--json", "result.json"],
}
WRITTEN = ("out", "plots", "result.json")


@contextlib.contextmanager
def physics():
    """What is computed is computed once and then handed out: neither physics nor pictures are what is tested.

    Yields the list of what was asked for.
    """
    kept, asked, stack = {}, [], contextlib.ExitStack()

    def once(module, name, key):
        owner = importlib.import_module(module) if isinstance(module, str) else module
        real = getattr(owner, name)

        def found(*values, **words):
            asked.append(name)
            known = name, key(*values)
            if known not in kept:
                kept[known] = real(*values, **words)
            return kept[known]

        setattr(owner, name, found)
        stack.callback(setattr, owner, name, real)

    with stack:
        stack.callback(setattr, run_store, "LATE", run_store.LATE)
        run_store.LATE = 0.0  # who failed to let go of a claim is this very process; in life it would be no more by the next run
        run = PlacementTest.run
        stack.callback(setattr, PlacementTest, "run", run)
        PlacementTest.run = lambda test, progress=None: run(test if test.rows < 8 else PlacementTest(**SMALL))
        once(PlacementTest, "run", lambda test, progress=None: key_of(settings_of(test)))
        once("hlcs.cli.experiments", "diagnose_file", lambda *values: None)
        once("hlcs.report.page", "png", lambda *values: None)
        once("hlcs.report.comparison", "png", lambda *values: None)
        once("hlcs.report.diagnosis", "pictures", lambda *values: None)
        once("hlcs.report.diagnosis", "diagnosis_panels", lambda *values: None)
        once("hlcs.placement.report", "report_page", lambda result: result.test)
        once("minibullet.report.drawing", "render", lambda *values: None)
        yield asked


class Scene:
    """One command, tried again and again in a folder of its own."""

    def __init__(self, name, asked):
        self.arguments, self.asked = SCENES[name], asked
        self.folder = Path(tempfile.mkdtemp(prefix="faults-"))
        self.work, self.spare, self.start = self.folder / "work", self.folder / "spare", self.folder / "start"
        self.work.mkdir()
        ended = subprocess.Popen([sys.executable, "-c", ""])
        ended.wait()
        self.gone = ended.pid
        for file, text in INPUTS.items():
            (self.work / file).write_text(text)
        status, _, err, _ = self.run()
        assert status == 0, err
        self.whole = {name: self.read(name) for name in WRITTEN if (self.work / name).exists()}
        for file in self.work.glob("*.sqlite"):
            file.unlink()
        shutil.copytree(self.work, self.start)

    def points(self):
        """How many there are."""
        self.reset()
        faults = Faults(self.folder)
        self.run(faults)
        return faults.count

    def trial(self, at, mode):
        """(what failed, a list of what is wrong afterwards)."""
        self.reset()
        faults = Faults(self.folder, at, mode)
        if mode == "killed":
            child = os.fork()
            if child == 0:
                self.run(faults)
                os._exit(0)
            killed = os.waitpid(child, 0)[1]
            return "kill -9", [*self.wrong_files(killed=True), *self.wrong_next(), *([] if killed else ["it was not killed"])]
        status, out, err, computed = self.run(faults)
        left = self.set_aside() if (faults.what or "").split(" ")[0] in REMOVALS else []
        wrong = self.wrong_files()
        if status == 0:
            old = [name for name in self.whole if not self.newer(name)]
            wrong += [f"status 0, but {old} are old"] * bool(old) + [f"status 0, stderr {err!r}"] * bool(err)
        elif status != 1 or err.count("\n") != 1 or not err.startswith("hlcs: "):
            wrong.append(f"status {status}, stderr {err!r}")
        elif computed and not self.somewhere(err, out):
            wrong.append(f"what was computed is lost: {err!r}")
        for path in left:
            (self.folder / path.name).rename(path)
        return faults.what, [*wrong, *self.wrong_next()]

    def run(self, faults=None):
        """(status, stdout, stderr, whether anything was computed) of the command."""
        self.spare.mkdir(exist_ok=True)
        before = os.getcwd(), tempfile.tempdir, os.environ.get("HLCS_CACHE")
        os.chdir(self.work)
        tempfile.tempdir, os.environ["HLCS_CACHE"] = str(self.spare), str(self.work)
        self.asked.clear()
        try:
            with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
                with faults or contextlib.nullcontext():
                    try:
                        status = commands.main(self.arguments)
                    except BaseException as problem:
                        status = f"{type(problem).__name__}: {problem}"
        finally:
            os.chdir(before[0])
            tempfile.tempdir = before[1]
            os.environ.pop("HLCS_CACHE") if before[2] is None else os.environ.update(HLCS_CACHE=before[2])
        return status, out.getvalue(), err.getvalue(), bool({"run", "diagnose_file"} & set(self.asked))

    def reset(self):
        """As after an earlier run, without its store."""
        for folder in (self.work, self.spare):
            shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.start, self.work)

    def read(self, name):
        """What tells whether a result is whole: the names in a folder whose list holds, or the keys of a JSON file."""
        path = self.work / name
        if path.is_dir():
            foreign = folders._foreign(path)
            return f"not as written: {foreign}" if foreign else sorted(entry.name for entry in path.iterdir())
        return sorted(json.loads(path.read_text())) if path.exists() else None

    def newer(self, name):
        """Whether a result is of the last run."""
        path = self.work / name
        path = path / folders.CONTENTS if path.is_dir() else path
        return path.stat().st_mtime_ns > (self.start / path.relative_to(self.work)).stat().st_mtime_ns

    def set_aside(self):
        """Move away what could not be removed, for it is the fault itself; returns where it is to be put back, as of a process
        that is no more, which it will be when the next one runs."""
        left = []
        for path in self.hidden():
            path.rename(self.folder / (name := path.name.replace(f".{os.getpid()}.", f".{self.gone}.")))
            left.append(path.with_name(name))
        return left

    def wrong_files(self, killed=False):
        """What is wrong with the files that a run left. After kill -9 some may be missing, and hidden ones may lie about."""
        wrong, hidden = [], [path.name for path in self.hidden()]
        for name, whole in self.whole.items():
            if (not killed or (self.work / name).is_file()) and self.read(name) != whole:
                wrong.append(f"{name} is not whole: {self.read(name)}")
            elif killed and (self.work / name).is_dir() and folders._foreign(self.work / name) not in {None, *hidden}:
                wrong.append(f"{name} holds {folders._foreign(self.work / name)}")
        if hidden and not killed:
            wrong.append(f"left behind: {hidden}")
        for file in self.work.glob("*.sqlite"):
            with contextlib.closing(sqlite3.connect(file)) as connection:
                if connection.execute("PRAGMA integrity_check").fetchone()[0] != "ok":
                    wrong.append(f"{file.name} is damaged")
        return wrong

    def hidden(self):
        """What lies about under a name of its own: half a result, or one that stepped aside."""
        found = [path for path in self.work.rglob(".*") if path.name != folders.CONTENTS]
        return [path for path in found if not any(parent in found for parent in path.parents)]

    def wrong_next(self):
        """What is wrong with the same command, run again without a fault."""
        status, _, err, _ = self.run()
        found = {name: self.read(name) for name in self.whole}
        return [f"the next run: status {status}, {err!r}, {found}"] if status != 0 or found != self.whole else []

    def somewhere(self, err, out):
        """Whether what was computed is in a place that the message names, or printed, or in its own place already."""
        if "is printed" in err:
            return bool(json.loads(out[out.index("{") :]))
        if "runs are kept" in err:
            return True
        (place,) = re.findall(r"the result is in '([^']+)'", err) or [None]
        return place is not None and any(Path(place).iterdir())


def run(scene, modes=MODES, every=1):
    """Yield (mode, point, what failed, what is wrong) for every n-th point of a scene."""
    with physics() as asked:
        trials = Scene(scene, asked)
        try:
            points = trials.points()
            for mode in modes:
                for at in range(1, points + 1, every):
                    yield mode, at, *trials.trial(at, mode)
        finally:
            shutil.rmtree(trials.folder)


def main():
    """All points of all scenes; exit status 1 where one did not survive."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", choices=SCENES, action="append")
    parser.add_argument("--mode", choices=MODES, action="append")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--all", action="store_true", help="print every point, not only those that did not survive")
    options = parser.parse_args()
    modes = [mode for mode in options.mode or MODES if mode != "killed" or hasattr(os, "fork")]
    lost = 0
    for scene in options.scene or SCENES:
        counts = dict.fromkeys(modes, 0)
        bad = dict.fromkeys(modes, 0)
        for mode, at, what, wrong in run(scene, modes, options.every):
            counts[mode] += 1
            bad[mode] += bool(wrong)
            if wrong or options.all:
                print(f"{scene}, {mode}, point {at} ({what}): {'; '.join(wrong) or 'survived'}")
        print(f"{scene}: " + ", ".join(f"{mode} {counts[mode]} points, {bad[mode]} not survived" for mode in modes), flush=True)
        lost += sum(bad.values())
    return int(lost > 0)


if __name__ == "__main__":
    raise SystemExit(main())
