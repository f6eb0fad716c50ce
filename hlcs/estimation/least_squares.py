"""Linear least squares on whitened columns: bases, projections, what is believed beforehand as rows of their own."""

from typing import NamedTuple

import numpy as np


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


def least_squares(s, r, cutoff=1e-6):
    """LinearFit of r (n,) on S (n, p), safe against columns that say the same: those share the estimate (minimum norm).

    cutoff: part of what the columns, each scaled to one, tell of what they tell best, below which a direction is left as it is.
    """
    length = np.linalg.norm(s, axis=0)
    length = np.where(length > 0, length, 1.0)
    u, d, vt = np.linalg.svd(s / length, full_matrices=False)
    keep = d > cutoff * max(d[0], 1e-300) if len(d) else np.zeros(0, bool)
    u, d, vt = u[:, keep], d[keep], vt[keep]
    dots = u.T @ r
    inverse = (vt.T / d) / length[:, None]
    return LinearFit(inverse @ dots, inverse @ inverse.T, float(dots @ dots))


def whitening_beside(unknown):
    """(function rows (n, ..) of unit variance -> the same, white for what they leave unknown too, log determinant of that):
    their covariance is 1 + J J^T, J the columns `unknown` (n, p)."""
    u, size, _ = np.linalg.svd(unknown, full_matrices=False)
    shrink = (1 - 1 / np.hypot(1, size))[:, None]

    def white(rows):
        return rows - u @ (shrink * (u.T @ rows.reshape(len(rows), -1))).reshape(-1, *rows.shape[1:])

    return white, float(np.sum(np.log1p(size**2)))


def largest_cosine(a, b):
    """Largest cosine between the spaces of two projected, whitened signatures (n, p) and (n, q): 1 = cannot be told apart.

    For p, q > 1 the smallest principal angle decides whether some member of one family looks like one of the other.
    """
    qa, qb = basis(a), basis(b)
    if qa.shape[1] == 0 or qb.shape[1] == 0:
        return 0.0
    return float(np.clip(np.linalg.svd(qa.T @ qb, compute_uv=False)[0], 0.0, 1.0))


def belief(values, frees):
    """What is believed of numbers at values (p,) as rows of least squares: (residuals (p,), their slopes (p,)).

    The square of each residual is -2 log of its relative density (`Free.surprise`).
    """
    aside = np.array([free.aside(value) for value, free in zip(values, frees, strict=True)])
    rows = np.sign(aside) * np.sqrt(2 * np.log1p(aside**2))
    slopes = np.where(np.abs(aside) > 1e-6, 2 * aside / (1 + aside**2) / np.where(rows == 0, 1.0, rows), np.sqrt(2.0))
    still = np.array([free.period is not None for free in frees], bool)
    return rows, np.where(still, 0.0, slopes / np.array([free.spread for free in frees]))
