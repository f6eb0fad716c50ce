"""What effects on contacts are told of them: the velocity of the moment of contact, or of the begin of the step."""

import numpy as np
import pytest

import minibullet as mb


def test_a_new_contact_is_seen_where_it_touches_and_a_held_one_as_the_step_begins():
    """From rest 10 um above a floor a ball touches at sqrt(2 g h); later the floor bears its weight and it does not move."""
    world = mb.World(effects=[mb.Gravity()])
    world.add_plane()
    world.add(mb.Sphere(0.1), mass=1.0, position=(0.0, 0.0, 0.1 + 1e-5))
    world.step()
    (touch,) = world.last_step.contacts.velocity
    assert touch == pytest.approx([0.0, 0.0, -np.sqrt(2 * 9.81 * 1e-5)], rel=1e-9)
    for _ in range(40):
        world.step()
    held = world.last_step.contacts
    assert held.load[0] == pytest.approx(9.81, rel=1e-6) and np.abs(held.velocity).max() < 1e-8
