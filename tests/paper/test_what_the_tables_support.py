"""What Tables 2 and 3 can and cannot tell: Welch, Holm, Fisher, the floor of eps_R, the campaign term.

Expected figures are recorded to the digits they are quoted with in docs/errata.md; tolerances are half a unit of the last
digit unless a Monte Carlo is involved, where the comment says so. The coefficients of variation are read as scatter between
tests.
"""

import numpy as np
import pytest

from hlcs.placement import printed_tables, statistics
from tests.paper import table_statistics

PAIRS = {
    name: (printed_tables.laboratory(table, grid), printed_tables.paper_numerical(table, grid))
    for name, table, grid in (("RPG", "table2", "RPG"), ("TPG", "table2", "TPG"), ("slope", "table3", "TPG"))
}


@pytest.mark.parametrize(
    ("name", "bias", "t"),
    [
        ("RPG", [0.0, 2.8, 2.2, -1.5, 0.4], [0.0, 3.9, 2.5, -1.5, 0.2]),
        ("TPG", [1.8, 0.3, 0.0, 1.3, -1.6], [5.0, 0.4, 0.0, 1.2, -1.2]),
        ("slope", [1.0, 6.0, 1.4, 1.7, 3.8], [1.6, 3.5, 0.7, 0.8, 1.6]),
    ],
)
def test_bias_and_welch_t_of_every_layer(name, bias, t):
    lab, model = PAIRS[name]
    assert 100 * statistics.signed_error(lab.mean, model.mean) == pytest.approx(bias, abs=0.051)
    assert statistics.welch(lab, model).t == pytest.approx(t, abs=0.051)


@pytest.mark.parametrize(
    ("name", "fisher", "layer", "adjusted"), [("RPG", 0.037, 2, 0.040), ("TPG", 0.103, 1, 0.038), ("slope", 0.017, 2, 0.023)]
)
def test_each_table_holds_one_layer_that_scatter_does_not_explain(name, fisher, layer, adjusted):
    """Holm within a table leaves exactly one layer below 0.05; Fisher's combination beside it."""
    p = statistics.welch(*PAIRS[name]).p
    assert table_statistics.fisher(p) == pytest.approx(fisher, abs=6e-4)
    holm = statistics.holm(p)
    assert np.flatnonzero(holm < 0.05).tolist() == [layer - 1]
    assert holm[layer - 1] == pytest.approx(adjusted, abs=6e-4)


def test_all_fifteen_layers_together():
    """Holm over all fifteen leaves none (smallest 0.069), yet together they reject a perfect model (Fisher 0.002)."""
    p = np.concatenate([statistics.welch(*pair).p for pair in PAIRS.values()])
    assert statistics.holm(p).min() == pytest.approx(0.069, abs=6e-4)
    assert table_statistics.fisher(p) == pytest.approx(0.002, abs=5e-4)


@pytest.mark.parametrize(
    ("name", "mean", "quantile", "p"), [("RPG", 0.76, 1.31, 0.03), ("TPG", 0.71, 1.17, 0.13), ("slope", 1.40, 2.29, 0.009)]
)
def test_floor_of_the_mean_relative_error(name, mean, quantile, p):
    """A perfect model scores this eps_R in percent; 0.02 % covers 200,000 draws and the choice of the common mean."""
    perfect = statistics.perfect_model_error(*PAIRS[name])
    assert 100 * perfect.mean == pytest.approx(mean, abs=0.02)
    assert 100 * perfect.quantile == pytest.approx(quantile, abs=0.02)
    assert perfect.p == pytest.approx(p, abs=0.005)


@pytest.mark.parametrize(("name", "error", "t"), [("RPG", 0.8, 1.7), ("TPG", 0.4, 1.1), ("slope", 2.7, 3.4)])
def test_total_height(name, error, t):
    lab, model = PAIRS[name]
    assert 100 * statistics.height_error(lab.mean, model.mean) == pytest.approx(error, abs=0.05)
    assert table_statistics.height_test(lab, model).t == pytest.approx(t, abs=0.05)


def test_the_slope_is_biased_one_way():
    """All five positive, +2.8 % on average: eps_R alone would not say so."""
    lab, model = PAIRS["slope"]
    assert np.all(model.mean > lab.mean) and 100 * statistics.signed_bias(lab.mean, model.mean) == pytest.approx(2.8, abs=0.05)


def test_campaigns_of_the_laboratory_differ():
    """First layers on flat floors, RPG and TPG: 1.9 % and 4.5 sigma
    apart; TPG flat and slope: t 2.4. Hence a term of 1 to 1.5 %.
    """
    rpg, tpg, slope = (PAIRS[name][0] for name in ("RPG", "TPG", "slope"))
    error = {lab.campaign: statistics.standard_error(lab)[0] for lab in (rpg, tpg, slope)}
    gap = (rpg.mean[0] - tpg.mean[0]) / np.hypot(error[rpg.campaign], error[tpg.campaign])
    assert 100 * (rpg.mean[0] / tpg.mean[0] - 1) == pytest.approx(1.9, abs=0.05) and gap == pytest.approx(4.55, abs=0.05)
    assert statistics.welch(tpg, slope).t[0] == pytest.approx(2.4, abs=0.05)
    for other in (rpg, slope):
        assert (
            0.010
            <= table_statistics.campaign_term([tpg.mean[0], other.mean[0]], [error[tpg.campaign], error[other.campaign]])
            <= 0.015
        )


