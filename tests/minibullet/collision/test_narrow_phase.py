"""Separation and normal of two convex pieces, against brute force: the distance program where they are apart, all
separating axes where they overlap."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb


def test_separation_of_pieces_apart_is_their_distance(generator):
    """Never more than the distance; less by at most 0.2 % of the piece's size, by which a corner must beat faces and edges, and
    as much again for directions that FCL found on hulls inset by 1 %."""
    tried = 0
    for _ in range(60):
        world, one, two = scenes.random_pair(generator, 0.7, 1.3)
        truth = scenes.distance(scenes.corners(one), scenes.corners(two))
        if truth < 1e-6:
            continue
        tried += 1
        gap, normal = scenes.separation(world, one)
        assert truth - 4e-3 * 0.5 < gap < truth + 1e-9
        along = (scenes.corners(two) @ normal).min() - (scenes.corners(one) @ normal).max()
        assert along == pytest.approx(gap, abs=1e-12)  # the number belongs to the normal
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
    assert tried > 20


def test_separation_of_overlapping_pieces_is_the_least_depth(generator):
    """All face normals and edge pairs tried (the separating-axis theorem); faces are preferred by 1e-5 of the size."""
    tried = 0
    for _ in range(60):
        world, one, two = scenes.random_pair(generator, 0.2, 0.8)
        truth = scenes.axis_separation(one, two)
        if truth > -1e-4:
            continue
        tried += 1
        gap, normal = scenes.separation(world, one)
        assert truth - 1e-5 * 0.5 - 1e-12 < gap < truth + 1e-12
        assert gap < 0.0
    assert tried > 30


def test_aligned_touching_boxes_have_the_face_normal():
    """The case in which FCL itself gives bad normals."""
    world = mb.World()
    lower = world.add(mb.Box(1, 1, 1), density=1.0)
    world.add(mb.Box(1, 1, 1), density=1.0, position=(0.2, 0.1, 1.0))
    gap, normal = scenes.separation(world, lower)
    assert gap == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(normal, (0, 0, 1), atol=1e-15)


def test_coincident_bodies_have_a_depth_and_a_normal():
    """Two equal boxes in one place: overlap by their whole edge, along one of the axes."""
    world = mb.World()
    one = world.add(mb.Box(1, 1, 1), density=1.0)
    world.add(mb.Box(1, 1, 1), density=1.0)
    gap, normal = scenes.separation(world, one)
    assert gap == pytest.approx(-1.0, abs=1e-12) and np.abs(normal).max() == pytest.approx(1.0, abs=1e-12)
