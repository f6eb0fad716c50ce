"""The tour's walk along the arrows of a step runs as printed, with the values it promises; its core is as short as it says."""

import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
TOUR, PACKAGE = ROOT / "docs" / "tour.md", ROOT / "minibullet"
MOST_LINES = 2000  # of the core, docstrings and comments included: what can be read in one evening


def test_every_arrow_of_the_tour_can_be_printed():
    """The code block of docs/tour.md, run; the numbers in its comments by hand: m g, g dt, mu g dt."""
    block = re.search(r"```python\n(.+?)```", TOUR.read_text(encoding="utf-8"), re.DOTALL).group(1)
    scope = {}
    exec(block, scope)  # a page of this repository, not a user's file
    step = scope["step"]
    assert len(step.wrenches) == 1 and step.wrenches[0][1, 2] == pytest.approx(-19.62)
    assert len(step.contacts.gap) == 4 and set(step.law.friction) == {0.6}
    assert step.problem.free_twist[1, 2] == pytest.approx(-9.81 / 240)
    np.testing.assert_array_equal(step.problem.target, 0.0)
    assert scope["W"].shape == (12, 12) and scope["q"].shape == (12,)
    assert scope["bound"][1] == pytest.approx(2.0 / 240, rel=1e-3) and len(scope["cache"].gap) == 1
    assert step.problem.factors.inverse_mass[1, 0, 0] == 0.5 and step.problem.factors.jacobian.shape == (4, 2, 3, 6)
    assert len(step.points.gap) == 4 and not step.points.impulse.any() and np.all(step.impact_impulse == 0.0)
    assert step.after.twist[1, 0] == pytest.approx(1.0 - 0.6 * 9.81 / 240, rel=1e-8)
    assert step.residual <= 1e-8 and set(step.work) >= {"gravity", "contact_normal", "contact_friction"}


def section(title):
    """The rows of the table under a heading of the tour, without its own heading."""
    text = TOUR.read_text(encoding="utf-8").split(f"## {title}\n")[1].split("\n## ")[0]
    return [line for line in text.splitlines() if line.startswith("| ")][1:]


def core():
    """The core files as the tour lists them: path below minibullet, and lines as printed."""
    rows = [
        re.fullmatch(r"\| \d+ \| `([\w/]+\.py)` \| about (\d+) \| .+ \|", row) for row in section("The core, in reading order")
    ]
    return {row.group(1): int(row.group(2)) for row in rows}


def test_the_core_can_be_read_in_one_evening():
    """All core files together have at most 2,000 lines, and each has as many as the tour prints, to ten."""
    lines = {path: len((PACKAGE / path).read_text(encoding="utf-8").splitlines()) for path in core()}
    assert len(lines) == 16 and sum(lines.values()) <= MOST_LINES, lines
    wrong = {path: (printed, lines[path]) for path, printed in core().items() if abs(printed - lines[path]) > 10}
    assert not wrong, f"(printed, counted): {wrong}"


def test_every_module_is_core_or_beside_the_road():
    """No module is missing from the tour, none is in both tables, and what the tables name exists."""
    beside = set()
    for place in re.findall(r"`([\w/]+(?:/|\.py))`", "\n".join(row.split("|")[1] for row in section("Beside the road"))):
        assert (PACKAGE / place).exists(), place
        beside |= set((PACKAGE / place).glob("*.py")) if place.endswith("/") else {PACKAGE / place}
    marked = {PACKAGE / path for path in core()}
    assert not marked & beside
    assert marked | beside >= {path for path in PACKAGE.rglob("*.py") if path.name != "__init__.py"}


def test_every_arrow_is_labelled_with_a_module():
    """The drawing of the step names modules and rooms of minibullet, none that was renamed."""
    drawing = re.search(r"```text\n(.+?)```", TOUR.read_text(encoding="utf-8"), re.DOTALL).group(1)
    named = set(re.findall(r"─ (\w+) ─", drawing))
    modules = {path.stem for path in PACKAGE.rglob("*.py")} | {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert len(named) >= 10 and named <= modules
