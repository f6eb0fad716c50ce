"""Units hung over a layer: free of overlaps, at the height asked for, each with the side down that was drawn."""

import numpy as np
import pytest

import minibullet as mb
from hlcs.placement import hanging
from hlcs.placement.grids import RPG
from hlcs.placement.units import Cubipod
from minibullet import rotations

UNIT, ROWS, LOWEST = Cubipod(side=1.0), 5, 3.0
CENTRES = RPG.centres(ROWS, ROWS, 1) * UNIT.nominal_diameter
LOAD = {"shape": UNIT.pieces, "density": 2300.0}


def hung(crowding, world=None):
    """A layer of 25 units on the rectangular grid, hung in an empty world."""
    world = world or mb.World()
    lowest = np.full(len(CENTRES), LOWEST)
    return world, hanging.hang_layer(world, 2, LOAD, CENTRES, lowest, np.random.default_rng(3), crowding=crowding)


def downwards(orientation):
    """The direction of the unit's own axes that points down."""
    return -rotations.matrix(orientation)[2]


@pytest.mark.parametrize("crowding", ["turn", "redraw"])
def test_units_find_room_at_the_height_asked_for(crowding):
    """No overlap, no lift, and the lowest corner of each where it was asked for, to rounding (1e-12 of some metres)."""
    world, layer = hung(crowding)
    assert not world.overlaps() and not layer.lifts.any()
    for handle in layer.handles:
        corners = np.concatenate([piece.vertices for piece in handle.shape.pieces]) @ rotations.matrix(handle.orientation).T
        assert handle.position[2] + corners[:, 2].min() == pytest.approx(LOWEST, abs=1e-11)


def test_turning_keeps_the_side_that_is_down():
    """A turn about the vertical leaves the downward direction in the unit as it was drawn (to rounding of some hundred turns):
    all but the units that are told to be redrawn, and these are few."""
    _, layer = hung("turn")
    generator = np.random.default_rng(3)
    drawn = [rotations.random(generator, 1)[0] for _ in CENTRES]
    off = [np.abs(downwards(o) - downwards(handle.orientation)).max() for o, handle in zip(drawn, layer.handles, strict=True)]
    assert sum(angle > 1e-9 for angle in off) == layer.redrawn <= 0.2 * len(drawn)
    turned = [not np.allclose(o, handle.orientation) for o, handle in zip(drawn, layer.handles, strict=True)]
    assert sum(turned) > layer.redrawn


def test_lifted_units_keep_the_orientation_that_was_drawn():
    world, layer = hung("lift")
    generator = np.random.default_rng(3)
    drawn = np.array([rotations.random(generator, 1)[0] for _ in CENTRES])
    kept = [handle.orientation for handle in layer.handles]
    np.testing.assert_allclose(kept, drawn, rtol=0.0, atol=1e-15)  # the engine makes them of unit length once more
    assert layer.redrawn == 0 and (layer.lifts > 0).sum() > 5 and not world.overlaps()


def test_a_unit_over_a_post_is_lifted_over_it():
    """No heading helps over a post as thin as a finger that ends half a metre above the lowest point asked for."""
    world = mb.World()
    world.add(mb.Box(0.1, 0.1, 2.0), density=1.0, position=(*CENTRES[12], LOWEST - 0.5), fixed=True)
    _, layer = hung("turn", world)
    assert not world.overlaps() and np.flatnonzero(layer.lifts).tolist() == [12]
    assert 0.3 < layer.lifts[12] < 0.7  # a corner may dip beside the post's end; steps, and tries of other headings, on top


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_unit_whose_aim_is_too_near_to_a_wall_hangs_beside_it(side):
    """A wall at x = 0 and an aim 0.5 Dn from it, nearer than the half width of any Cubipod: no turn and no lift frees it."""
    world = mb.World()
    world.add_plane((side, 0.0, 0.0), 0.0)
    aim = np.array([[0.5 * side * UNIT.nominal_diameter, 0.0]])
    layer = hanging.hang_layer(world, 2, LOAD, aim, np.array([LOWEST]), np.random.default_rng(3))
    (handle,) = layer.handles
    assert not world.overlaps() and layer.lifts[0] < 0.2 * UNIT.nominal_diameter
    corners = np.concatenate([piece.vertices for piece in handle.shape.pieces]) @ rotations.matrix(handle.orientation).T
    assert np.min(side * (handle.position[0] + corners[:, 0])) == pytest.approx(0.0, abs=2e-3)  # it touches the wall
