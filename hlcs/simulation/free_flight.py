"""Free flight of many bodies at once: classical Runge-Kutta for the effects' forces, no contacts.

The forces are those the engine would ask for (`effect.forces`, `effect.added_mass`); only the integration is another,
of fourth order, so that its error lies far below any measurement and many perturbed starts fly in one batch.
"""

from typing import NamedTuple

import numpy as np

from minibullet import rotations
from minibullet.bodies import Bodies
from minibullet.effects import AddedMass, contract
from minibullet.kernels import leaf
from minibullet.rotations import rotation_matrices
from minibullet.vectors import turn, turn_back

STIFF, SHORTEST = 1.0, 2e-3  # h |da/dv| above which steps are too long [-], and a step that is not cut any more [s]
JUMP = 60.0  # a mean acceleration over one step that only an impact gives [m/s2]


class Track(NamedTuple):
    """Motion of B bodies on a common grid of T times since the start."""

    times: np.ndarray  # (T,) [s]
    position: np.ndarray  # (T, B, 3) [m]
    velocity: np.ndarray  # (T, B, 3) [m/s]
    orientation: np.ndarray  # (T, B, 4)
    spin: np.ndarray  # angular velocity, world frame (T, B, 3) [rad/s]

    def subset(self, bodies):
        """The Track of some of the bodies (a slice or indices)."""
        return Track(self.times, *(part[:, bodies] for part in self[1:]))

    def observe(self, times):
        """Position (B, n, 3) and orientation (B, n, 4) at times (B, n).

        Cubic Hermite between nodes, straight on outside; where the velocity jumps inside a step (an impact), two straight
        pieces that meet at the moment of the jump.
        """
        h = np.diff(self.times)
        last = len(self.times) - 2
        index = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, last)
        who = np.arange(self.position.shape[1])[:, None]
        step = h[index]
        s = (times - self.times[index]) / step
        inside = np.clip(s, 0.0, 1.0)[..., None]
        beyond = ((s - np.clip(s, 0.0, 1.0)) * step)[..., None]
        x0, x1 = self.position[index, who], self.position[index + 1, who]
        v0, v1 = self.velocity[index, who] * step[..., None], self.velocity[index + 1, who] * step[..., None]
        square, cube = inside**2, inside**3
        position = (
            (2 * cube - 3 * square + 1) * x0
            + (cube - 2 * square + inside) * v0
            + (3 * square - 2 * cube) * x1
            + (cube - square) * v1
        )
        jump = v0 - v1
        size = np.sum(jump**2, axis=-1, keepdims=True)
        hit = size > (JUMP * step[..., None] ** 2) ** 2
        if hit.any():
            moment = np.clip(np.sum((x1 - x0 - v1) * jump, axis=-1, keepdims=True) / np.where(size > 0, size, 1.0), 0.0, 1.0)
            position = np.where(hit, np.where(inside < moment, x0 + inside * v0, x1 - (1 - inside) * v1), position)
        position = position + beyond * np.where(s[..., None] > 1, v1, v0) / step[..., None]
        q0, q1 = self.orientation[index, who], self.orientation[index + 1, who]
        turn = rotations.logarithm(rotations.product(q1, rotations.conjugate(q0)))
        orientation = rotations.product(rotations.exponential((inside + beyond / step[..., None]) * turn), q0)
        return position, orientation


@leaf
def euler(rotation, spin, torque, inertia, faster):
    """Fill in the angular accelerations (n, 3) of free bodies: Euler's equations in the principal axes of each.

    rotation: body axes to world axes (n, 3, 3); spin, torque, faster: along the world's axes (n, 3); inertia: principal (n, 3).
    """
    for n in range(len(spin)):
        a, b, c = turn_back(rotation[n], spin[n])
        x, y, z = turn_back(rotation[n], torque[n])
        i, j, k = inertia[n, 0], inertia[n, 1], inertia[n, 2]
        faster[n, 0], faster[n, 1], faster[n, 2] = turn(
            rotation[n], ((x + (j - k) * b * c) / i, (y + (k - i) * c * a) / j, (z + (i - j) * a * b) / k)
        )


