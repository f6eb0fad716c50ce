"""The pages on reliability and security say what is true: the tests that they name exist, their limits are the program's, and no
module does what they rule out."""

import ast
import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = {name: (ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("reliability.md", "security.md")}
MODULES = sorted(path for package in ("minibullet", "hlcs") for path in (ROOT / package).rglob("*.py"))


@pytest.mark.parametrize("page", PAGES)
def test_every_test_that_the_page_names_exists(page):
    """Each `tests/...py::test_name` is defined in that file."""
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGES[page])
    assert len(named) > 5 and PAGES[page].count("::test_") == len(named)  # none that the pattern overlooks
    missing = [
        f"{path}::{name}"
        for path, name in named
        if not (ROOT / path).is_file() or not re.search(rf"^def {name}\(", (ROOT / path).read_text("utf-8"), re.M)
    ]
    assert not missing


def test_every_test_that_continuous_integration_names_exists():
    """`.ci/run` names files and folders of tests; one that has moved would end it before a test has run."""
    named = re.findall(r"(?<![\w/])tests/[\w/.]+", (ROOT / ".ci" / "run").read_text(encoding="utf-8"))
    assert len(named) > 5 and not [path for path in named if not (ROOT / path).exists()]


def test_every_promise_names_its_test():
    """A row of the tables of promises that names no test says so: `not tested`, or `the same test`."""
    text = PAGES["reliability.md"]
    rows = [
        line
        for section in ("## The same bits", "## What survives", "## Windows and macOS")
        for line in text.split(section)[1].split("\n## ")[0].splitlines()
        if line.startswith("| ")
    ]
    silent = [row for row in rows if not re.search(r"::test_|not tested|the same test|\| test \|", row)]
    assert len(rows) > 20 and not silent


def test_limits_on_the_page_are_those_of_the_program():
    """`module.NAME`, with an index or a key, has the value beside it; no limit is typed in the page alone."""
    rows = re.findall(r"^\| [^|]+ \| (\d+) \| `([\w.]+)\.(\w+)([^`]*)` \|$", PAGES["reliability.md"], re.M)
    section = PAGES["reliability.md"].split("## Limits")[1].split("\n## ")[0]
    assert len(rows) == section.count("\n| ") - 1 > 5  # every row but the heading
    wrong = {}
    for value, module, name, places in rows:
        found = getattr(import_module(module), name)
        for key, index in re.findall(r'\["(\w+)"\]|\[(\d+)\]', places):
            found = found[key or int(index)]
        if found != int(value):
            wrong[f"{module}.{name}{places}"] = (int(value), found)
    assert not wrong


def calls(path):
    """Names of all functions that a file calls, as they are written: `exec`, `np.load`."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}


def imports(path):
    """Top-level names of all modules that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add(node.module.split(".")[0])
    return found


def where(found, wanted):
    """The files, relative to the checkout, that have any of what is wanted: {file: what}."""
    return {path.relative_to(ROOT).as_posix(): both for path in MODULES if (both := found(path) & wanted)}


def test_only_effects_files_are_executed():
    """One `exec` in both packages, in the reader of effects files; no `eval`, no pickle and nothing built on it."""
    assert where(calls, {"exec", "eval", "__import__"}) == {"minibullet/effects/catalogue.py": {"exec"}}
    assert not where(imports, {"pickle", "dill", "cloudpickle", "shelve", "marshal", "joblib", "yaml", "runpy", "code"})
    assert not where(calls, {"np.load", "np.lib.format.read_array"})  # `files.arrays` reads arrays from bytes
    assert not where(calls, {"pd.read_pickle", "np.fromregex", "pd.eval", "pd.read_hdf"})


def test_no_module_speaks_to_the_network():
    """No module that opens a connection is imported; Dask by the sweep alone, where the user gives an address."""
    network = {"socket", "ssl", "urllib", "http", "ftplib", "smtplib", "xmlrpc", "socketserver", "requests", "httpx", "aiohttp",
               "asyncio", "webbrowser", "telnetlib", "urllib3"}  # fmt: skip
    assert not where(imports, network)
    assert set(where(imports, {"dask", "distributed"})) == {"hlcs/processes/parallel.py"}


def test_no_module_starts_other_programs():
    """No subprocess, no shell; workers come from multiprocessing, which starts Python."""
    assert not where(imports, {"subprocess", "pty", "pexpect"})
    assert not where(calls, {"os.system", "os.popen", "os.startfile", "os.execv", "os.execvp", "os.spawnv", "os.fork"})
