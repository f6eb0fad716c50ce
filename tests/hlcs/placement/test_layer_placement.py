"""Placing one layer of units."""

import numpy as np

import minibullet as mb
from hlcs.placement.layer_placement import shake


def test_shaking_leaves_no_speed_of_its_own():
    """Jumps in turn, the first and the last of half the size: without friction a body ends as slow as it was, where it was."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.0))
    world.add_plane()
    box = world.add(mb.Box(1.0, 1.0, 1.0), density=2300.0, position=(0.0, 0.0, 0.5))
    farthest = []
    shake(world, [box], 0.3, 1.0)
    farthest.append(abs(box.position[0]))
    assert np.linalg.norm(box.velocity) < 1e-9
    # a jump of a / (pi f) for half a period: 0.3 g / (pi f) / (2 f) = 12 mm is the farthest it ever goes
    assert max(farthest) < 0.3 * 9.81 / (np.pi * 39.24) / 2 + 1e-6
