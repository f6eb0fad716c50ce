"""The natural-map residual of the whole problem, against plain NumPy; what it counts and what it does not know."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb
from minibullet.contact import gauss_seidel
from minibullet.contact import problem as problems
from minibullet.contact.block_rows import delassus
from minibullet.contact.problem import Iterate
from minibullet.contact.residual import free_squares, natural_map_error, residual_of


def test_residual_is_the_natural_map_of_the_whole_problem(generator):
    """The certificate recomputed with plain NumPy from W and q, impulses over the reference mass, for impulses of any quality."""
    world, _ = scenes.block_on_floor(velocity=(1.0, 0.5, -1.0))
    problem = scenes.problem(world, 0.4)
    impulse = generator.normal(size=(len(problem.target), 3)) + (1.0, 0.0, 0.0)
    solution = gauss_seidel.solve(problem, impulse, np.zeros_like(impulse), iterations=1, tolerance=1e-16)
    W, q = delassus(problem)
    r, u = solution.impulse / problem.reference_mass, (W @ solution.impulse.ravel() + q).reshape(-1, 3)
    y = r - u
    y[:, 0] -= 0.4 * np.hypot(u[:, 1], u[:, 2])
    slope = np.hypot(y[:, 1], y[:, 2])
    height = (y[:, 0] + 0.4 * slope) / (1 + 0.4**2)
    nearest = np.column_stack([height, 0.4 * height * y[:, 1] / slope, 0.4 * height * y[:, 2] / slope])
    nearest[0.4 * slope <= -y[:, 0]] = 0.0
    inside = slope <= 0.4 * y[:, 0]
    nearest[inside] = y[inside]
    expected = np.linalg.norm(r - nearest) / max(np.linalg.norm(q), np.linalg.norm(r), np.linalg.norm(u))
    assert expected > 1e-4  # two sweeps are no solution
    assert solution.residual == pytest.approx(expected, rel=1e-10)


def test_residual_below_rounding_of_the_velocities_is_zero():
    """Where the map's error is below what velocities are rounded by, more sweeps could only move noise: it counts as solved."""
    world = mb.World()
    world.add_plane()
    world.add(mb.Sphere(0.5), mass=2.0, position=(0, 0, 0.5), velocity=(3.0, 4.0, -2.0))
    problem, none = scenes.problem(world, 0.25), np.zeros((1, 3))
    unheld = Iterate(none, none, problem.free_twist)
    assert residual_of(problem, unheld) > 0.1
    assert residual_of(problem._replace(rounding=10.0), unheld) == 0.0


def test_residual_does_not_know_kilograms_from_grams():
    """Every mass times 1000: the same residual to rounding, because impulses are divided by the reference mass."""
    found = []
    for factor in (1.0, 1000.0):
        world = mb.World()
        world.add_plane()
        for k in range(3):
            world.add(mb.Box(1, 1, 1), mass=factor * (1 + k), position=(0.1 * k, 0, 0.5 + k), velocity=(0.5, 0.2 * k, -1.0))
        problem = scenes.problem(world)
        none = np.zeros((len(problem.target), 3))
        found.append(gauss_seidel.solve(problem, none, none, iterations=6, tolerance=1e-16).residual)
    assert found[0] > 1e-8 and found[1] == pytest.approx(found[0], rel=1e-6)


def test_residual_counts_rolling_and_spinning_moments():
    """A ball that rolls and spins on one contact: solved moments have residual 0; taken away they miss their discs by what the
    ball turns at the arm, |arm omega| <= r_N/m."""
    world = mb.World([mb.RollingFriction(arm=0.01), mb.SpinningFriction(arm=0.02)], mb.Settings(friction=0.5))
    world.add_plane()
    world.add(mb.Sphere(0.5), mass=2.0, position=(0, 0, 0.5), velocity=(1.0, 0, -3.0), angular_velocity=(0.5, 2.0, 3.0))
    world.step()
    problem, solution = world.last_step.problem, world.last_step.solution
    assert np.abs(solution.moment).min() > 0.0 and solution.residual < 1e-12
    twist, none = problem.free_twist.copy(), np.zeros((1, 3))
    problems.apply_impulses(problem.factors, solution.impulse, twist)
    ball = problem.factors.bodies[0, 1]
    u = problems.relative_velocity(problem.factors, twist)
    turned = np.append(0.01 * twist[ball, 3:5], 0.02 * twist[ball, 5])
    size = max(free_squares(problem)[0], (solution.impulse**2).sum() / 4.0, (u**2).sum() + (turned**2).sum())
    own = natural_map_error(solution.impulse[0] / 2.0, u[0], 0.5)  # the contact's share; masses in units of the ball's
    unheld = residual_of(problem, Iterate(solution.impulse, none, twist))
    assert unheld == pytest.approx(np.sqrt((own + (turned**2).sum()) / size), rel=1e-9)
    assert (turned**2).sum() > 0.01 * own


def test_rounding_of_a_slip_is_no_error_whatever_the_coefficient():
    """A box that stands with mu = 1e9: the law speaks of mu |u_T|, which turns the rounding of a slip that is none into an
    error of 1e-8; no sweep could take it away."""
    world = mb.World([mb.Gravity()], mb.Settings(time_step=0.004, solver="gauss_seidel", iterations=1000, friction=1e9))
    world.add_plane()
    for place, turn in ((0.0, 0.14), (1.0, 0.36)):
        world.add(mb.Box(0.12, 0.08, 0.04), mass=0.4, position=(place, 0, 0.02), orientation=(np.sqrt(1 - turn**2), 0, 0, turn))
    world.add(mb.Sphere(0.02), mass=0.4, position=(3, 0, 0.3), velocity=(1.7, 0.6, 0))  # speeds say what rounding is
    world.run(0.4)
    assert world.unsolved_steps == 0
    assert world.worst_residual <= world.settings.tolerance
