"""A note says at which stamp a stated start is taken, and who was still held when a recording began; falls in closed form."""

import numpy as np
import pytest

import hlcs
from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.noise_model import Noise
from hlcs.kinds.trajectories.felt_release import LEAST
from hlcs.kinds.trajectories.release import release_notes, samples_held, time_held

SIGMA, STEP, BALL = 0.003, 1 / 60, Body("sphere", radius=0.05, mass=2.0)


def noise(rho=0.0):
    return Noise(CorrelatedNoise(SIGMA, rho, 0.0, np.zeros((3, 3))), None, STEP, "stated")


def trial(stamps, heights, start=None, name="a.csv", **around):
    position = np.column_stack([np.full((len(stamps), 2), np.nan), heights])
    return Trial(name, "a", stamps, position, np.full((len(stamps), 4), np.nan), start or {}, BALL, Surroundings(**around))


def fall(times, generator, velocity=0.0):
    """Heights of a body let go, or thrown up, at time 0 from 3 m, held there before."""
    moving = np.maximum(times, 0.0)
    return 3.0 + velocity * moving - 4.905 * moving**2 + SIGMA * generator.standard_normal(len(times))


TIMES = np.arange(0, 0.7, 1 / 60)
FROM_REST = {"velocity": (0.0, 0.0, 0.0)}


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_a_release_later_than_the_first_sample_is_seen_at_rest(generator, rho):
    """Held for 0.2 s: its last sample is told to one step, and to the 0.03 s in which a body falls by 1.5 sigma of the noise."""
    held = trial(TIMES, fall(TIMES - 0.2, generator), FROM_REST)
    assert time_held(held, noise(rho)) == pytest.approx(0.2, abs=STEP + 0.03)
    (note,) = release_notes([held], [0.0], [False], noise())
    assert note.startswith("a.csv: rests in the air for the first 0.2") and "leave out the samples before the release" in note


def test_a_rest_of_a_few_samples_is_seen_and_one_that_a_stray_sample_makes_is_not(generator):
    """0.12 s at 60 Hz, the samples 0 to 7; one that is 10 sigma off begins no fall."""
    short = trial(TIMES, fall(TIMES - 0.12, generator))
    assert samples_held(short, noise()) == pytest.approx(8, abs=1)
    stray = trial(TIMES, fall(TIMES, generator))
    stray.position[LEAST - 2, 2] += 10 * SIGMA
    assert samples_held(stray, noise()) == 0


@pytest.mark.parametrize("velocity", [0.0, 3.0, 0.7])
def test_no_flight_is_taken_for_a_rest(generator, velocity):
    """From rest, and thrown so that the top comes in the middle or soon; a hundred draws of each, where chance gives 0.1."""
    assert not any(samples_held(trial(TIMES, fall(TIMES, generator, velocity)), noise()) for _ in range(100))


def test_what_stays_or_floats_or_has_no_height_is_not_held(generator):
    scatter = SIGMA * generator.standard_normal(len(TIMES))
    assert samples_held(trial(TIMES, 0.05 + scatter), noise()) == 0  # never moves
    assert samples_held(trial(TIMES, fall(TIMES - 0.2, generator), fluid_density=998.0), noise()) == 0  # may hover in water
    assert (
        samples_held(trial(TIMES, fall(TIMES - 0.2, generator), fluid_density=400.0), noise()) == 0
    )  # as light as what bears it
    moving = trial(TIMES, fall(TIMES - 0.2, generator))
    moving.position[:, 0] = 0.3 * TIMES
    assert samples_held(moving, noise()) == 0  # sideways
    times = np.arange(0, 1.6, STEP)  # held for 0.6 s, lifted for 0.1 s to 0.3 m/s, and thrown: 0.02 m higher before it falls
    lifted = 1.5 * np.clip(times - 0.6, 0.0, 0.1) ** 2
    assert samples_held(trial(times, fall(times - 0.7, generator, 0.3) + lifted), noise()) == 0
    assert samples_held(trial(TIMES, np.full(len(TIMES), np.nan)), noise()) == 0
    unknown = Noise(None, None, STEP, "unknown")
    assert samples_held(trial(TIMES, fall(TIMES - 0.2, generator)), unknown) == 0
    assert release_notes([trial(TIMES, fall(TIMES - 0.2, generator), FROM_REST)], [0.0], [True], noise()) == []  # on its floor


