"""Recordings made ready for a fit: steps long or short, samples set aside, floors touched."""

import numpy as np
import pytest
from experiments import FLOOR, TOML, experiment, measured
from throws import csv, write_throws
from tosses import CUBE

from hlcs.estimation.noise_model import estimate_noise
from hlcs.kinds.trajectories.preparation import beside, prepare, rebounds, starts_seated
from hlcs.selection.eligibility import candidates_for
from hlcs.simulation.model import Term
from minibullet.effects import QuadraticDrag
from minibullet.errors import InputError, InputWarning


def test_long_rolling_is_computed_in_long_steps_and_bouncing_is_not(tmp_path, monkeypatch, generator):
    """A rolling ball moves uniformly whatever the step: chi2 is that of noise, 1 within five of its standard deviations.

    A ball that bounces does not stand still in long steps: what comes out is what came out without trying them.
    """
    toml = FLOOR.replace("position = 0.01", "position = 0.001")
    times = np.arange(0, 8, 1 / 60)
    table = np.column_stack([0.4 * times, 0.03 + 0 * times]) + 0.001 * generator.standard_normal((len(times), 2))
    rows = "".join(f"{t:.6f},{x:.6f},0,{z:.6f}\n" for t, (x, z) in zip(times, table, strict=True))
    measurement = measured(experiment(tmp_path, csv="t_s,x_m,y_m,z_m\n" + rows, toml=toml))
    monkeypatch.setattr("hlcs.kinds.trajectories.preparation.LONG", 500)
    prepared = prepare(measurement)
    assert any("motion of 7.98 s is computed in steps" in note for note in prepared.notes)
    there = np.concatenate([prepared.problem.recordings[0].channel == channel for channel in (0, 2)]).reshape(2, -1)
    assert all(
        abs(np.mean(prepared.base.linearization.white[0][inside] ** 2) - 1) < 5 * np.sqrt(2 / len(times)) for inside in there
    )

    times = np.arange(120) / 60
    height = np.where(times < 0.5, 4.905 * (0.25 - times**2), 4.905 * (times - 0.5) * (1.5 - times) / 2) * (times < 1.5)
    rows = "".join(
        f"{t:.6f},{z + 0.03 + e:.6f}\n" for t, z, e in zip(times, height, 0.001 * generator.standard_normal(120), strict=True)
    )
    measurement = measured(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=toml))
    monkeypatch.setattr("hlcs.kinds.trajectories.preparation.LONG", 100)
    with pytest.warns(InputWarning, match="cannot be followed in longer ones"):
        tried = prepare(measurement)
    monkeypatch.setattr("hlcs.kinds.trajectories.preparation.LONG", 5000)
    assert tried.base.chi2 == prepare(measurement).base.chi2


def test_a_sample_that_stands_alone_is_told_beside_a_rest_that_is_left_out(tmp_path):
    """A puck slides for 0.5 s and rests for 3 s; row 12 was read 5 cm off. Both are said, the row as it stands in the file."""
    generator, times = np.random.default_rng(2), np.arange(210) / 60
    moving = np.minimum(times, 0.5)
    seen = np.column_stack([0.981 * moving - 0.981 * moving**2, 0 * times, 0.05 + 0 * times])
    seen += 0.0005 * generator.standard_normal(seen.shape)
    seen[10, 0] += 0.05
    (tmp_path / "a.csv").write_text(csv(times, seen))
    path = tmp_path / "puck.toml"
    path.write_text(CUBE.replace("position = 0.001", "position = 0.0005") + '[[trial]]\nfile = "a.csv"\n')
    prepared = prepare(measured(path))
    notes = " ".join((*prepared.notes, *prepared.aside))
    assert "at rest from t_s" in notes and "1 isolated sample set aside for all models: x row 12" in notes


