"""What a fit tells: chi2 with the initial states projected out, the place of a term's numbers, what numbers pay."""

from dataclasses import replace

import numpy as np
import pytest
from linear_models import RATE, Line, model

from hlcs.estimation.fitting import fit_at
from hlcs.estimation.linearization import Linearization, free_numbers, occam
from hlcs.simulation.model import Model, Term

TIMES = [np.arange(5.0)]


def test_chi2_is_that_of_the_residuals_about_the_state_that_was_fitted():
    """Residuals y - rate t about their own mean: the constant of the recording is free."""
    values = [np.array([1.0, 4.0, 2.0, 8.0, 5.0])]
    problem = Line(TIMES, values, 2.0)
    base = model(0.0).without(0)
    linear = problem.linearise(base, problem.initial_guess())
    fit = fit_at(base, problem.initial_guess(), linear)
    assert fit.chi2 == pytest.approx(np.sum((values[0] - values[0].mean()) ** 2) / 4)
    assert fit.count == 5 and fit.freedom == 4 and free_numbers(base) == []


def test_numbers_of_a_term_are_found_by_its_place_and_from_the_end():
    fit = Line(TIMES, [2.0 * TIMES[0]]).fit(model(1.0))
    two = replace(fit, model=fit.model.with_term(fit.model.terms[0]))
    assert (two.numbers_of(0), two.numbers_of(1), two.numbers_of(-1)) == (slice(0, 1), slice(1, 2), slice(1, 2))


def test_a_number_pays_twice_the_log_of_spread_over_error_and_never_more_than_one_observation():
    """log(1 + 24) for an information of 24 in units of the spread; of 1e6 the log of the count; nothing for what is not seen."""
    assert occam(np.diag([24.0, 0.0]), 1000) == pytest.approx(np.log(25.0))
    assert occam(np.diag([1e6, 1e6]), 50) == pytest.approx(2 * np.log(50.0))
    assert occam(np.zeros((0, 0)), 50) == 0.0 and occam(np.array([[np.nan]]), 50) == np.inf


def test_a_start_is_spared_its_price_as_far_as_the_data_do_not_show_it():
    """Position and speed of 50 readings along a line, noise of a thousandth of the way: nothing is spared, where a drag ends the
    speed at once the logarithm of the count of readings, where it is shown by less than a reading the rest of that."""
    count = 50
    ones, time = np.full(count, 1e3), np.linspace(0.0, 1e3, count)

    def spared(speed, overdispersion=1.0):
        columns = np.column_stack([ones, speed])
        return Linearization([], [], [columns], [], state_spreads=[np.ones(2)]).spared(overdispersion)

    assert spared(time) == 0.0
    assert spared(0 * time) == pytest.approx(np.log(count))
    assert spared(0 * time, 10.0) == pytest.approx(np.log(count / 10))
    alternate = np.tile([0.5, -0.5], count // 2)  # of information 50/4 and no part in the position
    assert spared(alternate) == pytest.approx(np.log(count) - np.log1p(count / 4))
    assert Linearization([], [], [np.zeros((count, 2))], []).spared() == 0.0  # starts of which nothing is believed


def test_where_many_residuals_count_as_one_the_data_tell_less_and_beliefs_stay():
    """A rate of 1 known to information I at chi2 X: X / 4 + surprise + log(1 + I / 4) where four count as one."""
    values = [np.array([1.0, 4.0, 2.0, 8.0, 5.0])]
    fit = Line(TIMES, values, 2.0).fit(model(1.0))
    paid = fit.tempered(4.0) - fit.chi2 / 4 - fit.surprise
    (information,) = fit.information.ravel()
    assert paid == pytest.approx(min(np.log1p(information / 4), np.log(5 / 4))) and fit.tempered(1.0) == fit.cost


def test_where_many_residuals_count_as_one_a_number_is_known_no_worse_than_it_was_believed():
    """Beside the information I of the data, in spreads, a belief at what is expected has 2: 1 / (I / 100 + 2)."""
    rate = replace(RATE, free=(replace(RATE.free[0], stated=2.0, error=0.1),))
    fit = Line(TIMES, [2.0 * TIMES[0]], 2.0).fit(Model((Term(rate, (("rate", 2.0),)),)))
    (information,) = fit.information.ravel()
    assert fit.covariance_at(1.0)[0, 0] == fit.covariance[0, 0] == pytest.approx(0.01 / (information + 2))
    assert fit.covariance_at(100.0)[0, 0] == pytest.approx(0.01 / (information / 100 + 2))
    assert fit.savings(100.0) == pytest.approx([0.0])


def test_predictions_that_change_as_a_number_does_move_it_by_as_much_the_other_way():
    """Predictions that rise by 0.3 t + 4, for which the rate and the constant of the recording stand: the rate falls by 0.3. What
    was believed of it tells 1e-6 of what the data tell (sigma 1e-3, five readings)."""
    problem = Line(TIMES, [2.0 * TIMES[0]], 1e-3)
    fit = problem.fit(model(1.0))
    assert fit.moved_by(problem.whitened([0.3 * TIMES[0] + 4.0])) == pytest.approx([-0.3], rel=1e-5)


def test_the_error_of_the_time_step_is_one_more_source_that_does_not_fall_with_the_readings():
    """Variances of independent errors add: 0.2^2 beside that of the data, however many readings count as one."""
    fit = Line(TIMES, [2.0 * TIMES[0]], 2.0).fit(model(1.0))
    with_it = replace(fit, step_error=np.array([0.2]))
    for count in (1.0, 4.0):
        assert with_it.covariance_at(count)[0, 0] == pytest.approx(fit.covariance_at(count)[0, 0] + 0.04)


def test_a_number_far_from_what_is_expected_saves_its_surprise_less_what_the_data_then_lose():
    """At 2, ten errors of 0.1 from an expected 1: 2 log(1 + 100) less I 100 / 10 where ten residuals count as one."""
    rate = replace(RATE, free=(replace(RATE.free[0], stated=1.0, error=0.1),))
    fit = Line(TIMES, [2.0 * TIMES[0]], 0.2).fit(Model((Term(rate, (("rate", 2.0),)),)))
    (aside,) = ((value - 1.0) / 0.1 for value in fit.estimate)
    told = fit.information[0, 0]
    assert fit.savings(10.0)[0] == pytest.approx(2 * np.log1p(aside**2) - told * aside**2 / 10, rel=1e-3)
