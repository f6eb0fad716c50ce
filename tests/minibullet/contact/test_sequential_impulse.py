"""Bullet's way beside the exact one: the friction pyramid, and what a fixed number of sweeps leaves."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb


def deceleration(solver, heading):
    """Deceleration over g of a block that slides at 3 m/s along ``heading`` [rad] on friction 0.6."""
    world = mb.World([mb.Gravity(10.0)], mb.Settings(friction=0.6, solver=solver))
    world.add_plane()
    start = 3.0 * np.array([np.cos(heading), np.sin(heading), 0.0])
    block = world.add(mb.Box(2.0, 2.0, 0.1), mass=1.0, position=(0, 0, 0.05), velocity=start)
    world.step(10)
    return np.linalg.norm(start - block.velocity) / (10.0 * world.time)


@pytest.mark.parametrize(("solver", "diagonal"), [("sequential_impulse", 0.6 * np.sqrt(2.0)), ("exact", 0.6)])
def test_two_clamped_rows_make_a_pyramid_and_the_cone_a_disc(solver, diagonal):
    """Along an axis of the contact frame both give 0.6; at 45 degrees two rows at their limit add up to 0.6 sqrt(2) = 0.85,
    where Coulomb's disc stays at 0.6. Fifty sweeps of clamped rows settle to 1e-3, the exact solver to its tolerance."""
    accuracy = 1e-3 if solver == "sequential_impulse" else 1e-7
    assert deceleration(solver, 0.0) == pytest.approx(0.6, rel=accuracy)
    assert deceleration(solver, np.pi / 4) == pytest.approx(diagonal, rel=accuracy)


def test_the_certificate_sees_the_pyramid():
    """At 45 degrees its answer is no solution of Coulomb's law, however many sweeps; the exact one is."""
    for solver, solved in (("sequential_impulse", False), ("exact", True)):
        world, _ = scenes.block_on_floor(velocity=(2.0, 2.0, -1.0), solver=solver, iterations=400)
        world.step()
        assert bool(world.last_step.converged) is solved
        assert (world.last_step.components["cone"] < 1e-9) is solved


def test_fifty_sweeps_is_fifty_sweeps():
    """A fixed number of sweeps, as Bullet makes; the residual is reported and never stops them."""
    world, _ = scenes.block_on_floor(velocity=(0.0, 0.0, -1.0), solver="sequential_impulse", iterations=50)
    world.step()
    assert world.last_step.iterations == 50
