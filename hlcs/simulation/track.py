"""What bodies did: their motion at the times of a grid, and in between."""

from typing import NamedTuple

import numpy as np

from minibullet import rotations

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
        """Position (B, n, 3) and orientation (B, n, 4) at times (B, n): turns are steady between nodes, and to both sides of an
        impact."""
        index, step, inside, beyond = places = self._places(times)
        who = np.arange(self.position.shape[1])[:, None]
        q0, q1 = self.orientation[index, who], self.orientation[index + 1, who]
        turn = rotations.logarithm(rotations.product(q1, rotations.conjugate(q0)))
        orientation = rotations.product(rotations.exponential((inside + beyond / step[..., None]) * turn), q0)
        hit, moment = impact = self._impact(index, step)
        if hit.any():
            first = inside < moment
            way = np.where(first, inside * self.spin[index, who], (inside - 1) * self.spin[index + 1, who]) * step[..., None]
            pieces = rotations.product(rotations.exponential(way), np.where(first, q0, q1))
            orientation = np.where(hit & (beyond == 0), pieces, orientation)
        return self._position(*places, *impact), orientation

    def position_at(self, times):
        """Position (B, n, 3) at times (B, n).

        Cubic Hermite between nodes, straight on outside; where a contact makes the velocity jump inside a step (an impact), two
        straight pieces that meet at the moment of the jump.
        """
        places = self._places(times)
        return self._position(*places, *self._impact(*places[:2]))

    def _position(self, index, step, inside, beyond, hit, moment):
        """The positions at places as `_places` gives them, with impacts as `_impact` does."""
        who = np.arange(self.position.shape[1])[:, None]
        x0, x1 = self.position[index, who], self.position[index + 1, who]
        v0, v1 = self.velocity[index, who] * step[..., None], self.velocity[index + 1, who] * step[..., None]
        square, cube = inside**2, inside**3
        position = (
            (2 * cube - 3 * square + 1) * x0
            + (cube - 2 * square + inside) * v0
            + (3 * square - 2 * cube) * x1
            + (cube - square) * v1
        )
        if hit.any():
            position = np.where(hit, np.where(inside < moment, x0 + inside * v0, x1 - (1 - inside) * v1), position)
        return position + beyond * np.where(beyond > 0, v1, v0) / step[..., None]

    def _impact(self, index, step):
        """Does an impact make the velocity jump inside the steps `index` (B, n, 1), and after which part of them (B, n, 1)?"""
        if not self.pushed.any():  # a flight: nothing to be looked for at each sample
            return np.zeros((1, 1, 1), bool), 0.0
        who, step = np.arange(self.position.shape[1])[:, None], step[..., None]
        after = self.velocity[index + 1, who] * step
        jump = self.velocity[index, who] * step - after
        size = np.sum(jump**2, axis=-1, keepdims=True)
        hit = (size > (JUMP * step**2) ** 2) & self.pushed[index, who][..., None]  # no drag, however strong it is
        way = self.position[index + 1, who] - self.position[index, who] - after
        moment = np.sum(way * jump, axis=-1, keepdims=True) / np.where(size > 0, size, 1.0)
        return hit, np.clip(moment, 0.0, 1.0)

    def _places(self, times):
        """(step that each of the times (B, n) lies in, its length [s], the part of it that has passed (B, n, 1) [-], the time
        (B, n, 1) before the first or beyond the last node [s])."""
        h = np.diff(self.times)
        index = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(h) - 1)
        step = h[index]
        passed = (times - self.times[index]) / step
        inside = np.clip(passed, 0.0, 1.0)
        return index, step, inside[..., None], ((passed - inside) * step)[..., None]

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
