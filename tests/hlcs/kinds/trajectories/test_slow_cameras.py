"""Balls that bounce before a slow camera: most stretches hold an impact, and the first guess of a start is far off."""

from dataclasses import replace

import numpy as np
import pytest
from throws import G, csv

import hlcs
from hlcs.estimation.flexible_curves import impact_times
from hlcs.estimation.noise_model import estimate_noise
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.protocol import Options
from hlcs.kinds.trajectories.preparation import posed
from hlcs.simulation.model import Model

SIGMA, RESTITUTION, RADIUS = 0.002, 0.85, 0.0213
BALL = (
    f'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = {RADIUS}\nmass = 0.0459\n[surroundings]\ngravity = {G}\n'
    f"restitution = {RESTITUTION}\nfloor = {{ height = 0.0 }}\n[measurement]\nnoise = {{ position = {SIGMA} }}\n"
)


def bounces(height, times):
    """Heights of a ball let go at rest, its lowest point `height` above the floor, by closed form; and when it meets it."""
    fall = np.sqrt(2 * height / G)
    heights, impacts, begin, speed = RADIUS + height - G * times**2 / 2, [], fall, RESTITUTION * G * fall
    while begin < times[-1]:
        later, impacts = times >= begin, [*impacts, begin]
        heights[later] = RADIUS + speed * (times - begin)[later] - G * (times - begin)[later] ** 2 / 2
        begin, speed = begin + 2 * speed / G, RESTITUTION * speed
    return heights, np.array(impacts)


@pytest.fixture
def experiment(tmp_path):
    """Four drops at 30 frames a second, the noise white and stated right."""
    generator, text = np.random.default_rng(7), BALL
    for k, height in enumerate((0.58, 0.88, 1.18, 0.68)):
        times = np.arange(60) / 30
        seen = bounces(height, times)[0] + SIGMA * generator.standard_normal(len(times))
        (tmp_path / f"r{k}.csv").write_text(csv(times, seen[:, None], ("z_m",)))
        text += f'[[trial]]\nfile = "r{k}.csv"\nstart = {{ velocity = [0.0, 0.0, 0.0] }}\n'
    (tmp_path / "e.toml").write_text(text)
    return Experiment.read(tmp_path / "e.toml")


def test_impacts_are_found_between_the_samples_that_they_lie_between(experiment):
    """To one step of the camera."""
    trials = experiment.opened(Options()).measurement.trials
    for trial, height in zip(trials, (0.58, 0.88, 1.18, 0.68), strict=True):
        true, found = bounces(height, trial.times)[1], impact_times(trial)
        apart = np.abs(found[:, None] - true)
        assert found.size and apart.min(axis=0).max() <= 1 / 30 and apart.min(axis=1).max() <= 1 / 30


def test_a_body_at_rest_is_thrown_back_nowhere_however_uneven_its_stamps_are(experiment):
    """The second difference of noise goes as the inverse square of the steps."""
    trial = experiment.opened(Options()).measurement.trials[0]
    generator, even = np.random.default_rng(1), np.arange(200) / 60
    for _ in range(20):
        times = np.sort(np.concatenate([even, generator.choice(even, 6, replace=False) + 0.002]))
        position = np.full((len(times), 3), np.nan)
        position[:, 2] = 0.5 + SIGMA * generator.standard_normal(len(times))
        assert not len(impact_times(replace(trial, times=times, position=position)))


def test_white_noise_between_impacts_is_white_and_as_large_as_it_is(experiment):
    """Some 150 samples in parts with curves of six numbers know the size to 8 %, the correlation to 0.12; three times that."""
    noise = estimate_noise(experiment.opened(Options()).measurement)
    assert noise.rho < 0.36 and noise.hint == pytest.approx(SIGMA, rel=0.25) and not noise.notes


def test_a_start_that_is_guessed_far_off_is_fitted_to_its_end(experiment):
    """What is left is what the linear model promises: no step of the starts would take away more than the fit stops at."""
    opened = experiment.opened(Options())
    problem = posed(opened.measurement, opened._noise, Model(), True)
    assert problem.initial_guess()[0, 2] == pytest.approx(0.58 + RADIUS, abs=0.1)
    fit = problem.fit(Model())
    left = sum(float(part @ part) for part in fit.linearization.white)
    assert left - fit.chi2 < 1.0
    assert np.abs(fit.initial_states[:, 2] - RADIUS - (0.58, 0.88, 1.18, 0.68)).max() < 0.002


def test_nothing_is_missing_and_no_sample_is_set_aside(experiment):
    found = hlcs.diagnose(experiment)
    assert found.verdict == "complete" and not [note for note in found.notes if "isolated" in note or "curve" in note]
