"""The reference pages: every effect has a picture that shows what its page says, every public name a page and an example."""

import doctest
import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from hlcs.effects import classes

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def extension():
    """The modules in docs/_ext by name, as Sphinx imports them."""
    sys.path.insert(0, str(ROOT / "docs" / "_ext"))
    yield importlib.import_module
    sys.path.remove(str(ROOT / "docs" / "_ext"))


def test_every_effect_belongs_to_one_standard_experiment(extension):
    experiments = extension("standard_experiments").EXPERIMENTS
    named = [name for experiment in experiments for name in experiment.effects]
    assert sorted(named) == sorted(classes())


@pytest.mark.parametrize(
    ("name", "power"),
    [("quadratic_drag", 4), ("linear_drag", 3), ("buoyancy", 2), ("tilted_gravity", 2), ("magnus", 2), ("uniform_flow", 2)],
)
def test_a_residual_grows_as_the_law_says(extension, name, power):
    """From rest v = g t: a force as v^2, v^1, v^0 leaves a gap as t^4, t^3, t^2; a side force that is there at once, as t^2.

    Read between 0.05 s and 0.1 s, where the next term of each series is below a tenth: half a power apart is far from the next.
    """
    times, left, _ = extension("standard_experiments").residual(name)
    early = (times > 0.05) & (times < 0.1)
    slope = np.polyfit(np.log(times[early]), np.log(np.abs(left[early])), 1)[0]
    assert slope == pytest.approx(power, abs=0.1)


EXAMPLES = ROOT / "docs" / "reference" / "examples"


def names():
    """Full names of all public names, without the modules that are only rooms of names."""
    sys.path.insert(0, str(ROOT / "docs" / "_ext"))
    try:
        return importlib.import_module("api_pages").public_names()
    finally:
        sys.path.remove(str(ROOT / "docs" / "_ext"))


def test_every_public_name_has_a_page_with_an_example(extension, tmp_path):
    """And no example is left of a name that has gone."""
    api = extension("api_pages")
    pages = set(api.write(tmp_path))
    assert {f"{name}.md" for name in names()} <= pages
    assert {path.stem for path in EXAMPLES.glob("*.txt")} == set(names())
    assert all("## Example" in (tmp_path / f"{name}.md").read_text(encoding="utf-8") for name in names())


@pytest.mark.parametrize("name", sorted(names()))
def test_the_example_of_a_name_runs_and_prints_what_it_says(name):
    result = doctest.testfile(str(EXAMPLES / f"{name}.txt"), module_relative=False, encoding="utf-8")
    assert result.attempted > 0 and result.failed == 0


def takes_arguments():
    """Full name -> what is called, of public classes and functions and of the methods of a World; records are not called."""
    found = {name: value for name, value in names().items() if callable(value) and not name.startswith("hlcs.records.")}
    world = found["minibullet.World"]
    return found | {f"minibullet.World.{name}": getattr(world, name) for name in vars(world) if callable(getattr(world, name))
                    and not name.startswith("_")}  # fmt: skip


@pytest.mark.parametrize("name", sorted(takes_arguments()))
def test_every_argument_is_described_and_every_number_has_a_unit(extension, name):
    """A default with a point is a quantity, as is a tuple of them; a pure number has the unit "-"."""
    known = extension("api_pages").arguments(takes_arguments()[name])
    assert not [one.name for one in known if not one.about and one.default != "none"]
    assert not [one.name for one in known if re.match(r"\(?-?\d+(\.\d|e)", one.default) and not one.unit]
