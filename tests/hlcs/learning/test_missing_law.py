"""From recordings to a law: the cases that the reports speak of, and those where nothing may be said."""

from dataclasses import replace

import numpy as np
import pytest
from throws import csv

import hlcs
import minibullet as mb
from hlcs.data.rigid_body import rigid_body
from hlcs.effects import candidate, classes
from hlcs.learning import learn
from hlcs.simulation.model import Term


@pytest.fixture(scope="module")
def pull(magnet):
    return learn(*magnet)


def test_a_magnet_is_a_pull_by_the_inverse_square_towards_its_place(magnet, pull):
    """Exponent and place within three standard errors of the truth (90 % intervals are 1.645 of them)."""
    assert (pull.variable, pull.form) == ("distance", "power")
    truth = {"exponent": -2.0, "point_x": 0.5, "point_y": 0.2, "point_z": 1.0}
    for name, value in truth.items():
        number = pull.numbers[name]
        assert abs(number["value"] - value) < 3 / 1.645 * (number["high"] - number["low"]) / 2
    assert pull.numbers["exponent"]["high"] - pull.numbers["exponent"]["low"] < 0.3
    assert pull.text.startswith("A pull towards (0.")


def test_what_is_held_out_falls_to_the_noise(magnet, pull):
    """sigma is 2 mm; 138 samples a recording less six starts; the numbers of five recordings add less than as much again."""
    assert pull.held_out["before"] > 2 * pull.held_out["after"]
    assert 0.0018 < pull.held_out["after"] < 0.0028
    assert pull.fit.chi2 / pull.fit.freedom == pytest.approx(1.0, abs=0.2)


def test_the_file_is_an_effect_that_compare_takes(magnet, pull, tmp_path):
    """Loaded and checked as a user's own; with it the recordings are those of the model within their noise."""
    effects, experiment = tmp_path / "learned_effect.py", tmp_path / "throws.toml"
    effects.write_text(pull.effect_file)
    (kind,) = mb.load_effects(effects).values()
    assert kind().exponent == pytest.approx(pull.numbers["exponent"]["value"], rel=1e-6)
    text = (
        'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[measurement]\nnoise = { position = 0.002 }\n'
    )
    for k, trial in enumerate(magnet[0].trials):
        (tmp_path / f"{k}.csv").write_text(csv(trial.times, trial.position))
        text += f'[[trial]]\nfile = "{k}.csv"\n'
    experiment.write_text(text + '[model]\neffects = [{ name = "learned_force" }]\n')
    after = hlcs.compare(experiment, effects_file=effects)
    experiment.write_text(text)
    assert after.adequate and not hlcs.compare(experiment).adequate


def test_a_law_without_sudden_changes_is_simulated_from_sample_to_sample(magnet, monkeypatch):
    """The flights are sampled every 0.02 s; steps of 1/240 s would make five times the work, of minutes of sinking the most."""
    problem, steps = magnet[0], []
    fit = type(problem).fit
    monkeypatch.setattr(type(problem), "fit", lambda self, *given: (steps.append(self.simulator.time_step), fit(self, *given))[1])
    learn(*magnet)
    assert steps == [pytest.approx(0.02)] and problem.simulator.time_step > 0.02


def test_a_law_through_contacts_is_simulated_in_the_step_that_the_correction_belongs_to(magnet, monkeypatch):
    """What is known of the error of a step, added to predictions, is wrong in any other."""
    problem, steps = magnet[0], []
    known = problem.simulator.time_step
    monkeypatch.setattr(problem.simulator, "contact", True)
    monkeypatch.setattr(
        type(problem), "fit", lambda self, *given: (steps.append(self.simulator.time_step), replace(magnet[1]))[1]
    )
    assert learn(*magnet) is None and steps == [known]  # the law that this fit has is none: it explains nothing


def test_an_effect_stands_beside_the_law_with_the_number_that_it_has_there(throw):
    """A drag of C = 2, and a pull of 3 m/s2 along x while 0.3 s < t: without the law the fit gives another C."""
    drag = 1.2 * 2.0 * np.pi * 0.03**2 / (2 * 0.05)

    def force(x, v, t):
        return -drag * np.linalg.norm(v, axis=1, keepdims=True) * v + [3.0 * (t > 0.3), 0.0, 0.0]

    problem, bare = throw(force)
    trial = problem.trials[0]
    kind = candidate(classes()["quadratic_drag"], trial.surroundings, rigid_body(trial.body), True)
    fit = problem.fit(bare.model.with_term(Term(kind, ()).at({"drag_coefficient": 1.0})))
    learned = learn(problem, fit)
    ((name, beside),) = (tuple(entry.values()) for entry in learned.beside)
    assert name == "quadratic_drag" and learned.variable == "time"
    wrong, right = abs(fit.estimate[0] - 2.0), abs(beside - 2.0)
    assert right < 4 * np.sqrt(learned.fit.covariance[0, 0]) < wrong


def test_a_shaking_camera_is_an_oscillation_of_its_frequency(throw):
    """Swinging by 4 mm in x and z at 4.6 Hz, with a phase of its own in every recording: no effect can say that."""
    problem, fit = throw(lambda x, v, t: 0.0 * x)
    phases = np.random.default_rng(2).uniform(0, 6.28, (len(problem.trials), 3))
    for trial, phase in zip(problem.trials, phases, strict=True):
        trial.position[:] += np.array([0.004, 0.0, 0.004]) * np.cos(2 * np.pi * 4.6 * trial.times[:, None] + phase)
    found = learn(problem, problem.fit(fit.model))
    assert found.text.startswith("An oscillation of 4.6 Hz in x and z") and "the camera shakes" in found.text
    assert found.effect_file == "" and found.form == "oscillation"
    assert found.numbers["amplitude_x"]["value"] == pytest.approx(0.004, rel=0.1)


def test_a_wrong_start_is_no_oscillation(throw):
    """Starts stated 0.1 m/s off, each its own way: a swing of 10 Hz drifts as well, and swings by 1.6 mm beside it."""
    problem, fit = throw(lambda x, v, t: 0.0 * x)
    for trial, off in zip(problem.trials, np.random.default_rng(3).uniform(-0.1, 0.1, (len(problem.trials), 3)), strict=True):
        trial.position[:] += off * trial.times[:, None]
    found = learn(problem, fit)
    assert found is None or found.form != "oscillation"


def test_a_law_that_foretells_other_recordings_worse_is_none(magnet, monkeypatch):
    """The true one, where these are told to be off by more with it than without it."""
    monkeypatch.setattr("hlcs.learning.missing_law._errors", lambda regression, foretold: {"before": 0.004, "after": 0.005})
    assert learn(*magnet) is None


def test_noise_teaches_nothing(throw):
    assert learn(*throw(lambda x, v, t: 0.0 * x, seed=3)) is None


def test_what_a_force_did_elsewhere_teaches_nothing(magnet):
    """The residuals of each recording added to another: no variable carries them."""
    problem, fit = magnet
    white = fit.linearization.projected[0]
    shuffled = replace(fit.linearization, white=[*white[1:], white[0]])
    assert learn(problem, replace(fit, linearization=shuffled)) is None


def test_two_recordings_are_too_few(throw):
    problem, fit = throw(lambda x, v, t: 0.0 * x)
    problem.trials = problem.trials[:2]
    assert learn(problem, fit) is None
