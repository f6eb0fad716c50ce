"""The one table of model beside measurement: its numbers recomputed by hand."""

import numpy as np
import pytest

import hlcs
from hlcs.placement.comparison import compare_layers, laboratory_for, repeated
from hlcs.placement.printed_tables import laboratory, paper_numerical
from hlcs.placement.statistics import Sample


def test_the_paper_s_own_columns_give_the_paper_s_own_errors():
    """eps_R of Table 2, TPG: printed 1.04 %, recomputed from the printed, rounded means 1.00 % (docs/errata.md)."""
    comparison = compare_layers(paper_numerical("table2", grid="TPG"), laboratory("table2", grid="TPG"))
    assert 100 * comparison.mean_relative_error == pytest.approx(1.00, abs=0.005)
    assert comparison.height_error == pytest.approx(5.327 / 5.304 - 1, rel=1e-12)
    first = (1.317 - 1.294) / np.sqrt((1.294 * 0.008) ** 2 / 5)
    assert comparison.z[0] == pytest.approx(first, rel=1e-12)


def test_one_test_takes_the_measurement_s_scatter(small_result):
    measured = laboratory("table2", grid="TPG")
    comparison = hlcs.compare(small_result, measured)
    k = small_result.layer_coefficients
    error = 1.294 * 0.008 * np.sqrt(1 + 1 / 5)
    assert comparison.z[0] == pytest.approx((k[0] - 1.294) / error, rel=1e-12)
    assert "layers 1 to 2 only" in str(comparison) and "one model test" in str(comparison)
    assert list(comparison.to_dataframe()["tests"]) == [1, 1]


def test_repeats_give_mean_scatter_and_number():
    sample = repeated([[1.3, 1.0], [1.3, 1.1], [1.3, 1.2]])
    np.testing.assert_allclose(sample.mean, [1.3, 1.1])
    np.testing.assert_allclose(sample.cv, [0.0, 0.1 / 1.1], atol=1e-15)
    assert list(sample.tests) == [3, 3]


def test_unknown_scatter_gives_no_z():
    comparison = compare_layers(Sample([1.3], [0.01], 5), Sample([1.2], [np.nan], 5))
    assert np.isnan(comparison.z).all() and "-" in str(comparison)


def test_what_has_no_layers_is_refused(small_result):
    with pytest.raises(hlcs.InputError, match="int has no layer coefficients"):
        compare_layers(3, laboratory("table2", grid="TPG"))
    one = hlcs.PlacementTest(layers=1, rows=2, columns=2).run()
    with pytest.raises(hlcs.InputError, match="different numbers of layers"):
        compare_layers([small_result, one], laboratory("table2", grid="TPG"))


def test_the_laboratory_measured_three_cases():
    assert laboratory_for(hlcs.PlacementTest(grid="RPG")).grid == "RPG"
    assert laboratory_for(hlcs.PlacementTest(bottom="slope:0.04")).bottom_slope == 0.04
    assert laboratory_for(hlcs.PlacementTest(grid="RPG", bottom="slope:0.04")) is None
    assert laboratory_for(hlcs.PlacementTest(grid="1.5,1.3")) is None
