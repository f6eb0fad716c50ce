"""Adequacy: noise alone passes as often as its quantile says, a slow misfit does not, whatever the fit has absorbed."""

import numpy as np
import pytest
from linear_models import Line, model

from hlcs.estimation.adequacy import QUANTILE, adequacy, against, block_matrix, blocks_in_time, fit_adequacy
from hlcs.estimation.fitting import fit_at
from hlcs.estimation.least_squares import basis, project_out

COUNT = 48
ONES = np.ones((COUNT, 1))
NONE = np.zeros((COUNT, 0))
LABELS = blocks_in_time(np.zeros(COUNT, int), 8)


def judged(values, generator, columns=ONES):
    """Adequacy of one recording whose mean was fitted."""

    def draw(index, count):
        return generator.standard_normal((COUNT, count))

    left = project_out(basis(columns), values)
    return adequacy([left], [columns], [NONE], {"blocks": LABELS}, draw, draws=200)


def test_noise_alone_passes_as_often_as_the_quantile_says(generator):
    """At 1 % of false alarms more than five in 100 happen once in 1,700 times; the mean square is 1 within five errors."""
    verdicts = [judged(generator.standard_normal(COUNT), generator) for _ in range(100)]
    assert QUANTILE == 0.99 and sum(not verdict.adequate for verdict in verdicts) <= 5
    assert abs(np.mean([verdict.chi2 for verdict in verdicts]) - 1) < 5 * np.sqrt(2 / (100 * COUNT))


@pytest.mark.parametrize("draws", [50, 100, 200, 600, 4000])
def test_above_the_threshold_and_only_there_p_is_at_most_one_per_cent(draws, generator):
    """Statistics between all draws, and on them: 7 of 601 are 1.2 %, so the seventh largest of 600 draws is not yet too large."""
    drawn = generator.standard_normal(draws)
    ordered = np.sort(drawn)
    for statistic in (*ordered, *(ordered[:-1] + ordered[1:]) / 2, ordered[-1] + 1):
        p, threshold = against(drawn, statistic)
        assert (p <= 0.01) == (statistic > threshold)


def test_a_slow_misfit_of_one_sigma_shows_in_the_blocks(generator):
    """A sine of one turn, amplitude 1: a block of eight sums to about 8 * 0.8 / sqrt(8) = 2.3 sigma, six of them to chi2 30."""
    slow = np.sin(2 * np.pi * np.arange(COUNT) / COUNT)
    verdict = judged(slow + generator.standard_normal(COUNT), generator)
    assert not verdict.adequate and verdict.worst == "blocks" and verdict.p < 0.02


def test_a_block_that_the_fit_has_fixed_says_nothing(generator):
    """With a constant of its own for each block every block sum is zero: only the variance is left to test."""
    own = (LABELS[:, None] == np.arange(6)) * 1.0
    verdict = judged(5.0 + generator.standard_normal(COUNT), generator, own)
    assert verdict.worst == "variance" and verdict.adequate


def test_block_sums_are_divided_by_the_root_of_their_count():
    matrix = block_matrix([0, 0, 0, 0, 7]).toarray()
    np.testing.assert_allclose(matrix @ np.ones(5), [2.0, 1.0])


def test_blocks_begin_anew_with_each_channel():
    assert blocks_in_time([0, 0, 0, 1, 1, 1, 1], 2).tolist() == [0, 0, 1, 2, 2, 3, 3]


def test_overdispersion_is_how_many_of_alike_residuals_count_as_one(generator):
    """Noise that is one value in each block of eight: its block sums have eight times the variance, so eight count as one.

    The mean of six such sums scatters by root(2/6) of 8; that of 200 trials by 0.33.
    """
    seen = [judged(np.repeat(generator.standard_normal(6), 8), generator, NONE).overdispersion for _ in range(200)]
    assert abs(np.mean(seen) - 8) < 4 * 8 * np.sqrt(2 / 6 / 200)


def test_overdispersion_of_white_noise_is_about_one(generator):
    """The larger of two means of squares about 1, that of six sums with errors of root(2/6) = 0.6."""
    seen = [judged(generator.standard_normal(COUNT), generator).overdispersion for _ in range(50)]
    assert 1 < np.mean(seen) < 1.6


def test_what_more_steps_of_a_fit_would_explain_it_has_not_explained(generator, monkeypatch):
    """A slope of 3 is read as 2.9, ten standard errors off: where it stands the fit leaves more than noise, at its end it does
    not, although the column of the slope can explain either."""
    monkeypatch.setattr(
        "hlcs.estimation.adequacy.NoiseDraws", lambda *known: lambda k, count: generator.standard_normal((100, count))
    )
    times = np.linspace(0.0, 1.0, 100)
    problem = Line([times, times], [3.0 * times + 0.002 * generator.standard_normal(100) for _ in range(2)], 0.002)
    problem.shared_doubt = None
    end = problem.fit(model(2.9))
    stuck = fit_at(model(2.9), end.initial_states, problem.linearise(model(2.9), end.initial_states), converged=False)
    labels = {"blocks": blocks_in_time(np.repeat([0, 1], 100), 10)}
    assert fit_adequacy(problem, end, labels).adequate
    assert not fit_adequacy(problem, stuck, labels).adequate
