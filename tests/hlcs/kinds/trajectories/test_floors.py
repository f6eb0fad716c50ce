"""Recordings of one experiment of which some have a floor and others none."""

import numpy as np
import pytest
from experiments import measured
from throws import G
from throws import csv as recording

import hlcs
from hlcs.estimation.segments import gaps, halves

RADIUS, RESTITUTION, SIGMA = 0.05, 0.75, 0.002
SETTINGS = f"""kind = "trajectory"
[body]
shape = "sphere"
radius = {RADIUS}
mass = 0.1
[surroundings]
gravity = {G}
fluid_density = 0.001
friction = 0.0
restitution = {RESTITUTION}
[measurement]
noise = {{ position = {SIGMA} }}
"""
TIMES = np.arange(0, 0.9, 1 / 60)


def bounce(height):
    """Heights of a ball let go at rest, its floor at 0, until after its first rebound (n,)."""
    falls = np.sqrt(2 * (height - RADIUS) / G)
    after = TIMES - falls
    return np.where(after < 0, height - G * TIMES**2 / 2, RADIUS + RESTITUTION * G * falls * after - G * after**2 / 2)


@pytest.fixture
def experiment(tmp_path):
    """Three drops on a floor and three throws over none, which a force of 4 Hz shakes by 2 cm: no candidate does that."""
    generator, text = np.random.default_rng(6), SETTINGS
    for k, height in enumerate((1.0, 1.2, 1.1)):
        drop = np.column_stack([0 * TIMES, 0 * TIMES, bounce(height)])
        throw = np.outer(TIMES, [1.0, 0.2 * k, 3.0]) - np.outer(G * TIMES**2 / 2, [0, 0, 1])
        throw[:, 0] += 0.02 * np.sin(2 * np.pi * 4.0 * TIMES)
        for name, path, floor in (("drop", drop, "floor = { height = 0.0 }\n"), ("throw", throw, "")):
            noise = SIGMA * generator.standard_normal(path.shape)
            (tmp_path / f"{name}_{k}.csv").write_text(recording(TIMES, path + noise))
            text += f'[[trial]]\nfile = "{name}_{k}.csv"\ngroup = "day {k % 2}"\n{floor}'
    (tmp_path / "e.toml").write_text(text)
    return tmp_path / "e.toml"


def test_a_body_without_a_floor_is_never_near_it_and_is_cut_in_its_middle(experiment):
    throw = next(trial for trial in measured(experiment).trials if trial.name.startswith("throw"))
    assert np.isinf(gaps(throw)).all()
    first, second = halves(throw)
    assert abs(len(first.times) - len(second.times)) <= 1


def test_what_needs_a_floor_needs_one_under_every_recording(experiment):
    """A force of 4 Hz in the throws alone: they are searched for a law of their own, all of each."""
    diagnosis = hlcs.diagnose(experiment, candidates=["quadratic_drag", "wall_drag"])
    why = {finding.effect: finding.why for finding in diagnosis.candidates}
    assert diagnosis.verdict == "unexplained" and "floor" in why["wall_drag"]
