"""Large structures: what is set aside changes no digit, and is there again when something falls on it."""

import numpy as np
import pytest

import minibullet as mb
from hlcs import PlacementTest
from hlcs.placement import deep_layers
from hlcs.placement.deep_layers import DeepLayers


def state(result):
    return np.concatenate([values.ravel() for values in (*result.poses, *result.readings)])


def test_setting_layers_aside_changes_no_digit(monkeypatch):
    """Four layers, with the first two set aside under the fourth, against all at hand: the order of what is left is the same, and
    so are the sums; nothing comes near to what is aside, so every bit agrees."""
    test = PlacementTest(grid="RPG", layers=4, rows=5, columns=5)
    asides, whole = [], test.run()
    monkeypatch.setattr(deep_layers.DeepLayers.__init__, "__defaults__", (0,))
    hold = DeepLayers._hold
    monkeypatch.setattr(DeepLayers, "_hold", lambda self, handles: (asides.append(len(handles)), hold(self, handles))[1])
    sparing = test.run()
    assert asides == [25]  # the first layer under the third and fourth; of RPG no unit falls
    np.testing.assert_array_equal(state(sparing), state(whole))


def test_a_body_that_falls_on_what_is_aside_lands_on_it():
    """Four fixed layers of boxes, the lower two set aside: a ball that falls past the flank is caught by the box it meets."""
    world = mb.World(mb.Gravity(9.81), mb.Settings(friction=0.5))
    world.add_plane()
    box = mb.Box(1.0, 1.0, 1.0)
    layers = [
        tuple(world.add(box, position=(x, 0.0, z + 0.5), fixed=True, name=f"{z}.{x}") for x in range(4 - z)) for z in range(4)
    ]
    deep = DeepLayers(world, at_hand=0)
    world.step()
    deep.set_aside(layers)
    assert len(world.bodies) == 3 and len(deep.aside) == 7
    ball = world.add(mb.Sphere(0.2), density=1000.0, position=(3.0, 0.0, 2.0))
    assert world.settle(5.0, watch=lambda world: deep.watch(2, world)) == "at_rest"
    assert ball.position[2] == pytest.approx(1.2, abs=1e-3)  # on the box of the first layer, not on the floor
    assert "0.3" in [handle.name for handle in world.bodies] and len(deep.aside) < 7


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
