"""The arithmetic of layer data: one vector of what was measured, of what was simulated, and the covariance of their difference.

One vector holds all measured sets: their layer coefficients and, last of each set, the logarithm of the scatter between tests
(pooled over the layers above the first). Tables cannot tell whether campaigns differ by one factor or layer by layer: the
covariance holds half of the variance of each. Arrays only, no physics.
"""

from typing import NamedTuple

import numpy as np

from hlcs.estimation.adequacy import against

CAMPAIGN = 0.0125  # relative standard deviation between campaigns: the laboratory's own first layers differ by 1.7-1.9 %
EITHER = CAMPAIGN / np.sqrt(2.0)  # of a factor common to all layers of a campaign, and of each layer by itself
MODEL = 0.0135  # relative standard deviation of layers above the first by which any one engine is off; the first is geometry. For
# one procedure Blender and pybullet differ by 2.2 % (root mean square), Blender and this engine by 1.6 %, two such errors each
ANSWER = 0.3  # relative standard deviation of what an effect does to a layer between engines: a filled unit raises layers 2-5 by
# 0.105, 0.060, 0.053, 0.045 Dn in Blender and by 0.090, 0.091, 0.064, 0.086 in pybullet
SCATTER = 0.35  # standard deviation of the logarithm of the scatter that hands and instruments add (set here)
PRIOR = 4.0  # degrees of freedom that the mean variance of the upper layers counts for (set here)
ROUNDING = 0.001 / np.sqrt(12.0)  # of a coefficient printed with three decimals


class Observed(NamedTuple):
    """Measured numbers of all sets, n rows."""

    value: np.ndarray  # (n,) layer coefficients [Dn]; logarithm of the scatter where layer = 0
    variance: np.ndarray  # (n,) of that value, from the scatter between tests
    tests: np.ndarray  # (n,) number of tests, for scatter its degrees of freedom plus one
    layer: np.ndarray  # (n,) from 1; 0 = the scatter of the set
    set: np.ndarray  # (n,) index of the set
    campaign: np.ndarray  # (n,) index of the campaign
    group: np.ndarray  # (n,) index of what is held out together
    case: np.ndarray  # (n,) index of grid, bottom and layer: the model is simulated once for several campaigns

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
    campaigns = list(dict.fromkeys(measured_set.campaign for measured_set in sets))
    groups = list(dict.fromkeys(group_of(measured_set) for measured_set in sets))
    grounds = list(dict.fromkeys((measured_set.grid, measured_set.bottom_slope) for measured_set in sets))
    rows = []
    for index, measured_set in enumerate(sets):
        mean, cv, tests = measured_set.sample
        deviation, freedom = mean * cv, float(np.sum(tests[1:] - 1))
        layers = list(zip(mean, deviation**2 / tests + ROUNDING**2, tests, range(1, len(mean) + 1), strict=True))
        scatter = np.sum((tests[1:] - 1) * deviation[1:] ** 2) / max(freedom, 1.0)
        if freedom > 0 and scatter > 0:
            layers.append((0.5 * np.log(scatter), 0.5 / freedom + SCATTER**2, freedom + 1, 0))
        ground = grounds.index((measured_set.grid, measured_set.bottom_slope))
        belongs = index, campaigns.index(measured_set.campaign), groups.index(group_of(measured_set))
        rows += [(*row, *belongs, 100 * ground + row[3]) for row in layers]
    return Observed(*map(np.array, zip(*rows, strict=True)))


def _upper_pooled(variance, freedom):
    """Variances (M,) of layers: the first its own, those above drawn to their mean, as few seeds know single ones badly."""
    pooled = variance.copy()
    if len(variance) > 1:
        pooled[1:] = (freedom * variance[1:] + PRIOR * variance[1:].mean()) / (freedom + PRIOR)
    return pooled


def simulated(data, runs_of_sets):
    """The Simulated of runs: (seeds, M) for each set, nan where the physics refused a run."""
    value, variance, tests = np.empty((3, len(data.value)))
    for index, runs in enumerate(runs_of_sets):
        runs = runs[np.isfinite(runs).all(axis=1)]
        layers, scatter = rows_of(data, index)
        seeds, freedom = len(runs), (runs.shape[1] - 1) * (len(runs) - 1)
        pooled = _upper_pooled(runs.var(axis=0, ddof=1), seeds - 1)
        value[layers], variance[layers], tests[layers] = runs.mean(axis=0), pooled / seeds, seeds
        if scatter.any():
            value[scatter] = 0.5 * np.log(max(pooled[1:].mean(), 1e-8))
            variance[scatter], tests[scatter] = 0.5 / freedom, freedom + 1
    return Simulated(value, variance, tests)


