"""The move of a step: with the mean velocity where gaps allow it, else with the last."""

import numpy as np
import pytest

import minibullet as mb


def test_constant_force_moves_by_the_mean_velocity_and_contact_by_the_last():
    """In the air x = v t + a t^2/2 exactly; a sphere that arrives on the floor within a step ends on it, not through it."""
    world = mb.World([mb.Gravity(10.0)])
    world.add_plane()
    flying = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 9.0), velocity=(1.0, 0, 2.0))
    landing = world.add(mb.Sphere(0.1), mass=1.0, position=(5, 0, 0.101), velocity=(0, 0, -2.0))
    world.step()
    t = world.time
    np.testing.assert_allclose(flying.position, (t, 0, 9.0 + 2.0 * t - 5.0 * t * t), atol=1e-15)
    assert landing.position[2] == pytest.approx(0.1, abs=1e-10)
    assert landing.velocity[2] == pytest.approx(-0.001 / t, rel=1e-6)  # closes its gap and no more
    world.step()
    assert landing.velocity[2] == pytest.approx(0.0, abs=1e-7)
