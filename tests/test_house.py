"""The rules of the house that tools can check: style, the order of the rooms, the length of a file."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def run_tool(name, *arguments):
    """Run a console tool of this environment in the checkout; skip where it is not installed."""
    tool = shutil.which(name, path=str(Path(sys.executable).parent)) or shutil.which(name)
    if tool is None:
        pytest.skip(f"{name} is not installed; it comes with the extra 'test'")
    finished = subprocess.run([tool, *arguments], cwd=ROOT, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stdout + finished.stderr


def test_style():
    """Ruff with the settings of pyproject.toml finds nothing, and has nothing to format."""
    run_tool("ruff", "check", "--no-cache", ".")
    run_tool("ruff", "format", "--check", "--no-cache", ".")


def test_every_arrow_points_one_way():
    """The import contracts of pyproject.toml hold: no cycles, physics below laboratory, numba and matplotlib in their rooms."""
    run_tool("lint-imports", "--no-cache")


def test_files_stay_readable():
    """A module of more than 400 lines wants to be two."""
    long = [
        f"{path.relative_to(ROOT)}: {lines}"
        for package in ("minibullet", "hlcs")
        for path in (ROOT / package).rglob("*.py")
        if (lines := len(path.read_text(encoding="utf-8").splitlines())) > 400
    ]
    assert not long, long