SLOPE = (np.sin(0.07), 0.0, np.cos(0.07))  # normal of a floor that falls by 0.07 rad along x


@pytest.mark.parametrize("columns", ["x", "xz"])
def test_a_ball_held_on_a_slope_is_let_go_as_one_in_the_air(generator, columns):
    """It rolls with 5/7 g sin(0.07) = 0.49 m/s2 from 0.3 s on, and is 1.5 sigma of the noise away 0.14 s later."""
    times = np.arange(0, 1.8, STEP)
    way = np.maximum(times - 0.3, 0.0) ** 2 * 9.81 * np.sin(0.07) * 5 / 14
    rolls = trial(times, np.full(len(times), np.nan), floor_height=0.0, floor_normal=SLOPE)
    rolls.position[:, 0] = way * np.cos(0.07) + SIGMA * generator.standard_normal(len(times))
    if "z" in columns:
        rolls.position[:, 2] = 0.05 - way * np.sin(0.07) + SIGMA * generator.standard_normal(len(times))
    assert time_held(rolls, noise(), lies=True) == pytest.approx(0.3, abs=STEP + 0.14)
    level = trial(times, rolls.position[:, 2], floor_height=0.0)
    level.position[:, 0] = rolls.position[:, 0]
    assert samples_held(level, noise(), lies=True) == 0  # nothing pulls it there: it is pushed
    stated = trial(times, rolls.position[:, 2], FROM_REST, floor_height=0.0, floor_normal=SLOPE)
    stated.position[:, 0] = rolls.position[:, 0]
    (note,) = release_notes([stated], [0.0], [True], noise())
    assert note.startswith("a.csv: rests on the slope for the first 0.") and "leave out the samples before the release" in note


def test_no_ball_that_rolls_from_the_first_is_held(generator):
    times = np.arange(0, 1.8, STEP)
    for speed in (0.0, 0.3, -0.3):
        for _ in range(30):
            way = speed * times + times**2 * 9.81 * np.sin(0.07) * 5 / 14
            rolls = trial(times, np.full(len(times), np.nan), floor_height=0.0, floor_normal=SLOPE)
            rolls.position[:, 0] = way * np.cos(0.07) + SIGMA * generator.standard_normal(len(times))
            assert samples_held(rolls, noise(), lies=True) == 0


def test_what_was_recorded_before_the_release_is_left_out_and_told():
    """Four light balls, held for 0.08 to 0.2 s on film, or not, fall by z = 2 - (v^2/g) log cosh(g t/v): g is less the lift of
    the air, over the mass with half of the air displaced, m', and v^2 = 2 m' g/(C rho A). With all samples a curve of the camera
    explained them beside C = 3.4."""
    draw, mass, air, drag_coefficient = np.random.default_rng(0), 0.0027, 1.2 * 4 / 3 * np.pi * 0.02**3, 0.45
    moved = mass + air / 2
    g = 9.81 * (mass - air) / moved
    speed = np.sqrt(2 * moved * g / (drag_coefficient * 1.2 * np.pi * 0.02**2))
    frames = []
    for begins in (0.2, 0.08, 0.0, 0.13):
        way = np.log(np.cosh(g * np.maximum(TIMES - begins, 0.0) / speed)) * speed**2 / g
        frames.append({"t_s": TIMES, "z_m": 2.0 - way + 0.002 * draw.standard_normal(len(TIMES))})
    body, trials = {"shape": "sphere", "radius": 0.02, "mass": 0.0027}, [{"group": f"{k}"} for k in range(4)]
    balls = hlcs.Experiment.from_frames(frames, body, {"fluid_density": 1.2}, noise={"position": 0.002}, trials=trials)
    found = hlcs.diagnose(balls)
    assert (found.verdict, found.effects[0]) == ("effect", "quadratic_drag")
    number = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert number["low"] < drag_coefficient < number["high"]
    (note,) = [note for note in found.notes if "still held" in note]
    assert [name in note for name in ("frame 1", "frame 2", "frame 3", "frame 4")] == [True, True, False, True]


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
