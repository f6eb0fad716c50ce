"""What bodies did: their motion at the times of a grid, and in between."""

from typing import NamedTuple

import numpy as np

from minibullet.kernels import kernel, leaf
from minibullet.rotations import one_exponential, one_logarithm, one_product, quaternion
from minibullet.vectors import along, at, dot, minus, plus, put, scaled

KINK = 0.1  # difference of accelerations before and after a step above which it may hold a change of contact [m/s2]
STEADIER = 4.0  # how many times the acceleration must change less on both sides of such a step than in it [-]
JUMP = 60.0  # mean acceleration above which a step in which a contact pushes holds an impact [m/s2]


class Track(NamedTuple):
    """Motion of B bodies on a common grid of T times since the start."""

    times: np.ndarray  # (T,) [s]
    position: np.ndarray  # (T, B, 3) [m]
    velocity: np.ndarray  # (T, B, 3) [m/s]
    orientation: np.ndarray  # (T, B, 4)
    spin: np.ndarray  # angular velocity, world frame (T, B, 3) [rad/s]
    pushed: np.ndarray  # by a contact, within each of the steps between (T - 1, B)

    def subset(self, bodies):
        """The Track of some of the bodies (a slice or indices)."""
        return Track(self.times, *(part[:, bodies] for part in self[1:]))

    def observe(self, times):
        """Position (B, n, 3) and orientation (B, n, 4) at times (B, n).

        Between nodes positions are cubic (Hermite) and turns steady, outside both are steady; where a contact makes the velocity
        jump inside a step (an impact), two straight pieces that meet at the moment of the jump.
        """
        return _observed(Track(*map(np.ascontiguousarray, self)), times)

    def position_at(self, times):
        """Position (B, n, 3) at times (B, n)."""
        return self.observe(times)[0]

    def mean_acceleration(self, times, window):
        """Mean acceleration (B, n, 3) over a window (B, 1) about each of the times (B, n), within the track [m/s2]."""
        begin, end = (np.clip(times + half, self.times[0], self.times[-1]) for half in (-window / 2, window / 2))
        return (self._velocity(end) - self._velocity(begin)) / (end - begin)[..., None]

    def _velocity(self, times):
        """Velocity (B, n, 3) at times (B, n) inside the track: straight between nodes.

        Where the acceleration is another on both sides of a step, and steady there (a slide that stops), two straight pieces that
        go on as those before and after, and meet inside the step.
        """
        step = np.diff(self.times)
        index = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(step) - 1)
        who = np.arange(self.position.shape[1])[:, None]
        slopes = np.diff(self.velocity, axis=0) / step[:, None, None]
        rates = np.concatenate([slopes[:1], slopes[:1], slopes, slopes[-1:], slopes[-1:]])  # that of step k is rates[k + 2]
        earlier, before, within, after, later = (rates[index + k, who] for k in range(5))
        since = (times - self.times[index])[..., None]
        start = self.velocity[index, who]
        kink = before - after
        size = np.sum(kink**2, axis=-1, keepdims=True)
        unsteady = np.sum((before - earlier) ** 2 + (later - after) ** 2, axis=-1, keepdims=True)
        share = np.sum((within - after) * kink, axis=-1, keepdims=True) / np.where(size > 0, size, 1.0)  # before the kink
        aside = np.sum((within - after - share * kink) ** 2, axis=-1, keepdims=True)  # what two such pieces do not explain
        bent = (size > KINK**2) & (unsteady + aside < size / STEADIER**2) & (share > 0) & (share < 1)
        moment = share * step[index][..., None]
        pieces = start + np.minimum(since, moment) * before + np.maximum(since - moment, 0.0) * after
        return np.where(bent, pieces, start + since * within)


@kernel
def _observed(track, times):
    position, orientation = np.empty((*times.shape, 3)), np.empty((*times.shape, 4))
    for b in range(times.shape[0]):
        for n in range(times.shape[1]):
            place = _place(track.times, times[b, n])
            impact = _impact(track, b, place)
            put(position[b], n, _position(track, b, place, impact))
            w, x, y, z = _orientation(track, b, place, impact)
            orientation[b, n, 0], orientation[b, n, 1], orientation[b, n, 2], orientation[b, n, 3] = w, x, y, z
    return position, orientation


@leaf
def _place(nodes, time):
    """(step that a time lies in, its length [s], the part of it that has passed [-], the time before the first or beyond the last
    node [s])."""
    first, last = 0, len(nodes) - 1
    while last - first > 1:
        middle = (first + last) // 2
        if nodes[middle] <= time:
            first = middle
        else:
            last = middle
    step = nodes[first + 1] - nodes[first]
    passed = (time - nodes[first]) / step
    inside = 0.0 if passed < 0.0 else 1.0 if passed > 1.0 else passed
    return first, step, inside, (passed - inside) * step


@leaf
def _impact(track, b, place):
    """(does an impact make the velocity of body b jump inside this step?, after which part of it)."""
    k, step, _, _ = place
    after = scaled(step, at(track.velocity[k + 1], b))
    jump = minus(scaled(step, at(track.velocity[k], b)), after)
    size = dot(jump, jump)
    if not track.pushed[k, b] or not size > (JUMP * step * step) ** 2:  # no drag, however strong it is
        return False, 0.0
    way = minus(minus(at(track.position[k + 1], b), at(track.position[k], b)), after)
    return True, min(max(dot(way, jump) / size, 0.0), 1.0)


@leaf
def _position(track, b, place, impact):
    """Position of body b."""
    (k, step, inside, beyond), (hit, moment) = place, impact
    x0, v0 = at(track.position[k], b), at(track.velocity[k], b)
    x1, v1 = at(track.position[k + 1], b), at(track.velocity[k + 1], b)
    if hit:
        there = along(x0, inside * step, v0) if inside < moment else along(x1, (inside - 1.0) * step, v1)
    else:
        square, cube = inside * inside, inside * inside * inside
        leaving = along(scaled(2.0 * cube - 3.0 * square + 1.0, x0), (cube - 2.0 * square + inside) * step, v0)
        there = plus(leaving, along(scaled(3.0 * square - 2.0 * cube, x1), (cube - square) * step, v1))
    return along(there, beyond, v1 if beyond > 0.0 else v0)


@leaf
def _orientation(track, b, place, impact):
    """Orientation of body b."""
    (k, step, inside, beyond), (hit, moment) = place, impact
    q0, q1 = quaternion(track.orientation[k], b), quaternion(track.orientation[k + 1], b)
    if hit and beyond == 0.0 and inside < moment:
        return one_product(one_exponential(scaled(inside * step, at(track.spin[k], b))), q0)
    if hit and beyond == 0.0:
        return one_product(one_exponential(scaled((inside - 1.0) * step, at(track.spin[k + 1], b))), q1)
    turn = one_logarithm(one_product(q1, (q0[0], -q0[1], -q0[2], -q0[3])))
    return one_product(one_exponential(scaled(inside + beyond / step, turn)), q0)
