"""What enters a world: refused in one line that names body, field and value, or kept as given."""

import numpy as np
import pytest

import minibullet as mb

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"position": (0, NAN, 0)}, ("position", "nan", "finite")),
        ({"position": (0, 0)}, ("position", "2 values", "needs 3")),
        ({"position": "here"}, ("position", "3 numbers")),
        ({"velocity": (INF, 0, 0)}, ("velocity", "inf", "finite")),
        ({"angular_velocity": (0, 0, NAN)}, ("angular_velocity", "nan", "finite")),
        ({"orientation": (0, 0, 0, 0)}, ("orientation", "length 0")),
        ({"orientation": (1, 0, 0)}, ("orientation", "needs 4")),
        ({"mass": -3.0}, ("mass = -3.0 kg", "needs mass > 0", "fixed=True")),
        ({"mass": 0.0}, ("mass = 0.0 kg", "needs mass > 0")),
        ({"mass": NAN}, ("mass = nan", "needs mass > 0")),
        ({"mass": "3"}, ("mass = '3'", "needs mass > 0")),
        ({"mass": 1 + 2j}, ("mass = (1+2j)", "needs mass > 0")),
        ({"group": "a"}, ("group = 'a'", "whole number")),
        ({"group": NAN}, ("group = nan", "whole number")),
        ({"inertia": "x"}, ("inertia = 'x'", "three principal moments")),
        ({"friction": "rough"}, ("friction = 'rough'", ">= 0")),
        ({"mass": 1.0, "density": 1.0}, ("exactly one",)),
        ({"mass": None}, ("exactly one", "fixed=True")),
        ({"mass": None, "density": -1.0}, ("density = -1.0 kg/m3", "density > 0")),
        ({"friction": -0.1}, ("friction = -0.1", ">= 0 and finite")),
        ({"friction": INF}, ("friction = inf", "finite")),
        ({"friction": NAN}, ("friction = nan", "finite")),
        ({"restitution": 1.5}, ("restitution = 1.5", "between 0 and 1")),
        ({"restitution": NAN}, ("restitution = nan", "between 0 and 1")),
        ({"margin": -0.1}, ("margin = -0.1", ">= 0")),
        ({"inertia": (1.0, 1.0, 2.5)}, ("inertia", "3.", "A + B >= C")),
        ({"inertia": (1.0, -1.0, 1.0)}, ("inertia", "must be > 0")),
        ({"inertia": (1.0, 1.0)}, ("inertia", "three principal moments")),
        ({"inertia": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, ("inertia", "symmetric")),
        ({"mass": None, "fixed": True, "velocity": (1, 0, 0)}, ("fixed=True", "never moves")),
    ],
)
def test_unusable_bodies_are_refused_in_one_line(given, words):
    """The message names the body, the field, the value and the remedy, and nothing has been added."""
    world = mb.World()
    with pytest.raises(mb.InputError) as refused:
        world.add(mb.Box(1, 1, 1), **{"mass": 1.0, "name": "u17", **given})
    message = str(refused.value)
    assert message.startswith("body 'u17':") and "\n" not in message
    assert all(word in message for word in words), message
    assert world.bodies == []


@pytest.mark.parametrize("shape", ["box", None, 3.0, mb.Box])
def test_an_unknown_shape_is_refused(shape):
    """A name, a number or a class in place of a shape."""
    with pytest.raises(mb.InputError, match="must be a shape such as"):
        mb.World().add(shape, mass=1.0)


@pytest.mark.parametrize("given", [{"normal": (0, 0, 0)}, {"normal": (0, NAN, 1)}, {"height": INF}, {"friction": -1.0},
                                   {"restitution": 2.0}])  # fmt: skip
def test_unusable_planes_are_refused(given):
    """A normal without direction, numbers that are none."""
    with pytest.raises(mb.InputError, match="plane 'floor'"):
        mb.World().add_plane(**{"name": "floor", **given})


def test_handles_are_live_and_what_is_set_is_what_is_read():
    """Before the first step and after it; what is read is a copy, and what is added to it is set."""
    world = mb.World()
    body = world.add(mb.Box(1, 2, 3), mass=1.0)
    turn = mb.rotations.exponential(np.array([0.3, -0.2, 0.9]))
    for _ in range(2):
        body.position, body.velocity, body.angular_velocity, body.orientation = (1, 2, 3), (4, 5, 6), (0.1, 0.2, 0.3), turn
        np.testing.assert_array_equal(body.position, (1, 2, 3))
        np.testing.assert_array_equal(body.velocity, (4, 5, 6))
        np.testing.assert_array_equal(body.angular_velocity, (0.1, 0.2, 0.3))
        np.testing.assert_allclose(body.orientation, turn, atol=1e-15)
        body.position[:] = 7.0
        body.velocity += (1.0, 0.0, 0.0)
        np.testing.assert_array_equal(body.velocity, (5, 5, 6))
        body.velocity -= (1.0, 0.0, 0.0)
        np.testing.assert_array_equal(body.position, (1, 2, 3))
        world.step()
        np.testing.assert_allclose(body.position, np.array([1, 2, 3]) + np.array([4, 5, 6]) / 240, atol=1e-15)


