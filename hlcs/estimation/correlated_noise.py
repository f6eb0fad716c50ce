"""Correlated noise fitted to series of samples by restricted maximum likelihood."""

from typing import NamedTuple

import numpy as np
from scipy import optimize

from hlcs.estimation.whitening import filter_of

LEAST_CERTAIN = 0.3  # largest standard deviation of log sigma, rho and share: series that tell less tell nothing
MOST_RHO, MOST_WHITE = 0.98, 0.9  # beyond them series of some hundred samples tell nothing more


class CorrelatedNoise(NamedTuple):
    """Noise of one kind of channel: AR(1) in time, and a share that is not correlated."""

    sigma: float  # standard deviation [unit of the series]
    rho: float  # correlation of the AR(1) part at one step [-]
    white: float  # share of the variance that is not correlated: rounding, pixels [-]
    covariance: np.ndarray  # of (log sigma, rho, white), (3, 3)


class RestrictedLikelihood:
    """Restricted likelihood of correlated noise in series [(times (n,), values (n,), columns (n, k))], k the same in all."""

    def __init__(self, series, step):
        times, values, columns = zip(*series, strict=True)
        lengths = np.array([len(part) for part in times])
        self.freedom = float(np.sum(lengths - columns[0].shape[1]))
        self.gaps = np.concatenate([np.append(np.diff(part) / step, np.inf) for part in times])  # no series knows of another
        self.table = np.column_stack([np.concatenate(columns), np.concatenate(values)])
        self.inside = np.arange(lengths.max()) < lengths[:, None]  # (series, samples of the longest)

    def terms(self, rho, share):
        """(sum of squares of the whitened values less what the columns fit, sum of the log determinants).

        With [columns, values] = Q R, what the columns leave of the values is the last diagonal entry of R."""
        filter = filter_of(self.gaps, rho, share)
        white = np.zeros((*self.inside.shape, self.table.shape[1]))
        white[self.inside] = filter.whiten(self.table)
        sizes = np.abs(np.diagonal(np.linalg.qr(white, mode="r"), axis1=1, axis2=2))
        logs = np.sum(np.log(filter.deviation)) + np.sum(np.log(sizes[:, :-1] + 1e-300))
        return float(np.sum(sizes[:, -1] ** 2)), 2 * float(logs)

    def deviance(self, log_sigma, rho, share):
        """Minus twice the log likelihood; log_sigma None: at the best sigma. Outside their ranges rho and share are clipped."""
        squares, logs = self.terms(min(max(rho, 0.0), MOST_RHO), min(max(share, 0.0), MOST_WHITE))
        if log_sigma is None:
            return self.freedom * np.log(max(squares, 1e-300) / self.freedom) + logs
        return 2 * self.freedom * log_sigma + squares * np.exp(-2 * log_sigma) + logs

    def best(self, log_sigma, white):
        """(rho, share) of least deviance: from a grid, then refined; white: the share where it is given."""
        shares = (0.0, 0.15, 0.4) if white is None else (white,)
        _, rho, share = min(
            (self.deviance(log_sigma, rho, share), rho, share)
            for rho in (0.0, 0.2, 0.4, 0.6, 0.75, 0.85, 0.93)
            for share in shares
        )
        if white is not None:
            best = optimize.minimize_scalar(
                lambda v: self.deviance(log_sigma, v, share),
                method="bounded",
                bounds=(max(rho - 0.2, 0.0), min(rho + 0.2, MOST_RHO)),
                options={"xatol": 1e-3},
            )
            return best.x, share

        def outside(rho, share):
            return 1e3 * (max(-rho, 0, rho - MOST_RHO) + max(-share, 0, share - MOST_WHITE))

        simplex = [(rho, share), (rho + 0.06, share), (rho, share + 0.08)]
        return optimize.minimize(
            lambda v: self.deviance(log_sigma, *v) + outside(*v),
            (rho, share),
            method="Nelder-Mead",
            options={"initial_simplex": simplex, "xatol": 2e-3, "fatol": 0.02, "maxiter": 60},
        ).x

    def covariance(self, best, free):
        """Covariance of (log sigma, rho, white) from the curvature of the deviance; zero for what was given, (3, 3)."""
        steps = np.array([0.01, 0.02, 0.02])
        middle = np.clip(best, [-np.inf, *steps[1:]], [np.inf, MOST_RHO - steps[1], MOST_WHITE - steps[2]])
        index = np.flatnonzero(free)
        hessian = np.zeros((len(index), len(index)))

        def at(u, i, v=0, j=0):
            return self.deviance(*(middle + u * steps * (np.arange(3) == i) + v * steps * (np.arange(3) == j)))

        for a, i in enumerate(index):
            hessian[a, a] = (at(1, i) - 2 * at(0, i) + at(-1, i)) / steps[i] ** 2
            for b, j in enumerate(index[:a]):
                mixed = at(1, i, 1, j) - at(1, i, -1, j) - at(-1, i, 1, j) + at(-1, i, -1, j)
                hessian[a, b] = hessian[b, a] = mixed / (4 * steps[i] * steps[j])
        values, vectors = np.linalg.eigh(hessian / 2)
        values = np.maximum(values, 1 / LEAST_CERTAIN**2)
        covariance = np.zeros((3, 3))
        covariance[np.ix_(index, index)] = (vectors / values) @ vectors.T
        return covariance


def fit_correlated_noise(series, step, sigma=None, white=None):
    """Restricted maximum likelihood of the noise from series [(times (n,), values (n,), columns (n, k))].

    The columns (smooth functions such as 1, t, t^2 ..) are fitted and their cost in freedom is accounted for, so that rho
    is not biased by the fit. Patterson and Thompson (1971), Biometrika 58, 545. sigma and white may be given.
    """
    likelihood = RestrictedLikelihood(series, step)
    log_sigma = None if sigma is None else np.log(sigma)
    rho, share = likelihood.best(log_sigma, white)
    rho, share = float(np.clip(rho, 0.0, MOST_RHO)), float(np.clip(share, 0.0, MOST_WHITE))
    if rho < 0.02:
        rho, share = 0.0, 0.0
    if sigma is None:
        sigma = float(np.sqrt(likelihood.terms(rho, share)[0] / likelihood.freedom))
    free = [log_sigma is None, True, white is None and rho > 0.0]
    covariance = likelihood.covariance(np.array([np.log(sigma), rho, share]), free)
    return CorrelatedNoise(float(sigma), rho, share, covariance)


def excess_deviance(series, step, sigma, white):
    """How much less likely series, as in `fit_correlated_noise`, are with noise of this sigma than with that of the best one.

    Minus twice the logarithm: chi-square of one degree of freedom where the noise has this sigma. rho is the best of each.

    Where noise hangs together for longer than a series lasts, many sigmas are as likely as the best one, far from it too.
    """
    likelihood = RestrictedLikelihood(series, step)
    least = likelihood.deviance(None, *likelihood.best(None, white)) + likelihood.freedom
    return likelihood.deviance(np.log(sigma), *likelihood.best(np.log(sigma), white)) - least


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
