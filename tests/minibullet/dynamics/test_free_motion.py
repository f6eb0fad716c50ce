"""Free motion: damping laws by name."""

import pytest

import minibullet as mb


@pytest.mark.parametrize(("law", "left"), [("bullet", 0.9**0.5), ("per_step", 0.9**120)])
def test_damping_takes_the_share_that_its_law_names(law, left):
    """Half a second at 1/240: bullet's law leaves (1 - d)^t, the printed one (1 - d)^steps; linear and angular alike."""
    world = mb.World(settings=mb.Settings(linear_damping=0.1, angular_damping=0.1, damping_law=law))
    body = world.add(mb.Sphere(1.0), mass=1.0, velocity=(2.0, 0, 0), angular_velocity=(0, 3.0, 0))
    world.run(0.5)
    assert body.velocity[0] == pytest.approx(2.0 * left, rel=1e-12)
    assert body.angular_velocity[1] == pytest.approx(3.0 * left, rel=1e-12)
