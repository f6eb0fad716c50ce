"""The arithmetic of layer data: residuals, covariances, signatures, generalised least squares, adequacy. Arrays only, no physics.

One vector holds all measured sets: their layer coefficients and, last of each set, the logarithm of the scatter between tests
(pooled over the layers above the first). Residuals are measured minus model. Two covariances are kept side by side, because
tables cannot tell whether campaigns differ by one factor ("common") or layer by layer ("individual"): a finding must survive
both.
"""

from typing import NamedTuple

import numpy as np

CAMPAIGN = 0.0125  # relative standard deviation between campaigns: the laboratory's own first layers differ by 1.7-1.9 %
MODEL = 0.0075  # relative standard deviation, of layers above the first, that another engine, step or plate would change: what
# Blender and pybullet give for one procedure differs by 0.5 to 2.5 %; the first layer is geometry
SCATTER = 0.35  # standard deviation of the logarithm of the scatter that hands and instruments add (set here)
PRIOR = 4.0  # degrees of freedom that the mean variance of the upper layers counts for (set here)
ROUNDING = 0.001 / np.sqrt(12.0)  # of a coefficient printed with three decimals
FORMS = ("common", "individual")


class Observed(NamedTuple):
    """Measured numbers of all sets, n rows."""

    value: np.ndarray  # (n,) layer coefficients [Dn]; logarithm of the scatter where layer = 0
    variance: np.ndarray  # (n,) of that value, from the scatter between tests
    tests: np.ndarray  # (n,) number of tests, for scatter its degrees of freedom plus one
    layer: np.ndarray  # (n,) from 1; 0 = the scatter of the set
    set: np.ndarray  # (n,) index of the set
    campaign: np.ndarray  # (n,) index of the campaign
    group: np.ndarray  # (n,) index of what is held out together
    place: np.ndarray  # (n,) index of grid, bottom and layer: what the model is asked once for several campaigns

    @property
    def mean(self):
        """Layer coefficients, 0 for the rows of scatter: what a campaign multiplies."""
        return np.where(self.layer > 0, self.value, 0.0)


class Simulated(NamedTuple):
    """The model's numbers for the rows of an Observed."""

    value: np.ndarray  # (n,)
    variance: np.ndarray  # (n,) of that value, from the scatter between seeds
    tests: np.ndarray  # (n,) seeds, for scatter its degrees of freedom plus one


def observed(sets, group_of):
    """The Observed of LayerSets; group_of: function of a set -> what is held out together with it."""
    campaigns = list(dict.fromkeys(one.campaign for one in sets))
    groups = list(dict.fromkeys(group_of(one) for one in sets))
    grounds = list(dict.fromkeys((one.grid, one.bottom_slope) for one in sets))
    parts = []
    for index, one in enumerate(sets):
        mean, cv, tests = one.sample
        deviation, upper = mean * cv, slice(1, None)
        value, variance, layers = list(mean), list(deviation**2 / tests + ROUNDING**2), list(range(1, one.layers + 1))
        counts = list(tests)
        freedom = float(np.sum(tests[upper] - 1))
        scatter = np.sum((tests[upper] - 1) * deviation[upper] ** 2) / max(freedom, 1.0)
        if freedom > 0 and scatter > 0:
            value.append(0.5 * np.log(scatter))
            variance.append(0.5 / freedom + SCATTER**2)
            layers.append(0)
            counts.append(freedom + 1)
        size = len(value)
        parts.append(
            (
                value,
                variance,
                counts,
                layers,
                [index] * size,
                [campaigns.index(one.campaign)] * size,
                [groups.index(group_of(one))] * size,
                [100 * grounds.index((one.grid, one.bottom_slope)) + layer for layer in layers],
            )
        )
    return Observed(*(np.concatenate([np.asarray(part[column]) for part in parts]) for column in range(8)))


def _upper_pooled(variance, freedom):
    """Variances (M,) of layers: the first its own, those above drawn to their mean, as few seeds know single ones badly."""
    pooled = variance.copy()
    if len(variance) > 1:
        pooled[1:] = (freedom * variance[1:] + PRIOR * variance[1:].mean()) / (freedom + PRIOR)
    return pooled


def simulated(data, rows):
    """The Simulated of runs: rows (seeds, M) of each set, nan where the physics refused a run."""
    value, variance, tests = (np.empty(len(data.value)) for _ in range(3))
    for index, runs in enumerate(rows):
        runs = runs[np.isfinite(runs).all(axis=1)]
        of_set, seeds = data.set == index, len(runs)
        layers = of_set & (data.layer > 0)
        spread = _upper_pooled(runs.var(axis=0, ddof=1), seeds - 1)
        value[layers], variance[layers], tests[layers] = runs.mean(axis=0), spread / seeds, seeds
        freedom = (runs.shape[1] - 1) * (seeds - 1)
        scatter = of_set & (data.layer == 0)
        if scatter.any():
            value[scatter] = 0.5 * np.log(max(spread[1:].mean(), 1e-8))
            variance[scatter], tests[scatter] = 0.5 / freedom, freedom + 1
    return Simulated(value, variance, tests)


