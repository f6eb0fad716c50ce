"""Linear least squares on whitened columns: bases, projections, estimates that keep to their bounds."""

from typing import NamedTuple

import numpy as np
from scipy import optimize


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


def largest_cosine(a, b):
    """Largest cosine between the spaces of two projected, whitened signatures (n, p) and (n, q): 1 = cannot be told apart.

    For p, q > 1 the smallest principal angle decides whether some member of one family looks like one of the other.
    """
    qa, qb = basis(a), basis(b)
    if qa.shape[1] == 0 or qb.shape[1] == 0:
        return 0.0
    return float(np.clip(np.linalg.svd(qa.T @ qb, compute_uv=False)[0], 0.0, 1.0))


def null_prior(values, frees):
    """Rows (p, p) and aims (p,) for least squares that keep near its null value what the data do not show.

    They count as much as one observation that says: within its bounds. What the data do show they leave alone.
    """
    width = np.array([min(free.high - free.low, 1e6) for free in frees])
    null = np.array([value if free.null is None else free.null for value, free in zip(values, frees, strict=True)])
    return np.diag(1 / width) if frees else np.zeros((0, 0)), (null - values) / width if frees else np.zeros(0)


def bounded_least_squares(residuals, columns, values, frees):
    """Least-squares step of numbers at `values` (p,) that keeps them within the bounds of their Free entries, (p,).

    residuals, columns: lists over recordings of (n_i,) and (n_i, p), both white and projected.
    """
    rows, aims = null_prior(values, frees)
    r, s = np.concatenate([*residuals, aims]), np.concatenate([*columns, rows])
    low = np.array([free.low if free.period is None else -np.inf for free in frees])
    high = np.array([free.high if free.period is None else np.inf for free in frees])
    step = least_squares(s, r).estimate if len(frees) else np.zeros(0)
    if ((values + step >= low) & (values + step <= high)).all() or not np.isfinite(s).all():
        return step
    bounds = np.minimum(low - values, 0.0), np.maximum(high - values, 0.0)
    return optimize.lsq_linear(s, r, bounds, method="bvls").x
