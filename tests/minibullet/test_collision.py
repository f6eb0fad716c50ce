"""Separation and normal of two convex pieces, against brute force: the distance program where they are apart, all
separating axes where they overlap."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb


def random_pair(generator, low, high):
    """Two random polytopes at a random distance of centres, and their world."""
    world = mb.World()
    direction = generator.normal(size=3)
    direction *= generator.uniform(low, high) / np.linalg.norm(direction)
    turns = mb.rotations.random(generator, 2)
    one = world.add(scenes.polytope(generator), density=1.0, orientation=turns[0])
    two = world.add(scenes.polytope(generator), density=1.0, position=direction, orientation=turns[1])
    return world, one, two


def answer(world, one, reach=1.0):
    """The one row's separation and normal from ``one`` to the other body."""
    rows, numbers = scenes.look(world, reach)
    assert len(rows) == 1
    return numbers[0, 0], numbers[0, 6:9] if rows[0, 0] == one._row else -numbers[0, 6:9]


def test_separation_of_pieces_apart_is_their_distance(generator):
    """Never more than the distance; less by at most 0.2 % of the piece's size, by which a corner must beat faces and edges, and
    as much again for directions that FCL found on hulls inset by 1 %."""
    tried = 0
    for _ in range(60):
        world, one, two = random_pair(generator, 0.7, 1.3)
        truth = scenes.distance(scenes.corners(one), scenes.corners(two))
        if truth < 1e-6:
            continue
        tried += 1
        gap, normal = answer(world, one)
        assert truth - 4e-3 * 0.5 < gap < truth + 1e-9
        along = (scenes.corners(two) @ normal).min() - (scenes.corners(one) @ normal).max()
        assert along == pytest.approx(gap, abs=1e-12)  # the number belongs to the normal
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
    assert tried > 20


def test_separation_of_overlapping_pieces_is_the_least_depth(generator):
    """All face normals and edge pairs tried (the separating-axis theorem); faces are preferred by 1e-5 of the size."""
    tried = 0
    for _ in range(60):
        world, one, two = random_pair(generator, 0.2, 0.8)
        truth = scenes.axis_separation(one, two)
        if truth > -1e-4:
            continue
        tried += 1
        gap, normal = answer(world, one)
        assert truth - 1e-5 * 0.5 - 1e-12 < gap < truth + 1e-12
        assert gap < 0.0
    assert tried > 30


def test_kept_answers_agree_with_fresh_ones_along_a_motion(generator):
    """A body turns and slides past another, from 0.1 m apart into overlap, in small moves. The kept answer never exceeds the
    true separation; it may lag behind by a share of the distance while bodies are far (it has only to keep them apart), and
    by 0.4 % of the size near touch, the freedom of a fresh answer. FCL is asked at few of the moves."""
    moves = overlaps = 0
    for _ in range(5):
        world, one, two = random_pair(generator, 1.2, 1.2)
        scene, inward = world.registry.enrol(), -two.position / 1.2
        two.position = two.position + inward * (scenes.distance(scenes.corners(one), scenes.corners(two)) - 0.1)
        sideways = np.cross(inward, generator.normal(size=3))
        sideways *= 1e-3 / np.linalg.norm(sideways)
        axis = generator.normal(size=3)
        turn = mb.rotations.exponential(4e-3 * axis / np.linalg.norm(axis))
        for _ in range(120):
            two.position = two.position + sideways + 2e-3 * inward
            two.orientation = mb.rotations.product(turn, two.orientation)
            scene.moved[two._row] = 3e-3 + 4e-3 * two.shape.bounding_radius  # what a step would say, in place of "void"
            kept, _ = answer(world, one, 0.3)
            truth = scenes.distance(scenes.corners(one), scenes.corners(two))
            truth = truth if truth > 1e-6 else scenes.axis_separation(one, two)
            assert kept <= truth + 1e-9
            assert kept >= truth - 0.25 * max(truth, 0.0) - 4e-3 * 0.5
            moves, overlaps = moves + 1, overlaps + (truth < 0.0)
        assert scene.collision.calls < 0.2 * 120
    assert 0.1 * moves < overlaps < 0.9 * moves


def test_fcl_is_seldom_asked_by_a_pile_at_rest(generator):
    """Ten blocks fall into a heap; in the last 60 steps, when they lie, FCL is asked for less than one pair in ten a step."""
    world = mb.World([mb.Gravity()], mb.Settings(friction=0.6))
    world.add_plane()
    for k, turn in enumerate(mb.rotations.random(generator, 10)):
        world.add(mb.Box(0.3, 0.2, 0.1), density=2000.0, position=(0.1 * (k % 3), 0.1 * (k % 2), 0.2 + 0.3 * k), orientation=turn)
    world.step(540)
    before = world.registry.scene.collision.calls
    world.step(60)
    assert world.registry.scene.collision.calls - before < 60 * 0.1 * len(world.registry.scene.collision.rows)


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
    gap, _ = answer(world, first, 4.0)
    assert gap == pytest.approx(expected, abs=1e-9)


def test_aligned_touching_boxes_have_the_face_normal():
    """The case in which FCL itself gives bad normals."""
    world = mb.World()
    lower = world.add(mb.Box(1, 1, 1), density=1.0)
    world.add(mb.Box(1, 1, 1), density=1.0, position=(0.2, 0.1, 1.0))
    gap, normal = answer(world, lower)
    assert gap == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(normal, (0, 0, 1), atol=1e-15)


def test_coincident_bodies_have_a_depth_and_a_normal():
    """Two equal boxes in one place: overlap by their whole edge, along one of the axes."""
    world = mb.World()
    one = world.add(mb.Box(1, 1, 1), density=1.0)
    world.add(mb.Box(1, 1, 1), density=1.0)
    gap, normal = answer(world, one)
    assert gap == pytest.approx(-1.0, abs=1e-12) and np.abs(normal).max() == pytest.approx(1.0, abs=1e-12)
