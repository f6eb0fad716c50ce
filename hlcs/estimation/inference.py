"""Statistics of correlated residuals: whitening, projection, least squares, adequacy. Arrays in, numbers out, no physics.

Noise is AR(1) in time within each channel of each recording, plus a share w that is not correlated (rounding):
cov(e_k, e_l) = sigma^2 ((1 - w) rho^(|t_k - t_l| / step) + w delta_kl). White, unit-variance combinations are L^-1 e with
L L^T that covariance, L its lower Cholesky factor. Such noise is a scalar state that decays between samples, seen through
white noise: what a Kalman filter does not foresee of each sample, over its standard deviation, is exactly L^-1 e (R. E. Kalman,
J. Basic Eng. 82 (1960) 35; the factor is unique), at a cost and a memory that grow with the number of samples alone.
"""

from typing import NamedTuple

import numpy as np
from scipy import optimize, sparse

from minibullet.kernels import leaf

QUANTILE = 0.98  # of the statistic under noise alone: the share of good models that pass the adequacy test
LEAST_FREEDOM = 0.25  # of a block sum of unit variance: what the fit must leave of it for the block to be tested
CLIP = 3.5  # whitened residuals are cut here in the adequacy test, so that a few outliers cannot fail a good model
MOST_DRAWN = 10_000_000  # numbers of noise held at a time (80 MB): draws of more observations are made some at a time


class Filter(NamedTuple):
    """Correlation of the samples of one channel, as what is foreseen of each from those before it; (n,) each, variance 1."""

    decay: np.ndarray  # of the correlated part from this sample to the next [-]
    gain: np.ndarray  # part of what was not foreseen of this sample that belongs to the correlated part [-]
    root: np.ndarray  # standard deviation of what is not foreseen of this sample: the diagonal of L [-]


class Chain(NamedTuple):
    """How the n observations of one recording hang together, channel by channel."""

    blocks: tuple  # (slice of the observations, Filter) of every channel
    sigma: np.ndarray  # standard deviation of each observation [unit of the channel], (n,)


@leaf
def _foresee(decay, rest, white, gain, root):
    """Fill in gain and root (n,); rest: 1 - decay^2."""
    unknown = 1.0 - white  # variance of the correlated part before its sample is seen
    for k in range(len(root)):
        variance = unknown + white
        gain[k] = unknown / variance
        root[k] = np.sqrt(variance)
        unknown = decay[k] ** 2 * white * gain[k] + (1.0 - white) * rest[k]


@leaf
def _whiten(decay, gain, root, values, foreseen):
    """Turn values (n, k) into L^-1 values, in place; foreseen: zeros (k,)."""
    for row in range(len(root)):
        for column in range(len(foreseen)):
            new = values[row, column] - foreseen[column]
            values[row, column] = new / root[row]
            foreseen[column] = decay[row] * (foreseen[column] + gain[row] * new)


@leaf
def _colour(decay, gain, root, values, foreseen):
    """Turn values (n, k) into L values, in place; foreseen: zeros (k,)."""
    for row in range(len(root)):
        for column in range(len(foreseen)):
            new = values[row, column] * root[row]
            values[row, column] = foreseen[column] + new
            foreseen[column] = decay[row] * (foreseen[column] + gain[row] * new)


def correlation(times, rho, white, step):
    """Filter of noise of variance 1 at the times (n,), increasing: AR(1) with rho per step, and a share `white` of its own."""
    exponent = np.diff(times, append=times[-1:]) / step * np.log(max(rho, 1e-12))
    found = Filter(np.exp(exponent), np.empty(len(times)), np.empty(len(times)))
    _foresee(found.decay, -np.expm1(2 * exponent), float(white), found.gain, found.root)
    return found


def _filtered(kernel, filter, values):
    """L or L^-1 times values, (n,) or (n, k) -> same shape."""
    result = np.array(values, dtype=float, order="C")
    columns = result.reshape(len(result), -1)
    kernel(*filter, columns, np.zeros(columns.shape[1]))
    return result


def whitened(filter, values):
    """L^-1 values for correlated values of variance 1, (n,) or (n, k) -> same shape."""
    return _filtered(_whiten, filter, values)


def coloured(filter, white):
    """L white: the inverse of `whitened`."""
    return _filtered(_colour, filter, white)


