"""A ball in flight that loses its spin within a recording: w exp(-r t) about one axis, so the turn is w (1 - exp(-r t))/r."""

from types import SimpleNamespace

import numpy as np
import pytest
from hard_cases import ball, throws, write

import hlcs
import minibullet as mb
from hlcs.data.bodies import Body
from hlcs.data.experiment_file import Surroundings
from hlcs.data.rigid_body import rigid_body
from hlcs.effects.candidates import candidate
from hlcs.kinds.trajectories.spinning import spin_losses_shown
from minibullet import rotations

AROUND = Surroundings(fluid_density=1.2, fluid_viscosity=1.8e-5)
BALL = Body("sphere", radius=0.05, mass=0.1)
LAWS = (mb.SpinDecay, mb.SpinningFriction, mb.QuadraticDrag, mb.LinearDrag)


def turns(times, spin, rate):
    """Orientations (n, 4) of a ball that spins exp(-rate t) as fast as at first."""
    course = -np.expm1(-rate * times) / rate if rate else times
    return rotations.product(rotations.exponential(course[:, None] * spin), np.array([0.6, 0.0, 0.8, 0.0]))


def shown(rate, body=BALL, seconds=1.0):
    """What one recording at 60 Hz shows of three laws, of which one acts on the spin."""
    times = np.arange(0, seconds, 1 / 60)
    orientation = turns(times, np.array([12.0, -20.0, 9.0]), rate)
    trial = SimpleNamespace(times=times, orientation=orientation, body=body, surroundings=AROUND)
    return spin_losses_shown([candidate(kind, AROUND, rigid_body(BALL), True) for kind in LAWS], [trial], contact=False)


@pytest.mark.parametrize("rate", [0.3, 2.0, 8.0, 30.0])
def test_a_loss_of_spin_is_read_off_a_recording_for_the_law_that_acts_on_it(rate):
    """Beginnings lie a factor 1000^(1/60) apart, so the nearest is off by a seventeenth at most."""
    read = shown(rate)
    assert set(read) == {"spin_decay"} and read["spin_decay"]["rate"] == pytest.approx(rate, rel=0.06)


def test_no_loss_is_read_of_a_steady_spin_nor_of_a_body_whose_axis_wanders():
    assert shown(0.0) == {}
    assert shown(8.0, body=Body("box", size=(0.1, 0.1, 0.2), mass=0.1)) == {}


def test_a_spin_that_dies_within_the_recording_is_told_beyond_what_is_plausible(tmp_path):
    """A rate of 8 /s where 5 is the most that is plausible: far from a steady spin nothing foresees it."""
    generator, sigma = np.random.default_rng(7), 0.02
    recordings = []
    speeds = (3.0, 3.5, 4.0, 4.5, 5.0, 5.5)
    for times, rows in throws(lambda place, v: np.array([0.0, 0.0, -9.81]), 0.003, generator, speeds, seconds=1.2):
        spin = generator.uniform(-30.0, 30.0, 3)
        noise = rotations.exponential(sigma * generator.standard_normal((len(times), 3)))
        recordings.append((times, np.column_stack([rows, rotations.product(noise, turns(times, spin, 8.0))])))
    settings = ball(0.05, 0.1, "", f"noise = {{ position = 0.003, orientation = {sigma} }}")
    columns = ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
    diagnosis = hlcs.diagnose(write(tmp_path, recordings, settings, columns))
    told = diagnosis.parameters["spin_decay"]["rate"]
    assert diagnosis.verdict == "effect" and diagnosis.effects == ("spin_decay",)
    assert told["low"] <= 8.0 <= told["high"] and "plausible" in told["beyond"]


def spun_on_the_spot(turned):
    """What two balls that turn about the normal of their floor by turned(spin, times) show, and one that lies there."""
    times, around = np.arange(0, 1.0, 1 / 120), Surroundings(floor_height=0.0, friction=0.6)
    noise = 0.005 * np.random.default_rng(3).standard_normal((3, len(times)))
    trials = []
    for spin, its in zip((16.0, -20.0, 0.0), noise, strict=True):
        half = (turned(spin, times) + its) / 2
        orientation = np.column_stack([np.cos(half), 0 * half, 0 * half, np.sin(half)])
        trials.append(SimpleNamespace(times=times, orientation=orientation, body=BALL, surroundings=around))
    return spin_losses_shown([candidate(kind, around, rigid_body(BALL), True) for kind in LAWS], trials, contact=True)


@pytest.mark.parametrize("rate", [3.0, 12.0])
def test_a_spin_that_the_air_takes_on_the_spot_is_read_of_the_balls_that_spin(rate):
    read = spun_on_the_spot(lambda spin, times: -np.expm1(-rate * times) / rate * spin)
    assert set(read) == {"spin_decay", "spinning_friction"} and read["spin_decay"]["rate"] == pytest.approx(rate, rel=0.15)


def test_a_moment_that_stops_a_ball_on_the_spot_is_read_well_enough_to_begin_with():
    """The spin falls by 5/2 g arm/r2 and ends; an exponential through such a course begins too steeply, by a factor of two."""
    arm = 0.008
    loss = 2.5 * 9.81 * arm / 0.05**2

    def turned(spin, times):
        until = np.minimum(times, abs(spin) / loss)
        return spin * until - np.sign(spin) * loss * until**2 / 2

    assert arm / 3 < spun_on_the_spot(turned)["spinning_friction"]["arm"] < 3 * arm


def test_nothing_is_read_of_balls_that_spin_on_steadily_on_their_spot():
    assert spun_on_the_spot(lambda spin, times: spin * times) == {}


def test_a_side_force_of_a_spin_that_nobody_stated_asks_for_the_spin(tmp_path):
    """Balls that swerve to another side in each throw, k w x v: no law without a spin does that."""
    generator, recordings = np.random.default_rng(5), []
    for side in (-4.0, 3.0, -2.0, 5.0):

        def swerving(place, velocity, side=side):
            return np.array([0.0, 0.0, -9.81]) + np.cross([0.0, 0.0, 0.1 * side], velocity)

        recordings += throws(swerving, 0.003, generator, (4.0,), seconds=0.7)
    diagnosis = hlcs.diagnose(write(tmp_path, recordings, ball(0.05, 0.1, "", "noise = { position = 0.003 }")))
    assert diagnosis.verdict == "unexplained"
    assert "state or measure the spin, without which magnus" in diagnosis.next_experiment.text
