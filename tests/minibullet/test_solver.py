"""Gauss-Seidel with exact local solves: hand-solved cases, the certificate, escalation, overlap undone without velocity."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb
from minibullet.contact import gauss_seidel
from minibullet.contact import problem as problems
from minibullet.contact.coulomb import natural_map_error


def solved(problem, **options):
    none = np.zeros((len(problem.bodies), 3))
    return gauss_seidel.solve(problem, none, none, **options)


def ball_on_floor(velocity, friction, spin=(0, 0, 0)):
    """One contact: a ball of 2 kg and radius 0.5 m on the floor with a velocity [m/s] at the end of the free motion."""
    world = mb.World()
    world.add_plane()
    ball = world.add(mb.Sphere(0.5), mass=2.0, position=(0, 0, 0.5), velocity=velocity, angular_velocity=spin)
    return scenes.problem(world, friction), ball


@pytest.mark.parametrize(
    ("velocity", "friction", "expected"),
    [
        ((1.0, 0.0, 0.5), 0.5, (1.0, 0.0, 0.5, 0.0, 0.0, 0.0)),  # takes off
        # sticks: v = 5/7 v0, rolling
        ((0.7, 0.0, -3.0), 0.5, (0.5, 0.0, 0.0, 0.0, 1.0, 0.0)),
        # slides: loses mu v_n, spins up by 5/2 mu v_n/r
        ((3.0, 4.0, -2.0), 0.25, (2.7, 3.6, 0.0, -2.0, 1.5, 0.0)),
        ((3.0, 4.0, -2.0), 0.0, (3.0, 4.0, 0.0, 0.0, 0.0, 0.0)),  # no friction
    ],
)
def test_one_contact_has_the_answer_of_hand_and_residual_zero(velocity, friction, expected):
    """Take-off, stick and slide of a solid ball, to rounding."""
    problem, ball = ball_on_floor(velocity, friction)
    solution = solved(problem)
    np.testing.assert_allclose(solution.twist[ball._row], expected, atol=1e-13)
    assert solution.residual < 1e-14


def test_residual_is_the_natural_map_of_the_whole_problem(generator):
    """The certificate recomputed with plain NumPy from W and q, impulses over the reference mass, for impulses of any quality."""
    world, _ = scenes.block_on_floor(velocity=(1.0, 0.5, -1.0))
    problem = scenes.problem(world, 0.4)
    impulse = generator.normal(size=(len(problem.bodies), 3)) + (1.0, 0.0, 0.0)
    solution = gauss_seidel.solve(problem, impulse, np.zeros_like(impulse), iterations=1, tolerance=1e-16)
    W, q = problems.delassus(problem)
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
    problem, _ = ball_on_floor((3.0, 4.0, -2.0), 0.25)
    none = np.zeros((1, 3))
    bad = gauss_seidel.solve(problem, none, none, iterations=1)._replace(impulse=none)
    size = gauss_seidel.free_size(problem)
    for rounding, expected in ((0.0, 1.0), (10.0, 0.0)):
        found = gauss_seidel.certify(
            problem._replace(rounding=rounding), bad.impulse, none, problem.free_twist, size, 1, 1, bad.stalled
        )
        assert (found.residual > 0.1) == (expected == 1.0)


def test_residual_does_not_know_kilograms_from_grams():
    """Every mass times 1000: the same residual to rounding, because impulses are divided by the reference mass."""
    found = []
    for factor in (1.0, 1000.0):
        world = mb.World()
        world.add_plane()
        for k in range(3):
            world.add(mb.Box(1, 1, 1), mass=factor * (1 + k), position=(0.1 * k, 0, 0.5 + k), velocity=(0.5, 0.2 * k, -1.0))
        found.append(solved(scenes.problem(world), iterations=6, tolerance=1e-16).residual)
    assert found[0] > 1e-8 and found[1] == pytest.approx(found[0], rel=1e-6)


def test_islands_that_stall_are_handed_to_newton():
    """Ten thousand kilograms on one kilogram: Gauss-Seidel stalls after 20 sweeps, the escalation meets the tolerance."""
    world = mb.World()
    world.add_plane()
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5))
    world.add(mb.Box(1, 1, 1), mass=1e4, position=(0, 0, 1.5))
    still = np.zeros((3, 6))
    still[1:, 2] = -9.81 / 240
    problem = scenes.problem(world, 0.5, still)
    first = solved(problem, iterations=20, tolerance=1e-8)
    assert first.residual > 1e-8 and len(first.stalled) == 1
    assert gauss_seidel.escalate(problem, first, 1e-8).residual <= 1e-8


def test_no_friction_outside_the_cone():
    """Every impulse of a sliding, toppling pile of blocks: |r_T| <= mu r_N (1 + 1e-9), r_N >= 0."""
    world = mb.World([mb.Gravity()], mb.Settings(friction=0.3))
    world.add_plane()
    for k in range(4):
        world.add(mb.Box(1, 1, 0.5), mass=1.0, position=(0.3 * k, 0, 0.25 + 0.5 * k), velocity=(2.0 * k, 1.0, 0))
    for _ in range(60):
        world.step()
        r = world.last_step.solution.impulse
        assert (r[:, 0] >= 0.0).all() and (np.hypot(r[:, 1], r[:, 2]) <= 0.3 * r[:, 0] * (1 + 1e-9)).all()


def test_overlap_is_undone_without_velocity():
    """A box sunk 1 cm into the floor rises by 30 % of what is left in each step, down to 1e-9 of its size, and is never given
    a speed."""
    world = mb.World()
    world.add_plane()
    box = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.49))
    for k in range(1, 11):
        world.step()
        assert 0.5 - box.position[2] == pytest.approx(0.01 * 0.7**k, abs=1e-8)
        assert np.abs(box.velocity).max() < 1e-15


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
    problems.apply_impulses(problem.bodies, problem.rows, solution.impulse, twist)
    ball = problem.bodies[0, 1]
    unheld = gauss_seidel.certify(problem, solution.impulse, none, twist, gauss_seidel.free_size(problem), 0, 0, [])
    u = problems.relative_velocity(problem.bodies, problem.rows, twist)
    turned = np.append(0.01 * twist[ball, 3:5], 0.02 * twist[ball, 5])
    size = max(gauss_seidel.free_size(problem)[0], (solution.impulse**2).sum() / 4.0, (u**2).sum() + (turned**2).sum())
    own = natural_map_error(*solution.impulse[0] / 2.0, *u[0], 0.5, 1.0)  # the contact's share; masses in units of the ball's
    assert unheld.residual == pytest.approx(np.sqrt((own + (turned**2).sum()) / size), rel=1e-9)
    assert (turned**2).sum() > 0.01 * own
