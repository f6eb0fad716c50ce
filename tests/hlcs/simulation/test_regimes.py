"""Regimes of a ball's motion: flight, impact, slide, roll, rest, each from its own definition."""

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.data.rigid_body import rigid_body
from hlcs.simulation.regimes import REGIMES, classify_regimes
from minibullet import rotations

TIMES = np.arange(30) / 120
RADIUS = 0.05


def regimes(position, spin=0.0, floor=0.0):
    """Names of the regimes of a ball with a spin about y [rad/s]."""
    body = Body(radius=RADIUS)
    orientation = rotations.exponential(np.outer(spin * TIMES, [0, 1, 0]))
    trial = Trial("ball", "1", TIMES, position, orientation, {}, body, Surroundings(floor_height=floor))
    return [REGIMES[k] for k in classify_regimes(trial, rigid_body(body).shape, position, orientation)]


def along(speed, height=RADIUS):
    return np.column_stack([speed * TIMES, 0 * TIMES, height + 0 * TIMES])


def test_on_a_floor_a_ball_slides_rolls_or_rests():
    """The point of contact moves by v without spin, and not at all where spin = v / r."""
    assert set(regimes(along(1.0))) == {"slide"}
    assert set(regimes(along(1.0), spin=1.0 / RADIUS)) == {"roll"}
    assert set(regimes(along(0.01))) == {"rest"}


def test_clear_of_the_floor_or_without_one_it_flies():
    assert set(regimes(along(1.0, height=2 * RADIUS))) == {"flight"}
    assert set(regimes(along(1.0), floor=None)) == {"flight"}


def test_a_jump_of_the_velocity_away_from_the_floor_is_an_impact():
    """Down at 2 m/s until the middle, then up at 1 m/s: 3 m/s in a step, where gravity makes 0.08 m/s."""
    middle = TIMES[15]
    height = RADIUS + np.where(TIMES <= middle, 2.0 * (middle - TIMES), 1.0 * (TIMES - middle))
    found = regimes(np.column_stack([0 * TIMES, 0 * TIMES, height]))
    assert [k for k, name in enumerate(found) if name == "impact"] == [15]
