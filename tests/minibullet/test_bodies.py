"""The records: their fields are an interface, so they are written down here once more."""

import numpy as np

from minibullet.bodies import Bodies, ContactLaw, Contacts, angular_velocity, moving, velocity


def some_bodies():
    return Bodies(
        np.zeros((2, 3)),
        np.array([[1.0, 0, 0, 0]] * 2),
        np.arange(12.0).reshape(2, 6),
        np.array([2.0, np.inf]),
        np.ones((2, 3)),
        np.ones(2),
        np.ones(2),
        np.ones(2),
    )


def test_fields_and_their_order():
    assert Bodies._fields == ("position", "orientation", "twist", "mass", "inertia", "volume", "area", "radius")
    assert Contacts._fields == ("body_a", "body_b", "point", "normal", "gap", "velocity", "load")
    assert ContactLaw._fields == ("friction", "restitution", "rolling_arm", "spinning_arm", "adhesion")


def test_twist_is_linear_then_angular():
    bodies = some_bodies()
    assert np.array_equal(velocity(bodies), [[0, 1, 2], [6, 7, 8]])
    assert np.array_equal(angular_velocity(bodies), [[3, 4, 5], [9, 10, 11]])


def test_infinite_mass_is_fixed():
    assert moving(some_bodies()).tolist() == [True, False]
