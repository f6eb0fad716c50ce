"""Units from mesh files: weighed and laid as the built-in ones, refused with the remedy, cut where they are not convex."""

import importlib.util

import numpy as np
import pytest

import hlcs
from hlcs import InputError, MeshUnit, PlacementTest, example_unit
from hlcs.placement.placement_file import make_placement, read_placement_file
from hlcs.placement.run_store import key_of
from hlcs.placement.settings_table import placement_table, settings_of
from hlcs.placement.units import Cube, Cubipod
from minibullet import rotations
from minibullet.shapes import polyhedra
from minibullet.shapes.convex import ConvexPiece

coacd = pytest.mark.skipif(importlib.util.find_spec("coacd") is None, reason="the extra 'units' is not installed")


def cubipod_shell():
    """(vertices, triangles) of a Cubipod of side 1 as one closed surface that is not convex, as a drawing program writes it."""
    square = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    quads = []
    for axis in range(3):
        for sign in (1, -1):
            rings = [
                sign * np.roll(np.column_stack([np.full(4, height), width * square]), axis, axis=1)
                for height, width in ((0.5, 1.0), (0.5, 0.5), (0.75, 0.25))
            ]
            sides = [(a[k], a[k - 3], b[k - 3], b[k]) for a, b in zip(rings, rings[1:], strict=False) for k in range(4)]
            quads += [side if sign > 0 else side[::-1] for side in (*sides, rings[2])]
    corners = np.array(quads).reshape(-1, 3).round(12) + 0.0
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return vertices, np.array([(a, b, c) for a, b, c, d in index.reshape(-1, 4) for (b, c) in ((b, c), (c, d))])


def write_obj(path, vertices, triangles):
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(lines))
    return path


@pytest.fixture
def cubipod_file(tmp_path):
    example_unit("cubipod").write(tmp_path / "cubipod.obj")
    return tmp_path / "cubipod.obj"


# --- what the mesh says


