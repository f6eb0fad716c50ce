"""The documentation builds without a warning, its notebooks run, and what it promises of the tables is in the tests."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("myst_nb") is None, reason="needs the extra 'docs'")
def test_documentation_builds_without_a_warning(tmp_path):
    """`sphinx-build -W`: every cross reference, docstring and notebook; minutes, because the notebooks are executed."""
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "-q",
        "-d",
        str(tmp_path / "trees"),
        "docs",
        str(tmp_path / "html"),
    ]
    finished = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stdout + finished.stderr


def test_errata_name_tests_that_exist():
    """Every `test_...` that the errata call as witness is defined in tests/paper."""
    named = set(re.findall(r"`(test_\w+)`", (ROOT / "docs" / "errata.md").read_text(encoding="utf-8")))
    defined = {
        name
        for path in (ROOT / "tests" / "paper").glob("*.py")
        for name in re.findall(r"def (test_\w+)", path.read_text(encoding="utf-8"))
    }
    assert named and named <= defined, named - defined


def test_readme_lines_are_the_ones_that_are_run():
    """The continuous integration takes the test line from the README; both lines begin from a bare Python and stand alone."""
    lines = [
        line for line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines() if line.startswith("python3 -m venv ")
    ]
    assert [line.rsplit(" && ", 1)[1] for line in lines] == [".venv/bin/hlcs demo --out out", ".venv/bin/python -m pytest -n 2"]
