"""Positions may be known less well along one axis than along the others, as the depth is that two cameras see."""

from dataclasses import replace

import numpy as np
from scipy import special

from hlcs.data.quantities import UNLIKELY
from hlcs.estimation.rounding import FINE

SAME_NOISE = (1.0, 1.0, 1.0)  # noise along x, y, z, over its root mean square


def axes_of(trial):
    """Three recordings like a Trial, of each coordinate alone."""
    return [replace(trial, position=np.where(np.arange(3) == axis, trial.position, np.nan)) for axis in range(3)]


def of_measured(along, trials):
    """(sigmas along x, y, z over their root mean square on the axes that Trials show, that root mean square); 1 on the others."""
    seen = np.any([np.isfinite(trial.position).any(axis=0) for trial in trials], axis=0)
    if along == SAME_NOISE or not seen.any():
        return along, 1.0
    size = float(np.sqrt(np.mean(np.square(along)[seen])))
    return tuple(np.where(seen, np.divide(along, size), 1.0).tolist()), size


def made_alike(trial, along):
    """A Trial whose positions have been divided along x, y and z by what makes their noise the same; itself where it is."""
    return trial if along == SAME_NOISE else replace(trial, position=trial.position / np.array(along))


def unlike(noises, rounding):
    """The sigmas along x, y, z over their root mean square, from the CorrelatedNoise of each, None = unknown.

    SAME_NOISE where they differ by no more than chance, or where readings are in steps that count."""
    known = {axis: noise for axis, noise in enumerate(noises) if noise and noise.sigma > 0}
    sigmas = np.array([noise.sigma for noise in known.values()])
    if len(known) < 2 or rounding > FINE * sigmas.min():
        return SAME_NOISE
    sizes, weights = np.log(sigmas), 1 / np.array([noise.covariance[0, 0] for noise in known.values()])
    if not weights @ (sizes - np.average(sizes, weights=weights)) ** 2 > special.chdtri(len(known) - 1, UNLIKELY):
        return SAME_NOISE
    along = np.ones(3)
    along[list(known)] = sigmas / np.sqrt(np.mean(sigmas**2))
    return tuple(along.tolist())
