"""The adequacy test keeps its level on recordings of free flight, whatever the noise, and sees what a flight has beside it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from experiments import experiment
from throws import correlated

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.recordings import Recordings, Trial
from hlcs.kinds.trajectories.observations import judge
from hlcs.kinds.trajectories.preparation import prepare

COUNT = 60  # sets of recordings: at 2 % of false alarms five or more happen once in 150 times
WORST = 4
LARGEST = 900  # rows of one set
NOISES = {  # correlation, share of outliers of 5 to 15 sigma, step of the readings [sigma]
    "white": (0.0, 0.0, 0.0),
    "correlated": (0.8, 0.0, 0.0),
    "correlated and rounded": (0.6, 0.0, 1.0),
    "few outliers": (0.0, 0.005, 0.0),
    "many outliers": (0.0, 0.03, 0.0),
    "correlated with outliers": (0.8, 0.03, 0.0),
    "pixels": (0.0, 0.0, 1.0),
    "coarse pixels": (0.0, 0.0, 3.0),
}


def read_by(generator, motion, sigma, noise):
    """What a tracker with this noise makes of a motion (n, 3)."""
    rho, share, step = noise
    seen = motion + correlated(generator, motion.shape, sigma, rho)
    wild = generator.random(motion.shape) < share
    seen[wild] += sigma * generator.uniform(5, 15, wild.sum()) * generator.choice([-1.0, 1.0], wild.sum())
    return np.round(seen / (step * sigma)) * (step * sigma) if step else seen


def throws(file, generator, noise, known, strength=0.0):
    """Recordings of throws without air; strength: of a shake of 3-12 Hz that is added [sigma]."""
    sigma = float(f"{10 ** generator.uniform(-3.5, -2.3):.1e}")
    rate = float(generator.choice([60, 120, 240]))
    count = int(np.exp(generator.uniform(np.log(40), np.log(600))))
    frequency, unknown = generator.uniform(3, 12), np.full((600, 4), np.nan)
    trials, times = [], np.arange(count) / rate
    for k in range(min(int(generator.integers(2, 9)), max(LARGEST // count, 2))):
        motion = generator.uniform(-6, 6, 3) * times[:, None] - [0, 0, 9.81 / 2] * times[:, None] ** 2
        motion[:, 0] += np.sqrt(6) * strength * sigma * np.sin(2 * np.pi * frequency * times + generator.uniform(0, 6.3))
        seen = read_by(generator, motion, sigma, noise)
        rows = np.arange(count) + 2
        trials.append(
            Trial(f"throw {k}", f"day {k % 2}", times, seen, unknown[:count], {}, file.body, file.surroundings, rows=rows)
        )
    rest = read_by(generator, np.tile(generator.uniform(0, 1, 3), (600, 1)), sigma, noise)
    static = Trial("rest", "rest", np.arange(600) / rate, rest, unknown, {}, file.body, file.surroundings)
    if known == "stated":
        return Recordings(replace(file, noise={"position": sigma}), tuple(trials), None, ())
    return Recordings(replace(file, noise={}, static=Path("rest")), tuple(trials), static, ())


def flagged(folder, noise, known, strength=0.0, count=COUNT):
    """Number of sets of throws whose model, which has all but the shake, is called inadequate."""
    file, bad = read_experiment_file(experiment(folder)), 0
    for seed in range(count):
        prepared = prepare(throws(file, np.random.default_rng([seed, 15]), NOISES[noise], known, strength))
        bad += not judge(prepared.problem, prepared.base)[0].adequate
    return bad


@pytest.mark.slow
@pytest.mark.parametrize("known", ["static", "stated"])
@pytest.mark.parametrize("noise", NOISES)
def test_a_right_model_passes_whatever_the_noise(tmp_path, noise, known):
    assert flagged(tmp_path, noise, known) <= WORST


@pytest.mark.slow
@pytest.mark.parametrize("noise", ["white", "many outliers", "coarse pixels"])
def test_a_shake_of_a_sigma_is_seen(tmp_path, noise):
    """A shake as large as the noise triples the variance of x: nine in ten are seen in any noise that is not slow."""
    assert flagged(tmp_path, noise, "static", 1.0, count=20) >= 18
