"""Statistics of correlated residuals: whitening, projection, least squares, adequacy. Arrays in, numbers out, no physics.

Noise is AR(1) in time within each channel of each recording, plus a share w that is not correlated (rounding):
cov(e_k, e_l) = sigma^2 ((1 - w) rho^(|t_k - t_l| / step) + w delta_kl). White, unit-variance combinations are L^-1 e with
L L^T that covariance.
"""

from typing import NamedTuple

import numpy as np
from scipy import linalg, optimize, sparse

QUANTILE = 0.98  # of the statistic under noise alone: the share of good models that pass the adequacy test
LEAST_FREEDOM = 0.25  # of a block sum of unit variance: what the fit must leave of it for the block to be tested
CLIP = 3.5  # whitened residuals are cut here in the adequacy test, so that a few outliers cannot fail a good model


class Chain(NamedTuple):
    """How the n observations of one recording hang together, channel by channel."""

    blocks: tuple  # (slice of the observations, lower Cholesky factor of their covariance, its inverse) of every channel
    sigma: np.ndarray  # standard deviation of each observation [unit of the channel], (n,)


def correlation(times, rho, white, step):
    """Correlation matrix of noise at the times (n,): AR(1) with rho per step, and a share `white` that is not correlated."""
    lag = np.abs(times[:, None] - times[None]) / step
    matrix = (1 - white) * np.power(max(rho, 1e-12), lag)
    matrix[np.diag_indices(len(times))] = 1.0
    return matrix


def factor(times, rho, white, step):
    """(L, inverse of L) with L L^T the correlation matrix."""
    lower = np.linalg.cholesky(correlation(times, rho, white, step))
    return lower, linalg.solve_triangular(lower, np.eye(len(times)), lower=True, check_finite=False)


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
            known[key] = factor(times[part], *correlations[int(name)], step)
        lower, inverse = known[key]
        blocks.append((part, sigma[part][:, None] * lower, inverse / sigma[part][None]))
    return Chain(tuple(blocks), sigma)


def whiten(links, values):
    """White, unit-variance combinations of correlated observations: (n,) or (n, k) -> same shape."""
    values = np.asarray(values, dtype=float)
    result = np.empty_like(values)
    for part, _, inverse in links.blocks:
        result[part] = inverse @ values[part]
    return result


def colour(links, white):
    """The inverse of whitening: (n,) or (n, k) -> same shape, in the units of the channels."""
    result = np.empty_like(np.asarray(white, dtype=float))
    for part, lower, _ in links.blocks:
        result[part] = lower @ white[part]
    return result


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
                lower, inverse = factor(times, rho, share, step)
                known[key] = inverse, 2 * np.sum(np.log(np.diag(lower)))
            inverse, log_size = known[key]
            r, x = inverse @ values, inverse @ columns
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
        found = optimize.minimize(lambda v: deviance(fixed, *v) + outside(*v), (rho, share), method="Nelder-Mead",
                                  options={"initial_simplex": [(rho, share), (rho + 0.06, share), (rho, share + 0.08)],
                                           "xatol": 2e-3, "fatol": 0.02, "maxiter": 60})
        rho, share = found.x
    else:
        found = optimize.minimize_scalar(lambda v: deviance(fixed, v, share), method="bounded", options={"xatol": 1e-3},
                                         bounds=(max(rho - 0.2, 0.0), min(rho + 0.2, 0.98)))
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
        for b, j in enumerate(index[:a + 1]):
            corners = [middle + u * steps * (np.arange(3) == i) + v * steps * (np.arange(3) == j) for u, v in
                       ((1, 1), (1, -1), (-1, 1), (-1, -1))]
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
    parts = [project_out(basis(column), draw(k, draws)) for k, column in enumerate(columns)]
    drawn = project_out(basis(np.concatenate(shared)), np.concatenate(parts))
    matrices = {}
    for name, labels in partitions.items():
        matrix = block_matrix(labels)
        open_blocks = np.flatnonzero(np.mean((matrix @ drawn) ** 2, axis=1) > LEAST_FREEDOM)
        if len(open_blocks):
            matrices[name] = matrix[open_blocks]
    observed = np.concatenate(residuals)[:, None]
    names = ["variance", *matrices]
    null, seen = np.cbrt(_statistics(drawn, matrices)), np.cbrt(_statistics(observed, matrices))[:, 0]
    centre, spread = null.mean(axis=1), null.std(axis=1) + 1e-12
    largest = ((null - centre[:, None]) / spread[:, None]).max(axis=0)
    z = (seen - centre) / spread
    freedom = max(np.mean(drawn**2), 1e-12)
    threshold = float(np.quantile(largest, QUANTILE))
    p = (1 + int(np.sum(largest >= z.max()))) / (1 + draws)
    return Adequacy(bool(z.max() <= threshold), float(z.max()), float(p), threshold, names[int(np.argmax(z))],
                    float(np.mean(observed**2) / freedom))


def _statistics(values, matrices):
    """Clipped mean square, then the mean square of the block sums of every partition: (n, draws) -> (statistics, draws)."""
    cut = np.clip(values, -CLIP, CLIP)
    return np.array([np.mean(cut**2, axis=0), *(np.mean((matrix @ cut) ** 2, axis=0) for matrix in matrices.values())])
