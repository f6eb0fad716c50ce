"""Algebra of the contact problem: islands, frames and back, impulses on both bodies."""

import numpy as np
import small_scenes as scenes
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import minibullet as mb
from minibullet.contact import problem as problems


def test_islands_are_the_connected_components_without_fixed_bodies(generator):
    """Against SciPy on random graphs of 40 bodies, a quarter of them fixed: same partition, each contact once, order kept."""
    for _ in range(20):
        moving = generator.random(40) < 0.75
        pairs = generator.integers(0, 40, (30, 2))
        pairs = pairs[(pairs[:, 0] != pairs[:, 1]) & (moving[pairs[:, 0]] | moving[pairs[:, 1]])]
        both = pairs[moving[pairs].all(axis=1)]
        _, label = connected_components(coo_matrix((np.ones(len(both)), both.T), shape=(40, 40)), directed=False)
        expected = label[np.where(moving[pairs[:, 0]], pairs[:, 0], pairs[:, 1])]
        order, starts = problems.find_islands(pairs, moving)
        found = [order[starts[i] : starts[i + 1]] for i in range(len(starts) - 1)]
        assert sorted(np.concatenate(found)) == list(range(len(pairs)))
        assert {tuple(island) for island in found} == {tuple(np.flatnonzero(expected == k)) for k in set(expected)}


def test_two_stacks_on_one_floor_are_two_islands():
    """The floor is fixed and does not link what stands on it."""
    world = mb.World()
    world.add_plane()
    for x in (0.0, 3.0):
        for z in (0.5, 1.5):
            world.add(mb.Box(1, 1, 1), mass=1.0, position=(x, 0, z))
    problem = scenes.problem(world)
    assert len(problem.target) == 16 and list(np.diff(problem.islands)) == [8, 8]


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
