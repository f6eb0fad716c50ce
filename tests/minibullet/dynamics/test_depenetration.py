"""Overlap is undone without velocity."""

import numpy as np
import pytest

import minibullet as mb


def test_overlap_is_undone_without_velocity():
    """A box sunk 1 cm into the floor rises by 30 % of what is left in
    each step, down to 1e-9 of its size, and is never given a speed."""
    world = mb.World()
    world.add_plane()
    box = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.49))
    for k in range(1, 11):
        world.step()
        assert 0.5 - box.position[2] == pytest.approx(0.01 * 0.7**k, abs=1e-8)
        assert np.abs(box.velocity).max() < 1e-15
