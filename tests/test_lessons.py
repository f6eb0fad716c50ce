"""The lessons of the course: each has its parts, its code runs, its solutions hold, also in a fresh environment."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest

from hlcs import course
from hlcs.course import lesson_text

ROOT = Path(__file__).resolve().parent.parent
SLOW = {"06_what_is_missing", "09_cubipod_to_layers"}  # more than 10 s of processor time
LESSONS = [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in course.names()]
WIDEST = 110  # characters of a line of code: what a page of 1300 px shows without scrolling
EXECUTE = """
import pathlib, sys, time, nbformat, nbclient
path = pathlib.Path(sys.argv[1])
notebook, place = nbformat.read(path, as_version=4), {"metadata": {"path": str(path.parent)}}
began = time.time()
nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources=place).execute()
print(f"{time.time() - began:.1f}")
"""


def text_of(name):
    return (course.folder() / f"{name}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", course.names())
def test_a_lesson_has_a_goal_an_idea_a_picture_and_two_exercises_with_solutions(name):
    text, cells = text_of(name), lesson_text.cells(text_of(name))
    assert re.match(rf"{int(name[:2])}\. ", lesson_text.title(text))
    assert text.count("**Goal.**") == text.count("**Idea.**") == 1
    assert "What to look at" in text and "Common mistakes" in text
    pictures = sum("plt.subplots(" in cell.text for cell in cells if cell.is_code)
    assert pictures == (2 if name.startswith("02") else 1)  # the second lesson has two parts
    assert len(re.findall(r"^##+ Exercise \d: ", text, re.MULTILINE)) == 2
    solutions = [cell.text for cell in cells if cell.is_solution]
    assert len(solutions) == 2 and all("assert " in solution for solution in solutions)


@pytest.mark.parametrize("name", course.names())
def test_the_code_of_a_lesson_fits_a_page(name):
    lines = [line for cell in lesson_text.cells(text_of(name)) if cell.is_code for line in cell.text.splitlines()]
    assert not [line for line in lines if len(line) > WIDEST]


@pytest.mark.parametrize("name", LESSONS)
def test_a_lesson_runs_and_its_solutions_hold(name, monkeypatch, capsys):
    """All cells in their order in plain Python, in the folder of the lessons, as the pages and the notebooks run them."""
    matplotlib.use("Agg", force=True)
    monkeypatch.chdir(course.folder())
    names = {"__name__": name}
    for number, cell in enumerate((cell for cell in lesson_text.cells(text_of(name)) if cell.is_code), start=1):
        exec(compile(cell.text, f"{name}, cell {number}", "exec"), names)  # a page of this repository, not a user's file
    matplotlib.pyplot.close("all")


@pytest.mark.slow
@pytest.mark.oracle
def test_the_recorded_stack_is_what_pybullet_does(monkeypatch, tmp_path):
    """The script beside lesson 3, run again: the same table to the last digit that it prints, on the same version."""
    pytest.importorskip("pybullet")
    script = course.folder() / "stack_in_pybullet.py"
    subprocess.run([sys.executable, str(script)], cwd=tmp_path, check=True, capture_output=True)
    ours = script.with_suffix(".csv").read_text("utf-8")
    assert (tmp_path / "stack_in_pybullet.csv").read_text("utf-8") == ours


@pytest.mark.slow
def test_the_lessons_run_in_a_fresh_environment_with_the_extra_notebook_only(tmp_path):
    """A new environment, the wheel with its extra, `hlcs course copy`, and every notebook executed without a browser."""
    python = tmp_path / "env" / ("Scripts" if os.name == "nt" else "bin") / "python"
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}

    def run(*words, **others):
        finished = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, **others)
        assert finished.returncode == 0, finished.stdout + finished.stderr
        return finished.stdout

    run(sys.executable, "-m", "venv", str(tmp_path / "env"))
    run(str(python), "-m", "pip", "install", "-q", f"{ROOT}[notebook]")
    run(str(python), "-m", "hlcs", "course", "copy", "--out", "lessons", "--quiet")
    times = {}
    for path in sorted((tmp_path / "lessons").glob("*.ipynb")):
        times[path.stem] = float(run(str(python), "-c", EXECUTE, str(path), timeout=900).split()[-1])
    print(json.dumps(times, indent=1))
    assert tuple(times) == course.names()
