"""The rules of the house that tools can check: style, the order of the rooms, the length of a file."""

import ast
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


# functions with more parameters than 8, or more lines than 60, and why
LONG = {
    "minibullet.world.World.add": "public: every property of a body has its name, most of them a default",
    "minibullet.scene.records.body": "takes what World.add was given",
    "hlcs.cli.experiments.compare": "one parameter for every option of the command",
    "hlcs.cli.experiments.diagnose": "one parameter for every option of the command",
}


def functions(node, name):
    """Every function under a node of the syntax tree, with its full name."""
    for child in ast.iter_child_nodes(node):
        own = f"{name}.{child.name}" if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) else name
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield own, child
        yield from functions(child, own)


def test_functions_stay_short():
    """At most 60 lines, and 8 parameters besides self; what is on the list has a reason, and nothing stands there in vain."""
    long = set()
    for package in ("minibullet", "hlcs"):
        for path in (ROOT / package).rglob("*.py"):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for name, function in functions(ast.parse(path.read_text(encoding="utf-8")), module):
                given = function.args
                named = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
                if function.end_lineno - function.lineno >= 60 or len(named) - (named[:1] in (["self"], ["cls"])) > 8:
                    long.add(name)
    assert long == set(LONG)
