"""A note says at which stamp a stated start is taken, and who was still held when a recording began; falls in closed form."""

import numpy as np
import pytest

import hlcs
from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.kinds.trajectories.release import release_notes, time_held

SIGMA, BALL = 0.003, Body("sphere", radius=0.05, mass=2.0)


def trial(stamps, heights, start=None, name="a.csv", **around):
    position = np.column_stack([np.full((len(stamps), 2), np.nan), heights])
    return Trial(name, "a", stamps, position, np.full((len(stamps), 4), np.nan), start or {}, BALL, Surroundings(**around))


def fall(times, generator, velocity=0.0):
    """Heights of a body let go, or thrown up, at time 0 from 3 m, held there before."""
    moving = np.maximum(times, 0.0)
    return 3.0 + velocity * moving - 4.905 * moving**2 + SIGMA * generator.standard_normal(len(times))


TIMES = np.arange(0, 0.7, 1 / 60)
FROM_REST = {"velocity": (0.0, 0.0, 0.0)}


@pytest.mark.parametrize("start", [None, FROM_REST])
def test_a_release_later_than_the_first_sample_is_seen_at_rest(generator, start):
    """Held for 0.2 s: the rest is told to two samples and 4 sigma of the fall behind it, sqrt(2 x 0.012/9.81) = 0.05 s."""
    held = trial(TIMES, fall(TIMES - 0.2, generator), start)
    assert time_held(held, SIGMA) == pytest.approx(0.2, abs=0.05 + 2 / 60)
    (note,) = release_notes([held], [0.0], [False], SIGMA)
    assert note.startswith("a.csv: rests in the air for the first 0.2") and "leave out the samples before the release" in note


@pytest.mark.parametrize("velocity", [0.0, 3.0, 0.7])
def test_no_flight_is_taken_for_a_rest(generator, velocity):
    """From rest, and thrown so that the top comes in the middle or soon: a parabola leaves any level by g T^2/16."""
    assert time_held(trial(TIMES, fall(TIMES, generator, velocity)), SIGMA) == 0.0


def test_what_stays_or_floats_or_has_no_height_is_not_held(generator):
    noise = SIGMA * generator.standard_normal(len(TIMES))
    assert time_held(trial(TIMES, 0.05 + noise), SIGMA) == 0.0  # never moves
    assert time_held(trial(TIMES, fall(TIMES - 0.2, generator), fluid_density=998.0), SIGMA) == 0.0  # may hover in water
    assert time_held(trial(TIMES, fall(TIMES - 0.2, generator), fluid_density=400.0), SIGMA) == 0.0  # as light as what bears it
    moving = trial(TIMES, fall(TIMES - 0.2, generator))
    moving.position[:, 0] = 0.3 * TIMES
    assert time_held(moving, SIGMA) == 0.0  # sideways
    assert time_held(trial(TIMES, np.full(len(TIMES), np.nan)), SIGMA) == 0.0
    assert time_held(trial(TIMES, fall(TIMES - 0.2, generator)), None) == 0.0
    assert release_notes([trial(TIMES, fall(TIMES - 0.2, generator))], [0.0], [True], SIGMA) == []  # lies on its floor


@pytest.mark.parametrize(
    ("first", "said"),
    [
        (0.0, None),
        (0.05, "the stated start is taken at t_s = 0, 0.05 s before the first sample"),  # some frames were lost
        (0.5, "the stated start is taken at the first sample, t_s = 0.5"),  # more than ten steps: another clock
        (-0.2, "the stated start is taken at the first sample, t_s = -0.2"),
    ],
)
def test_the_moment_of_a_stated_start_is_told_where_the_clock_does_not_begin_at_zero(generator, first, said):
    """And nothing is told where the start is fitted, whatever the clock."""
    frames = [{"t_s": TIMES + first, "z_m": fall(TIMES, generator)} for _ in range(2)]
    settings = {"body": {"shape": "sphere", "radius": 0.05, "mass": 2.0}, "noise": {"position": SIGMA}}
    start = {"start": {"velocity": [0.0, 0.0, 0.0]}}
    notes = hlcs.compare(hlcs.Experiment.from_frames(frames, trials=[start, start], **settings)).notes
    told = [note for note in notes if "stated start" in note]
    assert [note.split(": ")[0] for note in told] == ["frame 1, frame 2"] * bool(said) and all(said in note for note in told)
    assert not [note for note in hlcs.compare(hlcs.Experiment.from_frames(frames, **settings)).notes if "start" in note]
