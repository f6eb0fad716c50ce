"""Torque-free rotation: order four, momentum kept, and what torques make of it."""

import numpy as np

import minibullet as mb
from minibullet.dynamics.integrate import moved
from minibullet.dynamics.rigid_rotation import torque_free_rotation

INERTIA = np.array([1.0, 2.0, 3.0])


def tumble(step, duration=1.0):
    """Orientation (4,) and angular velocity (3,) of a free body with unequal moments after ``duration`` seconds."""
    q, w = np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[0.5, 3.0, 1.0]])
    for _ in range(round(duration / step)):
        turned, w = torque_free_rotation(q, w, INERTIA[None], step)
        _, q = moved(np.zeros((1, 3)), q, np.concatenate([np.zeros((1, 3)), turned / step], axis=1), step)
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
