"""The separating-feature cache: what it knows agrees with a fresh search, is kept while it holds, and is found again."""

import numpy as np
import small_scenes as scenes

import minibullet as mb
from minibullet.collision import feature_cache


def test_pairs_keep_what_was_known_of_them_when_the_list_is_made_anew(generator):
    """Every field of a pair that was in the list is carried over, as a dictionary does; of a new one nothing is known."""
    old, new = (np.unique(generator.integers(0, 6, (300, 4)), axis=0) for _ in range(2))
    cache = feature_cache.unknown(old)
    for number, field in enumerate(cache[2:]):
        field[:] = (np.arange(len(old)) + 1000.0 * number).reshape(-1, *[1] * (field.ndim - 1))
    place, carried = {tuple(pair): k for k, pair in enumerate(old)}, feature_cache.carried_over(cache, new)
    fresh, seen = feature_cache.unknown(new), set()
    for k, pair in enumerate(new):
        known = tuple(pair) in place
        seen.add(known)
        for name in cache._fields:
            source, row = (cache, place[tuple(pair)]) if known else (fresh, k)
            np.testing.assert_array_equal(getattr(carried, name)[k], getattr(source, name)[row])
    assert seen == {True, False}


def test_cached_features_agree_with_fresh_ones_along_a_motion(generator):
    """A body turns and slides past another, from 0.1 m apart into overlap, in small moves. The cached gap never exceeds the true
    separation; it may lag behind by a share of the distance while bodies are far (it has only to keep them apart), and
    by 0.4 % of the size near touch, the freedom of a fresh search. FCL is asked at few of the moves."""
    moves = overlaps = 0
    for _ in range(5):
        world, one, two = scenes.random_pair(generator, 1.2, 1.2)
        scene, inward = world.registry.commit(), -two.position / 1.2
        two.position = two.position + inward * (scenes.distance(scenes.corners(one), scenes.corners(two)) - 0.1)
        sideways = np.cross(inward, generator.normal(size=3))
        sideways *= 1e-3 / np.linalg.norm(sideways)
        axis = generator.normal(size=3)
        turn = mb.rotations.exponential(4e-3 * axis / np.linalg.norm(axis))
        for _ in range(120):
            two.position = two.position + sideways + 2e-3 * inward
            two.orientation = mb.rotations.product(turn, two.orientation)
            scene.past_motion[two._row] = 3e-3 + 4e-3 * two.shape.bounding_radius  # what a step would say, in place of "void"
            cached, _ = scenes.separation(world, one, 0.3)
            truth = scenes.distance(scenes.corners(one), scenes.corners(two))
            truth = truth if truth > 1e-6 else scenes.axis_separation(one, two)
            assert cached <= truth + 1e-9
            assert cached >= truth - 0.25 * max(truth, 0.0) - 4e-3 * 0.5
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
    assert world.registry.scene.collision.calls - before < 60 * 0.1 * len(world.registry.scene.collision.cache.gap)
