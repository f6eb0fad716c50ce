"""Bodies on a floor: the faces they lie on."""

import copy
import pickle

import numpy as np
import pytest
from boxes import SIZE, write_box

import minibullet as mb
from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.rigid_body import WithDragArea, rigid_body
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


@pytest.mark.parametrize(
    ("shape", "turns", "lies"),
    [
        ("disc", (0.0, np.pi), True),
        ("cylinder", (0.0, np.pi), True),
        ("cylinder", (np.pi / 2,), False),
        ("cone", (0.0,), True),
        ("cone", (np.pi,), False),
    ],
)
def test_a_round_body_lies_on_its_ends_and_not_on_its_side(shape, turns, lies):
    """A cone on its base alone; a roll by `turns` about x."""
    body, up = Body(shape=shape, radius=0.04, height=0.02, mass=0.17), np.array([0.0, 0.0, 1.0])
    for turn in turns:
        there = rotations.product(rotations.exponential(np.array([0, 0, 0.7])), rotations.exponential(np.array([turn, 0, 0])))
        assert lies_on_a_face(body, up, np.tile(there, (12, 1)), 0.001) is lies


@pytest.mark.parametrize("angle", [0.0, 0.1])
def test_a_box_put_on_a_floor_touches_it_and_keeps_only_its_speed_along_it(angle):
    """On a floor that leans more than the file says the box turns with it, its gap is the margin."""
    box = rigid_body(Body(shape="box", size=(0.1, 0.2, 0.04), mass=1.0)).shape
    nominal = Surroundings(floor_height=0.0)
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    actual = Surroundings(floor_height=0.0, floor_normal=tuple(normal))
    state = np.array([0.3, 0.1, 0.5, 1.0, 2.0, -3.0, 1, 0, 0, 0, 0, 0, 0])
    assert contact_motion.gap(box, state[:3], state[6:10], nominal) == pytest.approx(0.48)
    seated = contact_motion.seat(box, state, nominal, actual, 0.001)
    assert contact_motion.gap(box, seated[:3], seated[6:10], actual) == pytest.approx(0.001, abs=1e-12)
    assert seated[3:6] @ normal == pytest.approx(0.0, abs=1e-12) and seated[4] == 2.0
    np.testing.assert_allclose(rotations.rotate(seated[6:10], np.array([0.0, 0.0, 1.0])), normal, atol=1e-12)
    assert state[2] == 0.5  # the state that was given stays


def test_a_body_off_its_centre_of_mass_has_its_vertices_about_that_centre():
    box = rigid_body(Body(shape="box", size=(0.1, 0.2, 0.04), mass=1.0)).shape
    moved = contact_motion.off_centre(box, (0.01, 0.0, 0.005))
    np.testing.assert_allclose(moved.pieces[0].vertices, box.pieces[0].vertices - [0.01, 0.0, 0.005])
    assert moved.volume == box.volume and contact_motion.off_centre(box, (0.01, 0.0, 0.005)) is moved


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda solid: pickle.loads(pickle.dumps(solid))])
@pytest.mark.parametrize("changed", [{"centre": (0.01, 0.0, 0.005)}, {"drag_area": 0.2}])
def test_a_copy_of_an_altered_solid_is_the_solid(changed, again):
    """It is asked for names before it has a shape to know them, and must say that it has none."""
    box = rigid_body(Body(shape="box", size=(0.1, 0.2, 0.04), mass=1.0)).shape
    solid = contact_motion.off_centre(box, **changed) if "centre" in changed else WithDragArea(box, **changed)
    copied = again(solid)
    assert type(copied) is type(solid) and copied.volume == box.volume and copied.surface_area == solid.surface_area
    np.testing.assert_array_equal(copied.pieces[0].vertices, solid.pieces[0].vertices)


def test_a_run_knows_the_steps_in_which_its_floor_pushes_it():
    """A ball dropped from 0.1 m lands after 0.143 s; another that flies on beside it is never pushed."""
    ball = rigid_body(Body(shape="sphere", radius=0.05, mass=0.1))
    states = [np.array([0, 0, height, 0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0]) for height in (0.15, 5.0)]
    floor, gravity = ((0.0, 0.0, 1.0), 0.0), (mb.Gravity(9.81),)
    runs = [contact_motion.Run(ball, ball.shape, state, floor, gravity, 0.5, 0.5) for state in states]
    pushed = contact_motion.simulate(runs, 0.2, 1 / 500).pushed
    assert np.flatnonzero(pushed[:, 0]) == pytest.approx([np.sqrt(2 * 0.1 / 9.81) * 500], abs=1) and not pushed[:, 1].any()


def landing(position, step, orientation=(1.0, 0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0), restitution=0.0):
    """Track of 0.2 s of a box 0.1 m by 0.08 m by 0.06 m that falls on a floor with friction 0.5."""
    body = rigid_body(Body(shape="box", size=(0.1, 0.08, 0.06), mass=1.0))
    state, floor = np.concatenate([position, velocity, orientation, spin]), ((0.0, 0.0, 1.0), 0.0)
    run = contact_motion.Run(body, body.shape, state, floor, (mb.Gravity(9.81),), 0.5, restitution)
    return contact_motion.simulate([run], 0.2, step)


@pytest.mark.parametrize("height", [0.07, 0.072, 0.074, 0.08])  # it lands at another part of a step each
def test_a_body_that_lands_without_rebound_rests_from_the_moment_of_its_impact(height):
    """h - g t^2/2, then half of the box, at all times of the step of the impact and of the next: no straight line from node to
    node, which is 0.8 mm off. Tolerance: g dt^2/2, as the pieces of that step are straight."""
    times, step = np.linspace(0.0, 0.2, 4001), 1 / 240
    seen = landing((0.0, 0.0, height), step).position_at(times[None])[0, :, 2]
    np.testing.assert_allclose(seen, np.maximum(height - 9.81 * times**2 / 2, 0.03), atol=9.81 * step**2 / 2)


@pytest.mark.parametrize("height", [0.120, 0.124])
def test_a_turn_changes_at_the_moment_of_an_impact(height):
    """Against steps 64 times as short, until a step after the first impact of a corner. A turn that is steady over the step is
    0.008 rad off, and 0.002 rad are the turn of the step by what the spin changes in flight and by the place of the corner."""
    way = {
        "orientation": rotations.exponential(np.array([0.3, 0.2, 0.1])),
        "velocity": (0.5, 0.0, 0.0),
        "spin": (1.0, 2.0, 0.0),
        "restitution": 0.3,
    }
    coarse, fine = (landing((0.0, 0.0, height), step, **way) for step in (1 / 240, 1 / 240 / 64))
    times = np.linspace(0.0, fine.times[np.argmax(fine.pushed[:, 0])] + 1 / 240, 2001)[None]
    turns = rotations.product(coarse.observe(times)[1], rotations.conjugate(fine.observe(times)[1]))
    assert np.linalg.norm(rotations.logarithm(turns), axis=-1).max() < 0.002
