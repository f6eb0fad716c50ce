"""The Cubipod's numbers (volume, diameter, rest) against closed formulas and the paper, and its poses against the floor."""

import dataclasses
from math import atan, cbrt, pi, sqrt

import numpy as np
import pytest

from hlcs.placement.units import Cube, Cubipod
from minibullet import rotations
from minibullet.errors import InputError
from minibullet.shapes import polyhedra

UNIT = Cubipod()
OTHER = Cubipod(protrusion_height=0.2, protrusion_base=0.6, protrusion_top=0.3)
DN = UNIT.nominal_diameter


# --- the solid


def test_volume_is_39_32_of_the_cube():
    assert UNIT.volume == 39 / 32
    assert UNIT.pieces.volume == pytest.approx(39 / 32, rel=1e-14)
    assert UNIT.hull.volume == pytest.approx(1.65625, rel=1e-14)
    assert UNIT.hull.volume / UNIT.volume == pytest.approx(1.359, abs=5e-4)


def test_nominal_diameters_of_the_paper():
    """Table 1 prints 0.53 and 1.07 m for L = 0.5 and 1 m; its 2.14 m belongs to L = 2 m."""
    assert [round(Cubipod(side=side).nominal_diameter, 2) for side in (0.5, 1.0, 2.0)] == [0.53, 1.07, 2.14]
    assert pytest.approx(1.0681647, abs=5e-8) == DN


def test_laboratory_unit():
    """Dn = 3.80 cm is L = 3.5575 cm."""
    unit = Cubipod(nominal_diameter=0.0380)
    assert unit.side == pytest.approx(0.035575, abs=5e-7)
    assert unit.nominal_diameter == pytest.approx(0.0380, rel=1e-15)


def test_mass_of_the_prototype():
    assert UNIT.mass() == pytest.approx(2803.1, abs=0.05)
    assert UNIT.mass(2300.0) == UNIT.mass()


def test_inertia_is_the_same_about_every_axis():
    inertia = UNIT.pieces.inertia / UNIT.volume
    np.testing.assert_allclose(inertia, 0.183440 * np.eye(3), atol=5e-7)
    assert inertia[0, 0] / DN**2 == pytest.approx(0.160775, abs=5e-7)


def test_pieces_are_a_cube_and_six_frusta_in_place():
    pieces = UNIT.pieces.pieces
    assert [len(piece.vertices) for piece in pieces] == [8] * 7
    assert [piece.volume for piece in pieces] == pytest.approx([1.0] + 6 * [7 / 192], rel=1e-14)
    np.testing.assert_allclose(UNIT.pieces.centre_of_mass, 0.0, atol=1e-16)
    assert max(np.abs(piece.vertices).max() for piece in pieces) == pytest.approx(0.75, rel=1e-15)  # tip to tip 1.5 L


def test_hull_has_six_tips_and_24_trapezoids():
    assert sorted(len(loop) for loop in UNIT.hull.faces) == [4] * 30
    for piece in UNIT.pieces.pieces:
        assert np.all(piece.vertices @ UNIT.hull.normals.T <= UNIT.hull.offsets + 1e-15)


def test_a_unit_scaled_by_a_power_of_two_is_the_same_unit():
    small = Cubipod(side=2.0**-5)
    assert small.first_layer_coefficient == UNIT.first_layer_coefficient
    np.testing.assert_array_equal(small.pieces.inertia, np.ldexp(UNIT.pieces.inertia, -25))
    for little, large in zip(small.pieces.pieces, UNIT.pieces.pieces, strict=True):
        np.testing.assert_array_equal(little.vertices, np.ldexp(large.vertices, -5))


# --- how it rests


def test_first_layer_coefficient_is_the_paper_s_1_298():
    assert UNIT.rest_height == pytest.approx(5 / sqrt(52), rel=1e-15)  # 0.69338 L
    assert UNIT.low_height == pytest.approx(1.38675, abs=5e-6)
    assert UNIT.first_layer_coefficient == pytest.approx(1.29826, abs=5e-6)
    assert round(UNIT.first_layer_coefficient, 3) == 1.298


