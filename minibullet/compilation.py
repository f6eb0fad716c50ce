"""The engine compiled ahead of its first step, in parts that several processes can compile at once.

The compiler takes half a minute for the kernels of a step, once: the code is kept (`kernels`). Each part below is a call that
needs half of them. What a part leaves out, a first step compiles.
"""

import numpy as np

from minibullet.contact import gauss_seidel
from minibullet.contact.problem import ContactProblem, DelassusFactors
from minibullet.effects import Gravity
from minibullet.settings import Settings
from minibullet.shapes.primitives import Box
from minibullet.world import World


def find_pairs_and_solve():
    """Compile what looks for pairs of bodies and the features that separate them, and the solver: for one contact."""
    world = _world()
    world.add(Box(1.0, 1.0, 1.0), density=2300.0, position=(0.2, 0.0, 1.5))
    world.overlaps()
    jacobian, block = np.zeros((2, 1, 2, 3, 6)), np.eye(3)[None]
    factors = DelassusFactors(np.array([[0, 1]]), np.zeros((2, 6, 6)), *jacobian, block)
    order, islands = np.array([0]), np.array([0, 1])
    law = np.zeros(1), np.zeros(1), np.zeros((1, 2))
    problem = ContactProblem(factors, *law, np.zeros((2, 6)), order, islands, rounding=0.0, reference_mass=1.0)
    gauss_seidel.solve(problem, np.zeros((1, 3)), np.zeros((1, 3)))


def place_points_and_move():
    """Compile the rest of a step: contact points, constraints, the move; of a body with nobody near."""
    world = _world()
    collision = world.registry.commit().collision
    collision.update = lambda *given: collision.cache  # nobody is looked for: that is the other part's
    world.step()


def _world():
    world = World([Gravity(9.81)], Settings(solver="gauss_seidel"))
    world.add_plane()
    world.add(Box(1.0, 1.0, 1.0), density=2300.0, position=(0.0, 0.0, 0.5))
    return world


PARTS = (find_pairs_and_solve, place_points_and_move)
