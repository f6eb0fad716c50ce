"""Rigid bodies from mesh files: centre of mass, principal axes, mass left out."""

import numpy as np
import pytest
import trimesh
from boxes import MESH, SIZE, thrown, write_box

import hlcs
from hlcs.data.experiment_file import Body, read_experiment_file
from hlcs.data.rigid_body import rigid_body
from minibullet import rotations


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


def test_a_mesh_that_was_changed_is_read_again(tmp_path):
    """Nothing is kept under the name of the file: a session that corrects its mesh goes on with the new one."""
    write_box(tmp_path)
    path = thrown(tmp_path, MESH)
    before = rigid_body(read_experiment_file(path).body).volume
    trimesh.creation.box(2 * np.array(SIZE)).export(tmp_path / "box.stl")
    assert rigid_body(read_experiment_file(path).body).volume == pytest.approx(8 * before, rel=1e-5)
