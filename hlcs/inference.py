"""Statistics of correlated residuals: whitening, projection, least squares, adequacy. Arrays in, numbers out, no physics.

Noise is AR(1) in time within each channel of each recording, cov(e_k, e_l) = sigma^2 rho^(|t_k - t_l| / step), so that
(e_k - phi_k e_(k-1)) / (sigma sqrt(1 - phi_k^2)) with phi_k = rho^(dt_k / step) is white with unit variance.
"""

from typing import NamedTuple

import numpy as np
from scipy import optimize, sparse

CLIP = 3.5  # whitened residuals are cut here in the adequacy test, so that a few outliers cannot fail a good model


class Chain(NamedTuple):
    """How the n observations of one recording hang together: each knows the one before it in its own channel."""

    previous: np.ndarray  # index of the observation before in the same channel, -1 for the first, (n,)
    decay: np.ndarray  # correlation with it, 0 for the first [-], (n,)
    scale: np.ndarray  # standard deviation of the innovation [unit of the channel], (n,)


def chain(channel, times, sigma, rho, step):
    """Chain of observations sorted by channel, then time; sigma and rho are per observation, (n,)."""
    channel, times = np.asarray(channel), np.asarray(times, dtype=float)
    same = np.r_[False, channel[1:] == channel[:-1]] if len(channel) else np.zeros(0, bool)
    previous = np.where(same, np.arange(len(channel)) - 1, -1)
    lag = np.where(same, times - times[previous], np.inf) / step
    rho = np.broadcast_to(rho, lag.shape)
    decay = np.where(same & (rho > 0), np.power(np.maximum(rho, 1e-12), lag), 0.0)
    return Chain(previous, decay, sigma * np.sqrt(1 - decay**2))


def whiten(links, values):
    """White, unit-variance combinations of correlated observations: (n,) or (n, k) -> same shape."""
    values = np.asarray(values, dtype=float)
    decay, scale = (links.decay, links.scale) if values.ndim == 1 else (links.decay[:, None], links.scale[:, None])
    return (values - decay * values[links.previous]) / scale


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
    rho: float  # correlation at one step [-]
    freedom: float  # degrees of freedom that fixed them


def fit_noise(series, step, rho=None, sigma=None):
    """Restricted maximum likelihood of sigma and rho from series [(times (n,), values (n,), columns (n, k))].

    The columns (smooth functions such as 1, t, t^2 ..) are fitted and their cost in freedom is accounted for, so that rho
    is not biased by the fit. Patterson and Thompson (1971), Biometrika 58, 545. Either of the two may be given.
    """
    def terms(trial_rho):
        squares = logs = freedom = 0.0
        for times, values, columns in series:
            n, k = columns.shape
            links = chain(np.zeros(n, int), times, np.ones(n), trial_rho, step)
            r, x = whiten(links, values), whiten(links, columns)
            q, upper = np.linalg.qr(x)
            squares += float(np.sum(project_out(q, r) ** 2))
            logs += 2 * np.sum(np.log(links.scale)) + 2 * np.sum(np.log(np.abs(np.diag(upper)) + 1e-300))
            freedom += n - k
        return squares, logs, freedom

    def deviance(trial_rho):
        squares, logs, freedom = terms(trial_rho)
        if sigma is not None:
            return squares / sigma**2 + logs
        return freedom * np.log(max(squares, 1e-300) / freedom) + logs

    if rho is None:
        grid = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95])
        values = np.array([deviance(value) for value in grid])
        best = int(np.argmin(values))
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
        found = optimize.minimize_scalar(deviance, bounds=(low, min(high, 0.98)), method="bounded", options={"xatol": 1e-3})
        rho = float(found.x) if found.fun < values[best] else float(grid[best])
    squares, _, freedom = terms(rho)
    return Correlated(float(np.sqrt(squares / freedom)), float(rho), float(freedom))


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


def adequacy(residuals, links, columns, shared, partitions, noise_error=(0.0, 0.0), draws=400, pool=None):
    """Adequacy of projected, whitened residuals against noise alone, through the same whitening and projection.

    residuals: list over recordings of (n_i,); links: list of Chain; columns: list of (n_i, k_i) whitened columns that were
    fitted in that recording alone; shared: list of (n_i, p) columns of the numbers fitted to all, these projected out;
    partitions: name -> labels over all observations in one row, (sum n_i,), whose block sums are tested beside the
    variance; noise_error: standard errors of log sigma and of rho, carried into the draws; pool: whitened samples of a
    static recording to draw from (else Gaussian).
    """
    generator = np.random.default_rng(12345)  # a fixed stream of its own: the verdict never depends on the user's seed
    matrices = {name: block_matrix(labels) for name, labels in partitions.items()}
    stretch = 1 + noise_error[0] * generator.standard_normal(draws)
    shift = noise_error[1] * generator.standard_normal(draws)
    parts = []
    for link, column in zip(links, columns, strict=True):
        n = len(link.previous)
        white = generator.choice(pool, (n, draws)) if pool is not None else generator.standard_normal((n, draws))
        if noise_error[1] > 0:
            white = _whitened_with_error(link, white, shift)
        white *= stretch
        parts.append(project_out(basis(column), white))
    drawn = project_out(basis(np.concatenate(shared)), np.concatenate(parts))
    observed = np.concatenate(residuals)[:, None]
    names = ["variance", *matrices]
    null, seen = _statistics(drawn, matrices), _statistics(observed, matrices)[:, 0]
    centre, spread = null.mean(axis=1), null.std(axis=1) + 1e-12
    largest = ((null - centre[:, None]) / spread[:, None]).max(axis=0)
    z = (seen - centre) / spread
    freedom = max(np.mean(drawn**2), 1e-12)
    threshold = float(np.quantile(largest, 0.98))
    p = (1 + int(np.sum(largest >= z.max()))) / (1 + draws)
    return Adequacy(bool(z.max() <= threshold), float(z.max()), float(p), threshold, names[int(np.argmax(z))],
                    float(np.mean(observed**2) / freedom))


def _statistics(values, matrices):
    """Clipped mean square, then the mean square of the block sums of every partition: (n, draws) -> (statistics, draws)."""
    cut = np.clip(values, -CLIP, CLIP)
    return np.array([np.mean(cut**2, axis=0), *(np.mean((matrix @ cut) ** 2, axis=0) for matrix in matrices.values())])


def _whitened_with_error(link, white, shift):
    """White noise made correlated with the true rho and whitened again with a rho that is off by `shift`, (n, draws)."""
    coloured = np.empty_like(white)
    deviation = link.scale / np.sqrt(np.maximum(1 - link.decay**2, 1e-12))
    relative = link.scale / deviation
    for k in range(len(link.previous)):
        before = link.previous[k]
        coloured[k] = white[k] if before < 0 else link.decay[k] * coloured[before] + relative[k] * white[k]
    decay = np.where(link.previous[:, None] < 0, 0.0, np.clip(link.decay[:, None] + shift, 0.0, 0.98))
    return (coloured - decay * coloured[link.previous]) / np.sqrt(1 - decay**2)
