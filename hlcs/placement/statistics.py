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


# -------------------------------------------------------------------------------------------------------- uncertainty
def standard_error(sample):
    """Standard error of each layer's mean, mean * cv / sqrt(tests), (M,) [-]."""
    mean, deviation, tests = _checked(sample)
    return deviation / np.sqrt(tests)


def confidence_interval(sample, confidence=0.95):
    """Two-sided interval of each layer's mean, (low, high), each (M,): Student's t with tests - 1 degrees of freedom."""
    mean, deviation, tests = _checked(sample)
    half = special.stdtrit(tests - 1, 0.5 + 0.5 * confidence) * deviation / np.sqrt(tests)
    return mean - half, mean + half


def mean_interval(values, confidence=0.95):
    """(mean, low, high) of numbers of repeated tests (n,), such as counts of units of each structure: Student's t over the tests,
    those that are not finite left out; nan where there are too few."""
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if len(values) < 2:
        return (float(values[0]) if len(values) else np.nan), np.nan, np.nan
    mean, error = float(values.mean()), float(values.std(ddof=1)) / np.sqrt(len(values))
    half = float(special.stdtrit(len(values) - 1, 0.5 + 0.5 * confidence)) * error
    return mean, mean - half, mean + half


def welch(measured, model):
    """Welch's t of each layer between two samples, unequal variances; returns `Welch` of arrays (M,).

    Two layers without any scatter have no error to divide by: t is 0 (p = 1) where they agree and infinite (p = 0) where
    they do not.
    """
    mean_1, deviation_1, tests_1 = _checked(measured)
    mean_2, deviation_2, tests_2 = _checked(model)
    difference, variance_1, variance_2 = mean_2 - mean_1, deviation_1**2 / tests_1, deviation_2**2 / tests_2
    variance = variance_1 + variance_2
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(difference == 0.0, 0.0, difference / np.sqrt(variance))
        freedom = variance**2 / (variance_1**2 / (tests_1 - 1) + variance_2**2 / (tests_2 - 1))
    freedom = np.where(variance > 0.0, freedom, tests_1 + tests_2 - 2)
    return Welch(t, freedom, 2.0 * special.stdtr(freedom, -np.abs(t)))


def holm(p):
    """Holm's adjusted p-values (n,): multiple comparisons, no
    assumption of independence. S. Holm, Scand. J. Statist. 6 (1979).
    """
    p = np.asarray(p, dtype=float)
    order = np.argsort(p)
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate((p.size - np.arange(p.size)) * p[order]))
    return adjusted


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

    `standard_error` (M,) or scalar is that of the difference
    model - measured; Bonferroni over the layers, two-sided: 3.42 standard errors.
    """
    return (special.ndtri(1.0 - 0.5 * significance / layers) + special.ndtri(power)) * np.asarray(standard_error)


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