def chain(channel, times, sigma, correlations, step):
    """Chain of observations sorted by channel, then time.

    channel, sigma: per observation (n,); correlations: channel -> (rho, white); step: time over which rho holds [s].
    """
    channel, times, sigma = np.asarray(channel), np.asarray(times, dtype=float), np.asarray(sigma, dtype=float)
    blocks, known = [], {}
    for name in np.unique(channel):
        inside = np.flatnonzero(channel == name)
        part = slice(int(inside[0]), int(inside[-1]) + 1)
        key = (times[part].tobytes(), correlations[int(name)])
        if key not in known:
            known[key] = correlation(times[part], *correlations[int(name)], step)
        blocks.append((part, known[key]))
    return Chain(tuple(blocks), sigma)


def whiten(links, values):
    """White, unit-variance combinations of correlated observations: (n,) or (n, k) -> same shape."""
    values = np.asarray(values, dtype=float)
    values = values / links.sigma.reshape(-1, *[1] * (values.ndim - 1))
    for part, filter in links.blocks:
        values[part] = whitened(filter, values[part])
    return values


def colour(links, white):
    """The inverse of whitening: (n,) or (n, k) -> same shape, in the units of the channels."""
    result = np.empty_like(np.asarray(white, dtype=float))
    for part, filter in links.blocks:
        result[part] = coloured(filter, white[part])
    return result * links.sigma.reshape(-1, *[1] * (result.ndim - 1))


def basis(columns):
    """Orthonormal basis of the space of the columns, (n, k) -> (n, rank); columns are scaled first, so units do not matter."""
    length = np.linalg.norm(columns, axis=0)
    columns = columns[:, length > 0] / length[length > 0]
    if columns.shape[1] == 0:
        return np.zeros((len(columns), 0))
    u, s, _ = np.linalg.svd(columns, full_matrices=False)
    return u[:, s > 1e-7 * s[0]]


def project_out(q, values):
    """What is left of the values once everything in the span of the orthonormal q is taken away."""
    return values - q @ (q.T @ values)


class LinearFit(NamedTuple):
    """Least squares of r on the columns S, both white and projected."""

    estimate: np.ndarray  # (p,)
    covariance: np.ndarray  # for unit variance, (p, p)
    gain: float  # chi2 explained


def least_squares(s, r):
    """LinearFit of r (n,) on S (n, p), safe against columns that say the same: those share the estimate (minimum norm)."""
    length = np.linalg.norm(s, axis=0)
    length = np.where(length > 0, length, 1.0)
    u, d, vt = np.linalg.svd(s / length, full_matrices=False)
    keep = d > 1e-6 * max(d[0], 1e-300) if len(d) else np.zeros(0, bool)
    u, d, vt = u[:, keep], d[keep], vt[keep]
    dots = u.T @ r
    inverse = (vt.T / d) / length[:, None]
    return LinearFit(inverse @ dots, inverse @ inverse.T, float(dots @ dots))


def cosine(a, b):
    """Largest cosine between the spaces of two projected, whitened signatures (n, p) and (n, q): 1 = cannot be told apart.

    For p, q > 1 the smallest principal angle decides whether some member of one family looks like one of the other.
    """
    qa, qb = basis(a), basis(b)
    if qa.shape[1] == 0 or qb.shape[1] == 0:
        return 0.0
    return float(np.clip(np.linalg.svd(qa.T @ qb, compute_uv=False)[0], 0.0, 1.0))


# --- the noise itself --------------------------------------------------------------------------------------------------------


class Correlated(NamedTuple):
    """Result of `fit_noise`."""

    sigma: float  # standard deviation [unit of the series]
    rho: float  # correlation of the AR(1) part at one step [-]
    white: float  # share of the variance that is not correlated: rounding, pixels [-]
    freedom: float  # degrees of freedom that fixed them
    covariance: np.ndarray  # of (log sigma, rho, white), (3, 3)


