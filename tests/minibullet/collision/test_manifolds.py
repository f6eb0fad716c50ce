"""Contact points: on both surfaces, one normal where they overlap, never deeper than the bodies do, four a pair of faces."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb


def inside(body, point):
    """Signed distance of points (m, 3) to the planes of a one-piece body: largest over its faces, (m,)."""
    return ((point - body.position) @ scenes.normals(body).T - body.shape.pieces[0].offsets).max(axis=1)


def test_points_lie_on_both_surfaces_with_one_normal_and_the_right_depth(generator):
    """Random pairs that overlap by up to 4 % of their size: each point's two ends stand gap apart along its normal, those
    that overlap share one normal, the midpoint lies in both bodies to 1e-4 of the size, and no gap is below the true least
    depth but by the 1e-5 of the size by which an edge pair must beat a face. Points that wait beside crossed edges (gap >= 0)
    have their face's normal."""
    tried = 0
    for _ in range(150):
        world = mb.World()
        turns = mb.rotations.random(generator, 2)
        one = world.add(scenes.polytope(generator), density=1.0, orientation=turns[0])
        two = world.add(scenes.polytope(generator), density=1.0, orientation=turns[1], position=(1.2, 0.1, 0.0))
        while (apart := scenes.distance(scenes.corners(one), scenes.corners(two))) > 1e-3:
            two.position = two.position - (apart, 0.0, 0.0)
        two.position = two.position - (generator.uniform(2e-3, 2e-2), 0.0, 0.0)
        truth = scenes.axis_separation(one, two)
        if not -0.02 < truth < -1e-4:
            continue
        found = scenes.touch(world)
        tried += 1
        deep = found.normal[found.gap < 0.0]
        assert 1 <= len(deep) <= 4
        np.testing.assert_allclose(deep, np.tile(deep[0], (len(deep), 1)), atol=1e-12)
        np.testing.assert_allclose(found.on_b - found.on_a, found.gap[:, None] * found.normal, atol=1e-12)
        middle = 0.5 * (found.on_a + found.on_b)
        for body in (one, two):
            assert (inside(body, middle) <= 0.5 * np.abs(found.gap) + 1e-9).all()
        assert truth - 1e-5 * 0.5 <= found.gap.min() <= truth + 2e-3 * 0.5
    assert tried > 80


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.3, -0.2), (0.7, 0.6)])
def test_clipped_faces_span_the_common_area(angle, shift):
    """A box turned on another: the points are corners of the common polygon, found by brute force (corners of either square in
    the other, crossings of their sides); at most four of them, and each at gap 0."""
    world = mb.World()
    world.add(mb.Box(1, 1, 1), density=1.0)
    turn = np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
    world.add(mb.Box(1, 1, 1), density=1.0, position=(*shift, 1.0), orientation=turn)
    square = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    matrix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    other = square @ matrix.T + shift
    candidates = [p for p in square if (np.abs((p - shift) @ matrix) <= 0.5 + 1e-9).all()]
    candidates += [p for p in other if (np.abs(p) <= 0.5 + 1e-9).all()]
    for k in range(4):
        for m in range(4):
            p, u = square[k], square[(k + 1) % 4] - square[k]
            q, v = other[m], other[(m + 1) % 4] - other[m]
            cross = u[0] * v[1] - u[1] * v[0]
            if abs(cross) > 1e-12:
                s = ((q - p)[0] * v[1] - (q - p)[1] * v[0]) / cross
                t = ((q - p)[0] * u[1] - (q - p)[1] * u[0]) / cross
                if -1e-9 <= s <= 1 + 1e-9 and -1e-9 <= t <= 1 + 1e-9:
                    candidates.append(p + s * u)
    found = scenes.touch(world)
    assert 3 <= len(found.gap) <= 4
    np.testing.assert_allclose(found.gap, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.normal, np.tile(found.normal[0], (len(found.gap), 1)), atol=1e-12)
    for point in found.on_a:
        assert min(np.linalg.norm(point[:2] - p) for p in candidates) < 1e-9
    assert len(np.unique(found.on_a.round(9), axis=0)) == len(found.gap)


def test_edges_that_cross_touch_at_one_point_between_them():
    """Two boxes on their edges, crossed: one contact, at the middle of the common perpendicular."""
    world = mb.World()
    half = 0.5 * np.sqrt(2.0)
    about_x = np.array([np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0])
    about_y = np.array([np.cos(np.pi / 8), 0, np.sin(np.pi / 8), 0])
    world.add(mb.Box(1, 1, 1), density=1.0, orientation=about_x)
    world.add(mb.Box(1, 1, 1), density=1.0, position=(0.1, 0.2, 2 * half + 1e-3), orientation=about_y)
    found = scenes.touch(world)
    assert len(found.gap) == 1
    assert found.gap[0] == pytest.approx(1e-3, abs=1e-12)
    np.testing.assert_allclose(0.5 * (found.on_a + found.on_b)[0], (0.1, 0.0, half + 5e-4), atol=1e-12)


def test_parallel_capsules_touch_at_both_ends_of_their_common_length():
    """Cores from -0.5 to 0.5 and from -0.2 to 0.8: contacts at x = -0.2 and 0.5."""
    world = mb.World()
    world.add(mb.Capsule(0.1, 1.0), density=1.0)
    world.add(mb.Capsule(0.1, 1.0), density=1.0, position=(0.3, 0.0, 0.2))
    found = scenes.touch(world)
    assert sorted(found.on_a[:, 0]) == pytest.approx([-0.2, 0.5], abs=1e-12)
    np.testing.assert_allclose(found.gap, 0.0, atol=1e-12)


def test_margins_of_both_bodies_are_taken_off_the_gap():
    """Margins 0.02 and 0.03 on boxes 0.1 apart: every contact has gap 0.05, and its ends stand as far apart."""
    world = mb.World()
    world.add(mb.Box(1, 1, 1), density=1.0, margin=0.02)
    world.add(mb.Box(1, 1, 1), density=1.0, margin=0.03, position=(0, 0, 1.1))
    found = scenes.touch(world, 0.1)
    np.testing.assert_allclose(found.gap, 0.05, atol=1e-12)
    np.testing.assert_allclose(found.on_b - found.on_a, 0.05 * found.normal, atol=1e-12)


def test_impulses_start_where_they_ended():
    """Warm start: a box at rest finds last step's impulse at each contact, so the second step needs at most two sweeps."""
    world = mb.World([mb.Gravity(10.0)])
    world.add_plane()
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5))
    world.step(10)
    assert world.last_step.contacts.load.sum() == pytest.approx(10.0, rel=1e-7)
    assert world.last_step.iterations <= 2


@pytest.mark.parametrize("speed", [2.0, 5.6, 20.0])
def test_a_flat_box_stands_on_its_lower_corners_however_fast_it_slides(speed):
    """In a step of 1/240 s at 5 m/s a box 4 cm high may move by its own height, which brings its upper corners within reach of
    the floor: they carry nothing, and it slows down by Coulomb's mu g."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.3))
    world.add_plane()
    box = world.add(mb.Box(0.1, 0.1, 0.04), mass=0.3, position=(0.0, 0.0, 0.02), velocity=(speed, 0.0, 0.0))
    world.step(24)
    assert len(world.contacts) == 4 and box.position[2] == pytest.approx(0.02, abs=1e-9)
    assert box.velocity == pytest.approx([speed - 0.3 * 9.81 * 0.1, 0.0, 0.0], abs=1e-9)
