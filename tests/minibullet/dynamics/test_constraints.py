"""From contacts to the contact problem: W from finite differences, the velocity a gap allows, the pull of adhesion."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb
from minibullet.bodies import ContactLaw
from minibullet.contact import faces
from minibullet.contact.block_rows import delassus
from minibullet.dynamics import constraints


def leaning_pair(generator):
    """A flat block on a floor and another across it, turned a little, all moments different: 3 to 8 contacts."""
    world = mb.World()
    world.add_plane()
    world.add(mb.Box(1.0, 0.6, 0.3), mass=3.0, position=(0, 0, 0.15), velocity=generator.normal(size=3))
    turn = mb.rotations.exponential(np.array([2e-3, 1e-3, 0.4]))
    world.add(mb.Box(0.8, 0.5, 0.2), mass=0.7, position=(0.1, 0.1, 0.4), orientation=turn,
              angular_velocity=generator.normal(size=3))  # fmt: skip
    return world


def test_delassus_is_the_answer_of_the_contact_velocities_to_impulses(generator):
    """Column k of W by finite differences: an impulse is laid on the bodies at the contact's two surface points by Newton's
    and Euler's laws, and the velocity of the points against each other is read off. The map is linear, so agreement is to
    rounding."""
    world = leaning_pair(generator)
    found, problem = scenes.touch(world), scenes.problem(world)
    bodies = world.registry.scene.bodies
    turn = mb.rotations.matrix(bodies.orientation)
    axes = problem.factors.jacobian[:, 0, :, :3]

    def velocities(twist):
        at_a = twist[found.pair[:, 0], :3] + np.cross(twist[found.pair[:, 0], 3:], found.arms[:, :3])
        at_b = twist[found.pair[:, 1], :3] + np.cross(twist[found.pair[:, 1], 3:], found.arms[:, 3:6])
        return np.einsum("mik,mk->mi", axes, at_b - at_a).ravel()

    def struck(contact, axis):
        twist = problem.free_twist.copy()
        for body, arm, sign in zip(found.pair[contact], found.arms[contact, :6].reshape(2, 3), (-1.0, 1.0), strict=True):
            if np.isfinite(bodies.mass[body]):
                push = sign * axes[contact, axis]
                inertia = turn[body] @ np.diag(bodies.inertia[body]) @ turn[body].T
                twist[body, :3] += push / bodies.mass[body]
                twist[body, 3:] += np.linalg.solve(inertia, np.cross(arm, push))
        return twist

    W, q = delassus(problem)
    free = velocities(problem.free_twist)
    columns = np.stack([velocities(struck(c, i)) - free for c in range(len(found.gap)) for i in range(3)], axis=1)
    np.testing.assert_allclose(W, columns, atol=1e-12 * np.abs(W).max())
    np.testing.assert_allclose(W, W.T, atol=1e-12 * np.abs(W).max())
    assert np.linalg.eigvalsh(W).min() > -1e-12 * np.abs(W).max()
    q.reshape(-1, 3)[:, 0] += problem.target
    np.testing.assert_allclose(q, free, atol=1e-12)


def test_a_gap_may_close_within_the_step_and_no_overlap_asks_for_speed():
    """u_N >= -gap/dt: a box 1 mm up may come down at 0.24 m/s in a step of 1/240 s; one sunk by 1 mm gets target 0."""
    for height, target in ((0.501, -0.24), (0.499, 0.0)):
        world = mb.World()
        world.add_plane()
        world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, height))
        np.testing.assert_allclose(scenes.problem(world).target, target, atol=1e-12)


def test_frames_are_orthonormal_and_right_handed(generator):
    """For any normal, also straight down, where the formula for the tangents changes branch."""
    normal = generator.normal(size=(50, 3))
    normal /= np.sqrt((normal**2).sum(axis=1))[:, None]
    normal[:3] = (0, 0, -1), (0, 0, 1), (1e-5, 0, -np.sqrt(1 - 1e-10))
    vectors = np.concatenate([generator.normal(size=(50, 6)), normal], axis=1)
    factors = constraints.contact_factors(np.tile([0, 1], (50, 1)), vectors, np.zeros((2, 6, 6)))
    axes = factors.jacobian[:, 0, :, :3]
    np.testing.assert_allclose(axes[:, 0], normal, atol=1e-15)
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), np.tile(np.eye(3), (50, 1, 1)), atol=2e-9)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, atol=2e-9)


def test_adhesion_pulls_only_where_surfaces_touch():
    """Free twist of a box of 2 kg on the floor under four contacts of 3 N: -12 N dt / 2 kg; of one 1 mm up: unchanged."""
    for height, speed in ((0.5, -12.0 / 2.0 / 240.0), (0.501, 0.0)):
        world = mb.World()
        world.add_plane()
        box = world.add(mb.Box(1, 1, 1), mass=2.0, position=(0, 0, height))
        plain, found, scene = scenes.problem(world), scenes.touch(world), world.registry.scene
        none = np.zeros(4)
        law = ContactLaw(none, none, none, none, none + 3.0)
        still = np.zeros_like(plain.free_twist)
        contacts = scenes.step_contacts(scene, plain.factors, found.gap, law)
        problem = constraints.assemble(contacts, law, still, found.gap, 0.0, scene.reference_mass, 1 / 240)
        np.testing.assert_allclose(problem.free_twist[box._row], (0, 0, speed, 0, 0, 0), atol=1e-15)
        assert problem.reference_mass == pytest.approx(2.0)


@pytest.mark.parametrize("closing", [0.1, 0.0])
def test_targets_of_a_face_are_what_a_rigid_body_can_do(closing):
    """Eight contacts of two faces on a floor, their targets a plane and 1e-6 m/s of noise: moved, by no more than twice the
    largest deviation, to velocities that a twist of the body gives at all of them (least squares leave nothing), and that push
    nothing apart. A face that would have to be moved by more stays as it is."""
    generator = np.random.default_rng(0)
    world = mb.World()
    world.add_plane()
    for x in (0.0, 3.0):
        world.add(mb.Box(1, 1, 1), mass=1.0, position=(x, 0, 0.5))
    factors = scenes.problem(world).factors
    arms = factors.jacobian[:, 0, 0, 3:]
    target = np.minimum(closing * (-1 - 0.5 * arms[:, 0] + 0.2 * arms[:, 1]) + 1e-6 * generator.standard_normal(8), 0.0)
    moved = faces.attainable(target, factors, np.zeros((8, 2)), np.full(8, 1e-5))
    assert (moved <= 0.0).all() and np.abs(moved - target).max() < 4e-6
    for face in np.split(np.arange(8), 2):
        rows = factors.jacobian[face, 0, 0]
        twist, *_ = np.linalg.lstsq(rows, moved[face], rcond=None)
        np.testing.assert_allclose(rows @ twist, moved[face], atol=1e-15)
        assert np.abs(rows @ np.linalg.lstsq(rows, target[face], rcond=None)[0] - target[face]).max() > 1e-8
    np.testing.assert_array_equal(faces.attainable(target, factors, np.zeros((8, 2)), np.full(8, 1e-8)), target)


def test_targets_of_a_face_that_cannot_roll_are_one_velocity():
    """Corners that each resist rolling hold their face from turning: targets within what they may be moved by become the least
    closing one of their face, the others are moved to a plane."""
    world = mb.World()
    world.add_plane()
    for x in (0.0, 3.0):
        world.add(mb.Box(1, 1, 1), mass=1.0, position=(x, 0, 0.5))
    factors = scenes.problem(world).factors
    tilt = factors.jacobian[:, 0, 0, 3]
    target = -0.1 + np.repeat([1e-6, 1.0], 4) * (tilt - tilt.max())
    moved = faces.attainable(target, factors, np.full((8, 2), 1e-3), np.full(8, 1e-5))
    np.testing.assert_array_equal(moved[:4], target[:4].max())
    np.testing.assert_allclose(moved[4:], target[4:], atol=1e-15)
