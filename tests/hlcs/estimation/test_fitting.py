"""Fits of a problem in closed form: a line through recordings with a constant each; and of one whose law bends."""

from dataclasses import replace

import numpy as np
import pytest
from linear_models import Line, model

from hlcs.effects import Candidate, Free, class_named
from hlcs.estimation.fitting import measured_errors, with_values
from hlcs.estimation.linearization import Linearization, values_of
from hlcs.estimation.whitening import whiten
from hlcs.simulation.model import Model, Term

TIMES = [np.linspace(0.0, 2.0, 9), np.linspace(0.0, 1.0, 7)]


def test_a_linear_problem_is_solved_in_one_step_with_the_covariance_of_the_textbook(generator):
    """Slope and variance of the pooled regression with a constant for each recording: Sxy / Sxx and sigma^2 / Sxx.

    What is believed of the number, 3 of a spread of 5, bends the misfit by 0.05 beside Sxx / sigma^2 of 5e4.
    """
    values = [3.0 * t + c + 0.01 * generator.standard_normal(len(t)) for t, c in zip(TIMES, (5.0, -2.0), strict=True)]
    fit = Line(TIMES, values, 0.01).fit(model(1.0))
    centred = [t - t.mean() for t in TIMES]
    sxx = sum(t @ t for t in centred)
    slope = sum(t @ y for t, y in zip(centred, values, strict=True)) / sxx
    assert fit.estimate[0] == pytest.approx(slope, rel=1e-5)
    assert fit.covariance[0, 0] == pytest.approx(0.01**2 / sxx, rel=1e-5)
    assert fit.initial_states[:, 0] == pytest.approx(
        [y.mean() - slope * t.mean() for t, y in zip(TIMES, values, strict=True)], rel=1e-5
    )
    assert fit.freedom == 16 - 3 and fit.converged


def test_a_number_stops_where_its_law_ends_and_not_at_the_end_of_its_range():
    """A negative rate cannot be; one of 30 lies beyond the plausible 0 to 10, and is what the data say."""
    assert Line(TIMES, [-1.0 * t for t in TIMES]).fit(model(1.0)).estimate[0] == pytest.approx(0.0, abs=1e-6)
    fit = Line(TIMES, [30.0 * t for t in TIMES], 0.01).fit(model(1.0))
    assert fit.estimate[0] == pytest.approx(30.0, rel=1e-4) and fit.surprise == pytest.approx(2 * np.log(37.0), rel=1e-3)


@pytest.mark.parametrize("wrong", [0.04, 25.0])
def test_errors_are_those_that_the_ends_of_the_interval_show(wrong):
    """Variances a factor 25 off are found anew where the problem is linear; also beside the end of a law, from one side."""
    for rate in (3.0, 0.0):
        problem = Line(TIMES, [rate * t + 1.0 for t in TIMES], 0.01)
        fit = problem.fit(model(1.0))
        measured = measured_errors(problem, replace(fit, covariance=wrong * fit.covariance))
        assert measured.covariance[0, 0] == pytest.approx(fit.covariance[0, 0], rel=1e-3)


class Uneven(Line):
    """The same with what `beside` adds to the residuals at a rate, in sigmas of each row."""

    def __init__(self, beside):
        super().__init__(TIMES, [3.0 * t + 1.0 for t in TIMES], 0.01)
        self.beside = beside

    def residuals(self, model, initial_states):
        beside = self.beside(model.terms[0].numbers["rate"], sum(map(len, self.times)))
        parts = np.split(0.01 * beside, np.cumsum([len(t) for t in self.times])[:-1])
        return [a + b for a, b in zip(super().residuals(model, initial_states), parts, strict=True)]


def rough(rate, count):
    """Three sigmas that are drawn anew wherever one looks, as of a solver that ends at another sweep."""
    return 3.0 * np.random.default_rng(int(1e12 * rate)).standard_normal(count)


@pytest.mark.parametrize("wrong", [0.04, 1.0, 25.0])
def test_rough_residuals_do_not_make_an_interval_narrower(wrong):
    """The Cramer-Rao bound of the slope is sigma^2 / Sxx, whatever the solver adds. It adds 2 * 16 * 3^2 = 288 to the square of
    each change, of which two standard errors to both sides are 16: ends that are not farther off show a fourth of the error. The
    reading over a reach that shows no more is short by a fifth at most (SETTLED), and chance does as much: 288 is known to
    a third.
    """
    problem, (centred, sigma) = Uneven(rough), ([t - t.mean() for t in TIMES], 0.01)
    fit = Line.fit(Line(TIMES, problem.values, sigma), model(3.0))
    measured = measured_errors(problem, replace(fit, covariance=wrong * fit.covariance))
    bound = sigma / np.sqrt(sum(t @ t for t in centred))
    assert np.sqrt(measured.covariance[0, 0]) == pytest.approx(bound, rel=0.3)


@pytest.mark.parametrize("part", [0.2, 0.7])
def test_an_interval_ends_where_the_law_is_cut(part):
    """Beyond a part of two standard errors rows leap by 100 sigmas and more: the interval reaches there, to a fifth (SETTLED)."""
    centred = [t - t.mean() for t in TIMES]
    error = 0.01 / np.sqrt(sum(t @ t for t in centred))
    wall = part * 2 * error
    problem = Uneven(lambda rate, count: 100.0 * np.sign(rate - 3.0) * (abs(rate - 3.0) > wall) * np.arange(count))
    fit = Line.fit(Line(TIMES, problem.values, 0.01), model(3.0))
    assert 2 * np.sqrt(measured_errors(problem, fit).covariance[0, 0]) == pytest.approx(wall, rel=0.25)


