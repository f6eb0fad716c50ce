"""The books of a step: energy and momentum add up, contact takes energy and never gives, the certificate has its parts."""

import numpy as np
import pytest
import small_scenes as scenes

import minibullet as mb


def heap(generator, **settings):
    """Three blocks of unequal moments that fall onto each other."""
    world = mb.World([mb.Gravity(9.81), mb.LinearDrag(rate=0.5)], mb.Settings(friction=0.4, **settings))
    world.add_plane()
    for k, turn in enumerate(mb.rotations.random(generator, 3)):
        world.add(mb.Box(0.6, 0.4, 0.2), density=1000.0, position=(0.1 * k, 0, 0.5 + 0.5 * k), orientation=turn,
                  angular_velocity=generator.normal(size=3))  # fmt: skip
    return world


def world_energy(world):
    """Kinetic energy from masses, moments and velocities of the handles [J]."""
    energy = 0.0
    for body in world.bodies:
        spin = mb.rotations.matrix(body.orientation).T @ body.angular_velocity
        energy += 0.5 * body.mass * body.velocity @ body.velocity + 0.5 * body.inertia @ spin**2
    return energy


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_energy_and_momentum_of_every_step_add_up(generator, restitution):
    """Kinetic energy is the sum of the lines and momentum that of the impulses, to rounding: 1e-12 of the largest line."""
    world = heap(generator, restitution=restitution)
    energy, lost = world_energy(world), 0.0
    for _ in range(200):
        world.step()
        step = world.last_step
        lines = dict(step.work)
        defect = lines.pop("defect")
        largest = max(max(abs(value) for value in lines.values()), step.kinetic_energy)
        assert abs(defect) <= 1e-12 * largest
        assert sum(lines.values()) == pytest.approx(step.kinetic_energy - energy, abs=1e-11 * max(largest, 1.0))
        assert step.momentum_defect <= 1e-12
        assert lines["linear_drag"] <= 0.0
        energy, lost = step.kinetic_energy, lost + lines["contact_normal"] + lines["contact_friction"]
    assert lost < -1.0  # the heap has fallen and lies: joules went into its contacts


def test_friction_books_what_a_sliding_block_loses():
    """10 steps at mu g: the friction lines add up to the change of m v^2/2, the normal ones to nothing."""
    world = mb.World([mb.Gravity(10.0)], mb.Settings(friction=0.3))
    world.add_plane()
    block = world.add(mb.Box(2, 2, 0.1), mass=2.0, position=(0, 0, 0.05), velocity=(3.0, 0, 0))
    friction = normal = 0.0
    for _ in range(10):
        world.step()
        friction, normal = friction + world.last_step.work["contact_friction"], normal + world.last_step.work["contact_normal"]
    assert friction == pytest.approx(0.5 * 2.0 * (block.velocity[0] ** 2 - 9.0), rel=1e-8)
    assert block.velocity[0] == pytest.approx(3.0 - 0.3 * 10.0 * world.time, rel=1e-8)
    assert normal == pytest.approx(0.0, abs=1e-8)


def test_to_dict_has_plain_values_under_the_documented_names(generator):
    """Everything a log needs, as Python numbers; the deepest contact by the names of its bodies."""
    world, _ = scenes.block_on_floor(velocity=(1.0, 0, -1.0))
    world.step()
    found = world.last_step.to_dict()
    assert {"step", "t", "dt", "residual", "converged", "iterations_outer", "iterations_inner", "cone", "dual", "signorini",
            "slip", "penetration_max", "E_kin", "E_pot", "work_by_effect", "work_normal", "work_friction", "ledger_defect",
            "momentum_defect", "reference_mass", "wall_s"} <= set(found)  # fmt: skip
    assert found["step"] == 1 and found["t"] == pytest.approx(1 / 240) and found["n_contacts"] == 4
    assert found["reference_mass"] == 2.0 and found["deepest_contact"]["bodies"] == ("plane 0", "body 1")
    assert found["deepest_contact"]["point"][2] == pytest.approx(0.0, abs=1e-12)
    assert all(found[name] <= 1e-7 for name in ("cone", "dual", "signorini", "slip", "penetration_max"))
    assert np.isfinite([found["E_kin"], found["ledger_defect"]]).all()


def test_a_step_without_contacts_has_books_too():
    """One ball in the air: gravity's line is all, residual 0, no deepest contact."""
    world = mb.World([mb.Gravity(10.0)])
    world.add(mb.Sphere(0.1), mass=2.0)
    world.step()
    found = world.last_step.to_dict()
    assert found["n_contacts"] == 0 and found["residual"] == 0.0 and found["deepest_contact"] is None
    assert found["work_by_effect"]["gravity"] == pytest.approx(0.5 * 2.0 * (10.0 / 240) ** 2, rel=1e-12)


def test_kinetic_and_potential_energy_of_a_free_fall_add_up_to_what_was_there():
    """m a z + m v^2/2 with gravity less buoyancy, a = g (1 - rho V/m): the fall is exact, so the sum is exact to rounding."""
    world = mb.World([mb.Gravity(10.0), mb.Buoyancy(500.0, acceleration=10.0)])
    world.add(mb.Sphere(0.1), density=1000.0, position=(0.0, 0.0, 5.0))
    weight = 1000.0 * 4 / 3 * np.pi * 0.1**3 * 10.0
    world.step(200)
    found = world.last_step.to_dict()
    assert found["E_pot"] == pytest.approx(0.5 * weight * world.bodies[0].position[2], rel=1e-12)
    assert found["E_kin"] + found["E_pot"] == pytest.approx(0.5 * weight * 5.0, rel=1e-12)