def fit_noise(series, step, sigma=None, white=None):
    """Restricted maximum likelihood of the noise from series [(times (n,), values (n,), columns (n, k))].

    The columns (smooth functions such as 1, t, t^2 ..) are fitted and their cost in freedom is accounted for, so that rho
    is not biased by the fit. Patterson and Thompson (1971), Biometrika 58, 545. sigma and white may be given.
    """
    freedom = float(sum(len(values) - columns.shape[1] for _, values, columns in series))

    def terms(rho, share):
        squares = logs = 0.0
        known = {}
        for times, values, columns in series:
            key = np.round((times - times[0]) / step, 3).tobytes()
            if key not in known:
                known[key] = correlation(times, rho, share, step)
            white = whitened(known[key], np.column_stack([values, columns]))
            r, x = white[:, 0], white[:, 1:]
            log_size = 2 * np.sum(np.log(known[key].root))
            q, upper = np.linalg.qr(x)
            squares += float(np.sum(project_out(q, r) ** 2))
            logs += log_size + 2 * np.sum(np.log(np.abs(np.diag(upper)) + 1e-300))
        return squares, logs

    def deviance(log_sigma, rho, share):
        squares, logs = terms(min(max(rho, 0.0), 0.98), min(max(share, 0.0), 0.9))
        if log_sigma is None:
            return freedom * np.log(max(squares, 1e-300) / freedom) + logs
        return 2 * freedom * log_sigma + squares * np.exp(-2 * log_sigma) + logs

    fixed = None if sigma is None else np.log(sigma)
    shares = (0.0, 0.15, 0.4) if white is None else (white,)
    grid = [(deviance(fixed, rho, share), rho, share) for rho in (0.0, 0.2, 0.4, 0.6, 0.75, 0.85, 0.93) for share in shares]
    _, rho, share = min(grid)

    def outside(rho, share):
        return 1e3 * (max(-rho, 0, rho - 0.98) + max(-share, 0, share - 0.9))

    if white is None:
        found = optimize.minimize(
            lambda v: deviance(fixed, *v) + outside(*v),
            (rho, share),
            method="Nelder-Mead",
            options={
                "initial_simplex": [(rho, share), (rho + 0.06, share), (rho, share + 0.08)],
                "xatol": 2e-3,
                "fatol": 0.02,
                "maxiter": 60,
            },
        )
        rho, share = found.x
    else:
        found = optimize.minimize_scalar(
            lambda v: deviance(fixed, v, share),
            method="bounded",
            options={"xatol": 1e-3},
            bounds=(max(rho - 0.2, 0.0), min(rho + 0.2, 0.98)),
        )
        rho = found.x
    rho, share = float(np.clip(rho, 0.0, 0.98)), float(np.clip(share, 0.0, 0.9))
    if rho < 0.02:
        rho, share = 0.0, 0.0
    if sigma is None:
        sigma = float(np.sqrt(terms(rho, share)[0] / freedom))
    free = [fixed is None, True, white is None and rho > 0.0]
    return Correlated(float(sigma), rho, share, freedom, _spread(deviance, np.array([np.log(sigma), rho, share]), free))


def _spread(deviance, best, free):
    """Covariance of (log sigma, rho, white) from the curvature of the deviance; zero for what was given, (3, 3)."""
    steps = np.array([0.01, 0.02, 0.02])
    middle = np.array([best[0], min(max(best[1], steps[1]), 0.98 - steps[1]), min(max(best[2], steps[2]), 0.9 - steps[2])])
    index = np.flatnonzero(free)
    hessian = np.zeros((len(index), len(index)))
    for a, i in enumerate(index):
        for b, j in enumerate(index[: a + 1]):
            corners = [
                middle + u * steps * (np.arange(3) == i) + v * steps * (np.arange(3) == j)
                for u, v in ((1, 1), (1, -1), (-1, 1), (-1, -1))
            ]
            w, x, y, z = (deviance(*corner) for corner in corners) if i != j else (0, 0, 0, 0)
            if i == j:
                w, x, z = (deviance(*(middle + u * steps * (np.arange(3) == i))) for u in (1, 0, -1))
                hessian[a, a] = (w - 2 * x + z) / steps[i] ** 2
            else:
                hessian[a, b] = hessian[b, a] = (w - x - y + z) / (4 * steps[i] * steps[j])
    covariance = np.zeros((3, 3))
    values, vectors = np.linalg.eigh(hessian / 2)
    values = np.maximum(values, [1 / 0.3**2] * len(values))  # nothing is less certain than 0.3
    covariance[np.ix_(index, index)] = (vectors / values) @ vectors.T
    return covariance


def lower_factor(covariance):
    """Lower L with L L^T a covariance (n, n), zero columns where it is singular: what was given has no share in any draw.

    The Cholesky factor is unique and changes as little as the covariance does. The signs of singular vectors do not: with them
    the last bit of a covariance, which differs from processor to processor, would choose other draws.
    """
    lower, left = np.zeros_like(covariance), np.array(covariance, dtype=float)
    for k in range(len(left)):
        if left[k, k] > 1e-12 * covariance[k, k]:  # below: rounding of what the numbers before it already tell
            lower[k:, k] = left[k:, k] / np.sqrt(left[k, k])
            left -= np.outer(lower[:, k], lower[:, k])
    return lower


