"""docs/paper.md: every function, command and test that the page names exists; no equation, table or figure is left out."""

import re
from importlib import import_module
from pathlib import Path

import pytest

from hlcs.cli.commands import COMMANDS
from hlcs.cli.placement_options import CHOICES
from hlcs.paper.reproduce import TABLES
from hlcs.placement.presets import PAPER
from hlcs.placement.procedure import PlacementTest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
NAMES = sorted(set(re.findall(r"`((?:hlcs|minibullet)\.[\w.]+)`", PAGE)))


def section(title):
    """The rows of the table under a heading, their cells."""
    lines = PAGE.split(f"## {title}\n")[1].split("\n## ")[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")][1:]


@pytest.mark.parametrize("name", NAMES)
def test_every_function_on_the_page_exists(name):
    module, _, attribute = name.rpartition(".")
    assert hasattr(import_module(module), attribute)


def test_every_test_and_command_on_the_page_exists():
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)
    assert len(named) > 15 and PAGE.count("::test_") == len(named)
    missing = [test for path, test in named if not re.search(rf"^def {test}\(", (ROOT / path).read_text("utf-8"), re.M)]
    assert not missing
    for command, argument in re.findall(r"`hlcs (\w+) ?(\w+)?[^`]*`", PAGE):
        assert command in COMMANDS
        assert command != "reproduce" or not argument or argument in (*TABLES, "all")
    assert {"bullet", "per_step"} == set(CHOICES["damping_law"])


def test_no_equation_table_or_figure_is_left_out():
    """14 equations, 3 tables, 14 figures; each equation has a function and a test."""
    rows = section("Equations")
    assert [int(n) for row in rows for n in row[0].split(",")] == list(range(1, 15))
    assert all(re.search(r"`(hlcs|minibullet)\.", row[2]) and "::test_" in row[3] for row in rows)
    assert [row[0] for row in section("Tables")][:3] == ["1", "2", "3"]
    assert [int(row[0].split()[0]) for row in section("Figures")[:-1]] == list(range(1, 15))


def test_the_settings_on_the_page_are_those_of_the_program():
    rows = {row[0]: row[1:] for row in section("The paper's settings and ours")}
    default = PlacementTest()
    assert rows["contact friction"][:2] == [f"{PAPER['friction']:g}", f"{default.friction:g}"]
    assert rows["margin"][0].startswith(f"{PAPER['margin']:g} ") and PAPER["margin"] == PAPER["plate_margin"]
    assert rows["margin"][1] == f"{default.margin:g}"
    assert rows["plates"][0].startswith(", ".join(str(3 * row) for row in PAPER["plate_rows"]))
    assert rows["time step, iterations"][0] == f"1/{1 / PAPER['time_step']:.0f} s, {PAPER['iterations']}"
    assert rows["time step, iterations"][1] == f"1/{1 / default.time_step:.0f} s, at most {default.iterations}"