def test_a_cubipod_from_a_file_has_the_numbers_of_the_built_in_one(cubipod_file):
    """Volume 39/32 L^3, isotropic inertia, low pose and rest height of the closed formulas; sums of ten terms round to 1e-14."""
    unit, built_in = MeshUnit.read(cubipod_file), Cubipod()
    assert unit.volume == pytest.approx(39 / 32, rel=1e-14)
    assert unit.nominal_diameter == pytest.approx(built_in.nominal_diameter, rel=1e-14)
    assert unit.mass(2300.0) == pytest.approx(built_in.mass(2300.0), rel=1e-14)
    np.testing.assert_allclose(unit.pieces.inertia, built_in.pieces.inertia, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(unit.pieces.centre_of_mass, 0.0, atol=1e-15)
    assert unit.pieces.bounding_radius == pytest.approx(built_in.pieces.bounding_radius, rel=1e-14)
    assert unit.pieces.surface_area == pytest.approx(built_in.pieces.surface_area, rel=1e-14)
    assert (unit.rest_height, unit.low_height) == pytest.approx((built_in.rest_height, built_in.low_height), rel=1e-14)
    np.testing.assert_allclose(unit.first_layer_orientation(0.3), built_in.first_layer_orientation(0.3), atol=1e-14)
    assert unit.volume_error == pytest.approx(0.0, abs=1e-14)


def test_a_cubipod_rests_on_24_trapezoids_and_6_tips(cubipod_file):
    """The stable rests of the unit: 24 low ones, 6 on a tip (docs of `Cubipod`), found from the faces of the hull alone."""
    unit = MeshUnit.read(cubipod_file)
    assert len(unit.low_poses()) == 24 and len(unit.tip_poses()) == 6
    for pose in unit.low_poses():
        heights = rotations.rotate(pose, unit.pieces.hull.vertices)[:, 2]
        assert (-heights.min(), np.ptp(heights)) == pytest.approx((unit.rest_height, unit.low_height), rel=1e-12)


@pytest.mark.parametrize("name, low, tips", [("cube", 6, 6), ("tetrapod", 4, 4)])
def test_other_units_rest_on_their_faces(name, low, tips):
    """A cube on 6 equal faces; a tetrapod lowest on three legs (4 ways), highest between them: the hull's cap of one leg."""
    unit = example_unit(name)
    assert len(unit.low_poses()) == low and len(unit.tip_poses()) == tips


def test_a_tetrapod_has_the_volume_of_the_drawing():
    """The sheet with its measures prints V = 0.280 H^3 for round legs: three digits, so 0.2 %. A leg of 18 sides with its corners
    on the cone has the section 18/(2 pi) sin(2 pi/18) of a round one."""
    section = 18 / (2 * np.pi) * np.sin(2 * np.pi / 18)
    unit = example_unit("tetrapod")
    assert unit.volume / section == pytest.approx(0.280, rel=2.5e-3)
    assert unit.low_height == pytest.approx(1.0, rel=1e-12)  # the height H


def test_mass_comes_from_the_mesh_and_contacts_from_the_pieces(tmp_path):
    """A unit cube with two pieces in its pieces file, one half and one half that is 1 % longer: the volume stays that of the
    mesh, the pieces hold 0.5 % more."""
    unit = example_unit("cube")
    unit.write(tmp_path / "block.obj")
    corners = unit.hulls[0].vertices
    halves = [ConvexPiece(corners * (0.5, 1, 1) - (0.25, 0, 0)), ConvexPiece(corners * (0.505, 1, 1) + (0.2525, 0, 0))]
    hollow = MeshUnit("two.obj", tuple((half.vertices, polyhedra.triangles_of(half.faces)) for half in halves), tuple(halves))
    hollow.write(tmp_path / "two.obj")
    (tmp_path / "two.obj").rename(tmp_path / "block.pieces.obj")
    cut = MeshUnit.read(tmp_path / "block.obj")
    assert cut.volume == 1.0 and len(cut.shape("pieces").pieces) == 2
    assert cut.volume_error == pytest.approx(0.005, rel=1e-9)
    cut.write(tmp_path / "again.obj")
    assert MeshUnit.read(tmp_path / "again.obj") == cut != unit


def test_a_file_in_millimetres_is_told_by_its_side(cubipod_file, tmp_path):
    """side: metres per unit of the file; the nominal diameter in its place gives the same."""
    test = PlacementTest(armour=str(cubipod_file), side=0.038)
    assert test.unit.nominal_diameter == pytest.approx(0.038 * Cubipod().nominal_diameter, rel=1e-12)
    by_diameter = make_placement({"armour": str(cubipod_file), "nominal_diameter": 0.038})
    assert by_diameter.unit.nominal_diameter == pytest.approx(0.038, rel=1e-12)
    with pytest.warns(hlcs.InputWarning, match="lengths are in m"):
        PlacementTest(armour=str(cubipod_file), side=1000.0)


# --- placed


def test_a_cubipod_from_a_file_gives_the_layers_of_the_built_in_one(cubipod_file):
    """The same solids at the same places: what differs is rounding, 1e-16 at the start. Falls and impacts make more of it, as
    for a ball among pins; after two small layers it is still below a hundred-thousandth of Dn."""
    small = {"layers": 2, "rows": 3, "columns": 3}
    from_file, built_in = (PlacementTest(armour=armour, **small).run() for armour in (str(cubipod_file), "cubipod"))
    np.testing.assert_allclose(from_file.heights, built_in.heights, atol=1e-5)
    for poses, expected in zip(from_file.poses, built_in.poses, strict=True):
        np.testing.assert_allclose(poses[:, :3], expected[:, :3], atol=1e-5)


def test_a_result_with_a_unit_from_a_file_loads_and_repeats(cubipod_file, tmp_path):
    test = PlacementTest(armour=str(cubipod_file), layers=1, rows=2, columns=2)
    result = test.run()
    result.save(tmp_path / "out")
    again = hlcs.PlacementResult.load(tmp_path / "out")
    assert again.test == test and read_placement_file(tmp_path / "out" / "settings.toml") == test
    assert result.to_dict()["unit"]["pieces"] == 7
    assert "volume error +0.00 %" in result.summary()


def test_a_unit_lies_beside_the_file_that_names_it(cubipod_file, tmp_path):
    """The name is relative to the TOML file, not to where the command runs; a folder above it needs leave."""
    (tmp_path / "test.toml").write_text('[placement]\narmour = "cubipod.obj"\nlayers = 2\n')
    assert read_placement_file(tmp_path / "test.toml").armour == MeshUnit.read(cubipod_file)
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "test.toml").write_text('[placement]\narmour = "../cubipod.obj"\n')
    with pytest.raises(InputError, match="test.toml, line 2.*armour"):
        read_placement_file(tmp_path / "inner" / "test.toml")
    assert read_placement_file(tmp_path / "inner" / "test.toml", allow_outside=True).armour == MeshUnit.read(cubipod_file)


