"""What impacts show without any engine: restitution against approach speed, and the friction that acted.

In free flight a coordinate less its share of gravity is a straight line in time. Lines through at least five samples on each
side of a kink meet at the moment of contact and give the velocities there. With P = m (v+ - v-), whatever the shape,
mu_eff = |P_t|/P_n, which is the friction where the contact slides one way and less where it grips; for a sphere e = -v_n+/v_n-,
because its centre moves along the normal as its lowest point does.

Drag bends these lines, and a slope at their end is then off: e of a table-tennis ball by 4 %. So a drag k |v| v is read from the
bend of all flights of a body together, and taken off with gravity where they show it.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import integrate

from hlcs.data.rigid_body import lowest_points, rigid_body
from hlcs.data.turns import continued
from minibullet import rotations

LEAST = 5  # samples on each side [-]
LONGEST = 0.15  # how far from an impact samples are used: their lines are straight but for a small bend [s]
SHOWN = 2.0  # standard errors from which a drag is taken off: below, it would scatter the readings more than it mends them
MOST_AT_ONCE = 2_000_000  # numbers of overlapping lines that are held at a time (16 MB each)
CERTAIN = 6.0  # kinks below this many standard errors are no impacts [-]
LOW = 5.0  # errors of a position above the lowest corner at which another may be the one that touches: of two on an edge one [-]


@dataclass(frozen=True)
class Impact:
    """One impact with the floor, as the samples around it show it; SI units, one standard error beside each reading."""

    trial: str
    time: float  # of contact [s]
    speed: float  # of approach of the point that touches, of the centre where it is not known; along the normal, positive [m/s]
    restitution: float | None  # None for bodies that are no spheres and whose turns were not recorded
    restitution_error: float | None
    slip: float | None  # speed along the floor before, of the centre [m/s]; None where it was not recorded
    friction: float | None  # |P_t|/P_n
    friction_error: float | None


class StraightFlight(NamedTuple):
    """The samples of a recording less their share of gravity, so that free flight is a straight line."""

    times: np.ndarray  # (n,) [s]
    positions: np.ndarray  # (n, 3) [m]
    orientations: np.ndarray  # quaternions (n, 4), NaN where not recorded
    heights: np.ndarray  # along the normal of the floor (n,) [m]
    normal: np.ndarray  # of the floor (3,)
    pull: np.ndarray  # gravity (3,) [m/s2]
    sigma: float  # of a position, its correlation from sample to sample included [m]
    unread: tuple = ()  # samples before kinks of which no impact can be read

    @property
    def on_floor(self):
        """The same with the heights as they were recorded: those of a body that stays on its floor are a straight line."""
        fallen = 0.5 * (self.times - self.times[0]) ** 2 * (self.pull @ self.normal)
        return self._replace(heights=self.heights + fallen)

    def bend(self, part, edge):
        """What a drag k |v| v bends a part (a slice) by (n, 3), for k = 1/m: place and slope are kept at the sample `edge`, which
        is next to the impact.

        -|v| v integrated twice over time, v from the line through the part and gravity; 0 along axes that were not recorded.
        """
        times = self.times[part]
        slopes = np.array([line(times, axis, times[0])[1] for axis in self.positions[part].T])
        velocity = np.nan_to_num(slopes) + (times - self.times[0])[:, None] * self.pull
        slowed = -np.linalg.norm(velocity, axis=1)[:, None] * velocity
        for _ in ("velocity", "place"):
            slowed = integrate.cumulative_trapezoid(slowed, times, axis=0, initial=0)
            slowed -= slowed[edge - part.start]
        return slowed

    def without(self, drag, part, edge):
        """The flight with what a drag [1/m] bent a part by taken off there."""
        if not drag:
            return self
        positions, heights = self.positions.copy(), self.heights.copy()
        bend = drag * self.bend(part, edge)
        positions[part] -= bend
        heights[part] -= bend @ self.normal
        return self._replace(positions=positions, heights=heights)


def line(times, values, moment):
    """(value at a moment, slope, covariance of the two for unit noise (2, 2)) of a straight line through samples."""
    design = np.column_stack([np.ones(len(times)), times - moment])
    inverse = np.linalg.inv(design.T @ design)
    return (*(inverse @ (design.T @ values)), inverse)


def slopes(times, values, width):
    """Slopes, and their errors for unit noise, of the lines through each `width` samples in a row, (2, n + 1 - width)."""
    times, values = (np.lib.stride_tricks.sliding_window_view(part, width) for part in (times, values))
    lines = []
    for rows in np.array_split(np.arange(len(times)), 1 + len(times) * width // MOST_AT_ONCE):
        away = times[rows] - times[rows].mean(axis=1, keepdims=True)
        spread = np.sum(away**2, axis=1)
        lines.append((np.sum(away * values[rows], axis=1) / spread, 1 / np.sqrt(spread)))
    return np.concatenate(lines, axis=1)


def kinks(times, height, sigma, width):
    """Places k where a line up to sample k and one from k + 1 on differ most in slope, upwards, by more than CERTAIN errors."""
    count, places = len(times), np.arange(LEAST - 1, len(times) - LEAST)
    before, after = np.empty((2, 2, count))  # slope and error of the line that ends at, and that follows after, each sample
    longest = min(width, count - LEAST)
    for size in range(LEAST, longest):  # near the ends
        before[:, size - 1 : size] = slopes(times[:size], height[:size], size)
        after[:, count - size - 1 : count - size] = slopes(times[-size:], height[-size:], size)
    every = slopes(times, height, longest)
    before[:, longest - 1 :], after[:, : count - longest] = every, every[:, 1:]
    before, after = before[:, places], after[:, places]
    strength = (after[0] - before[0]) / (sigma * np.hypot(after[1], before[1]))
    free, chosen = np.ones(count, bool), []
    for place in np.argsort(-strength, kind="stable"):
        if not strength[place] > CERTAIN:
            break
        if free[places[place]]:  # its neighbours see the same kink
            chosen.append(int(places[place]))
            free[max(chosen[-1] - width, 0) : chosen[-1] + width + 1] = False
    return sorted(chosen)


def impacts_between(trial, flight, sides, drag):
    """The impacts of one recording between the parts of its StraightFlight, as `sides_of` gives them; drag: k of the deceleration
    k v^2 that is taken off beside gravity [1/m]."""
    impacts = [_impact(trial, flight, before, after, drag) for before, after in sides]
    return [impact for impact in impacts if impact is not None]


def sides_of(trial, sigma, rho=0.0):
    """(StraightFlight of a recording, [(samples before, samples after) of each kink that may be an impact, as slices]); None and
    no kinks where it has no floor or no height above it.

    sigma, rho: noise of a position along the normal of the floor [m] and its correlation from sample to sample, which widens the
    errors of slopes.
    """
    around, normal = trial.surroundings, trial.surroundings.normal
    used = np.abs(normal) > 1e-9
    if around.floor_height is None or not sigma:
        return None, []
    there = np.isfinite(trial.position[:, used]).all(axis=1)
    t, x = trial.times[there], trial.position[there]
    if len(t) < 2 * LEAST:
        return None, []
    pull = np.array([0.0, 0.0, -around.gravity])
    straight = x - 0.5 * (t[:, None] - t[0]) ** 2 * pull
    sigma = sigma * np.sqrt((1 + rho) / (1 - rho))
    flight = StraightFlight(t, straight, trial.orientation[there], straight[:, used] @ normal[used], normal, pull, sigma)
    width = max(LEAST, int(LONGEST / np.median(np.diff(t))))
    places = kinks(t, flight.heights, sigma, max(LEAST, width // 3))
    sides, unread = [], []
    for number, k in enumerate(places):
        first = max(k + 1 - width, places[number - 1] + 1 if number else 0)
        last = min(k + 1 + width, places[number + 1] + 1 if number + 1 < len(places) else len(t))
        split = _best_split(flight, first, k + 1, last)
        if split is not None and not _carried(flight, first, split, last):
            sides.append((slice(first, split), slice(split, last)))
        else:
            unread.append(k)
    return flight._replace(unread=tuple(unread)), sides


def _best_split(flight, first, guess, last):
    """Which sample is the first one after an impact: near `guess`, where the two lines leave least; None where a side
    has not enough then. One sample on the wrong side moves a restitution by ten of its standard errors."""

    def left(split):
        enough = min(split - first, last - split) > 2  # else a line leaves nothing
        return _misfit(flight, slice(first, split)) + _misfit(flight, slice(split, last)) if enough else np.inf

    best = guess
    while (near := min((best - 1, best + 1), key=left)) and left(near) < left(best):
        best = near
    return best if min(best - first, last - best) >= LEAST else None


def _carried(flight, first, split, last):
    """Do samples look more like those of a body that rests, slides or rolls on its floor than like two flights?"""
    carried = _misfit(flight.on_floor, slice(first, last))
    flown = _misfit(flight, slice(first, split)) + _misfit(flight, slice(split, last))
    return carried / (last - first - 2) < flown / (last - first - 4)


def _misfit(flight, part):
    """Sum of the squares that a line through the heights of a part of a flight leaves [m2]."""
    times, heights = flight.times[part], flight.heights[part]
    value, slope, _ = line(times, heights, times[0])
    return float(np.sum((heights - value - slope * (times - times[0])) ** 2))


def _along_normal(flight, part, moment):
    """(height [m], velocity [m/s], its error) of the centre along the normal at a moment, by a part of a flight; where it stays
    at one height there, gravity pulls it no further."""
    if len(flight.times[part]) * np.var(flight.on_floor.heights[part]) < _misfit(flight, part):
        flight, since, pull = flight.on_floor, 0.0, 0.0
    else:
        since, pull = moment - flight.times[0], flight.pull @ flight.normal
    value, slope, inverse = line(flight.times[part], flight.heights[part], moment)
    return value + pull * since**2 / 2, slope + pull * since, flight.sigma * np.sqrt(inverse[1, 1])


def _impact(trial, flight, before, after, drag):
    """The Impact between two parts (slices) of a flight, None where they do not meet in an impact upwards."""
    flight = flight.without(drag, before, before.stop - 1).without(drag, after, after.start)
    t = flight.times
    middle = (t[before.stop - 1] + t[after.start]) / 2
    (ends, down, _), (begins, up, _) = (_along_normal(flight, part, middle) for part in (before, after))
    moment = middle - (begins - ends) / (up - down)
    if not t[before.stop - 1] - (t[1] - t[0]) <= moment <= t[after.start] + (t[1] - t[0]):
        return None
    (_, down, error_down), (_, up, error_up) = (_along_normal(flight, part, moment) for part in (before, after))
    speeds, errors, restitution, error = (down, up), (error_down, error_up), None, None
    if (points := _touching(trial.body, flight, before, after, moment)) is not None:
        speeds, errors, restitution, error = _of_a_point(*points, flight.normal, speeds, errors)
    if speeds[0] >= 0.0 or speeds[1] < -CERTAIN * errors[1]:  # on the way down: samples after an impact may be taken for one
        return None
    slip = friction = friction_error = None
    if np.isfinite(flight.positions).all():
        slip, friction, friction_error = _friction(flight, before, after, moment)
    return Impact(trial.name, float(moment), float(-speeds[0]), restitution, error, slip, friction, friction_error)


def _friction(flight, before, after, moment):
    """(speed along the floor before an impact [m/s], |P_t|/P_n, its error) from parts (slices) of a flight on its two sides.

    P is what the floor gave on average between the two parts, while the body stayed on it too: the same average of all three
    coordinates, gravity taken off. So |P_t| <= mu P_n whatever the contact does, and equal while it slides one way.
    """
    lines = [[line(flight.times[part], axis[part], moment) for axis in flight.positions.T] for part in (before, after)]
    down, up = (np.array([slope for _, slope, _ in side]) for side in lines)
    error = flight.sigma * np.sqrt(sum(side[0][2][1, 1] for side in lines))
    normal, along = (up - down) @ flight.normal, _along(up - down, flight.normal)
    slip = _along(down + flight.pull * (moment - flight.times[0]), flight.normal)
    return float(slip), float(along / normal), float(error * np.hypot(1.0, along / normal) / normal)


def _touching(body, flight, before, after, moment):
    """(points that may touch, the lowest first, from the centre of mass (k, 3) [m], [(angular velocity (3,), its error [rad/s])
    before and after]) of an impact; None where the body's turns were not recorded. That of a sphere moves along the normal
    as its centre does."""
    if body.shape == "sphere":
        return np.zeros((1, 3)), [(np.zeros(3), 0.0)] * 2
    if not np.isfinite(flight.orientations[before.start : after.stop]).all():
        return None
    (orientation, *first), (_, *second) = (_turning(flight, part, moment) for part in (before, after))
    return lowest_points(rigid_body(body).shape, orientation, flight.normal, LOW * flight.sigma), (first, second)


def _of_a_point(points, turning, normal, speeds, errors):
    """((speed before, after), their errors, restitution, its error) of the point of a body that touches.

    points, turning: see `_touching`; speeds, errors: of the centre along the normal. What the restitution of the other points
    that may touch differs by is part of the error; where one of them does not approach it is not known: None.
    """
    down, up = (speed + np.cross(spin, points) @ normal for speed, (spin, _) in zip(speeds, turning, strict=True))
    arm = _along(points[0], normal)
    errors = [float(np.hypot(error, arm * its)) for error, (_, its) in zip(errors, turning, strict=True)]
    speeds = down[0], up[0]
    if not (down < 0.0).all():
        return speeds, errors, None, None
    ratio = -up / down
    error = np.hypot(np.hypot(errors[1], ratio[0] * errors[0]) / -down[0], np.ptp(ratio) / 2)
    return speeds, errors, float(ratio[0]), float(error)


def _turning(flight, part, moment):
    """(orientation at a moment, steady angular velocity (3,), its error [rad/s]) of a part of a flight."""
    times, turns = flight.times[part], flight.orientations[part]
    reference = turns[np.argmin(np.abs(times - moment))]
    away = continued(rotations.logarithm(rotations.product(turns, rotations.conjugate(reference))))
    values, spin, inverse = line(times, away, moment)
    left = away - values - np.outer(times - moment, spin)
    sigma = np.sqrt(np.sum(left**2) / (3 * (len(times) - 2)))
    return rotations.product(rotations.exponential(values), reference), spin, sigma * np.sqrt(inverse[1, 1])


def _along(vector, normal):
    """Length of the part of a vector (3,) along a plane."""
    return np.linalg.norm(vector - (vector @ normal) * normal)


def flights_of(flight, sides):
    """Parts (slices) of a StraightFlight that hold no impact: all that lies between two impacts, where no kink is seen there,
    else the samples beside each: drag bends them by far less than all of a flight. Two samples, or one between two impacts that
    follow at once, show no bend and are left out."""
    parts = [sides[0][0]] if sides else []
    for (_, after), (before, _) in pairwise(sides):
        free = not any(after.start < k < before.stop for k in flight.unread)
        parts += [slice(after.start, before.stop)] if free else [after, before]
    parts += [sides[-1][1]] if sides else []
    return [part for part in parts if part.stop - part.start > 2]


def read_drag(recordings):
    """k of the deceleration k v^2 [1/m] that bends the flights around the impacts of recordings of one body; 0.0 where they do
    not show it by SHOWN standard errors. recordings: what `sides_of` gives of each.

    Least squares in one number, a line of its own left to every flight.
    """
    moment, information = 0.0, 0.0
    for flight, sides in recordings:
        for part in flights_of(flight, sides):
            bend = flight.bend(part, part.start) @ flight.normal
            bend -= np.polyval(np.polyfit(flight.times[part], bend, 1), flight.times[part])
            moment += bend @ flight.heights[part] / flight.sigma**2
            information += bend @ bend / flight.sigma**2
    return moment / information if moment > SHOWN * np.sqrt(information) else 0.0


def read_impacts(measurement, noise):
    """The impacts of all recordings of a measurement, tuple of Impact; a drag is read for each body and fluid."""
    found, drags = _flown(measurement, noise)
    return tuple(
        impact
        for trial, parts in found
        for impact in impacts_between(trial, *parts, drags[trial.body, trial.surroundings.fluid_density])
    )


def read_drags(measurement, noise):
    """{(body, density of the fluid): k of the deceleration k v^2 [1/m] between its impacts, 0.0 where they do not show it}."""
    return _flown(measurement, noise)[1]


def _flown(measurement, noise):
    """([(trial, what `sides_of` gives of it)], {(body, density of the fluid): its drag}) of a measurement."""
    found = [(trial, sides_of(trial, noise.towards(trial.surroundings.normal), noise.rho)) for trial in measurement.trials]
    alike = {}
    for trial, parts in found:
        alike.setdefault((trial.body, trial.surroundings.fluid_density), []).append(parts)
    return found, {key: read_drag(recordings) for key, recordings in alike.items()}