def test_second_layer_drops_on_the_slope_in_the_laboratory_only():
    """Laboratory 1.076 -> 1.022 (-5.0 %, t -3.6); model 1.079 -> 1.083."""
    assert statistics.welch(PAIRS["TPG"][0], PAIRS["slope"][0]).t[1] == pytest.approx(-3.6, abs=0.05)
    assert 100 * (PAIRS["slope"][0].mean[1] / PAIRS["TPG"][0].mean[1] - 1) == pytest.approx(-5.0, abs=0.05)
    assert abs(PAIRS["slope"][1].mean[1] / PAIRS["TPG"][1].mean[1] - 1) < 0.005


@pytest.mark.parametrize(
    ("name", "layer", "low", "high"), [("RPG", 2, 1.66, 2.25), ("slope", 2, 2.62, 3.00), ("TPG", 1, 1.15, 1.67)]
)
def test_what_survives_the_campaign_term(name, layer, low, high):
    """Marginal z of the flagged layers with a term of 1.5 % (low)
    and 1 % (high): only the slope's second layer stays above 2.6.
    """
    lab, model = PAIRS[name]
    for term, expected in ((0.015, low), (0.010, high)):
        for form in ("common", "individual"):
            z = (model.mean - lab.mean) / np.sqrt(np.diag(table_statistics.covariance(lab, model, **{form: term})))
            assert z[layer - 1] == pytest.approx(expected, abs=0.006)


@pytest.mark.parametrize(("name", "common", "individual"), [("RPG", 0.02, 0.27), ("TPG", 0.12, 0.66), ("slope", 0.14, 0.07)])
def test_whole_tables_with_a_campaign_term(name, common, individual):
    """Bootstrap p at 1.25 %, both forms; 0.008 is half a digit plus the draws. A finding must
    survive both: none does.
    """
    assert table_statistics.chi_squared(*PAIRS[name], common=0.0125, draws=200_000)[2] == pytest.approx(common, abs=0.008)
    assert table_statistics.chi_squared(*PAIRS[name], individual=0.0125, draws=200_000)[2] == pytest.approx(individual, abs=0.008)


def test_chi_squared_law_is_too_sure_with_five_tests():
    """RPG: 24.1 on 5; the law says 0.0002, the bootstrap 0.03."""
    observed, law, bootstrap = table_statistics.chi_squared(*PAIRS["RPG"])
    assert (
        observed == pytest.approx(24.1, abs=0.05)
        and law == pytest.approx(0.0002, abs=5e-5)
        and bootstrap == pytest.approx(0.034, abs=0.004)
    )


@pytest.mark.parametrize(("name", "ratio", "p"), [("RPG", 2.0, 0.004), ("TPG", 1.1, 0.37), ("slope", 1.5, 0.05)])
def test_physical_scatter_over_numerical_scatter(name, ratio, p):
    """Pooled over layers 2 to 5; p one-sided."""
    upper = [statistics.Sample(side.mean[1:], side.cv[1:], side.tests[1:]) for side in PAIRS[name]]
    found = statistics.scatter_ratio(*upper)
    assert found[0] == pytest.approx(ratio, abs=0.05) and found[1] == pytest.approx(p, abs=0.01)


def test_detectable_shifts():
    """80 % power among five layers, percent of k: L1 0.8-2.1, L2 2.2-5.9, L3-L5 3.0-8.1."""
    shifts = np.array(
        [
            100 * statistics.detectable_shift(np.sqrt(np.diag(table_statistics.covariance(*pair)))) / pair[0].mean
            for pair in PAIRS.values()
        ]
    )
    for layers, low, high in ((slice(0, 1), 0.8, 2.1), (slice(1, 2), 2.2, 5.9), (slice(2, 5), 3.0, 8.1)):
        assert shifts[:, layers].min() == pytest.approx(low, abs=0.05) and shifts[:, layers].max() == pytest.approx(
            high, abs=0.05
        )


def test_subtracting_two_margins_per_layer_does_not_mend_all():
    """0.016 off every layer: slope 2.8 -> 1.4 %, RPG 1.4 -> 1.5 %, TPG 1.0 -> 1.4 %."""
    for name, expected in (("slope", 1.4), ("RPG", 1.5), ("TPG", 1.4)):
        lab, model = PAIRS[name]
        assert 100 * statistics.mean_relative_error(lab.mean, model.mean - 0.016) == pytest.approx(expected, abs=0.06)


def test_reference_runs_score_what_is_recorded():
    """eps_R of the runs in reference.csv against laboratory and
    against the paper's model; their k are printed to 0.001, so 0.1 %.
    """
    for _, run in table_statistics.reference_runs().dropna(subset="k1").iterrows():
        lab, model = PAIRS["slope" if run.bottom_slope else run.grid]
        k = run[["k1", "k2", "k3", "k4", "k5"]].to_numpy(float)
        assert 100 * statistics.mean_relative_error(lab.mean, k) == pytest.approx(run.eps_physical_percent, abs=0.1), run.run
        if np.isfinite(run.eps_numerical_percent):
            assert 100 * statistics.mean_relative_error(model.mean, k) == pytest.approx(run.eps_numerical_percent, abs=0.1), (
                run.run
            )
