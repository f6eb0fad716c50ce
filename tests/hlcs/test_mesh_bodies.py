"""A body given as a mesh file: the same answers as the same solid by its name, or a complaint when the experiment is read."""

import numpy as np
import pytest
import trimesh
from throws import correlated, csv

import hlcs
from hlcs.data.experiment_file import Body, read_experiment_file
from hlcs.data.rigid_body import rigid_body
from hlcs.simulation.contact_motion import faces, flattened, lies_on_a_face
from minibullet import InputError, rotations

SIZE = (0.06, 0.1, 0.2)
COLUMNS = ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
NAMED = f'shape = "box"\nsize = {list(SIZE)}\n'
MESH = 'shape = "mesh"\nmesh = "box.stl"\n'


def write_box(folder, at=(0.0, 0.0, 0.0), name="box.stl", turn=(1.0, 0.0, 0.0, 0.0)):
    """The box in a mesh file whose origin is not its centre, and whose axes may not be its own."""
    box = trimesh.creation.box(SIZE)
    box.vertices = rotations.rotate(np.array(turn), box.vertices) + at
    box.export(folder / name)
    return folder / name


def thrown(folder, body, drag=0.0, more=""):
    """Four spinning throws, recorded with noise; spin about a principal axis, so that it is steady. -> path of the experiment."""
    generator, trials = np.random.default_rng(4), ""
    for k in range(4):
        times = np.arange(0, 0.8, 1 / 60)
        speed = np.array([1.5 * (k % 2), 1.0 + k, 3.0])
        decay = (1 - np.exp(-drag * times)) / drag if drag else times
        fall = -9.81 / drag * (times - decay) if drag else -9.81 * times**2 / 2
        place = np.outer(decay, speed) + np.outer(fall, [0, 0, 1]) + [0, 0, 1.5]
        turn = rotations.exponential(np.outer(times, [0, 0, 2.0 + k])) + correlated(generator, (len(times), 4), 0.005, 0.0)
        place = place + correlated(generator, (len(times), 3), 0.003, 0.0)
        seen = np.hstack([place, turn / np.linalg.norm(turn, axis=1)[:, None]])
        (folder / f"throw_{k}.csv").write_text(csv(times, seen, COLUMNS))
        trials += f'[[trial]]\nfile = "throw_{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "thrown.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\n' + body + more + "[surroundings]\nfluid_density = 0.0\n[measurement]\n"
        "noise = { position = 0.003, orientation = 0.01 }\n" + trials
    )
    return path


def slid(folder, body):
    """Four slides to rest on a rough floor (friction 0.3), on the largest face; -> path of the experiment, which says 0.3."""
    generator, trials = np.random.default_rng(5), ""
    for k in range(4):
        times, speed = np.arange(0, 0.9, 1 / 60), 1.0 + 0.4 * k
        rest = speed / (0.3 * 9.81)
        way = np.where(times < rest, speed * times - 0.3 * 9.81 * times**2 / 2, speed * rest / 2)
        place = np.column_stack([way, 0 * way, 0.03 + 0 * way]) + correlated(generator, (len(times), 3), 0.001, 0.0)
        down = rotations.exponential(np.array([0, np.pi / 2, 0]))  # the face across x lies on the floor
        turn = rotations.product(rotations.exponential(correlated(generator, (len(times), 3), 0.003, 0.0)), down)
        (folder / f"slide_{k}.csv").write_text(csv(times, np.hstack([place, turn]), COLUMNS))
        trials += f'[[trial]]\nfile = "slide_{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "slid.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\n' + body + "mass = 1.5\n[surroundings]\nfluid_density = 0.0\nfriction = 0.3\n"
        "floor = { height = 0.0 }\n[measurement]\nnoise = { position = 0.001, orientation = 0.003 }\n" + trials
    )
    return path


