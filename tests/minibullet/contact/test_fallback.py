"""What Gauss-Seidel leaves unconverged is solved by Newton's method."""

import numpy as np
import small_scenes as scenes

import minibullet as mb
from minibullet.contact import gauss_seidel
from minibullet.contact.fallback import solve_unconverged


def test_islands_that_stall_are_handed_to_newton():
    """Ten thousand kilograms on one kilogram: Gauss-Seidel stalls after 20 sweeps, the escalation meets the tolerance."""
    world = mb.World()
    world.add_plane()
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5))
    world.add(mb.Box(1, 1, 1), mass=1e4, position=(0, 0, 1.5))
    still = np.zeros((3, 6))
    still[1:, 2] = -9.81 / 240
    problem = scenes.problem(world, 0.5, still)
    none = np.zeros((len(problem.target), 3))
    first = gauss_seidel.solve(problem, none, none, iterations=20, tolerance=1e-8)
    assert first.residual > 1e-8 and len(first.unconverged) == 1
    assert solve_unconverged(problem, first, 1e-8).residual <= 1e-8
