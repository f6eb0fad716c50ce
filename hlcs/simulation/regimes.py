"""What a body is doing at each sample: flight, impact, slide, roll (or tip about an edge), rest; from the model's motion."""

import numpy as np

from hlcs.data.rigid_body import support
from minibullet import rotations

REGIMES = ("flight", "impact", "slide", "roll", "rest")
TOUCHING_GAP = 0.01  # gap below which a body touches, in bounding radii
REST_SPEED = 0.02  # speed below which it rests [m/s]
ROLLING_SLIP = 0.2  # slip below this part of the speed is rolling


def classify_regimes(trial, shape, position, orientation):
    """Index into REGIMES of every sample (n,) of a model's motion: position (n, 3), orientation (n, 4)."""
    regime = np.zeros(len(position), int)
    surroundings = trial.surroundings
    if surroundings.floor_height is None or len(position) < 3:
        return regime
    normal, times = surroundings.normal, trial.times
    lowest = np.array([support(shape, turn, normal).min() for turn in orientation])
    gap = surroundings.above_floor(position) + lowest
    steps = np.diff(times)
    velocity = np.gradient(position, times, axis=0)
    turns = rotations.logarithm(rotations.product(orientation[1:], rotations.conjugate(orientation[:-1]))) / steps[:, None]
    spin = np.concatenate([turns[:1], (turns[1:] + turns[:-1]) / 2, turns[-1:]])
    speed = np.linalg.norm(velocity, axis=1)
    point = velocity + np.cross(spin, lowest[:, None] * normal)
    slip = np.linalg.norm(point - (point @ normal)[:, None] * normal, axis=1)
    touching = gap < TOUCHING_GAP * shape.bounding_radius
    moving = np.maximum(speed, np.linalg.norm(spin, axis=1) * shape.bounding_radius)
    regime[touching] = 2
    regime[touching & (slip < ROLLING_SLIP * np.maximum(moving, 1e-9))] = 3
    regime[touching & (moving < REST_SPEED)] = 4
    before = np.diff(position @ normal) / steps
    change = np.diff(before)  # at the samples 1 .. n-2
    limit = 3 * surroundings.gravity * (steps[1:] + steps[:-1]) / 2 + 0.1
    hits = 1 + np.flatnonzero(change > limit)
    regime[hits] = 1
    return regime
