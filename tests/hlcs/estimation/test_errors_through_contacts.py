"""Errors of numbers through a contact: those that hide each other where a ball rolls on a level floor, one that only a bound is
known of where it grips."""

from dataclasses import replace

import numpy as np
import pytest
from throws import G, csv

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.recordings import read_recordings
from hlcs.estimation.fitting import fit_at, measured_errors
from hlcs.estimation.noise_model import estimate_noise
from hlcs.kinds.trajectories.preparation import posed
from hlcs.selection.eligibility import candidates_for
from hlcs.simulation.model import Model, Term

ARM, RADIUS = 4e-4, 0.028
BALL = (
    f'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = {RADIUS}\nmass = 0.17\n[surroundings]\nfluid_density = 0.0\n'
    "friction = 0.3\nfloor = { height = 0.0, normal = [0.0, 0.0, 1.0] }\n[measurement]\n"
    "noise = { position = 1e-3, orientation = 0.01 }\n[model]\ntime_step = 0.01\n"
)


def rolls(folder, headings, seconds=0.8, speed=0.4):
    """(Recordings, their Problem, initial states) of a ball that rolls, slowed by (5/7) g arm / r (closed form, no noise)."""
    times, text, states = np.arange(0, seconds, 0.04), BALL, []
    way = speed * times - 5 / 7 * G * ARM / RADIUS * times**2 / 2
    for k, heading in enumerate(headings):
        along, axis = np.array([np.cos(heading), np.sin(heading), 0.0]), np.array([-np.sin(heading), np.cos(heading), 0.0])
        half = way[:, None] / RADIUS / 2
        seen = np.hstack([way[:, None] * along + [0.0, 0.0, RADIUS], np.cos(half), np.sin(half) * axis])
        (folder / f"roll_{k}.csv").write_text(csv(times, seen, ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")))
        text += f'[[trial]]\nfile = "roll_{k}.csv"\n'
        states.append([0.0, 0.0, RADIUS, *(speed * along), 1.0, 0.0, 0.0, 0.0, *(speed / RADIUS * axis)])
    (folder / "rolls.toml").write_text(text)
    measurement = read_recordings(read_experiment_file(folder / "rolls.toml"))
    model = Model(time_step=measurement.file.time_step)
    return measurement, posed(measurement, estimate_noise(measurement), model, True), np.array(states)


def test_numbers_of_which_only_one_combination_is_told_are_known_no_better_than_beforehand(tmp_path):
    """(m + I/r2) a = m g arm/r tells arm / (1 + 2/5 f) and not f, the factor of two moments of inertia: darm = arm 2/7 df.

    The Cramer-Rao bound of f has nothing but what is believed of both, each to 1.5 / sqrt(2): 0.75. An interval is measured to a
    fifth (SETTLED).
    """
    measurement, problem, states = rolls(tmp_path, (0.3, 2.4))
    rolling, inertia = (candidates_for(measurement, True, [name])[0][0] for name in ("rolling_friction", "inertia_error"))
    terms = Term(rolling, (("arm", ARM),)), Term(inertia, tuple((free.name, 1.0) for free in inertia.free))
    model = Model(terms, time_step=measurement.file.time_step)
    fit = fit_at(model, states, problem.linearise(model, states))
    error = np.sqrt(np.diag(measured_errors(problem, fit).covariance))
    assert error[1:3] == pytest.approx(1.5 / 2, rel=0.2)
    assert error[0] == pytest.approx(ARM * 2 / 7 * error[1], rel=0.3)  # of the ratio of two of these


def test_a_friction_at_which_a_ball_grips_its_floor_is_bounded_from_below_alone(tmp_path):
    """A solid ball that grips keeps 5/7 of its speed along the floor (2/7 v = mu (1 + e) u where it just does: mu = 0.078 here),
    and any larger friction does the same. From 0.1 an interval goes down to where the ball slides, where ends are found to a
    fifth (SETTLED) for the covariance and for the side, and up as far as it was believed: more than 0.3."""
    rebound, along, height = 0.75, 1.5, 0.5
    moment, speed, times = np.sqrt(2 * height / G), np.sqrt(2 * height * G), np.arange(0, 0.7, 0.005)
    since = np.maximum(times - moment, 0.0)
    x = along * np.minimum(times, moment) + 5 / 7 * along * since
    z = np.where(times < moment, height - G / 2 * times**2, rebound * speed * since - G / 2 * since**2)
    (tmp_path / "throw.csv").write_text(csv(times, np.column_stack([x, 0 * x, RADIUS + z])))
    text = BALL.replace("friction = 0.3", f"friction = 0.3\nrestitution = {rebound}").replace(", orientation = 0.01", "")
    (tmp_path / "throw.toml").write_text(
        text.replace("time_step = 0.01", "time_step = 0.0041666667")
        + '[[trial]]\nfile = "throw.csv"\nstart = { angular_velocity = [0.0, 0.0, 0.0] }\n'
    )
    measurement = read_recordings(read_experiment_file(tmp_path / "throw.toml"))
    friction = candidates_for(measurement, True, ["friction"])[0][0]
    model = Model((Term(friction, (("coefficient", 0.1),)),), time_step=measurement.file.time_step)
    problem = posed(measurement, estimate_noise(measurement), model, True)
    state = np.array([[0.0, 0.0, RADIUS + height, along, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    fit = measured_errors(problem, fit_at(model, state, problem.linearise(model, state)))
    down, up = 2 * np.sqrt(fit.covariance[0, 0]) * fit.sides[:, 0]
    slides = 2 / 7 * along / ((1 + rebound) * speed)
    assert 0.8 < down / (0.1 - slides) < 1.2**2 and up > 0.3


def test_numbers_that_fit_better_at_an_end_of_their_interval_go_on_from_there(tmp_path):
    """At 1.5 standard errors beside the truth the end at two of them leaves 0.25 of chi2 and the fit 2.25, a difference that
    shows: the number goes on to the truth, which fits end short of by 0.3 of chi2 at most, half a standard error."""
    measurement, problem, states = rolls(tmp_path, (0.3, 2.4))
    rolling = candidates_for(measurement, True, ["rolling_friction"])[0][0]

    def at(arm):
        model = Model((Term(rolling, (("arm", arm),)),), time_step=measurement.file.time_step)
        return fit_at(model, states, problem.linearise(model, states))

    error = np.sqrt(at(ARM).covariance[0, 0])
    measured = measured_errors(problem, replace(at(ARM + 1.5 * error), step_error=np.array([0.1 * error])))
    assert measured.estimate[0] == pytest.approx(ARM, abs=0.55 * error)
    assert measured.step_error == [0.1 * error]  # it goes on with what is left of the error of the time step
