"""Gauss-Seidel with exact local solves: hand-solved cases, and no friction outside the cone."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb
from minibullet.contact import faces, gauss_seidel


def solved(problem, **options):
    none = np.zeros((len(problem.target), 3))
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


def test_the_corners_of_a_face_share_its_load_in_few_sweeps():
    """Four corners of which two are to close by 1e-6 m/s more than any motion of a rigid body lets them: sweeps hand the load
    from corner to corner by as little as that, for thousands of them. With targets that a body can attain it is solved in ten."""
    generator = np.random.default_rng(5)
    world = mb.World()
    world.add_plane()
    velocity, spin = (*0.4 * generator.normal(size=2), -0.5), 3 * generator.normal(size=3)
    world.add(mb.Box(0.1, 0.1, 0.1), mass=0.37, position=(0, 0, 0.05), velocity=velocity, angular_velocity=spin)
    problem = scenes.problem(world)
    corner = problem.factors.jacobian[:, 0, 0]
    unlike = problem.target + 1e-6 * (np.sign(corner[:, 3] * corner[:, 4]) - 1)
    attainable = faces.attainable(unlike, problem.factors, problem.rolling, np.full(4, 1e-5))
    last = np.abs(generator.normal(size=(4, 3))) * np.array([0.02, 0.0, 0.0])
    handed_on, shared = (
        gauss_seidel.solve(problem._replace(target=target), last, 0 * last, iterations=1000, tolerance=1e-8)
        for target in (unlike, attainable)
    )
    assert handed_on.iterations == 1000 and handed_on.residual > 1e-7
    assert shared.iterations < 100 and shared.residual <= 1e-8
    assert (shared.impulse[:, 0] > 0.0).all()
