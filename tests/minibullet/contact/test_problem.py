"""Algebra of the contact problem: frames and back, impulses on both bodies."""

import numpy as np
import small_scenes as scenes

import minibullet as mb
from minibullet.contact import problem as problems


def test_impulses_act_on_both_bodies_at_one_point_and_keep_momentum(generator):
    """Momentum and angular momentum about the origin of two free bodies are unchanged by any contact impulse."""
    world = mb.World()
    for k in range(2):
        world.add(mb.Box(1.0, 0.8, 0.6), mass=1.0 + k, position=(0.1 * k, 0, 0.6 * k))
    problem, bodies = scenes.problem(world), world.registry.scene.bodies
    impulse, twist = generator.normal(size=(len(problem.target), 3)), np.zeros((2, 6))
    problems.apply_impulses(problem.factors, impulse, twist)
    momentum = bodies.mass[:, None] * twist[:, :3]
    spin = bodies.inertia * twist[:, 3:] + np.cross(bodies.position, momentum)
    np.testing.assert_allclose(momentum.sum(axis=0), 0.0, atol=1e-13)
    np.testing.assert_allclose(spin.sum(axis=0), 0.0, atol=1e-13)


def test_vectors_come_back_from_contact_axes(generator):
    """into_world undoes into_axes to rounding."""
    problem = scenes.problem(scenes.block_on_floor()[0])
    vector = generator.normal(size=(len(problem.target), 3))
    np.testing.assert_allclose(
        problems.into_world(problem.factors.jacobian, problems.into_axes(problem.factors.jacobian, vector)), vector, atol=1e-14
    )
