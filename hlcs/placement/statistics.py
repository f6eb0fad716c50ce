"""The paper's arithmetic and the tests it leaves out: arrays in, numbers out, no physics.

A `Sample` is what a table prints of a set of repeated tests: the mean of each layer, its coefficient of variation between
tests, and the number of tests. Anything with the attributes `mean`, `cv` and `tests` will do, for instance
`hlcs.placement.printed_tables.LayerTable`. Differences are always model minus measured: positive means the model stands too high.
Equations are numbered as in Molines et al. (2021); where the print slips (docs/errata.md), the corrected form is coded and
said so.
"""

from typing import NamedTuple

import numpy as np
from scipy import special

from minibullet.errors import InputError


class Sample(NamedTuple):
    """Repeated tests, summarised."""

    mean: np.ndarray  # (M,) layer coefficients [-]
    cv: np.ndarray  # (M,) standard deviation between tests over the mean [-]
    tests: np.ndarray  # scalar or (M,) number of tests


class Welch(NamedTuple):
    """Welch's test of model against measured."""

    t: np.ndarray  # model minus measured over its standard error
    degrees_of_freedom: np.ndarray  # Welch-Satterthwaite
    p: np.ndarray  # two-sided


class PerfectModel(NamedTuple):
    """What the error measure of a model without any error would show, because both sides are means of few tests."""

    mean: float  # expected mean relative error [-]
    quantile: float  # 95 % of perfect models stay below this [-]
    p: float  # chance that a perfect model does as badly as observed; nan where nothing was observed


# ------------------------------------------------------------------------------------------------ the paper's measures
def relative_error(measured, model):
    """Relative error of each layer, |measured - model| / measured (Eq. 10). Arrays (M,) of layer coefficients -> (M,) [-]."""
    return np.abs(signed_error(measured, model))


def mean_relative_error(measured, model):
    """Mean of the relative errors of the layers, the paper's eps_R (Eq. 11) [-]. It has no sign: read it beside `signed_bias`."""
    return float(np.mean(relative_error(measured, model)))


def signed_error(measured, model):
    """(model - measured) / measured of each layer [-]; positive: the model is too thick."""
    measured, model = _means(measured), _means(model, least=-np.inf)  # a layer of a model may sink: not thick, but a number
    if measured.shape != model.shape:
        raise InputError(f"measured has {measured.size} layers, the model {model.size}: give both the same layers")
    return (model - measured) / measured


def signed_bias(measured, model):
    """Mean over the layers of `signed_error` [-]."""
    return float(np.mean(signed_error(measured, model)))


def height_error(measured, model):
    """Relative error of the whole height, (sum of model - sum of measured) / sum of measured [-], signed. Heights are Eq. 14."""
    signed_error(measured, model)  # for its checks
    return float(np.sum(model) / np.sum(measured) - 1.0)


def packing_density(spacing_x, spacing_y):
    """Units per square of the nominal diameter on a grid, 1/(a b) with spacings in Dn; rectangular and triangular alike [-]."""
    return 1.0 / (spacing_x * spacing_y)


def porosity(packing, mean):
    """Nominal porosity of the structure, 1 - M phi / sum(k): Eq. 2 for M layers of coefficients `mean` (M,) and packing
    density phi [-].
    """
    mean = _means(mean)
    return float(1.0 - mean.size * packing / mean.sum())


# -------------------------------------------------------------------------------------------------------- uncertainty
def standard_error(sample):
    """Standard error of each layer's mean, mean * cv / sqrt(tests), (M,) [-]."""
    mean, deviation, tests = _checked(sample)
    return deviation / np.sqrt(tests)


