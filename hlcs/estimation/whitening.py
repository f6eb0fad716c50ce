"""Whitening of correlated noise: a Kalman filter that is the inverse Cholesky factor of its covariance.

Noise is AR(1) in time within each channel of each recording, plus a share w that is not correlated (rounding):
cov(e_k, e_l) = sigma^2 ((1 - w) rho^(|t_k - t_l| / step) + w delta_kl). White, unit-variance combinations are L^-1 e with
L L^T that covariance, L its lower Cholesky factor. Such noise is a scalar state that decays between samples, seen through
white noise: what a Kalman filter does not foresee of each sample, over its standard deviation, is exactly L^-1 e (R. E. Kalman,
J. Basic Eng. 82 (1960) 35; the factor is unique), at a cost and a memory that grow with the number of samples alone.
"""

from typing import NamedTuple

import numpy as np

from minibullet.kernels import leaf


class Filter(NamedTuple):
    """Correlation of the samples of one channel, as what is foreseen of each from those before it; (n,) each, variance 1."""

    decay: np.ndarray  # of the correlated part from this sample to the next [-]
    gain: np.ndarray  # part of what was not foreseen of this sample that belongs to the correlated part [-]
    deviation: np.ndarray  # standard deviation of what is not foreseen of this sample: the diagonal of L [-]

    def whiten(self, values):
        """L^-1 values for correlated values of variance 1, (n,) or (n, k) -> same shape."""
        return _filtered(_whiten, self, values)

    def colour(self, white):
        """L white: the inverse of `whiten`."""
        return _filtered(_colour, self, white)


class Whitening(NamedTuple):
    """How the noise of the n observations of one recording is correlated, channel by channel."""

    blocks: tuple  # (slice of the observations, Filter of a channel or Shared of a setting)
    sigma: np.ndarray  # standard deviation of each observation [unit of the channel], (n,)
    common: np.ndarray | None = None  # part of it that all observations of a block share (n,); None = there is none


@leaf
def _fill_in(decay, rest, white, gain, deviation):
    """Fill in gain and deviation (n,); rest: 1 - decay^2."""
    unknown = 1.0 - white  # variance of the correlated part before its sample is seen
    for k in range(len(deviation)):
        variance = unknown + white
        gain[k] = unknown / variance
        deviation[k] = np.sqrt(variance)
        unknown = decay[k] ** 2 * white * gain[k] + (1.0 - white) * rest[k]


@leaf
def _whiten(decay, gain, deviation, values, foreseen):
    """Turn values (n, k) into L^-1 values, in place; foreseen: zeros (k,)."""
    for row in range(len(deviation)):
        for column in range(len(foreseen)):
            new = values[row, column] - foreseen[column]
            values[row, column] = new / deviation[row]
            foreseen[column] = decay[row] * (foreseen[column] + gain[row] * new)


@leaf
def _colour(decay, gain, deviation, values, foreseen):
    """Turn values (n, k) into L values, in place; foreseen: zeros (k,)."""
    for row in range(len(deviation)):
        for column in range(len(foreseen)):
            new = values[row, column] * deviation[row]
            values[row, column] = foreseen[column] + new
            foreseen[column] = decay[row] * (foreseen[column] + gain[row] * new)


def kalman_filter(times, rho, white, step):
    """Filter of noise of variance 1 at the times (n,), increasing: AR(1) with rho per step, and a share `white` of its own."""
    return filter_of(steps_between(times, step), rho, white)


def steps_between(times, step):
    """From each of the times (n,) to the next, 0 behind the last, (n,) [steps]."""
    return np.diff(times, append=times[-1:]) / step


def exponent_of(rho):
    """Logarithm of a correlation from step to step, finite where there is none."""
    return np.log(np.maximum(rho, 1e-12))


def filter_of(gaps, rho, white):
    """The same of samples with these times from each to the next (n,) [steps]; inf: there another series begins."""
    exponent = gaps * exponent_of(rho)
    result = Filter(np.exp(exponent), np.empty(len(gaps)), np.empty(len(gaps)))
    _fill_in(result.decay, -np.expm1(2 * exponent), float(white), result.gain, result.deviation)
    return result


def _filtered(kernel, filter, values):
    """L or L^-1 times values, (n,) or (n, k) -> same shape."""
    result = np.array(values, dtype=float, order="C")
    columns = result.reshape(len(result), -1)
    kernel(*filter, columns, np.zeros(columns.shape[1]))
    return result


def whitening_of(channel, times, sigma, correlations, step):
    """Whitening of observations sorted by channel, then time.

    channel, sigma: per observation (n,); correlations: channel -> (rho, white); step: time over which rho holds [s].
    """
    channel, times, sigma = np.asarray(channel), np.asarray(times, dtype=float), np.asarray(sigma, dtype=float)
    blocks, filters = [], {}
    for number in np.unique(channel):
        inside = np.flatnonzero(channel == number)
        part = slice(int(inside[0]), int(inside[-1]) + 1)
        key = (times[part].tobytes(), correlations[int(number)])
        if key not in filters:
            filters[key] = kalman_filter(times[part], *correlations[int(number)], step)
        blocks.append((part, filters[key]))
    return Whitening(tuple(blocks), sigma)


class Shared(NamedTuple):
    """Correlation of the observations of one setting, which share an error, in units of their standard deviation."""

    own: float  # standard deviation of the error of each
    shrink: float  # what whitening leaves of their mean, beside what it leaves of how they differ

    def whiten(self, values):
        """White combinations of values (n, k): the symmetric root of their covariance, so that their order is of no account."""
        return (values - (1 - self.shrink) * values.mean(axis=0)) / self.own

    def colour(self, white):
        """The inverse of `whiten`."""
        return self.own * (white + (1 / self.shrink - 1) * white.mean(axis=0))


def whitening_of_settings(setting, sigma, common):
    """Whitening of observations with an error of their own and one that all observations of a setting share.

    setting: integers, those of one setting together (n,); sigma: of the own error; common: of the shared one (n,) each. The
    covariance is sigma^2 delta_kl + common^2 within a setting: its mean has the variance sigma^2 / n + common^2.
    """
    total, blocks = np.hypot(sigma, common), []
    first = np.flatnonzero(np.r_[True, np.diff(setting) != 0])
    for begin, end in zip(first, [*first[1:], len(setting)], strict=True):
        shrink = sigma[begin] / np.hypot(sigma[begin], np.sqrt(end - begin) * common[begin])
        blocks.append((slice(int(begin), int(end)), Shared(float(sigma[begin] / total[begin]), float(shrink))))
    return Whitening(tuple(blocks), total, common)


def whiten(whitening, values):
    """White, unit-variance combinations of correlated observations: (n,) or (n, k) -> same shape."""
    values = np.asarray(values, dtype=float)
    values = values / whitening.sigma.reshape(-1, *[1] * (values.ndim - 1))
    for part, filter in whitening.blocks:
        values[part] = filter.whiten(values[part])
    return values


def colour(whitening, white):
    """The inverse of whitening: (n,) or (n, k) -> same shape, in the units of the channels."""
    result = np.empty_like(np.asarray(white, dtype=float))
    for part, filter in whitening.blocks:
        result[part] = filter.colour(white[part])
    return result * whitening.sigma.reshape(-1, *[1] * (result.ndim - 1))
