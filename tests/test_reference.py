"""The reference pages: every effect has a picture that shows what its page says, every public name a page and an example."""

import importlib
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