def confidence_interval(sample, confidence=0.95, law="student"):
    """Two-sided interval of each layer's mean: (low, high), each (M,).

    law "student" uses Student's t with tests - 1 degrees of freedom (2.78 for five tests at 95 %); "normal" is Eq. 12 in
    its corrected form, k (1 -+ 1.96 CV / sqrt(N)), which is too narrow for few tests.
    """
    mean, deviation, tests = _checked(sample)
    tail = 0.5 + 0.5 * confidence
    if law == "student":
        factor = special.stdtrit(tests - 1, tail)
    elif law == "normal":
        factor = special.ndtri(tail)
    else:
        raise InputError(f"law = {law!r}; known laws are 'student' and 'normal'")
    half = factor * deviation / np.sqrt(tests)
    return mean - half, mean + half


def welch(measured, model):
    """Welch's t of each layer between two samples, unequal variances; returns `Welch` of arrays (M,).

    Two layers without any scatter have no error to divide by: t is 0 (p = 1) where they agree and infinite (p = 0) where
    they do not.
    """
    mean_1, deviation_1, tests_1 = _checked(measured)
    mean_2, deviation_2, tests_2 = _checked(model)
    return _welch_of(mean_2 - mean_1, deviation_1**2 / tests_1, tests_1, deviation_2**2 / tests_2, tests_2)


def height_test(measured, model):
    """Welch's test of the total heights sum(k), layers taken as independent; returns `Welch` of floats.

    Neighbouring layers share a plate reading, which makes their errors cancel in the sum: the true t is somewhat larger.
    """
    mean_1, deviation_1, tests_1 = _checked(measured)
    mean_2, deviation_2, tests_2 = _checked(model)
    variances = np.concatenate([deviation_1**2 / tests_1, deviation_2**2 / tests_2])
    freedom = variances.sum() ** 2 / np.sum(variances**2 / (np.concatenate([tests_1, tests_2]) - 1))
    t = (mean_2.sum() - mean_1.sum()) / np.sqrt(variances.sum())
    return Welch(float(t), float(freedom), float(2.0 * special.stdtr(freedom, -abs(t))))


def holm(p):
    """Holm's adjusted p-values (n,): multiple comparisons, no assumption of independence. S. Holm, Scand. J. Statist. 6
    (1979).
    """
    p = np.asarray(p, dtype=float)
    order = np.argsort(p)
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate((p.size - np.arange(p.size)) * p[order]))
    return adjusted


def fisher(p):
    """One p-value from independent ones: -2 sum log p against chi-squared of 2n. R. A. Fisher, Statistical Methods (1932)."""
    p = np.asarray(p, dtype=float)
    with np.errstate(divide="ignore"):
        return float(special.chdtrc(2 * p.size, -2.0 * np.log(p).sum()))


def scatter_ratio(first, second):
    """Ratio of the pooled standard deviations of two samples over their layers, and the one-sided p of an equal or larger
    one (F test).
    """
    _, deviation_1, tests_1 = _checked(first)
    _, deviation_2, tests_2 = _checked(second)
    freedom_1, freedom_2 = np.sum(tests_1 - 1), np.sum(tests_2 - 1)
    ratio = (np.sum((tests_1 - 1) * deviation_1**2) / freedom_1) / (np.sum((tests_2 - 1) * deviation_2**2) / freedom_2)
    return float(np.sqrt(ratio)), float(special.fdtrc(freedom_1, freedom_2, ratio))


# ----------------------------------------------------------------------------------- what the data could and could not show
def perfect_model_error(measured, model, draws=200_000, seed=0):
    """The mean relative error that a perfect model would score on these data; returns `PerfectModel`.

    Both samples are drawn again from normal laws with one common mean, midway between the two, and their own standard
    errors, and scored by Eq. 11. A model below `mean` was lucky; only one above `quantile` is shown to be wrong.
    """
    centre = 0.5 * (_means(measured.mean) + _means(model.mean))
    generator = np.random.default_rng(seed)
    shape = (draws, centre.size)
    first = centre + standard_error(measured) * generator.standard_normal(shape)
    second = centre + standard_error(model) * generator.standard_normal(shape)
    scores = np.mean(np.abs(second - first) / first, axis=1)
    observed = mean_relative_error(measured.mean, model.mean)
    return PerfectModel(float(scores.mean()), float(np.quantile(scores, 0.95)), float(np.mean(scores >= observed)))


