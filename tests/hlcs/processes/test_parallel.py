"""Independent runs in several processes: order, complaints, and an end that leaves nobody behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from hlcs import InputError
from hlcs.processes import parallel

SLEEPERS = """
import os, time
from pathlib import Path
from hlcs.processes import parallel

def sleep(folder):
    (Path(folder) / str(os.getpid())).touch()
    time.sleep(60)

if __name__ == "__main__":
    list(parallel.each(sleep, [{folder!r}] * 2, workers=2))
"""


def alive(pid):
    """Whether a process runs (one that ended and was not fetched does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (OSError, IndexError):
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks processes up in /proc")
@pytest.mark.parametrize("blow", [signal.SIGKILL, signal.SIGTERM])
def test_workers_end_with_the_process_that_started_them(tmp_path, blow):
    """kill -9 cannot be answered: the workers must notice by themselves."""
    folder = tmp_path / "pids"
    folder.mkdir()
    script = tmp_path / "sleepers.py"
    script.write_text(SLEEPERS.format(folder=str(folder)))
    process = subprocess.Popen([sys.executable, str(script)], env=os.environ | {"PYTHONPATH": os.getcwd()})
    wait(lambda: len(list(folder.iterdir())) == 2)
    process.send_signal(blow)
    process.wait(timeout=300)
    pids = [int(path.name) for path in folder.iterdir()]
    wait(lambda: not any(alive(pid) for pid in pids))


def wait(condition, longest=60.0):
    """Until the condition holds; fails when it does not in time."""
    end = time.monotonic() + longest
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def test_results_keep_their_order_and_complaints_come_through():
    assert parallel.in_order(abs, [-1, -2, -3], workers=2) == [1, 2, 3]
    with pytest.raises(TypeError):
        list(parallel.each(abs, ["text", "text"], workers=2))
    with pytest.raises(InputError, match="workers"):
        list(parallel.each(abs, [1], workers=0))


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
@pytest.mark.parametrize(
    ("end", "words"),
    [("os.kill(os.getpid(), 9)", ["was killed (signal 9)", "fewer workers"]), ("os._exit(3)", ["ended with status 3"])],
)
def test_a_worker_that_is_gone_is_not_blamed_on_the_script(tmp_path, end, words):
    script = tmp_path / "careful.py"
    script.write_text(
        f"import os\nfrom hlcs.processes import parallel\ndef work(number):\n    {end}\n"
        'if __name__ == "__main__":\n    list(parallel.each(work, [1, 2], workers=2))\n'
    )
    environment = os.environ | {"PYTHONPATH": os.getcwd()}
    done = subprocess.run([sys.executable, str(script)], env=environment, capture_output=True, text=True)
    last = done.stderr.strip().splitlines()[-1]
    assert done.returncode == 1 and last.startswith("minibullet.errors.RunError: a worker process")
    assert all(word in last for word in words) and "__main__" not in last


FIRST = [((1, 3), "status 3"), ((1, -15), "status 1"), ((1, -9, -15), "signal 9"), ((-15,), "signal 15")]


@pytest.mark.parametrize(("codes", "word"), FIRST)
def test_the_worker_that_went_first_is_told_of(codes, word):
    """The others are ended by the pool, or lose their pipe to it as they start, which is status 1."""
    assert word in str(parallel._ended([SimpleNamespace(exitcode=code) for code in codes]))


def test_a_worker_whose_status_is_known_late_is_told_of():
    """Where the pool waits for it at the same time the operating system tells one of the two."""

    class Late:
        asked = 0

        @property
        def exitcode(self):
            self.asked += 1
            return -9 if self.asked > 3 else None

    assert "signal 9" in str(parallel._ended([SimpleNamespace(exitcode=-15), Late()]))


def test_tasks_are_drawn_when_a_worker_is_free_and_not_before():
    drawn, seen = [], []

    def tasks():
        for number in range(6):
            drawn.append(number)
            yield -number

    for index, value in parallel.each(abs, tasks(), workers=2, most=6):
        assert index == value and len(drawn) <= len(seen) + 2
        seen.append(value)
    assert sorted(seen) == drawn == list(range(6))


def test_a_script_without_a_main_guard_is_told_so_once(tmp_path):
    script = tmp_path / "careless.py"
    script.write_text("import math\nfrom hlcs.processes import parallel\nlist(parallel.each(math.sqrt, [1.0, 4.0], workers=2))\n")
    environment = os.environ | {"PYTHONPATH": os.getcwd()}
    done = subprocess.run([sys.executable, str(script)], env=environment, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("Traceback") == 1
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("minibullet.errors.InputError: a worker process ended") and "__main__" in last
