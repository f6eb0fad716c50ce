"""What the engine asks of effects, and the names they go by."""

import numpy as np
import pytest

from minibullet import effects
from minibullet.bodies import Bodies
from minibullet.effects.samples import sample_bodies


@pytest.mark.parametrize("fixed", [[1, 4], [0, 1, 6]], ids=["scattered", "at the ends"])
def test_fixed_bodies_feel_nothing_and_ask_nothing(fixed):
    """wrench and added_mass: rows of fixed bodies are 0, those of moving ones as without the fixed."""
    bodies = sample_bodies()
    mass = bodies.mass.copy()
    mass[fixed] = np.inf
    some = bodies._replace(mass=mass)
    moving = np.isfinite(mass)
    for effect in (effects.Gravity(), effects.LinearDrag(1.0)):
        wrench = effects.wrench(effect, some, 0.0)
        assert not wrench[~moving].any() and np.array_equal(wrench[moving], effect.forces(bodies, 0.0)[moving])
    added = effects.added_mass([effects.AddedMass(0.5)], some)
    assert not added[~moving].any() and added[2, 0, 0] == 0.5 * 1000.0 * bodies.volume[2]
    assert effects.added_mass([effects.Gravity()], some) is None
    nothing = Bodies(*(array[:0] for array in bodies))
    assert effects.wrench(effects.Gravity(), nothing, 0.0).shape == (0, 6)


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (effects.VelocityDependentRestitution, "velocity_dependent_restitution"),
        (type("MyDrag", (), {}), "my_drag"),
        (type("FCLDrag", (), {}), "fcl_drag"),
    ],
)
def test_names_are_snake_case(kind, name):
    assert effects.name_of(kind) == name