@pytest.mark.parametrize("unit", [UNIT, Cubipod(2.0), OTHER, Cube()])
def test_low_poses_lie_flat_on_a_face_of_the_hull(unit):
    """Four corners of the hull touch the floor, the centre is above them, none is lower."""
    hull = unit.hull.pieces[0]
    poses = unit.low_poses()
    assert poses.shape == (24, 4)
    for pose in poses:
        corners = rotations.rotate(pose, hull.vertices)
        foot = corners[corners[:, 2] < -unit.rest_height + 1e-12 * unit.side]
        assert len(foot) == 4
        np.testing.assert_allclose(foot[:, 2], -unit.rest_height, rtol=1e-14)
        assert np.all(foot[:, :2].min(axis=0) < 0) and np.all(foot[:, :2].max(axis=0) > 0)
        assert np.ptp(corners[:, 2]) == pytest.approx(unit.low_height, rel=1e-14)


def test_low_poses_are_24_different_turns_that_look_alike():
    poses = UNIT.low_poses()
    matrices = rotations.matrix(poses).reshape(24, 9).round(9)
    assert len(np.unique(matrices, axis=0)) == 24
    clouds = [rotations.rotate(pose, UNIT.hull.vertices).round(9) + 0.0 for pose in poses]
    assert len({tuple(sorted(map(tuple, cloud))) for cloud in clouds}) == 1


def test_low_pose_lays_the_horizontal_tip_axis_along_x():
    """Plan footprint 1.404 x 1.298 Dn, which is the paper's RPG 1.40 x 1.30; two sides are vertical planes, the top is flat."""
    corners = rotations.rotate(UNIT.first_layer_orientation(0.0), UNIT.hull.vertices)
    np.testing.assert_allclose(np.ptp(corners, axis=0) / DN, [1.40428, 1.29826, 1.29826], atol=5e-6)
    for axis in (1, 2):
        for side in (corners[:, axis].min(), corners[:, axis].max()):
            assert np.sum(np.abs(corners[:, axis] - side) < 1e-12) == 4


def test_heading_of_half_a_turn_is_another_placement():
    there, back = (rotations.rotate(UNIT.first_layer_orientation(heading), UNIT.hull.vertices) for heading in (0.0, pi))
    assert len({tuple(sorted(map(tuple, cloud.round(9) + 0.0))) for cloud in (there, back)}) == 2
    np.testing.assert_allclose(back, there * (-1, -1, 1), atol=1e-15)


def test_tip_poses_stand_on_a_protrusion():
    for pose in UNIT.tip_poses():
        corners = rotations.rotate(pose, UNIT.hull.vertices)
        assert np.sum(corners[:, 2] < -UNIT.tip_rest_height + 1e-12) == 4
        assert np.ptp(corners[:, 2]) == pytest.approx(1.5, rel=1e-14)
    assert len(np.unique(rotations.matrix(UNIT.tip_poses())[:, 2].round(9), axis=0)) == 6
    assert 2 * UNIT.tip_rest_height / DN == pytest.approx(1.404, abs=5e-4)


def test_tipping_angles():
    """Low: the cube edge is 0.5/sqrt(13) L beside the centre and 2.5/sqrt(13) L below it. Tip: L/8 and 3L/4."""
    assert UNIT.low_tipping_angle == pytest.approx(atan(0.2), rel=1e-14)
    assert np.degrees(UNIT.low_tipping_angle) == pytest.approx(11.3, abs=0.05)
    assert UNIT.tip_tipping_angle == pytest.approx(atan(1 / 6), rel=1e-14)
    assert np.degrees(UNIT.tip_tipping_angle) == pytest.approx(9.5, abs=0.05)


# --- neighbours on the grids


