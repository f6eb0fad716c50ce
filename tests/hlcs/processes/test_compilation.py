"""The engine is compiled ahead where nothing is compiled yet, and only there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hlcs.processes import compilation, parallel
from minibullet import kernels

SCRIPT = """
import os, pathlib
import hlcs
from hlcs.processes.compilation import compile_engine
def compiled():
    return sum(1 for _ in pathlib.Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nbc"))
if __name__ == "__main__":
    compile_engine()
    first = compiled()
    hlcs.PlacementTest(rows=4, columns=4, layers=2).run()
    print(first, compiled())
"""


def test_code_is_cold_until_a_kernel_is_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(kernels.numba.config, "DISABLE_JIT", 0)
    monkeypatch.setattr(kernels, "_folder", lambda chosen: str(tmp_path))
    assert kernels.cold()
    (tmp_path / "minibullet").mkdir()
    (tmp_path / "minibullet" / "kernel.nbi").write_bytes(b"")
    assert not kernels.cold()


def test_where_no_code_can_be_kept_kernels_run_without_and_the_remedy_is_told(tmp_path, monkeypatch):
    """As a user who may write neither beside the package nor at home: a file stands where the folder should be."""
    (tmp_path / "file").write_text("")
    with pytest.warns(UserWarning, match="set NUMBA_CACHE_DIR to a folder that you may write"):
        assert kernels._folder.__wrapped__(str(tmp_path / "file" / "cache")) == ""
    monkeypatch.setattr(kernels, "_folder", lambda chosen: "")
    assert kernels.kernel(lambda x: 2 * x)(21) == 42 and not kernels.cold()


def test_where_code_is_kept_nothing_is_compiled_and_nothing_said(monkeypatch, capsys):
    monkeypatch.setattr(kernels, "cold", lambda: False)
    monkeypatch.setattr(parallel, "each", lambda *_: pytest.fail("processes were started"))
    compilation.compile_engine()
    assert capsys.readouterr().err == ""


@pytest.mark.slow
@pytest.mark.skipif(parallel.cores() < 2, reason="on one core nothing is compiled ahead")
def test_two_parts_compile_nearly_all_that_a_placement_test_needs(tmp_path):
    """What is left to the first step is less than a tenth of the kernels; the line on standard error comes once."""
    (tmp_path / "script.py").write_text(SCRIPT)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path.cwd())}
    lines = []
    for _ in range(2):
        done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, env=environment, capture_output=True, text=True)
        lines.append(done.stderr)
        first, last = map(int, done.stdout.split())
        assert last - first < 0.1 * last
    assert "compiling the engine" in lines[0] and "compiling" not in lines[1]