def test_what_cannot_be_set_says_so():
    """Mass after adding, a state that is no state, speed of a fixed body, a name that no body has."""
    world = mb.World()
    body, rock = world.add(mb.Sphere(1), mass=1.0), world.add(mb.Sphere(1), fixed=True, position=(3, 0, 0))
    with pytest.raises(AttributeError, match="mass cannot be set"):
        body.mass = 2.0
    with pytest.raises(mb.InputError, match="finite"):
        body.position = (0, 0, NAN)
    with pytest.raises(mb.InputError, match="length 0"):
        body.orientation = (0, 0, 0, 0)
    with pytest.raises(mb.InputError, match="never moves"):
        rock.velocity = (1, 0, 0)
    with pytest.raises(AttributeError, match="no 'colour'"):
        body.colour  # noqa: B018


def test_inertia_about_skew_axes_turns_with_its_principal_axes():
    """A full tensor and its principal moments in a turned body are the same body: same motion to rounding; the handle's
    orientation stays the user's."""
    turn = mb.rotations.exponential(np.array([0.4, 0.3, -0.8]))
    matrix = mb.rotations.matrix(turn)
    moments, spin = np.array([1.0, 2.0, 2.5]), np.array([1.0, 2.0, -1.0])
    world = mb.World()
    plain = world.add(mb.Sphere(0.1), mass=1.0, inertia=moments, orientation=turn, angular_velocity=spin)
    skew = world.add(mb.Sphere(0.1), mass=1.0, inertia=matrix @ np.diag(moments) @ matrix.T, position=(5, 0, 0),
                     angular_velocity=spin)  # fmt: skip
    world.step(240)
    np.testing.assert_allclose(skew.angular_velocity, plain.angular_velocity, atol=1e-12)
    expected = mb.rotations.product(plain.orientation, mb.rotations.conjugate(turn))
    np.testing.assert_allclose(mb.rotations.matrix(skew.orientation), mb.rotations.matrix(expected), atol=1e-12)


def test_friction_of_a_contact_follows_its_rule():
    """Both have one: geometric mean. One has one: that. None: the settings'. Numbers by hand."""
    world = mb.World([mb.Gravity()], mb.Settings(friction=0.11))
    world.add_plane(name="floor")
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5), friction=0.9, name="rough")
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 1.5), friction=0.4, name="smooth")
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 2.5), name="silent")
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(5, 0, 0.5), name="alone")
    world.step()
    table = world.contacts.to_dataframe()
    found = {frozenset(key): group.friction.unique() for key, group in table.groupby(["body_a", "body_b"])}
    expected = {("floor", "rough"): 0.9, ("rough", "smooth"): 0.6, ("smooth", "silent"): 0.4, ("floor", "alone"): 0.11}
    for pair, value in expected.items():
        np.testing.assert_allclose(found[frozenset(pair)], [value], rtol=1e-15)


@pytest.mark.parametrize("group", [-1, 0.5, "a", True, float("nan")])
def test_a_group_that_is_no_number_is_refused_for_bodies_and_planes_alike(group):
    """One line that names who, the value and the rule; a plane of a group lets other groups through."""
    world = mb.World([mb.Gravity()])
    for add in (lambda: world.add(mb.Sphere(0.1), mass=1.0, group=group), lambda: world.add_plane(group=group)):
        with pytest.raises(mb.InputError, match="group = .*whole number >= 0"):
            add()
    world.add_plane(group=1)
    through = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 0.1), group=2)
    held = world.add(mb.Sphere(0.1), mass=1.0, position=(1, 0, 0.1), group=1)
    world.step(60)
    assert through.position[2] < -0.1 and abs(held.position[2] - 0.1) < 1e-9


def test_a_body_like_another_is_what_it_would_be_if_it_were_added():
    """Its record is the same in every field, mass and principal moments too, and its state is checked as that of any body."""
    state = {"position": (1, 2, 3), "orientation": (1, 1, 0, 0), "velocity": (1, 0, 0), "angular_velocity": (0, 2, 0)}
    manners = {"group": 4, "friction": 0.3, "restitution": None}
    world, shape = mb.World(), mb.Box(1, 2, 3)
    first = world.add(shape, mass=2.0, name="first")
    alike = world.registry.add_alike(first, "other", **manners, **state)._record
    added = world.add(shape, mass=2.0, name="other", **manners, **state)._record
    assert alike.keys() == added.keys()
    for key, value in added.items():
        np.testing.assert_array_equal(alike[key], value)
    with pytest.raises(mb.InputError, match="velocity"):
        world.registry.add_alike(first, "other", **manners, **(state | {"velocity": (np.nan, 0, 0)}))