@pytest.mark.parametrize(
    ("heights", "seated"), [({}, True), ({2: 0.08}, True), ({0: 0.08}, True), ({0: 0.058}, False), ({0: 0.08, 1: 0.06}, False)]
)
def test_one_reading_that_a_tracker_lost_lifts_no_body_off_its_floor(tmp_path, heights, seated):
    """The centre of a cube of 10 cm on its floor is 5 cm above it. Within a frame, 1/25 s, a body let go falls 7.8 mm, and no
    3 cm: in two frames it does."""
    times, seen = np.arange(12) / 25, np.full((12, 3), [0.0, 0.0, 0.05])
    seen[:, 0] = 0.5 * times
    seen += 1e-4 * np.random.default_rng(1).standard_normal(seen.shape)  # read in no steps
    for row, height in heights.items():
        seen[row, 2] = height
    (tmp_path / "a.csv").write_text(csv(times, seen))
    path = tmp_path / "puck.toml"
    path.write_text(CUBE + '[[trial]]\nfile = "a.csv"\n')
    recordings = measured(path)
    assert starts_seated(recordings.trials[0], estimate_noise(recordings)) == seated


def test_a_rebound_between_two_samples_is_seen_and_a_throw_is_none():
    """At 25 frames a second a ball that falls 0.9 m is never near the floor in any frame: v = 4.2 m/s, 0.17 m a frame."""
    times = np.arange(0.02, 0.8, 0.04)
    impact = np.sqrt(2 * 0.9 / 9.81)
    up = 0.75 * 9.81 * impact
    falling = 0.9 - 0.5 * 9.81 * times**2
    bouncing = np.where(times < impact, falling, up * (times - impact) - 0.5 * 9.81 * (times - impact) ** 2)
    assert bouncing.min() > 0.02 and rebounds(times, bouncing, reach=0.005)
    assert not rebounds(times, 0.9 + 3.0 * times - 0.5 * 9.81 * times**2, reach=0.005)
    assert not rebounds(times[times < 0.9 * impact], falling[times < 0.9 * impact], reach=0.005)


def test_a_model_with_which_the_motion_does_not_stay_finite_is_refused_with_its_line(tmp_path, monkeypatch):
    """A law whose force overflows as soon as the body moves."""
    monkeypatch.setattr(QuadraticDrag, "forces", lambda law, bodies, time: np.exp(1e9 * bodies.twist**2))
    times = np.arange(60) / 60
    throw = csv(times, np.column_stack([3 * times, 0 * times, 3 * times - 9.81 * times**2 / 2]))
    path = experiment(
        tmp_path, csv=throw, toml=TOML + '[model]\neffects = [{ name = "quadratic_drag", drag_coefficient = 0.5 }]\n'
    )
    with np.errstate(all="ignore"), pytest.raises(InputError, match=r"e.toml, line 9: model.effects: with these the motion"):
        prepare(measured(path))


@pytest.mark.parametrize(("drag", "shorter"), [(0.0, False), (0.02, False), (1.0, True)])
def test_the_step_of_a_flight_is_that_of_the_set_that_was_found(tmp_path, drag, shorter):
    """Throws of 2 to 9 m/s: without a drag any step is exact. A drag of 1 /m slows the fastest by 9 /s at first: the norm of what
    halving the step moves at all 1,440 samples of 0.5 mm is then above 0.1, the most that a number may move by."""
    prepared = prepare(measurement := measured(write_throws(tmp_path, 0.0005, drag_per_metre=drag)))
    problem, (entry,) = prepared.problem, candidates_for(measurement, False, ("quadratic_drag",))[0]
    step, (number,) = problem.simulator.time_step, entry.free
    model = prepared.base.model.with_term(Term(entry, ((number.name, max(drag, 0.001)),)))
    renewed = beside(prepared, problem.fit(model, prepared.base.initial_states))
    assert step == 1 / 15 and (problem.simulator.time_step < step) == shorter
    assert not shorter or renewed.base.model == prepared.base.model
