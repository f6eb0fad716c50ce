"""Islands of contacts: against SciPy, and over a fixed floor."""

import numpy as np
import small_scenes as scenes
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import minibullet as mb
from minibullet.contact.islands import find_islands


def test_islands_are_the_connected_components_without_fixed_bodies(generator):
    """Against SciPy on random graphs of 40 bodies, a quarter of them fixed: same partition, each contact once, order kept."""
    for _ in range(20):
        moving = generator.random(40) < 0.75
        pairs = generator.integers(0, 40, (30, 2))
        pairs = pairs[(pairs[:, 0] != pairs[:, 1]) & (moving[pairs[:, 0]] | moving[pairs[:, 1]])]
        both = pairs[moving[pairs].all(axis=1)]
        _, label = connected_components(coo_matrix((np.ones(len(both)), both.T), shape=(40, 40)), directed=False)
        expected = label[np.where(moving[pairs[:, 0]], pairs[:, 0], pairs[:, 1])]
        order, starts = find_islands(pairs, moving)
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