def change(data, without, changed, shared):
    """(change of all values (n,) between runs, some of them with the same seeds, its variance (n,)); None where fewer than two
    of a set stand.

    without, changed: runs (seeds, M) of each set, of the second the first seeds alone, or all; shared (M,): what part of the
    scatter of a layer its seed decides, see `shared_scatter`. With that part runs of the same seed are compared, with the rest
    all of them: the least variance that a mean over few of many seeds can have (control variates: R. Y. Rubinstein, R. Marcus,
    Oper. Res. 33 (1985) 661).
    """
    moved, variance = np.empty((2, len(data.value)))
    for index, (before, after) in enumerate(zip(without, changed, strict=True)):
        stand = np.isfinite(before).all(axis=1)
        both = stand[: len(after)] & np.isfinite(after).all(axis=1)
        if both.sum() < 2:
            return None
        same, all_of_them, after = before[: len(after)][both], before[stand], after[both]
        layers, scatter = rows_of(data, index)
        part = shared[: same.shape[1]]
        moved[layers] = after.mean(axis=0) - part * same.mean(axis=0) - (1.0 - part) * all_of_them.mean(axis=0)
        seeds = len(after)
        variance[layers] = _upper_pooled((after - part * same).var(axis=0, ddof=1), seeds - 1) / seeds
        if scatter.any():
            pooled = [max(part[:, 1:].var(axis=0, ddof=1).mean(), 1e-8) for part in (all_of_them, after)]
            moved[scatter] = 0.5 * np.log(pooled[1] / pooled[0])
            variance[scatter] = 0.5 / ((after.shape[1] - 1) * (seeds - 1))
    return moved, variance


def shared_scatter(without, many):
    """What part of the scatter of each layer its seed decides (M,): slope of runs with an effect over those without it, of all
    effects and sets together; many: [runs (seeds, M) of each set] of each effect."""
    most = max(runs.shape[1] for runs in without)
    products, squares = np.zeros((2, most))
    for changed in many:
        for before, after in zip(without, changed, strict=True):
            before = before[: len(after)]
            both = np.isfinite(before).all(axis=1) & np.isfinite(after).all(axis=1)
            if both.sum() > 1:
                x, y = (part[both] - part[both].mean(axis=0) for part in (before, after))
                products[: x.shape[1]] += np.sum(x * y, axis=0)
                squares[: x.shape[1]] += np.sum(x * x, axis=0)
    return np.clip(np.where(squares > 0, products / np.where(squares > 0, squares, 1.0), 1.0), 0.0, 1.0)


def rows_of(data, index):
    """(rows of the layers of a set, row of its scatter), booleans (n,)."""
    return (data.set == index) & (data.layer > 0), (data.set == index) & (data.layer == 0)


def doubt(data, change=0.0, variance=0.0):
    """Standard deviation (n,) by which any engine may be wrong, a number of its own for each grid and layer: in its prediction,
    and in the `change` (n,) that effects make in it; variance (n,) of that change by the seeds of its runs."""
    return np.sqrt((MODEL * data.mean * (data.layer > 1)) ** 2 + (ANSWER * change) ** 2 + variance)


def covariance(data, variance, doubt):
    """Covariance (n, n) of measured - model: `variance` (n,) of both, and what another campaign or engine would change."""
    mean = data.mean
    matrix = np.diag(variance + (EITHER * mean) ** 2)
    matrix += EITHER**2 * np.outer(mean, mean) * (data.campaign[:, None] == data.campaign)
    return matrix + np.outer(doubt, doubt) * (data.case[:, None] == data.case)


def adequacy(data, model, residual, columns, unsure, draws=4000):
    """(chi2, p, its 99 % quantile, number of draws) of residuals (n,) by parametric bootstrap: draws of tests that agree, each
    judged by its own scatter. With five tests the chi-squared law is far too sure. columns: derivatives (n, p) of fitted
    numbers, projected out; unsure: the `doubt` (n,) of the model.
    """
    generator, size = np.random.default_rng(0), len(data.value)
    draws = min(draws, max(200, int(4e7 / size**2)))  # the matrices of all draws are held at once
    shape, total = (draws, size), data.variance + model.variance
    cases, case = np.unique(data.case, return_inverse=True)
    noise = np.sqrt(total + (EITHER * data.mean) ** 2) * generator.standard_normal(shape)
    noise += unsure * generator.standard_normal((draws, len(cases)))[:, case]
    noise += EITHER * data.mean * generator.standard_normal((draws, int(data.campaign.max()) + 1))[:, data.campaign]
    drawn = [_drawn_variance(part, generator, shape) for part in (data, model)]
    variance = np.where(data.layer == 0, total, drawn[0] + drawn[1])
    matrices = covariance(data, np.zeros(size), unsure) + variance[:, :, None] * np.eye(size)
    observed, scores = _chi2(covariance(data, total, unsure)[None], residual[None], columns)[0], _chi2(matrices, noise, columns)
    return float(observed), *against(scores, observed), draws


def _chi2(matrices, residuals, columns):
    """chi2 of residuals (draws, n) under covariances (draws, n, n), columns (n, p) projected out: (draws,)."""
    scores = np.sum(residuals * np.linalg.solve(matrices, residuals[:, :, None])[:, :, 0], axis=1)
    if columns.shape[1]:
        weighted = np.linalg.solve(matrices, np.broadcast_to(columns, (len(residuals), *columns.shape)))
        right, normal = np.einsum("dip,di->dp", weighted, residuals), np.einsum("ip,diq->dpq", columns, weighted)
        scores -= np.einsum("dp,dp->d", right, np.linalg.solve(normal, right[:, :, None])[:, :, 0])
    return scores


def _drawn_variance(part, generator, shape):
    """Variances as draws of tests would show them; part: an Observed or a Simulated."""
    freedom = np.maximum(part.tests - 1, 1)
    return part.variance * generator.chisquare(freedom, shape) / freedom