def test_the_key_of_a_run_is_that_of_the_mesh_not_of_its_name(cubipod_file, tmp_path):
    (tmp_path / "b").mkdir()
    other = tmp_path / "b" / "other.obj"
    other.write_bytes(cubipod_file.read_bytes())
    first, second = (PlacementTest(armour=str(path)) for path in (cubipod_file, other))
    assert key_of(settings_of(first)) == key_of(settings_of(second)) and first == second
    assert key_of(settings_of(first)) != key_of(settings_of(PlacementTest(armour=example_unit("cube"))))
    assert placement_table(first)["armour"] == "unit.obj"


# --- what is no unit


@pytest.mark.parametrize(
    "spoil, words",
    [
        (lambda v, t: (v, t[1:]), "not a closed surface, a triangle is missing at the edge"),
        (lambda v, t: (v, t[:, ::-1]), "inside out.*turn its faces outward"),
        (lambda v, t: (v, np.concatenate([t[:1, ::-1], t[1:]])), "turned opposite ways"),
        (lambda v, t: (np.concatenate([v, v + 0.5]), np.concatenate([t, t + len(v)])), "overlap.*cut them"),
    ],
)
def test_a_mesh_that_is_no_solid_is_refused_with_the_remedy(spoil, words, tmp_path):
    block = Cube().pieces.pieces[0]
    path = write_obj(tmp_path / "bad.obj", *spoil(block.vertices, polyhedra.triangles_of(block.faces)))
    with pytest.raises(InputError, match=rf"mesh 'bad.obj'.*{words}"):
        PlacementTest(armour=str(path))


@pytest.mark.parametrize(
    "armour, words",
    [
        ("tetrapod", "armour = 'tetrapod'; it must be one of cubipod, cube, or a mesh file"),
        ("nowhere.stl", "mesh 'nowhere.stl': cannot be read"),
        (5, "armour = 5"),
    ],
)
def test_what_is_no_armour_is_refused(armour, words):
    with pytest.raises(InputError, match=words):
        PlacementTest(armour=armour)


def test_pieces_of_another_mesh_are_refused(tmp_path):
    example_unit("cube").write(tmp_path / "block.obj")
    example_unit("cube", side=2.0).write(tmp_path / "block.pieces.obj")
    with pytest.raises(InputError, match=r"block.pieces.obj\) hold \+700 %"):
        MeshUnit.read(tmp_path / "block.obj")


def test_without_the_extra_a_hollowed_solid_names_it(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "coacd", None)
    path = write_obj(tmp_path / "shell.obj", *cubipod_shell())
    with pytest.raises(
        InputError, match=r"mesh 'shell.obj'.*the extra 'units' is needed: .* python -m pip install -e '.\[units\]'"
    ):
        MeshUnit.read(path)


@coacd
@pytest.mark.slow
def test_a_cubipod_of_one_surface_is_cut_into_pieces_that_are_nearly_it(tmp_path):
    """One surface of a drawing: mass exact, pieces within CoACD's concavity of 5 %; found: 9 pieces, volume error 0.04 %.
    It writes corners to about five digits."""
    unit = MeshUnit.read(write_obj(tmp_path / "shell.obj", *cubipod_shell()))
    assert unit.volume == pytest.approx(39 / 32, rel=1e-12)
    assert 7 <= len(unit.hulls) <= 20 and abs(unit.volume_error) < 0.01
    assert unit.first_layer_coefficient == pytest.approx(Cubipod().first_layer_coefficient, rel=1e-4)
