"""Free motion: order four of the rotation, momentum kept, damping laws by name, which mean twist a body moves with."""

import numpy as np
import pytest

import minibullet as mb
from minibullet.dynamics import integration

INERTIA = np.array([1.0, 2.0, 3.0])


def tumble(step, duration=1.0):
    """Orientation (4,) and angular velocity (3,) of a free body with unequal moments after ``duration`` seconds."""
    q, w = np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[0.5, 3.0, 1.0]])
    for _ in range(round(duration / step)):
        turned, w = integration.spin_freely(q, w, INERTIA[None], step)
        _, q = integration.moved(np.zeros((1, 3)), q, np.concatenate([np.zeros((1, 3)), turned / step], axis=1), step)
    return q[0], w[0]


def momentum(q, w):
    turn = mb.rotations.matrix(q)
    return turn @ (INERTIA * (turn.T @ w))


def test_free_rotation_has_order_four():
    """Error against a step 16 times smaller falls by 2^4 when the step is halved (15 to 17 here: the next order still shows)."""
    exact = tumble(1 / 3200)[0]
    errors = [np.linalg.norm(tumble(step)[0] - exact) for step in (1 / 50, 1 / 100, 1 / 200)]
    assert errors[2] < 1e-7
    for coarse, fine in zip(errors, errors[1:], strict=False):
        assert 14.0 < coarse / fine < 18.0


def test_angular_momentum_of_free_rotation_is_kept():
    """It is a datum of every step, so 240 steps leave only rounding."""
    start = momentum(np.array([1.0, 0, 0, 0]), np.array([0.5, 3.0, 1.0]))
    np.testing.assert_allclose(momentum(*tumble(1 / 240)), start, rtol=1e-12)


def test_angular_momentum_takes_exactly_the_impulse_of_a_torque():
    """keep_angular_momentum through World: a block with unequal moments, spinning, struck by a constant moment; its angular
    momentum grows by M t to rounding although its inertia turns within each step."""

    class Moment(mb.Effect):
        def forces(self, bodies, time):
            wrench = np.zeros((len(bodies.mass), 6))
            wrench[:, 3:] = (0.3, -0.2, 0.5)
            return wrench

    world = mb.World([Moment()])
    body = world.add(mb.Box(1, 1, 1), mass=1.0, inertia=INERTIA, angular_velocity=(0.5, 3.0, 1.0))
    start = momentum(body.orientation, body.angular_velocity)
    world.step(100)
    change = momentum(body.orientation, body.angular_velocity) - start
    np.testing.assert_allclose(change, np.array([0.3, -0.2, 0.5]) * world.time, atol=1e-12)


@pytest.mark.parametrize(("law", "left"), [("bullet", 0.9**0.5), ("per_step", 0.9**120)])
def test_damping_takes_the_share_that_its_law_names(law, left):
    """Half a second at 1/240: bullet's law leaves (1 - d)^t, the printed one (1 - d)^steps; linear and angular alike."""
    world = mb.World(settings=mb.Settings(linear_damping=0.1, angular_damping=0.1, damping_law=law))
    body = world.add(mb.Sphere(1.0), mass=1.0, velocity=(2.0, 0, 0), angular_velocity=(0, 3.0, 0))
    world.run(0.5)
    assert body.velocity[0] == pytest.approx(2.0 * left, rel=1e-12)
    assert body.angular_velocity[1] == pytest.approx(3.0 * left, rel=1e-12)


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


def test_path_bound_holds_for_every_point_of_the_body(generator):
    """(|v| + |omega| R) t against where the points of a turning box really go."""
    twist = generator.normal(size=(1, 6)) * (1, 1, 1, 5, 5, 5)
    corner = np.array([0.3, 0.4, 1.2])
    bound = integration.path_bound(twist, np.array([1.3]), 0.1)[0]
    place, pose = integration.moved(np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), twist, 0.1)
    assert np.linalg.norm(place[0] + mb.rotations.rotate(pose[0], corner) - corner) <= bound


def test_the_inverse_mass_is_that_of_the_library(generator):
    """Gauss-Jordan against NumPy on 100 masses with added mass and coupling, moments apart by up to 1e6: to rounding times the
    condition number."""
    root = generator.normal(size=(100, 6, 6)) * 10.0 ** generator.uniform(-1.5, 1.5, (100, 6, 1))
    matrices = root @ root.swapaxes(1, 2)
    found = matrices.copy()
    integration.invert(found)
    error = np.linalg.norm(found @ matrices - np.eye(6), axis=(1, 2))
    assert (error < 1e-14 * np.linalg.cond(matrices)).all()
