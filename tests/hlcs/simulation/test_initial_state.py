"""Initial states: what of them is unknown, a guess from exact samples, steps of the unknowns."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.simulation.initial_state import initial_guess, shifted, steady_turn, stepped, unknowns
from minibullet import rotations

TIMES = np.arange(20) / 60
SPIN = np.array([0.3, -0.2, 4.0])
TURN = rotations.exponential(np.array([0.2, 0.5, -0.1]))
ALL, NO_TURNS = np.ones(6, bool), np.array([True] * 3 + [False] * 3)


def trial(start=None, shape="box", **surroundings):
    """A throw with a steady spin, recorded exactly."""
    position = [1.0, 2.0, 3.0] + np.outer(TIMES, [4.0, 0.0, 2.0]) - np.outer(9.81 * TIMES**2 / 2, [0, 0, 1])
    orientation = rotations.product(rotations.exponential(np.outer(TIMES, SPIN)), TURN)
    body = Body(shape="box", size=(0.1, 0.2, 0.3)) if shape == "box" else Body(radius=0.1)
    return Trial("throw", "1", TIMES, position, orientation, start or {}, body, Surroundings(**surroundings))


def test_in_flight_every_part_that_is_not_stated_is_unknown():
    assert len(unknowns(trial(), ALL, False, False, False)) == 12
    assert len(unknowns(trial(), NO_TURNS, False, False, False)) == 6
    stated = unknowns(trial({"position": (0, 0, 0), "angular_velocity": (0, 0, 0)}), ALL, False, False, False)
    assert {slot for slot, _ in stated} == {1, 2}


def test_on_a_floor_the_unknowns_lie_along_it():
    normal = (np.sin(0.1), 0.0, np.cos(0.1))
    found = unknowns(trial(floor_height=0.0, floor_normal=normal), NO_TURNS, True, False, True)
    assert len(found) == 4 and all(abs(direction @ np.array(normal)) < 1e-12 for _, direction in found)
    ball = unknowns(trial(shape="sphere", floor_height=0.0), NO_TURNS, True, False, True)
    assert [slot for slot, _ in ball] == [0, 0, 1, 1, 3, 3]  # it rolls with a spin of its own
    from_the_side = np.array([True, False, True] + [False] * 3)
    ball = unknowns(trial(shape="sphere", floor_height=0.0, floor_normal=normal), from_the_side, True, False, True)
    assert [slot for slot, _ in ball] == [0, 1, 3]  # along the slope, and the spin about y
    assert abs(ball[1][1]) == pytest.approx([np.cos(0.1), 0, np.sin(0.1)]) and list(ball[2][1]) == [0, 1, 0]


def test_an_exact_throw_is_guessed_exactly():
    state = initial_guess(trial(), 0.0, False, False, False)
    assert state[:6] == pytest.approx([1, 2, 3, 4, 0, 2], abs=1e-9)
    assert state[10:] == pytest.approx(SPIN, abs=1e-9)
    assert abs(state[6:10] @ TURN) == pytest.approx(1.0, abs=1e-12)


def test_a_ball_put_on_its_floor_rolls():
    """Spin = n x v / r, and the centre one radius above the floor."""
    ball = trial(shape="sphere", floor_height=0.0)
    ball.orientation[:] = np.nan
    state = initial_guess(ball, 0.0, True, False, True)
    assert state[2] == pytest.approx(0.1) and state[5] == pytest.approx(0.0)
    assert state[10:] == pytest.approx(np.cross([0, 0, 1], state[3:6]) / 0.1)


def test_a_step_moves_what_it_names_and_nothing_else():
    state = np.concatenate([np.zeros(6), TURN, np.zeros(3)])
    moved = stepped(state, ((0, np.eye(3)[2]), (3, np.eye(3)[0])), (0.5, 2.0))
    assert moved.tolist() == [0, 0, 0.5, 0, 0, 0, *TURN, 2.0, 0, 0]
    turned = shifted(state, (2, np.eye(3)[1]), 0.1)
    difference = rotations.logarithm(rotations.product(turned[6:10], rotations.conjugate(TURN)))
    assert difference == pytest.approx([0, 0.1, 0], abs=1e-12) and (state[6:10] == TURN).all()


def test_a_lost_sample_does_not_spoil_a_steady_turn():
    seen = trial().orientation
    seen[0] = rotations.exponential(np.array([2.0, 0.0, 0.0]))
    spin, start = steady_turn(TIMES, seen)
    assert spin == pytest.approx(SPIN, abs=1e-9) and abs(start @ TURN) == pytest.approx(1.0, abs=1e-12)