def placed(place, heading):
    """(vertices, normals, offsets) of each piece of a unit in low pose at place (x, y) [Dn]."""
    turn, centre = rotations.matrix(UNIT.first_layer_orientation(heading)).T, np.array([*place, 0.0]) * DN
    return [(p.vertices @ turn + centre, p.normals @ turn, p.offsets + p.normals @ turn @ centre) for p in UNIT.pieces.pieces]


def overlapping(difference, heading_a, heading_b):
    """Whether two units in low pose share volume, the second one `difference` (x, y) in Dn away."""
    for p, p_normals, p_offsets in placed((0.0, 0.0), heading_a):
        for q, q_normals, q_offsets in placed(difference, heading_b):
            # Most pairs are parted by a face of one of them; the others need the linear programme.
            apart = np.all(q @ p_normals.T >= p_offsets, axis=0).any() or np.all(p @ q_normals.T >= q_offsets, axis=0).any()
            if not apart and polyhedra.common_ball((p_normals, p_offsets), (q_normals, q_offsets)) > 1e-6:
                return True
    return False


@pytest.mark.parametrize(
    "difference, share",
    [((0.0, 1.30), 0.97), ((1.40, 0.0), 0.49), ((0.79, 1.27), 0.057), ((1.58, 0.0), 0.004)],
    ids=["RPG along Y", "RPG along X", "TPG diagonal", "TPG in the row"],
)
def test_share_of_overlaps_with_free_headings(difference, share, generator):
    """Why the RPG's first layer cannot have free headings and the TPG's can. 100 pairs, four standard errors."""
    headings = generator.uniform(0, 2 * pi, (100, 2))
    found = np.mean([overlapping(difference, a, b) for a, b in headings])
    assert abs(found - share) < 4 * sqrt(share * (1 - share) / 100)


@pytest.mark.parametrize("headings", [(0, 0), (0, pi), (pi, 0)])
def test_rpg_fits_with_the_tip_axis_along_x(headings):
    """1.298 < 1.30 along Y at any heading of 0 or 180 degrees; along X the tips pass below or above each other's."""
    assert not overlapping((0.0, 1.30), *headings)


# --- a plain cube, and refusals


def test_cube():
    cube = Cube(side=2.0)
    assert (cube.volume, cube.nominal_diameter, cube.first_layer_coefficient, cube.rest_height) == (8.0, 2.0, 1.0, 1.0)
    assert cube.shape("pieces") == cube.shape("hull")
    assert Cube(nominal_diameter=3.0).side == 3.0


def test_units_are_values():
    assert Cubipod() == Cubipod(1.0)
    assert hash(Cubipod()) == hash(Cubipod(1.0))
    assert dataclasses.replace(UNIT, side=2.0) == Cubipod(2.0)
    # other fractions: V = 1 + 2 h (b2 + b t + t2)
    assert OTHER.nominal_diameter == pytest.approx(cbrt(1.252), rel=1e-15)


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: Cubipod(side=-1.0), "cubipod: side = -1.0"),
        (lambda: Cubipod(side="1"), "cubipod: side = '1'"),
        (lambda: Cubipod(nominal_diameter=float("nan")), "nominal_diameter = nan"),
        (lambda: Cubipod(1.0, 1.07), "give one of the two"),
        (lambda: Cubipod(protrusion_top=0.6), "narrows outwards"),
        (lambda: Cubipod(protrusion_height=0.0), "protrusion_height = 0.0"),
        (lambda: UNIT.shape("mesh"), "shape = 'mesh'; give 'pieces'"),
        (lambda: UNIT.first_layer_orientation(0.0, 24), "roll_choice = 24"),
        (lambda: Cube(side=0), "cube: side = 0"),
    ],
)
def test_what_is_no_unit_is_refused_by_name(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_a_cube_tips_over_its_edge_at_45_degrees():
    cube = Cube(side=2.0)
    assert cube.low_tipping_angle == cube.tip_tipping_angle == pytest.approx(np.pi / 4, rel=1e-15)
