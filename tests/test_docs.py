"""The documentation builds without a warning, its notebooks run, and what it promises of the tables is in the tests."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

from hlcs.selection import thresholds

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


def pages_on_a_diagnosis():
    """The text of the page that tells the procedure, and of the one that has its details."""
    return [(ROOT / "docs" / "theory" / f"{name}.md").read_text(encoding="utf-8") for name in ("diagnosis", "diagnosis_details")]


def test_the_procedure_of_a_diagnosis_is_told_in_two_screens():
    """At most 1,000 words, what stands in formulas among them; its details have the same headings in the same order."""
    short, details = pages_on_a_diagnosis()
    assert len(re.findall(r"\S*\w\S*", short)) <= 1000
    headings = [re.findall(r"^## .+", text, re.MULTILINE) for text in (short, details)]
    assert headings[0] and headings[0] == headings[1]


def test_pages_on_a_diagnosis_name_every_threshold_with_its_value():
    """Each `NAME` = value is that of the table of thresholds, and none of the table is missing."""
    told = re.findall(r"`([A-Z_]+)` = (\d+(?:\.\d+)?)", "".join(pages_on_a_diagnosis()))
    known = {name: value for name, value in vars(thresholds).items() if name.isupper()}
    assert {name for name, _ in told} == known.keys()
    assert [(name, float(value)) for name, value in told] == [(name, known[name]) for name, _ in told]
