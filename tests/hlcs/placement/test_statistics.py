"""Statistics against hand calculation, closed forms and SciPy's own two-sample test."""

import numpy as np
import pytest
from scipy import stats

from hlcs.placement import statistics
from hlcs.placement.statistics import Sample
from minibullet.errors import InputError


def test_errors_by_hand():
    """Two layers, +10 % and -5 %: eps_R 7.5 %, bias +2.5 %; heights 3 and 3.0 -> 0 only if the thick layer weighs as computed."""
    measured, model = [1.0, 2.0], [1.1, 1.9]
    assert statistics.relative_error(measured, model) == pytest.approx([0.1, 0.05], abs=1e-15)
    assert statistics.mean_relative_error(measured, model) == pytest.approx(0.075, abs=1e-15)
    assert statistics.signed_bias(measured, model) == pytest.approx(0.025, abs=1e-15)
    assert statistics.height_error(measured, model) == pytest.approx(0.0, abs=1e-15)


def test_welch_equals_scipy_on_raw_samples(generator):
    """From summaries or from raw numbers, the same test; 1e-10 is rounding through mean and standard deviation."""
    first, second = generator.normal(1.3, 0.02, 5), generator.normal(1.32, 0.01, 9)
    ours = statistics.welch(*(Sample([x.mean()], [x.std(ddof=1) / x.mean()], x.size) for x in (first, second)))
    theirs = stats.ttest_ind(second, first, equal_var=False)
    assert (ours.t[0], ours.degrees_of_freedom[0], ours.p[0]) == pytest.approx(
        (theirs.statistic, theirs.df, theirs.pvalue), rel=1e-10
    )


def test_welch_without_any_scatter():
    result = statistics.welch(Sample([1.0, 1.0], 0.0, 5), Sample([1.0, 1.1], 0.0, 5))
    assert result.t.tolist() == [0.0, np.inf] and result.p.tolist() == [1.0, 0.0]


def test_holm_by_hand():
    """0.01, 0.04, 0.03 -> 3*0.01, then max(2*0.03), then max(1*0.04, 0.06)."""
    assert statistics.holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06], abs=1e-15)
    assert statistics.holm([0.6, 0.9]).tolist() == [1.0, 1.0]


def test_intervals_use_student_for_few_tests():
    """Five tests: 2.776 standard errors (tables of Student's t)."""
    sample = Sample([1.0], [0.1], 5)
    low, high = statistics.confidence_interval(sample)
    assert (high - low)[0] / 2 == pytest.approx(2.776 * 0.1 / np.sqrt(5), rel=2e-4)


def test_perfect_model_error_closed_form():
    """One layer: the mean of a folded normal, sqrt(2/pi) se; 1 % covers the draws (200,000) and the denominator."""
    sample = Sample([1.0], [0.02], 4)
    result = statistics.perfect_model_error(sample, sample)
    assert result.mean == pytest.approx(np.sqrt(2 / np.pi) * 0.01 * np.sqrt(2), rel=0.01)
    assert result.quantile == pytest.approx(1.96 * 0.01 * np.sqrt(2), rel=0.01) and result.p == 1.0
    assert result == statistics.perfect_model_error(sample, sample), "the same seed gives the same figures"


def test_scatter_ratio():
    ratio, p = statistics.scatter_ratio(Sample([1.0, 1.0], [0.2, 0.2], 5), Sample([1.0, 1.0], [0.1, 0.1], 5))
    assert ratio == pytest.approx(2.0, rel=1e-12) and p == pytest.approx(stats.f.sf(4.0, 8, 8), rel=1e-12)


def test_detectable_shift_is_3_42_standard_errors():
    """z(0.995) + z(0.8) = 2.576 + 0.842."""
    assert statistics.detectable_shift(1.0) == pytest.approx(2.5758 + 0.8416, abs=1e-4)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: statistics.relative_error([1.0, 1.0], [1.0]), "measured has 2 layers, the model 1"),
        (lambda: statistics.relative_error([1.0, np.nan], [1.0, 1.0]), "layer 2: mean = nan"),
        (lambda: statistics.standard_error(Sample([1.0], [-0.1], 5)), "cv = -0.1"),
        (lambda: statistics.standard_error(Sample([1.0], [0.1], np.nan)), "tests = nan"),
        (lambda: statistics.standard_error(Sample([1.0], [0.1], 1)), "tests = 1"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, message):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