class Bent(Line):
    """The same with a slope of sinh(rate): from far off a full Gauss-Newton step leads nowhere."""

    def residuals(self, model, initial_states):
        slope = np.sinh(model.terms[0].numbers["rate"]) if model.terms else 0.0
        return [y - slope * t - state[0] for t, y, state in zip(self.times, self.values, initial_states, strict=True)]

    def linearise(self, model, initial_states):
        linear, bend = super().linearise(model, initial_states), np.cosh(model.terms[0].numbers["rate"])
        raw = self.residuals(model, initial_states)
        white = [whiten(recording.whitening, part) for recording, part in zip(self.recordings, raw, strict=True)]
        return Linearization(raw, white, linear.state_columns, [bend * part for part in linear.parameter_columns])


@pytest.mark.parametrize("start", [0.0, 1.0, 9.0])
def test_a_law_that_bends_is_followed_to_its_only_minimum_from_anywhere(start):
    """sinh(6) = 202: at rate 0 the linear step is 202, where the law has left the finite numbers."""
    fit = Bent(TIMES, [np.sinh(6.0) * t + 1.0 for t in TIMES], 0.01).fit(model(start))
    assert fit.estimate[0] == pytest.approx(6.0, rel=1e-5) and fit.converged


def test_a_fit_that_is_promised_no_end_within_its_limit_is_given_up_and_no_other_one_is_changed():
    """What t^2 leaves beside a line stays, wherever the rate stands: chi2 of the end is foreseen at every point."""
    problem = Bent(TIMES, [np.sinh(6.0) * t + 0.1 * t**2 for t in TIMES], 0.01)
    end = problem.fit(model(9.0))
    limits = (end.chi2 + end.surprise + 1.0, end.chi2 - 100.0)
    within, beyond = (problem.fit(model(9.0), limit=lambda limit=limit: limit) for limit in limits)
    assert within.converged and within.estimate[0] == end.estimate[0]
    assert not beyond.converged and beyond.estimate[0] > 7.0  # two steps of a Newton iteration from 9 to 6, one unit each


def test_a_fit_whose_numbers_cannot_be_is_given_up():
    """A file that states a gas is not off by the density of a rock: the fit ends on its way to 3,000, at an infinite cost."""
    dense = Free("fluid_density", "kg/m3", 0.0, 1.5, 0.0, 1.2, stated=1.2, error=500.0, certain=True, highest=1100.0)
    entry = Candidate("buoyancy", class_named("buoyancy"), (dense,))

    class Rising(Line):
        def residuals(self, model, initial_states):
            rate = model.terms[0].numbers["fluid_density"]
            return [y - rate * t - state[0] for t, y, state in zip(self.times, self.values, initial_states, strict=True)]

    problem = Rising(TIMES, [3000.0 * t for t in TIMES], 0.01)
    fit = problem.fit(Model((Term(entry, (("fluid_density", 1.2),)),)))
    assert fit.cost == np.inf and not fit.converged


class Thrown(Line):
    """x = p + ln(1 + k v t)/k: a body thrown into a liquid that stops it within k = 80 1/m; its states are p and v."""

    k = 80.0

    def residuals(self, model, initial_states):
        told = zip(self.times, self.values, initial_states, strict=True)
        with np.errstate(all="ignore"):
            return [y - state[0] - np.log1p(self.k * state[3] * t) / self.k for t, y, state in told]

    def linearise(self, model, initial_states, only=None):
        raw = self.residuals(model, initial_states)
        columns = [
            np.stack([np.ones_like(t), t / (1 + self.k * s[3] * t)], 1) for t, s in zip(self.times, initial_states, strict=True)
        ]
        white = [
            [whiten(recording.whitening, part) for recording, part in zip(self.recordings, parts, strict=True)]
            for parts in (raw, columns)
        ]
        return Linearization(raw, *white, [np.zeros((len(t), 0)) for t in self.times])


@pytest.mark.parametrize("start", [5.0, 20.0, 80.0])
def test_a_start_far_from_the_best_is_found_by_parts_of_steps(start):
    """A throw at 1 m/s with k = 80 1/m, seen at 60 Hz; from far off whole Gauss-Newton steps lead away from it."""
    t = np.arange(60) / 60
    problem = Thrown([t], [0.2 + np.log1p(80.0 * t) / 80.0], 4e-4)
    unknown = tuple((kind, np.array([1.0, 0.0, 0.0])) for kind in (0, 1))
    problem.recordings = [replace(recording, unknown=unknown) for recording in problem.recordings]
    states = problem.initial_guess()
    states[0, [0, 3]] = 0.2, start
    assert problem.fit(Model(), states).chi2 < 0.1  # a step that is foreseen to gain 0.02 is not taken


def test_a_fit_that_leaves_the_finite_numbers_costs_infinitely_much():
    assert Line(TIMES, [t * np.nan for t in TIMES]).fit(model(1.0)).cost == np.inf


def test_numbers_of_a_model_go_out_and_in():
    assert values_of(model(4.0)).tolist() == [4.0]
    assert values_of(with_values(model(4.0), np.array([7.0]))).tolist() == [7.0]
    assert values_of(with_values(model(4.0), np.array([-7.0]))).tolist() == [0.0]  # kept where its law holds
