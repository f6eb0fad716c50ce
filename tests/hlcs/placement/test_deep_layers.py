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
