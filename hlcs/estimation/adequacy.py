"""Adequacy: do whitened residuals look like noise alone, through the same projection as the fit?"""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.noise_draws import NoiseDraws

QUANTILE = 0.99  # of the statistic under noise alone: of good models one in a hundred fails; what is missing fails by far more
LEAST_FREEDOM = 0.25  # of a block sum of unit variance: what the fit must leave of it for the block to be tested
CLIP = 3.5  # whitened residuals are cut here in the adequacy test, so that a few outliers cannot fail a good model
MOST_DRAWN = 10_000_000  # numbers of noise held at a time (80 MB): draws of more observations are made some at a time


class Adequacy(NamedTuple):
    """Do the residuals look like noise alone?"""

    adequate: bool
    statistic: float  # largest standardised statistic
    p: float  # share of pure-noise draws that reach it
    threshold: float  # 99 % quantile of the statistic under noise alone: above it p is below 1 %
    worst: str  # which statistic spoke
    chi2: float  # mean square of the whitened residuals per degree of freedom
    overdispersion: float  # largest mean square of block sums over that of noise alone, chi2 among them: how many residuals count
    # as one, since a misfit that hangs together is one misfit however often it is sampled
    draws: int | None = None  # of noise, that p is counted in: it is never below 1/(draws + 1)


def against(drawn, statistic):
    """(p, threshold) of a statistic beside its draws under noise alone (n,): above the threshold, and only there, p is at most
    1 - QUANTILE. p counts the statistic itself among the draws, so that it is never 0 (B. V. North et al., Am. J. Hum. Genet. 71
    (2002) 439)."""
    largest = np.sort(drawn)[::-1]
    place = int((1 - QUANTILE) * (len(drawn) + 1) + 1e-9)  # draws that may be as large
    threshold = largest[place - 1] if place else np.inf
    return float((1 + np.sum(drawn >= statistic)) / (len(drawn) + 1)), float(threshold)


def block_matrix(labels):
    """Sparse (bins, n) matrix that sums values by label and divides by the square root of the count."""
    _, index, count = np.unique(labels, return_inverse=True, return_counts=True)
    return sparse.csr_matrix((1 / np.sqrt(count[index]), (index, np.arange(len(index)))), shape=(len(count), len(index)))


def blocks_in_time(channel, length):
    """Labels of consecutive blocks of `length` samples within each channel (sorted by channel): (n,) integers."""
    channel = np.asarray(channel)
    first = np.r_[True, channel[1:] != channel[:-1]]
    start = np.maximum.accumulate(np.where(first, np.arange(len(channel)), 0))
    return np.cumsum(first | ((np.arange(len(channel)) - start) % length == 0)) - 1


def fit_adequacy(problem, fit, partitions, models=None):
    """Adequacy of a fit as it stands: one that did not come to its end has not explained what more steps would.

    partitions: as for `adequacy`; models: list of what the fit expects of every observation (n_i,): readings may be rounded.
    """
    residuals, signatures = fit.linearization.projected
    signatures = [columns * ~fit.held for columns in signatures]
    draw = NoiseDraws(problem.noise, problem.recordings, models, problem.shared_doubt)
    return adequacy(residuals, fit.linearization.state_columns, signatures, partitions, draw)


def adequacy(residuals, columns, shared, partitions, draw, draws=600):
    """Adequacy of whitened residuals against noise alone, through the same whitening and the projection of the fit.

    residuals: list over recordings of (n_i,), the initial states projected out; columns: list of (n_i, k_i) whitened columns that
    were fitted in that recording alone; shared: list of (n_i, p) columns of the numbers fitted to all;
    partitions: name -> labels over all observations in one row, (sum n_i,), whose block sums are tested beside the
    variance; draw: function (index of recording, count) -> white noise (n_i, count) as these data may hold it, what is
    not known of the noise included. A block whose sum the fit has all but fixed says nothing and is left out. Every
    statistic is a mean of squares, so its cube root is nearly normal (Wilson and Hilferty, PNAS 17 (1931) 684) and the
    largest of the standardised roots treats all of them alike.
    """
    own, common = [basis(column) for column in columns], basis(np.concatenate(shared))
    observed = np.concatenate(residuals)[:, None]
    matrices = {name: block_matrix(labels) for name, labels in partitions.items()}
    null, freedom = [], 0.0
    for some in np.array_split(np.arange(draws), -(-draws * len(observed) // MOST_DRAWN)):
        drawn = np.concatenate([project_out(q, draw(k, len(some))) for k, q in enumerate(own)])
        drawn -= common @ (common.T @ drawn)
        if not null:
            matrices = {name: matrix[np.mean((matrix @ drawn) ** 2, axis=1) > LEAST_FREEDOM] for name, matrix in matrices.items()}
            matrices = {name: matrix for name, matrix in matrices.items() if matrix.shape[0]}
        freedom += float(np.sum(drawn**2)) / (draws * len(observed))
        null.append(_statistics(drawn, matrices))
    names, null = ["variance", *matrices], np.concatenate(null, axis=1)
    overdispersion = float(np.max(_statistics(observed, matrices, cut=np.inf)[:, 0] / (null.mean(axis=1) + 1e-12)))
    null, seen = np.cbrt(null), np.cbrt(_statistics(observed, matrices))[:, 0]
    centre, spread = null.mean(axis=1), null.std(axis=1) + 1e-12
    largest = ((null - centre[:, None]) / spread[:, None]).max(axis=0)
    z = (seen - centre) / spread
    p, threshold = against(largest, z.max())
    return Adequacy(
        bool(z.max() <= threshold),
        float(z.max()),
        p,
        threshold,
        names[int(np.argmax(z))],
        float(np.mean(observed**2) / max(freedom, 1e-12)),
        overdispersion,
        draws,
    )


def _statistics(values, matrices, cut=CLIP):
    """Clipped mean square, then the mean square of the block sums of every partition: (n, draws) -> (statistics, draws)."""
    cut = np.clip(values, -cut, cut)
    return np.array([np.mean(cut**2, axis=0), *(np.mean((matrix @ cut) ** 2, axis=0) for matrix in matrices.values())])