def polynomials(times, degree):
    """Legendre polynomials of degree 0..degree over the span of the times, (n, degree + 1)."""
    middle, half = (times[0] + times[-1]) / 2, max((times[-1] - times[0]) / 2, 1e-12)
    return np.polynomial.legendre.legvander((times - middle) / half, degree)


def isolated_outliers(values, threshold=5.5):
    """Samples of an equally spaced series that stand alone: boolean (n,).

    The second difference at a sample is compared with its own robust scatter; smooth misfit of a model leaves no mark on it.
    """
    values = np.asarray(values, dtype=float)
    flags = np.zeros(len(values), bool)
    if len(values) < 10:
        return flags
    second = np.zeros(len(values))
    second[1:-1] = values[1:-1] - (values[:-2] + values[2:]) / 2
    spread = 1.4826 * np.median(np.abs(second[1:-1] - np.median(second[1:-1])))
    if spread <= 0:
        return flags
    size = np.abs(second)
    around = np.maximum(np.r_[0, size[:-1]], np.r_[size[1:], 0])
    flags = (size > threshold * spread) & (size >= around)
    for end, inner, beyond in ((0, 1, 2), (-1, -2, -3)):  # an outlier at the end marks its neighbour, and only that one
        if flags[inner] and size[beyond] < size[inner] / 4:
            flags[inner], flags[end] = False, True
    return flags


# --- adequacy ------------------------------------------------------------------------------------------------------------------


class Adequacy(NamedTuple):
    """Do the residuals look like noise alone?"""

    adequate: bool
    statistic: float  # largest standardised statistic
    p: float  # share of pure-noise draws that exceed it
    threshold: float  # 98 % quantile of the statistic under noise alone
    worst: str  # which statistic spoke
    chi2: float  # mean square of the whitened residuals per degree of freedom


def block_matrix(labels):
    """Sparse (bins, n) matrix that sums values by label and divides by the square root of the count; label -1 is left out."""
    labels = np.asarray(labels)
    inside = labels >= 0
    names, index = np.unique(labels[inside], return_inverse=True)
    count = np.bincount(index)
    return sparse.csr_matrix((1 / np.sqrt(count[index]), (index, np.flatnonzero(inside))), shape=(len(names), len(labels)))


def blocks_in_time(channel, length):
    """Labels of consecutive blocks of `length` samples within each channel (sorted by channel): (n,) integers."""
    channel = np.asarray(channel)
    first = np.r_[True, channel[1:] != channel[:-1]]
    start = np.maximum.accumulate(np.where(first, np.arange(len(channel)), 0))
    return np.cumsum(first | ((np.arange(len(channel)) - start) % length == 0)) - 1


def adequacy(residuals, columns, shared, partitions, draw, draws=600):
    """Adequacy of projected, whitened residuals against noise alone, through the same whitening and projection.

    residuals: list over recordings of (n_i,); columns: list of (n_i, k_i) whitened columns that were
    fitted in that recording alone; shared: list of (n_i, p) columns of the numbers fitted to all, these projected out;
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
    names = ["variance", *matrices]
    null, seen = np.cbrt(np.concatenate(null, axis=1)), np.cbrt(_statistics(observed, matrices))[:, 0]
    centre, spread = null.mean(axis=1), null.std(axis=1) + 1e-12
    largest = ((null - centre[:, None]) / spread[:, None]).max(axis=0)
    z = (seen - centre) / spread
    threshold = float(np.quantile(largest, QUANTILE))
    p = (1 + int(np.sum(largest >= z.max()))) / (1 + draws)
    return Adequacy(
        bool(z.max() <= threshold),
        float(z.max()),
        float(p),
        threshold,
        names[int(np.argmax(z))],
        float(np.mean(observed**2) / max(freedom, 1e-12)),
    )


def _statistics(values, matrices):
    """Clipped mean square, then the mean square of the block sums of every partition: (n, draws) -> (statistics, draws)."""
    cut = np.clip(values, -CLIP, CLIP)
    return np.array([np.mean(cut**2, axis=0), *(np.mean((matrix @ cut) ** 2, axis=0) for matrix in matrices.values())])
