"""The statistics of the theory page against closed forms and against themselves with many tests."""

import numpy as np
import pytest

from hlcs.placement.statistics import Sample
from tests.paper import table_statistics


def test_fisher_closed_form():
    """For two p-values of product w, Fisher's p is w (1 - log w)."""
    assert table_statistics.fisher([0.1, 0.2]) == pytest.approx(0.02 * (1 - np.log(0.02)), rel=1e-12)
    assert table_statistics.fisher([0.0, 0.5]) == 0.0


def test_chi_squared_bootstrap_has_the_right_size(generator):
    """Among tables without any difference, p below 0.1 in about a
    tenth: 0.1 -+ 3 standard deviations of 200 tables is 0.036-0.164.
    """
    low = 0
    for _ in range(200):
        tests = generator.normal(1.0, 0.02, (2, 5, 3))
        first, second = (Sample(x.mean(0), x.std(0, ddof=1) / x.mean(0), 5) for x in tests)
        low += table_statistics.chi_squared(first, second, draws=1000)[2] < 0.1
    assert 0.036 < low / 200 < 0.164


@pytest.mark.parametrize("terms", [{}, {"common": 0.0125}, {"individual": 0.0125}, {"common": 0.01, "individual": 0.01}])
def test_chi_squared_bootstrap_tends_to_the_law(terms):
    """With many tests the standard deviations are known and both p agree; 0.01 is four standard errors of 50,000 draws."""
    first, second = Sample([1.3, 1.0, 0.95], [0.1, 0.2, 0.3], 4000), Sample([1.303, 1.008, 0.945], [0.1, 0.2, 0.3], 4000)
    _, law, bootstrap = table_statistics.chi_squared(first, second, **terms)
    assert bootstrap == pytest.approx(law, abs=0.01)


def test_campaign_term():
    """Two means d apart: variance d^2/2 less the mean squared error; explained scatter gives exactly zero."""
    assert table_statistics.campaign_term([1.0, 1.02], [0.0, 0.0]) == pytest.approx(0.02 / np.sqrt(2) / 1.01, rel=1e-12)
    assert table_statistics.campaign_term([1.0, 1.001], [0.01, 0.01]) == 0.0
