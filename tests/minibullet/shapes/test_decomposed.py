"""A solid that weighs what its surface encloses and touches as its pieces: an L of two boxes, by hand."""

import numpy as np
import pytest

import minibullet as mb
from minibullet.shapes import polyhedra
from minibullet.shapes.decomposed import DecomposedSolid


def box(low, high):
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return mb.ConvexPiece(np.array(low) + corners * (np.array(high) - low))


def part(piece):
    return piece.vertices, polyhedra.triangles_of(piece.faces)


FOOT, STEM = box((0, 0, 0), (2, 1, 1)), box((0, 0, 1), (1, 1, 2))


def test_an_l_weighs_what_its_boxes_weigh():
    """Volumes 2 and 1 with centres (1, .5, .5) and (.5, .5, 1.5): V = 3, centre (5/6, 1/2, 5/6). About x: the boxes' own
    2 (1+1)/12 and 1 (1+1)/12, and 2 (1/3)^2 and 1 (2/3)^2 of the parallel axes: 1/2 + 2/3."""
    solid = DecomposedSolid((part(FOOT), part(STEM)), (FOOT, STEM))
    assert solid.volume == pytest.approx(3.0, rel=1e-14) and solid.volume_error == pytest.approx(0.0, abs=1e-14)
    np.testing.assert_allclose(solid.centre_of_mass, (5 / 6, 1 / 2, 5 / 6), rtol=1e-14)
    assert solid.inertia[0, 0] == pytest.approx(1 / 2 + 2 / 3, rel=1e-13)
    np.testing.assert_allclose(solid.inertia, mb.Compound((FOOT, STEM)).inertia, rtol=1e-12, atol=1e-14)
    assert solid.bounding_radius == pytest.approx(np.sqrt((7 / 6) ** 2 + 1 / 4 + (5 / 6) ** 2), rel=1e-14)


def test_coarse_pieces_touch_and_weigh_nothing():
    """One hull in place of two boxes: it fills the notch between the corners (2, 1) and (1, 2), half a square, with 1/2 more."""
    hull = mb.ConvexPiece(np.concatenate([FOOT.vertices, STEM.vertices]))
    solid = DecomposedSolid((part(FOOT), part(STEM)), (hull,))
    assert solid.volume == pytest.approx(3.0, rel=1e-14) and solid.volume_error == pytest.approx(1 / 6, rel=1e-12)
    assert len(solid.pieces) == 1 and solid.surface_area == pytest.approx(hull.surface_area, rel=1e-14)


def test_a_body_rests_on_its_pieces_with_the_weight_of_its_surface():
    """The L on a floor: its centre at 5/6 m, and the floor bears 3 m3 of it, m g dt each step."""
    world = mb.World(mb.Gravity(9.81), mb.Settings(friction=0.5))
    world.add_plane()
    body = world.add(DecomposedSolid((part(FOOT), part(STEM)), (FOOT, STEM)), density=1000.0, position=(0.0, 0.0, 5 / 6))
    assert body.mass == pytest.approx(3000.0, rel=1e-14)
    assert world.settle(2.0) == "at_rest"
    assert body.position[2] == pytest.approx(5 / 6, abs=1e-6)
    assert world.last_step.impulse[:, 2].sum() == pytest.approx(3000.0 * 9.81 / 240, rel=1e-3)


@pytest.mark.parametrize("parts, hulls", [((), (FOOT,)), ((part(FOOT),), ())])
def test_nothing_is_no_solid(parts, hulls):
    with pytest.raises(mb.InputError, match="no parts or no pieces"):
        DecomposedSolid(parts, hulls)