def signature(data, off, on, step):
    """(F (n,), variance of F (n,)): change of all numbers per unit of a candidate, from runs with the same seeds.

    off, on: rows (seeds, M) of each set without and with it; None where too few pairs of runs were possible.
    """
    slope, variance = (np.empty(len(data.value)) for _ in range(2))
    for index, (without, with_it) in enumerate(zip(off, on, strict=True)):
        seeds = min(len(without), len(with_it))
        difference = with_it[:seeds] - without[:seeds]
        good = np.isfinite(difference).all(axis=1)
        pairs = int(good.sum())
        if pairs < 2:
            return None
        difference = difference[good]
        of_set = data.set == index
        layers, scatter = of_set & (data.layer > 0), of_set & (data.layer == 0)
        slope[layers] = difference.mean(axis=0) / step
        variance[layers] = _upper_pooled(difference.var(axis=0, ddof=1), pairs - 1) / pairs / step**2
        if scatter.any():
            spread = [max(runs[:seeds][good][:, 1:].var(axis=0, ddof=1).mean(), 1e-8) for runs in (without, with_it)]
            freedom = (difference.shape[1] - 1) * (pairs - 1)
            slope[scatter] = 0.5 * np.log(spread[1] / spread[0]) / step
            variance[scatter] = 1.0 / freedom / step**2
    return slope, variance


def covariance(data, variance, form, campaign=CAMPAIGN):
    """Covariance (n, n) of measured - model: `variance` (n,) of both, and what another campaign or engine would change."""
    mean, upper = data.mean, data.mean * (data.layer > 1)
    matrix = np.diag(variance) + MODEL**2 * np.outer(upper, upper) * (data.place[:, None] == data.place)
    if form == "individual":
        return matrix + np.diag((campaign * mean) ** 2)
    return matrix + campaign**2 * np.outer(mean, mean) * (data.campaign[:, None] == data.campaign)


def chi_squared(matrix, residual):
    """residual^T V^-1 residual."""
    return float(residual @ np.linalg.solve(matrix, residual))


def amount(matrix, residual, slope):
    """Generalised least squares of residual = slope * amount: (amount, standard deviation); (0, inf) where the slope vanishes."""
    weighted = np.linalg.solve(matrix, slope)
    information = float(slope @ weighted)
    return (float(residual @ weighted) / information, information**-0.5) if information > 1e-12 else (0.0, np.inf)


def cosine(matrix, first, second):
    """Angle of two signatures in the metric of the noise: |F1.F2| / (|F1| |F2|)."""
    weighted = np.linalg.solve(matrix, np.column_stack([first, second]))
    norms = float(first @ weighted[:, 0]) * float(second @ weighted[:, 1])
    return float(abs(first @ weighted[:, 1]) / np.sqrt(norms)) if norms > 0 else 0.0


def adequacy(data, model, residual, slopes=(), draws=4000, seed=0):
    """{form: (chi2, p)} of residuals by parametric bootstrap: draws of tests that agree, each judged by its own scatter.

    With five tests the chi-squared law is far too sure. slopes: signatures whose amounts were fitted; they are projected out.
    """
    generator, size = np.random.default_rng(seed), len(data.value)
    draws = min(draws, max(200, int(4e7 / size**2)))  # the matrices of all draws are held at once
    result, columns = {}, np.array(slopes).reshape(-1, size).T
    scatter = data.layer == 0
    for form in FORMS:
        matrix = covariance(data, data.variance + model.variance, form)
        observed_chi2 = chi_squared(matrix, residual)
        shape = (draws, size)
        noise = np.sqrt(data.variance + model.variance) * generator.standard_normal(shape)
        places, own = np.unique(data.place, return_inverse=True)
        noise += MODEL * data.mean * (data.layer > 1) * generator.standard_normal((draws, len(places)))[:, own]
        if form == "individual":
            noise += CAMPAIGN * data.mean * generator.standard_normal(shape)
        else:
            noise += CAMPAIGN * data.mean * generator.standard_normal((draws, int(data.campaign.max()) + 1))[:, data.campaign]
        freedom = [np.maximum(part.tests - 1, 1) for part in (data, model)]
        seen = [part.variance * generator.chisquare(nu, shape) / nu for part, nu in zip((data, model), freedom, strict=True)]
        variance = np.where(scatter, data.variance + model.variance, seen[0] + seen[1])
        fixed = covariance(data, np.zeros(size), form)
        matrices = fixed + variance[:, :, None] * np.eye(size)
        solved = np.linalg.solve(matrices, noise[:, :, None])[:, :, 0]
        scores = np.sum(noise * solved, axis=1)
        if columns.shape[1]:
            weighted = np.linalg.solve(matrices, np.broadcast_to(columns, (draws, *columns.shape)))
            right = np.einsum("dip,di->dp", weighted, noise)
            normal = np.einsum("ip,diq->dpq", columns, weighted)
            scores -= np.einsum("dp,dp->d", right, np.linalg.solve(normal, right[:, :, None])[:, :, 0])
        result[form] = (observed_chi2, float((1 + np.sum(scores >= observed_chi2)) / (draws + 1)))
    return result
