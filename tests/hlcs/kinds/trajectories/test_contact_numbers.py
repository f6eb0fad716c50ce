"""What a model has at impacts stands beside what they show: its laws of contact, not the material as it was typed."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.impacts import Impact
from hlcs.data.recordings import Trial
from hlcs.kinds.trajectories.contact_numbers import numbers_at
from hlcs.simulation.model import Model

SPEEDS, SLIPS = np.array([4.0, 2.0, 1.0]), np.array([3.0, 2.0, 1.0])
IMPACTS = [Impact("a.csv", 0.0, v, 0.6, 0.01, slip, 0.5, 0.1) for v, slip in zip(SPEEDS, SLIPS, strict=True)]


def at_impacts(*effects, normal=(0.0, 0.0, 1.0)):
    none = np.full((1, 4), np.nan)
    around = Surroundings(floor_height=0.0, floor_normal=normal, restitution=0.6, friction=0.3, fluid_density=0.0)
    body = Body(shape="sphere", radius=0.05, mass=0.1)
    return numbers_at(IMPACTS, Model(fixed=effects), [Trial("a.csv", "1", np.zeros(1), none[:, :3], none, {}, body, around)])


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, 1.0, 0.0)])
def test_a_model_of_no_effects_has_what_is_stated_on_any_floor(normal):
    assert at_impacts(normal=normal) == pytest.approx({"restitution": 0.6, "friction": 0.3}, rel=1e-12)


def test_a_mended_model_has_the_numbers_of_its_effects():
    """One coefficient in place of another; e = e_1 v^-k and mu + slope v_t are means over the impacts, each at its own speed."""
    mended = at_impacts({"name": "restitution", "coefficient": 0.8}, {"name": "friction", "coefficient": 0.1})
    assert mended == pytest.approx({"restitution": 0.8, "friction": 0.1}, rel=1e-12)
    law = at_impacts(
        {"name": "velocity_dependent_restitution", "exponent": 0.1, "threshold": 0.0}, {"name": "viscous_friction", "slope": 0.05}
    )
    wanted = {"restitution": np.mean(0.6 * SPEEDS**-0.1), "friction": np.mean(0.3 + 0.05 * SLIPS)}
    assert law == pytest.approx(wanted, rel=1e-12)


def test_without_impacts_nothing_is_told():
    assert numbers_at((), Model(), []) == {}