def accelerations(bodies: Bodies, effects):
    """Function (time, position, velocity, orientation, spin) -> (linear, angular acceleration) of n free bodies, (n, 3) each."""
    mass, added = bodies.mass[:, None], contract.added_mass(effects, bodies)
    if added is not None and all(
        type(effect) is AddedMass for effect in effects if type(effect).added_mass is not contract.Effect.added_mass
    ):
        mass, added = mass + added[:, 0, :1], None  # the same in every direction and attitude: so much more to accelerate
    forceful = [effect for effect in effects if type(effect).forces is not contract.Effect.forces]
    isotropic = np.allclose(bodies.inertia, bodies.inertia[:, :1])
    n = len(bodies.mass)

    def rates(time, x, v, q, w):
        state = bodies._replace(position=x, orientation=q, twist=np.concatenate([v, w], axis=1))
        total = np.zeros((n, 6))
        for effect in forceful:
            total += effect.forces(state, time)
        if added is None and isotropic:
            return total[:, :3] / mass, total[:, 3:] / bodies.inertia
        axes = rotation_matrices(q)
        if added is None:
            angular = np.empty((n, 3))
            euler(axes, w, total[:, 3:], bodies.inertia, angular)
            return total[:, :3] / mass, angular
        inertia = np.einsum("nij,nj,nkj->nik", axes, bodies.inertia, axes)
        total[:, 3:] -= rotations.cross(w, np.einsum("nij,nj->ni", inertia, w))
        effective = np.zeros((n, 6, 6))
        effective[:, [0, 1, 2], [0, 1, 2]] = mass
        effective[:, 3:, 3:] = inertia
        effective += contract.added_mass(effects, state)
        acceleration = np.linalg.solve(effective, total[:, :, None])[:, :, 0]
        return acceleration[:, :3], acceleration[:, 3:]

    return rates


def turned(q, angle):
    """Orientations (n, 4) turned by rotation vectors (n, 3), world frame."""
    return rotations.product(rotations.exponential(angle), q) if angle.any() else q


def fly(bodies: Bodies, effects, duration, step) -> Track:
    """Fly n bodies for `duration` [s] under the effects (gravity among them), in equal steps of at most `step` [s].

    Where an acceleration answers a change of velocity within the step (the drag of a light body in a liquid) the flight is done
    again in shorter steps: beyond 2.8 / h Runge-Kutta's answer grows without end.
    """
    count = max(int(np.ceil(duration / step - 1e-9)), 1)
    h, rates = duration / count, accelerations(bodies, effects)
    x, v, q, w = (
        np.array(part, dtype=float) for part in (bodies.position, bodies.twist[:, :3], bodies.orientation, bodies.twist[:, 3:])
    )
    record = [np.empty((count + 1, *part.shape)) for part in (x, v, q, w)]
    for k in range(count + 1):
        for store, value in zip(record, (x, v, q, w), strict=True):
            store[k] = value
        if k == count:
            break
        t = k * h
        a1, w1 = rates(t, x, v, q, w)
        half = turned(q, h / 2 * w)  # a steady spin is turned exactly, however fast it is
        a2, w2 = rates(t + h / 2, x + h / 2 * v, v + h / 2 * a1, half, w + h / 2 * w1)
        v2, v3 = v + h / 2 * a1, v + h / 2 * a2
        a3, w3 = rates(t + h / 2, x + h / 2 * v2, v3, turned(q, h / 2 * (w + h / 4 * w1)), w + h / 2 * w2)
        stiff = 2 * np.max(np.abs(a3 - a2) / (np.abs(a2 - a1) + 1e-3 * np.abs(a1).max() + 1e-9))  # h |da/dv|
        if stiff > STIFF and h > SHORTEST:
            return fly(bodies, effects, duration, max(h / min(np.ceil(2 * stiff), 4.0), SHORTEST))
        v4 = v + h * a3
        a4, w4 = rates(t + h, x + h * v3, v4, turned(q, h * (w + h / 2 * w2)), w + h * w3)
        x = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        q = turned(q, h * w + h * h / 6 * (w1 + w2 + w3))
        w = w + h / 6 * (w1 + 2 * w2 + 2 * w3 + w4)
    return Track(np.arange(count + 1) * h, *record)
