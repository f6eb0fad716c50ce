"""The error of the time step: extrapolation to a step of zero."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from throws import G, write_throws

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.recordings import read_recordings
from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.noise_model import Noise
from hlcs.kinds.trajectories import time_step
from hlcs.kinds.trajectories.preparation import posed
from hlcs.kinds.trajectories.thinning import on_all_rows, thinned
from hlcs.kinds.trajectories.time_step import (
    each_in_its_steps,
    misfit_by_step,
    polished,
    polisher,
    richardson,
    settling,
    with_step_error,
)
from hlcs.selection.eligibility import candidates_for
from hlcs.simulation.model import Model, Term
from hlcs.simulation.simulator import Motion


def test_two_steps_are_carried_on_to_zero():
    """An error of first order vanishes, that of a turn and of a reading too."""

    def answer(step):
        half = (0.4 + 2 * step) / 2
        turn = np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]])
        return [Motion(np.array([[1.0 + 3 * step, 0.0, 0.0]]), turn, np.array([[0.0, 0.0, 9.81 - 5 * step]]))]

    ((position, turn, force),) = richardson(answer(0.02), answer(0.01))
    np.testing.assert_allclose(position, [[1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(turn, [[np.cos(0.2), 0.0, 0.0, np.sin(0.2)]], atol=1e-12)
    np.testing.assert_allclose(force, [[0.0, 0.0, 9.81]], atol=1e-12)


def test_a_recording_that_finds_no_rest_with_shorter_steps_is_not_corrected(monkeypatch):
    """Halving moves one by 0.4, 0.2 and 0.1 sigma; another by 0.1, then by 3, where its body goes another way; one by nothing."""
    monkeypatch.setattr(time_step, "recording_scale", lambda recording: 1.0)
    problem = SimpleNamespace(recordings=[None, None, None], segmented=False)
    problem.changes = lambda before, after: [np.array([b - a]) for a, b in zip(before, after, strict=True)]
    runs = {1: [0.0, 0.0, 5.0], 1 / 2: [0.4, 0.1, 5.0], 1 / 4: [0.6, 3.1, 5.0], 1 / 8: [0.7, 3.3, 5.001]}
    kept = settling(problem, runs)
    assert [kept[share] for share in runs] == [[0.0, 0.0, 5.0], [0.4, 0.0, 5.0], [0.6, 0.0, 5.0], [0.7, 0.0, 5.001]]


def test_each_segment_has_the_step_that_it_needs(monkeypatch):
    """Errors of first order of 2.9, 3.1, 11.9 and 1,000 sigma in a step of 1/240 s: NEAR is 3, and no step is below 1/2,000 s."""
    monkeypatch.setattr(time_step, "recording_scale", lambda recording: 1.0)
    monkeypatch.setattr(time_step, "improve_for", lambda *_: None)
    monkeypatch.setattr(time_step, "refit_initial_states", lambda problem, fit: fit)
    errors, simulator = np.array([2.9, 3.1, 11.9, 1000.0]), SimpleNamespace(time_step=1 / 240, halvings=np.zeros(4, int))
    simulator.simulate = lambda model, states, asked, step: errors[asked] * 240 * step / 2.0 ** simulator.halvings[asked]
    problem = SimpleNamespace(simulator=simulator, trials=[None] * 4, recordings=[None] * 4)
    problem.residuals_of = lambda owner, runs: [np.array([seen]) for seen in runs]
    problem.fit = lambda model, states: "fitted anew"
    fit = SimpleNamespace(model=None, initial_states=np.zeros((4, 13)))
    assert each_in_its_steps(problem, fit) == "fitted anew"
    assert simulator.halvings.tolist() == [0, 1, 2, 3]
    errors /= 1000.0
    simulator.halvings[:] = 0
    assert each_in_its_steps(problem, fit) is fit


def slides(folder, slope, noise):
    """(Problem, Model) of a block that slides down boards, slowed by (0.3 + slope v) of its load: closed form, without noise."""
    text = (
        'kind = "trajectory"\n[body]\nshape = "box"\nsize = [0.12, 0.08, 0.04]\nmass = 0.5\n[surroundings]\nfluid_density = 0.0\n'
        f"friction = 0.3\n[measurement]\nnoise = {{ position = {noise} }}\n"
    )
    for k, angle in enumerate(np.deg2rad([24.0, 28.0, 32.0, 36.0])):
        normal, half = [float(np.sin(angle)), 0.0, float(np.cos(angle))], angle / 2
        pull, rate, times = G * (np.sin(angle) - 0.3 * np.cos(angle)), slope * G * np.cos(angle), np.arange(0, 1.0, 0.002)
        way = pull / rate * (times - -np.expm1(-rate * times) / rate)
        seen = 0.02 * np.array(normal) + way[:, None] * [np.cos(angle), 0.0, -np.sin(angle)]
        (folder / f"slide_{k}.csv").write_text(
            "t_s,x_m,y_m,z_m\n"
            + "".join(f"{t:.4f},{x:.12f},{y:.12f},{z:.12f}\n" for t, (x, y, z) in zip(times, seen, strict=True))
        )
        start = (
            f"{{ position = [{seen[0][0]}, 0.0, {seen[0][2]}], velocity = [0.0, 0.0, 0.0], angular_velocity = [0.0, 0.0, 0.0], "
            f"orientation = [{np.cos(half)}, 0.0, {np.sin(half)}, 0.0] }}"
        )
        text += f'[[trial]]\nfile = "slide_{k}.csv"\nstart = {start}\nfloor = {{ height = 0.0, normal = {normal} }}\n'
    (folder / "slides.toml").write_text(text)
    measurement = read_recordings(read_experiment_file(folder / "slides.toml"))
    (law,), _ = candidates_for(measurement, True, ["viscous_friction"])
    model = Model((Term(law, (("slope", slope),)),), time_step=measurement.file.time_step)
    white = Noise(CorrelatedNoise(noise, 0.0, 0.0, np.zeros((3, 3))), None, 0.002, "stated")
    return posed(measurement, white, model, True), model


def test_many_readings_that_are_each_off_by_little_move_no_number_that_is_told(tmp_path):
    """Friction that grows by 0.006 s/m: a step of 1/240 s moves 6,000 readings by 0.03 of their noise RMS, halving it by less
    than STILL, and the slope by two of its errors. What is told is the closed form, to a fifth of one (two errors of MOVED)."""
    problem, model = slides(tmp_path, 0.006, 1e-3)
    rough = problem.fit(model)
    told = polished(problem, rough)
    error = np.sqrt(told.covariance[0, 0])
    assert abs(rough.estimate[0] - 0.006) > error
    assert told.estimate[0] == pytest.approx(0.006, abs=0.2 * error)


def test_what_is_left_of_the_error_of_the_step_is_told_as_an_error_of_the_number(tmp_path):
    """Readings of 20 mm: halving the step moves the slope by less than MOVED, and nothing is corrected. What is told is how far
    the number is from that of the closed form: twice what halving changes, to a tenth (second order, and where the fit ends)."""
    problem, model = slides(tmp_path, 0.006, 0.02)
    told = polished(problem, problem.fit(model))
    assert problem.step_change is None and abs(told.step_error[0]) > 0.1 * np.sqrt(told.covariance[0, 0])
    assert told.step_error[0] == pytest.approx(0.006 - told.estimate[0], rel=0.1)


def test_a_set_that_is_told_beside_the_final_one_has_the_error_of_the_step_in_its_numbers(tmp_path):
    """Not corrected at all, and readings of 1 mm: the slope is off by more than two errors of the data, which is what is told, to
    a tenth; the square of it stands in its interval."""
    problem, model = slides(tmp_path, 0.006, 1e-3)
    fit = problem.fit(model)
    told, error = with_step_error(problem, fit), np.sqrt(fit.covariance[0, 0])
    assert told.step_error[0] == pytest.approx(0.006 - fit.estimate[0], rel=0.1)
    assert told.covariance_at(1.0)[0, 0] > (1 + 2**2) * error**2


def test_a_slide_under_constant_friction_has_no_error_of_the_step(tmp_path):
    """The path is a parabola, which a step of any length follows: what is left is rounding of the last digit written, 1e-12 m
    of a noise of 1e-3 m, and what the contacts are solved to."""
    problem, model = slides(tmp_path, 1e-9, 1e-3)
    told = polished(problem, problem.fit(model))
    assert np.abs(told.step_error[0]) < 1e-3 * np.sqrt(told.covariance[0, 0])


def test_a_fit_that_leaves_far_more_than_the_step_moves_is_judged_as_it_is(tmp_path):
    """Friction that grows by 0.3 s/m: without it 140 times the noise is left, and the step moves the readings by half of it. With
    it nothing is left, and the same correction is taken out anew."""
    problem, model = slides(tmp_path, 0.3, 1e-3)
    fit, bare = problem.fit(model), problem.fit(replace(model, terms=()))
    time_step.corrected(problem, fit)
    assert problem.step_change is not None and bare.chi2_per_freedom > 1000
    assert time_step.alone(problem, bare) is bare
    assert time_step.alone(problem, fit) is not fit


def test_the_misfit_that_a_step_makes_in_flight_is_known_from_one_run_in_half_of_it(tmp_path):
    """Throws through a medium that slows them as they go, no noise, in steps of 0.2 s: all that a fit leaves is the error of the
    step, and half of a step of fourth order makes a sixteenth of it. In steps so long the next order adds a tenth."""
    measurement = read_recordings(read_experiment_file(write_throws(tmp_path, 0.0, static=False, drag_per_metre=0.2)))
    (law,), _ = candidates_for(measurement, False, ["quadratic_drag"])
    model = Model((Term(law, (("drag_coefficient", 5.0),)),), time_step=0.2)
    white = Noise(CorrelatedNoise(1e-5, 0.0, 0.0, np.zeros((3, 3))), None, 1 / 60, "stated")
    problem = posed(measurement, white, model, False, 0.2)
    fit = problem.fit(model)
    assert misfit_by_step(problem, fit) == pytest.approx((15 / 16) ** 2 * fit.chi2, rel=0.2)


@pytest.mark.parametrize(("name", "wrong"), [("viscous_friction", False), ("load_dependent_friction", True)])
def test_intervals_are_measured_only_where_the_model_may_be_right(tmp_path, monkeypatch, name, wrong):
    """Friction that grows by 0.3 s/m, fitted by itself and by a law of the load, which leaves more than ten times the noise."""
    problem, _ = slides(tmp_path, 0.3, 1e-3)
    (law,), _ = candidates_for(read_recordings(read_experiment_file(tmp_path / "slides.toml")), True, [name])
    (number,) = law.free
    fit = problem.fit(Model((Term(law, ((number.name, number.start),)),), time_step=problem.simulator.time_step))
    assert (fit.chi2_per_freedom > 100) == wrong
    measured = []
    monkeypatch.setattr(time_step, "measured_errors", lambda problem, fit: measured.append(fit) or fit)
    told = polished(problem, fit)
    assert bool(measured) != wrong and np.isfinite(told.covariance).all()


def test_numbers_of_a_search_of_fewer_rows_are_made_final_on_all(tmp_path, monkeypatch):
    """Of 2,000 rows the search has every tenth: the error of the slope, measured to both sides, is that of all rows."""
    monkeypatch.setattr("hlcs.kinds.trajectories.thinning.MOST_SEARCHED", 200)
    whole, model = slides(tmp_path, 0.3, 1e-3)
    measurement = read_recordings(read_experiment_file(tmp_path / "slides.toml"))
    few = posed(thinned(measurement, whole.noise), whole.noise, model, True)
    fit = few.fit(model)
    problem, told = polisher(few, fit, on_all_rows(measurement))(fit)
    assert fit.count < 800 and told.count == whole.fit(model).count > 5000
    assert problem is not few and np.shape(told.sides) == (2, 1)
    assert told.covariance[0, 0] == pytest.approx(polished(whole, whole.fit(model)).covariance[0, 0], rel=0.05)