def same(one, other, tolerance):
    """Equal words, and numbers equal within a relative tolerance, however they stand in each other."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        return all(same(one[key], other[key], tolerance) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(same(*pair, tolerance) for pair in zip(one, other, strict=True))
    if isinstance(one, float):
        return one == pytest.approx(other, rel=tolerance, abs=tolerance)
    return one == other


# 32-bit numbers of the file are right to 1e-7 of the size; fits stop where chi2 falls by less than 1e-2 of itself.
@pytest.mark.parametrize("write", [thrown, slid])
def test_a_box_from_a_file_and_a_box_by_name_compare_alike(write, tmp_path):
    write_box(tmp_path, at=(0.3, -0.2, 0.5))
    named, mesh = (hlcs.compare(write(tmp_path, body)) for body in (NAMED, MESH))
    assert named.adequate and mesh.adequate
    assert len(mesh.where) == len(named.where) and same(mesh.where, named.where, 1e-3)


def test_a_box_from_a_file_and_a_box_by_name_are_diagnosed_alike(tmp_path):
    """Throws that a drag linear in speed brakes, 0.4 per second: the same verdict, effects and numbers."""
    write_box(tmp_path, at=(0.3, -0.2, 0.5))
    named, mesh = (hlcs.diagnose(thrown(tmp_path, body, drag=0.4, more="mass = 1.5\n"), progress=False) for body in (NAMED, MESH))
    assert named.verdict == mesh.verdict and named.effects == mesh.effects and "linear_drag" in str(mesh)
    assert same(*(one.to_json()["parameters"] for one in (mesh, named)), 1e-3)


def test_the_centre_of_mass_is_the_centre_wherever_the_file_has_its_origin(tmp_path):
    here, there = (
        rigid_body(Body(shape="mesh", mesh=str(write_box(tmp_path, at, name))))
        for at, name in (((0, 0, 0), "here.stl"), ((7.0, -3.0, 2.0), "there.stl"))
    )
    for one in (here, there):
        np.testing.assert_allclose(np.ptp(one.shape.pieces[0].vertices, axis=0), SIZE, rtol=1e-5)  # 7 m in 32 bits: 5e-7 m
        np.testing.assert_allclose(one.shape.pieces[0].vertices.mean(axis=0), 0, atol=1e-6)
    np.testing.assert_allclose(here.inertia, rigid_body(Body(shape="box", size=SIZE)).inertia, rtol=1e-6)


def test_a_mesh_in_other_axes_turns_about_its_own_principal_axes(tmp_path):
    """The tensor turns with the solid: R I R^T. Moments that are stated go to the axes by size."""
    turn = np.array([0.5, 0.1, -0.7, 0.5])
    turn /= np.linalg.norm(turn)
    path = str(write_box(tmp_path, turn=turn, name="turned.stl"))
    matrix, plain = rotations.matrix(turn), rigid_body(Body(shape="box", size=SIZE, mass=2.0))
    expected = matrix @ np.diag(plain.inertia) @ matrix.T
    found = rigid_body(Body(shape="mesh", mesh=path, mass=2.0)).tensor
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * expected.max())
    stated = rigid_body(Body(shape="mesh", mesh=path, mass=2.0, inertia=(0.02, 0.01, 0.015)))
    least = matrix @ np.eye(3)[np.argmin(plain.inertia)]
    assert least @ stated.tensor @ least == pytest.approx(0.01, rel=1e-5)


def test_mass_left_out_is_one_kilogram_and_no_law_that_needs_it_is_tried(tmp_path):
    write_box(tmp_path)
    file = read_experiment_file(thrown(tmp_path, MESH))
    assert rigid_body(file.body).mass == 1.0 and file.body.mass is None
    assert hlcs.compare(file.path).adequate


def test_faces_of_a_mesh_on_which_it_can_lie_are_those_of_its_hull(tmp_path):
    box, mesh = Body(shape="box", size=SIZE), Body(shape="mesh", mesh=str(write_box(tmp_path)))
    assert {tuple(np.round(row)) for row in faces(mesh)} == {tuple(row) for row in faces(box)}
    tilted = rotations.exponential(np.array([0.1, 0.0, 0.3]))
    up = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(flattened(tilted, up, faces(mesh)), flattened(tilted, up), atol=1e-6)
    flat = np.tile(flattened(tilted, up), (12, 1))
    assert lies_on_a_face(mesh, up, flat, 0.001) and not lies_on_a_face(mesh, up, np.tile(tilted, (12, 1)), 0.001)


BAD = {
    "missing": (None, 'shape = "mesh"\nmesh = "gone.stl"\n', "line 4: body.mesh: file 'gone.stl' is not there"),
    "open": (b"solid a\nendsolid a\n", MESH, "line 4: body.mesh: mesh 'box.stl': no triangles; the file is empty"),
    "not named": (None, 'shape = "mesh"\n', 'line 3: body.shape: "mesh" of which file. Add mesh = "unit.stl"'),
    "folder": ("folder", MESH, "line 4: body.mesh: file 'box.stl' is not there"),
    "millimetres": ("mm", MESH + "mass = 1.5\n", "line 5: body.mass: mass and size give a density of .*units are kg and m"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_mesh_is_refused_where_the_experiment_names_it(case, tmp_path):
    content, body, words = BAD[case]
    if content == "folder":
        (tmp_path / "box.stl").mkdir()
    elif content == "mm":
        trimesh.creation.box(1000 * np.array(SIZE)).export(tmp_path / "box.stl")
    elif content:
        (tmp_path / "box.stl").write_bytes(content)
    path = thrown(tmp_path, body)
    with pytest.raises(InputError, match=f"thrown.toml, {words}") as refusal:
        hlcs.compare(path)
    assert "\n" not in str(refusal.value)


def test_a_mesh_that_was_changed_is_read_again(tmp_path):
    """Nothing is kept under the name of the file: a session that corrects its mesh goes on with the new one."""
    write_box(tmp_path)
    path = thrown(tmp_path, MESH)
    before = rigid_body(read_experiment_file(path).body).volume
    trimesh.creation.box(2 * np.array(SIZE)).export(tmp_path / "box.stl")
    assert rigid_body(read_experiment_file(path).body).volume == pytest.approx(8 * before, rel=1e-5)
