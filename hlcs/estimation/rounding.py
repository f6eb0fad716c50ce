"""Rounded readings (pixels, last digits): the step, what it adds to the noise, and the noise below it.

A body in motion crosses many steps, and rounding adds q^2/12 to the variance of its readings (W. F. Sheppard, Proc. London Math.
Soc. 29 (1898) 353). A body at rest shows a few values only, or one, and how they scatter depends on where between two steps it
lies: there the noise is read from how often each value is shown.
"""

import numpy as np
from scipy import special

from hlcs.data.rounded_readings import are_multiples, as_it_moved, last_decimal, reading_step
from hlcs.estimation.correlated_noise import MOST_WHITE, CorrelatedNoise

FINE = 0.1  # steps of so many standard deviations add 0.04 % to the noise: they are left out of account
COARSE = 0.6  # standard deviation of readings at rest [steps] from which Sheppard's q^2/12 holds to 2 %, wherever the body lies
SMALLEST = 0.02  # noise [steps] below which readings at rest are all the same, wherever the body lies


def lattice_of(trials, static):
    """Step and one reading of each coordinate, (3, 2) [m]; step 0 where readings are not seen to be rounded.

    The coarsest step of all coordinates that a coordinate's own readings are multiples of: one tracker reads all of them.
    """
    found, every = np.zeros((3, 2)), [trial.position for trial in (*trials, *([static] if static else []))]
    paths = [[path[np.isfinite(path)] for path in axis] for axis in zip(*(each.T for each in every), strict=True)]
    readings = [np.concatenate(axis) for axis in paths]
    steps = sorted((step for axis in zip(paths, readings, strict=True) if (step := step_of_axis(*axis))), reverse=True)
    for axis, values in enumerate(readings):
        fitting = (step for step in steps if len(values) and are_multiples(values, step))
        found[axis] = next(((step, values[0]) for step in fitting), (0.0, 0.0))
    return found


def step_of_axis(paths, readings):
    """Step of the readings of one coordinate, all together and path by path in the order of time; 0 where none is seen."""
    step = reading_step(readings)
    moved = step and all(as_it_moved(path, step) for path in paths if len(path))
    return last_decimal(np.unique(readings)) if moved else step


def step_of(lattice):
    """Step of the readings of all coordinates: root mean square of those that are rounded [m]."""
    steps = lattice[lattice[:, 0] > 0, 0]
    return float(np.sqrt(np.mean(steps**2))) if len(steps) else 0.0


def share_of_rounding(step, sigma):
    """Share of rounding to steps, q^2/12, in the variance of readings with this standard deviation, at most MOST_WHITE."""
    return min(step**2 / 12 / sigma**2, MOST_WHITE)


def before_rounding(noise, step):
    """The CorrelatedNoise beneath that of readings rounded to steps: the variance q^2/12, which is known, taken off."""
    share = share_of_rounding(step, noise.sigma)
    rest = 1 - share
    scale = np.array([1 / rest, 1.0, 1 / rest])
    covariance = noise.covariance * np.outer(scale, scale)
    return CorrelatedNoise(noise.sigma * np.sqrt(rest), noise.rho, max(noise.white - share, 0.0) / rest, covariance)


def rounded(noise, step):
    """The CorrelatedNoise of readings rounded to steps, of that beneath them; what is uncertain of it is left as it is."""
    total = float(np.hypot(noise.sigma, step / np.sqrt(12)))
    share = step**2 / 12 / total**2
    return noise._replace(sigma=total, white=share + noise.white * (1 - share))


def noise_below_the_step(readings, step, rho):
    """(sigma, variance of log sigma) of the noise of a body at rest that shows few steps: readings is a list of (n,).

    The likelihood of how often each value is shown, averaged over where between two steps the body lies; every log sigma is
    as likely beforehand. Samples correlated by rho at their steps count as fewer.
    """
    sizes = np.geomspace(SMALLEST, 2.0, 120)
    places = (np.arange(50) + 0.5) / 50
    log_likelihood = np.zeros(len(sizes))
    for values in readings:
        shown, count = np.unique(np.round((values - values[0]) / step), return_counts=True)
        shown = shown - shown[np.argmax(count)]
        edges = (np.r_[shown - 0.5, shown + 0.5] - (places[:, None, None] - 0.5)) / sizes[:, None]  # (places, sizes, 2 values)
        low, high = np.split(special.ndtr(-np.abs(edges)), 2, axis=-1)
        below, above = np.split(edges, 2, axis=-1)
        inside = np.where(below * above < 0, 1 - low - high, np.abs(high - low))
        sums = np.log(np.maximum(inside, 1e-300)) @ count * (1 - rho) / (1 + rho)
        log_likelihood += special.logsumexp(sums, axis=0)
    weight = np.exp(log_likelihood - log_likelihood.max())
    weight /= weight.sum()
    middle = float(weight @ np.log(sizes))
    return step * float(np.exp(middle)), float(weight @ (np.log(sizes) - middle) ** 2)
