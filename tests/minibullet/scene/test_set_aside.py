"""Bodies set aside and brought back: the motion of the others keeps every bit, and what cannot be says so."""

import numpy as np
import pytest

import minibullet as mb


def test_set_aside_and_brought_back_is_as_if_never_gone():
    """A block slides on fixed boxes; one far away is set aside half-way and brought back: every bit of the motion is the same."""

    def slide(change):
        world = mb.World(mb.Gravity(9.81), mb.Settings(friction=0.3))
        far = world.add(mb.Box(1.0, 1.0, 1.0), position=(-20.0, 0.0, 0.5), fixed=True, name="far")
        world.add_plane()
        for x in range(4):
            world.add(mb.Box(1.0, 1.0, 1.0), position=(x, 0.0, 0.5), fixed=True)
        block = world.add(mb.Box(0.5, 0.5, 0.5), density=1000.0, position=(0.0, 0.0, 1.25), velocity=(2.0, 0.1, 0.0))
        world.step(20)
        if change:
            world.set_aside([far])
            np.testing.assert_array_equal(far.position, (-20.0, 0.0, 0.5))
        world.step(20)
        if change:
            world.bring_back([far])
        world.step(20)
        return np.concatenate([block.position, block.orientation, block.velocity, block.angular_velocity]), world

    (changed, world), (plain, _) = slide(True), slide(False)
    np.testing.assert_array_equal(changed, plain)
    assert sorted(handle.name for handle in world.bodies)[-1] == "far"


def test_what_cannot_be_set_aside_says_so(tmp_path):
    world = mb.World(mb.Gravity(9.81))
    moving = world.add(mb.Sphere(0.5), density=1000.0, position=(0.0, 0.0, 5.0))
    fixed = world.add(mb.Sphere(0.5), position=(0.0, 0.0, 1.0), fixed=True)
    with pytest.raises(mb.InputError, match="freeze it first"):
        world.set_aside([moving])
    with pytest.raises(mb.InputError, match="was not set aside"):
        world.bring_back([fixed])
    world.set_aside([fixed])
    with pytest.raises(mb.InputError, match="set aside: body 'body 1'|body 'body 1' is not a fixed body of this world"):
        world.set_aside([fixed])
    with pytest.raises(mb.InputError, match="1 bodies are set aside.*bring them back to save it"):
        world.save(tmp_path / "world.npz")
