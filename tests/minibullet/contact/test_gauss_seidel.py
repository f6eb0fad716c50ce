"""Gauss-Seidel with exact local solves: hand-solved cases, and no friction outside the cone."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb
from minibullet.contact import gauss_seidel


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


def test_sweeps_that_only_hand_a_load_round_from_corner_to_corner_end_early():
    """Four corners of a face share a load that three could bear: from impulses of last step each sweep hands on the same share,
    for thousands of sweeps, and the block moves the same: here to a thousand tolerances, what a residual of so much may cost of
    its largest velocity. It is left within ten thousand of them. A tolerance that forbids this has all the sweeps."""
    generator = np.random.default_rng(0)
    world = mb.World()
    world.add_plane()
    world.add(
        mb.Box(0.1, 0.1, 0.1),
        mass=0.37,
        position=(0, 0, 0.05 + 1e-4 * generator.random()),
        orientation=mb.rotations.exponential(1e-3 * generator.normal(size=3)),
        velocity=(*0.4 * generator.normal(size=2), -generator.random()),
        angular_velocity=3 * generator.normal(size=3),
    )
    problem = scenes.problem(world)
    last = np.abs(generator.normal(size=(4, 3))) * np.array([0.02, 0.0, 0.0])
    early = gauss_seidel.solve(problem, last, 0 * last, iterations=1000, tolerance=1e-8)
    all_sweeps = gauss_seidel.solve(problem, last, 0 * last, iterations=1000, tolerance=1e-12)
    assert early.iterations < 300 and all_sweeps.iterations == 1000
    assert 1e-8 < early.residual < 1e-5 and len(early.unconverged) == 1
    np.testing.assert_allclose(early.twist, all_sweeps.twist, atol=1e-5 * np.abs(problem.free_twist).max())
