"""Bodies on a floor: the faces they lie on."""

import numpy as np
import pytest
from boxes import SIZE, write_box

from hlcs.data.experiment_file import Body
from hlcs.simulation import contact_motion
from hlcs.simulation.contact_motion import faces, flattened, lies_on_a_face
from minibullet import rotations


def test_a_box_that_lies_still_on_a_face_is_set_flat():
    """Attitude noise of 0.005 rad does not lean it; a tilt of 0.05 rad, or one that grows at 1 rad/s, is no lying."""
    generator = np.random.default_rng(5)
    box, up, times = Body(shape="box", size=(0.1, 0.08, 0.04), mass=0.2), (0.0, 0.0, 1.0), np.arange(12) / 60
    noise = rotations.exponential(0.005 * generator.standard_normal((12, 3)))
    yaw = rotations.exponential(np.array([0.0, 0.0, 0.7]))
    flat = rotations.product(noise, yaw)
    assert contact_motion.lies_on_a_face(box, up, flat, 0.005)
    for lean in (np.tile([0.05, 0, 0], (12, 1)), times[:, None] * [0.0, 1.0, 0.0]):
        assert not contact_motion.lies_on_a_face(box, up, rotations.product(rotations.exponential(lean), flat), 0.005)
    assert not contact_motion.lies_on_a_face(Body(shape="sphere", radius=0.1), up, flat, 0.005)
    set_flat = contact_motion.flattened(flat[0], up)
    assert rotations.rotate(set_flat, np.array(up)) == pytest.approx(np.array(up), abs=1e-12)
    assert np.linalg.norm(rotations.logarithm(rotations.product(set_flat, rotations.conjugate(yaw)))) < 0.02


def test_faces_of_a_mesh_on_which_it_can_lie_are_those_of_its_hull(tmp_path):
    box, mesh = Body(shape="box", size=SIZE), Body(shape="mesh", mesh=str(write_box(tmp_path)))
    assert {tuple(np.round(row)) for row in faces(mesh)} == {tuple(row) for row in faces(box)}
    tilted = rotations.exponential(np.array([0.1, 0.0, 0.3]))
    up = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(flattened(tilted, up, faces(mesh)), flattened(tilted, up), atol=1e-6)
    flat = np.tile(flattened(tilted, up), (12, 1))
    assert lies_on_a_face(mesh, up, flat, 0.001) and not lies_on_a_face(mesh, up, np.tile(tilted, (12, 1)), 0.001)
