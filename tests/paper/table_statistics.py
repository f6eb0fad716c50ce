"""What docs/theory/statistics.md and docs/errata.md recompute of the paper's tables, beyond what the program itself needs."""

from importlib import resources

import numpy as np
import pandas
from scipy import special

from hlcs.placement import printed_tables, statistics
from minibullet.errors import InputError


def spread(sample):
    """Means, standard deviations and numbers of tests of a sample, each (M,)."""
    mean = np.asarray(sample.mean, dtype=float)
    return mean, mean * np.asarray(sample.cv, dtype=float), np.broadcast_to(np.asarray(sample.tests, dtype=float), mean.shape)


def equation_12(sample):
    """The paper's 95 % interval of each mean in its corrected form, k (1 -+ 1.96 CV / sqrt(N)): (low, high), each (M,)."""
    half = special.ndtri(0.975) * statistics.standard_error(sample)
    mean = np.asarray(sample.mean, dtype=float)
    return mean - half, mean + half


def packing_density(spacing_x, spacing_y):
    """Units per square of the nominal diameter on a grid, 1/(a b) with spacings in Dn; rectangular and triangular alike [-]."""
    return 1.0 / (spacing_x * spacing_y)


def porosity(packing, mean):
    """Nominal porosity of the structure, 1 - M phi / sum(k): Eq. 2 for M layers of coefficients `mean` (M,) and packing
    density phi [-].
    """
    mean = np.asarray(mean, dtype=float)
    return float(1.0 - mean.size * packing / mean.sum())


def height_test(measured, model):
    """Welch's test of the total heights sum(k), layers taken as independent; returns `Welch` of floats.

    Neighbouring layers share a plate reading, which makes their errors cancel in the sum: the true t is somewhat larger.
    """
    mean_1, deviation_1, tests_1 = spread(measured)
    mean_2, deviation_2, tests_2 = spread(model)
    variances = np.concatenate([deviation_1**2 / tests_1, deviation_2**2 / tests_2])
    freedom = variances.sum() ** 2 / np.sum(variances**2 / (np.concatenate([tests_1, tests_2]) - 1))
    t = (mean_2.sum() - mean_1.sum()) / np.sqrt(variances.sum())
    return statistics.Welch(float(t), float(freedom), float(2.0 * special.stdtr(freedom, -abs(t))))


def fisher(p):
    """One p-value from independent ones: -2 sum log p against chi-squared of 2n. R. A. Fisher, Statistical Methods (1932)."""
    p = np.asarray(p, dtype=float)
    with np.errstate(divide="ignore"):
        return float(special.chdtrc(2 * p.size, -2.0 * np.log(p).sum()))


def campaign_term(mean, standard_error):
    """Relative standard deviation between campaigns that measured the
    same thing [-], 0 where their scatter explains the differences.

    `mean` and `standard_error` (C,) of C >= 2 campaigns. Method of
    moments: variance of the means less their mean squared standard error.
    """
    mean, standard_error = np.asarray(mean, dtype=float), np.asarray(standard_error, dtype=float)
    if mean.size < 2:
        raise InputError("a between-campaign term needs at least two campaigns")
    return float(np.sqrt(max(0.0, np.var(mean, ddof=1) - np.mean(standard_error**2))) / mean.mean())


def covariance(measured, model, common=0.0, individual=0.0):
    """Covariance (M, M) of model - measured: both standard errors, and what another campaign would change.

    `common` shifts all layers of a campaign by one factor, `individual` each layer by its own; both relative standard
    deviations [-]. The tables cannot tell which of the two it is, so a finding must survive both.
    """
    mean = np.asarray(measured.mean, dtype=float)
    own = np.diag(statistics.standard_error(measured) ** 2 + statistics.standard_error(model) ** 2)
    return own + common**2 * np.outer(mean, mean) + individual**2 * np.diag(mean**2)


def chi_squared(measured, model, common=0.0, individual=0.0, draws=50_000, seed=0):
    """Chi-squared of the whole table, its p by the chi-squared law, and its p by parametric bootstrap: three floats.

    The bootstrap draws means *and* standard deviations of tests that agree, and judges each draw by its own standard
    deviations, as the data are judged: with five tests the chi-squared law is far too sure.
    """
    mean, deviation_1, tests_1 = spread(measured)
    mean_2, deviation_2, tests_2 = spread(model)
    difference = mean_2 - mean
    observed = float(difference @ np.linalg.solve(covariance(measured, model, common, individual), difference))
    generator = np.random.default_rng(seed)
    shape = (draws, mean.size)
    drawn = np.sqrt(deviation_1**2 / tests_1 + deviation_2**2 / tests_2) * generator.standard_normal(shape)
    drawn += mean * (common * generator.standard_normal((draws, 1)) + individual * generator.standard_normal(shape))
    variance = deviation_1**2 * generator.chisquare(tests_1 - 1, shape) / (tests_1 - 1) / tests_1
    variance += deviation_2**2 * generator.chisquare(tests_2 - 1, shape) / (tests_2 - 1) / tests_2
    weight = 1.0 / (variance + individual**2 * mean**2)
    # the common term is of rank one, so its inverse is known (Sherman and Morrison)
    aligned = np.sum(mean * drawn * weight, axis=1)
    scores = np.sum(drawn**2 * weight, axis=1) - common**2 * aligned**2 / (1.0 + common**2 * np.sum(mean**2 * weight, axis=1))
    return observed, float(special.chdtrc(mean.size, observed)), float(np.mean(scores >= observed))


def printed_errors(table, grid=None, study="numerical"):
    """Errors as printed, in percent: (Er of each layer (M,), eps_R or nan where none is printed)."""
    grid = printed_tables._grid_of(table, grid, study)
    rows = [row for row in printed_tables.rows_of("printed_errors") if _matches(row, table, grid, study)]
    layers = np.array([float(row["percent"]) for row in rows if row["layer"] != "all"])
    overall = [float(row["percent"]) for row in rows if row["layer"] == "all"]
    return layers, overall[0] if overall else float("nan")


def reference_runs():
    """What Blender's Bullet and pybullet gave on the same procedure, measured by this project: a DataFrame, one row a run."""
    with resources.files("hlcs.placement").joinpath("printed", "reference.csv").open(encoding="utf-8") as file:
        return pandas.read_csv(file)


def _matches(row, table, grid, study):
    return row["table"].lower().replace(" ", "") == table and row["grid"] == grid and row["study"] == study
