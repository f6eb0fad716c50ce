"""Spheres and capsules: distances that a hand can work out."""

import pytest
import small_scenes as scenes

import minibullet as mb


@pytest.mark.parametrize(
    ("one", "two", "place", "expected"),
    [
        (mb.Sphere(0.3), mb.Sphere(0.2), (0.3, 0.4, 0.0), 0.0),
        (mb.Sphere(0.3), mb.Box(1.0, 1.0, 1.0), (1.0, 0.0, 0.0), 0.2),  # face
        (mb.Sphere(0.1), mb.Box(1.0, 1.0, 1.0), (0.8, 0.9, 0.0), 0.4),  # edge: 3-4-5
        (mb.Sphere(0.1), mb.Box(2.0, 2.0, 2.0), (2.0, 3.0, 3.0), 2.9),  # corner: 1-2-2
        (mb.Capsule(0.1, 1.0), mb.Capsule(0.1, 1.0), (1.3, 0.4, 0.0), 0.3),  # end on end: 3-4-5
        (mb.Capsule(0.1, 1.0), mb.Box(1.0, 1.0, 1.0), (0.2, 0.0, 0.7), 0.1),  # side on face
        (mb.Capsule(0.1, 1.0), mb.Box(1.0, 1.0, 1.0), (1.3, 0.9, 0.0), 0.4),  # end on edge: 3-4-5
    ],
)
def test_round_bodies_have_their_closed_forms(one, two, place, expected):
    """Distances of hand, to rounding; the search along a capsule for its nearest point ends within 1e-9 of its length."""
    world = mb.World()
    first = world.add(one, density=1.0)
    world.add(two, density=1.0, position=place)
    gap, _ = scenes.separation(world, first, 4.0)
    assert gap == pytest.approx(expected, abs=1e-9)