def detectable_shift(standard_error, layers=5, significance=0.05, power=0.8):
    """Smallest shift of one layer among `layers` that is found with the given power, (z_(1 - a/2M) + z_power) * standard error.

    `standard_error` (M,) or scalar is that of the difference model - measured; Bonferroni over the layers, two-sided: 3.42
    standard errors.
    """
    return (special.ndtri(1.0 - 0.5 * significance / layers) + special.ndtri(power)) * np.asarray(standard_error)


def campaign_term(mean, standard_error):
    """Relative standard deviation between campaigns that measured the same thing [-], 0 where their scatter explains the
    differences.

    `mean` and `standard_error` (C,) of C >= 2 campaigns. Method of moments: variance of the means less their mean squared
    standard error.
    """
    mean, standard_error = _means(mean), np.asarray(standard_error, dtype=float)
    if mean.size < 2:
        raise InputError("a between-campaign term needs at least two campaigns")
    return float(np.sqrt(max(0.0, np.var(mean, ddof=1) - np.mean(standard_error**2))) / mean.mean())


def covariance(measured, model, common=0.0, individual=0.0):
    """Covariance (M, M) of model - measured: both standard errors, and what another campaign would change.

    `common` shifts all layers of a campaign by one factor, `individual` each layer by its own; both relative standard
    deviations [-]. The tables cannot tell which of the two it is, so a finding must survive both.
    """
    mean = _means(measured.mean)
    own = np.diag(standard_error(measured) ** 2 + standard_error(model) ** 2)
    return own + common**2 * np.outer(mean, mean) + individual**2 * np.diag(mean**2)


def chi_squared(measured, model, common=0.0, individual=0.0, draws=50_000, seed=0):
    """Chi-squared of the whole table, its p by the chi-squared law, and its p by parametric bootstrap: three floats.

    The bootstrap draws means *and* standard deviations of tests that agree, and judges each draw by its own standard
    deviations, as the data are judged: with five tests the chi-squared law is far too sure.
    """
    mean, deviation_1, tests_1 = _checked(measured)
    mean_2, deviation_2, tests_2 = _checked(model)
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


# -------------------------------------------------------------------------------------------------------------- checks
def _means(values, least=0.0):
    """Layer coefficients as a float array (M,), refused where they are not finite numbers above ``least``."""
    values = np.atleast_1d(np.asarray(values, dtype=float))
    good = np.isfinite(values) & (values > least)
    if not np.all(good):
        layer = int(np.flatnonzero(~good)[0])
        kind = "a positive" if least == 0.0 else "a finite"
        raise InputError(f"layer {layer + 1}: mean = {values[layer]}; a layer coefficient is {kind} number")
    return values


def _checked(sample):
    """Means, standard deviations and numbers of tests of a sample, each (M,)."""
    mean = _means(sample.mean)
    cv = np.broadcast_to(np.asarray(sample.cv, dtype=float), mean.shape)
    tests = np.broadcast_to(np.asarray(sample.tests, dtype=float), mean.shape)
    if not np.all(cv >= 0.0):
        raise InputError(f"cv = {cv[~(cv >= 0.0)][0]}; a coefficient of variation is zero or positive")
    if not np.all(tests >= 2):
        raise InputError(f"tests = {tests[~(tests >= 2)][0]:g}; an uncertainty needs a known number of at least 2 tests")
    return mean, mean * cv, tests


def _welch_of(difference, variance_1, tests_1, variance_2, tests_2):
    """Welch's t, degrees of freedom and p from a difference of means and the variances of the two means."""
    variance = variance_1 + variance_2
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(difference == 0.0, 0.0, difference / np.sqrt(variance))
        freedom = variance**2 / (variance_1**2 / (tests_1 - 1) + variance_2**2 / (tests_2 - 1))
    freedom = np.where(variance > 0.0, freedom, tests_1 + tests_2 - 2)
    return Welch(t, freedom, 2.0 * special.stdtr(freedom, -np.abs(t)))
