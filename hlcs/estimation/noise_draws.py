"""Draws of the noise as these data may hold it: what is not known of it, outliers that stayed and rounding included."""

from typing import NamedTuple

import numpy as np

from hlcs.estimation.correlated_noise import MOST_RHO, MOST_WHITE, CorrelatedNoise, lower_factor
from hlcs.estimation.whitening import colour, exponent_of, steps_between, whiten, whitening_of_settings
from minibullet.kernels import leaf

PERTURBATIONS = 200  # sets of noise parameters that are drawn from their uncertainty: of 16, p kept an error of 0.1


class NoiseDraws:
    """White noise of recordings as it may be, given what is not known of a Noise."""

    def __init__(self, noise, recordings, models=None, doubt=0.0):
        """models: list of what is expected of every observation (n,), so that its rounded reading can be drawn; None: none is;
        doubt: standard deviation of the logarithm of errors that observations share.

        Where a path lies among the steps of its readings is not known if its start was fitted to them: around the fitted path
        the same readings would be drawn, and what the fit took from them be taken once more."""
        self.noise, self.recordings, self.models = noise, recordings, models
        self.generator = np.random.default_rng(12345)  # a fixed stream of its own: the verdict never depends on the user's seed
        unknown = CorrelatedNoise(1.0, 0.0, 0.0, np.zeros((3, 3)))
        self.kinds = [kind or unknown for kind in (noise.positions, noise.orientations, noise.accelerations)]
        normal = self.generator.standard_normal
        self.shifts = [normal((PERTURBATIONS, 3)) @ lower_factor(kind.covariance).T for kind in self.kinds]
        self.shared = np.exp(doubt * normal(PERTURBATIONS)) if doubt else np.ones(PERTURBATIONS)
        self.places = np.random.default_rng(54321)  # a stream of its own: the noise is the same where nothing is rounded
        self.drawn = {}  # index of a recording -> draws that were made of it: each takes the next set of noise parameters

    def __call__(self, index, count):
        """Draws of recording `index`, (n, count)."""
        first, n = self.drawn.get(index, 0), len(self.recordings[index].channel)
        self.drawn[index] = first + count
        white = self.generator.standard_normal((n, count))
        self.noise.tail.sprinkle(self.generator, white)
        sets = (first + np.arange(count)) % PERTURBATIONS
        if self.recordings[index].whitening.common is None:
            self._as_read(index, white, sets)
        else:
            self._with_shared(index, white, sets)
        return white

    def _with_shared(self, index, white, sets):
        """The same as `_as_read` where observations of a block share an error that is not known exactly."""
        whitening = self.recordings[index].whitening
        own, lengths = np.sqrt(whitening.sigma**2 - whitening.common**2), [part.stop - part.start for part, _ in whitening.blocks]
        setting = np.repeat(np.arange(len(lengths)), lengths)
        for k in np.unique(sets):
            actual = whitening_of_settings(setting, np.exp(self.shifts[0][k, 0]) * own, self.shared[k] * whitening.common)
            white[:, sets == k] = whiten(whitening, colour(actual, white[:, sets == k]))

    def _as_read(self, index, white, sets):
        """Turn white noise (n, count), in place, into what readings with noise of other parameters look like when whitened.

        sets: of those parameters, of each column (count,).
        """
        recording, noise = self.recordings[index], self.noise
        for part, filter in recording.whitening.blocks:
            channel = int(recording.channel[part.start])
            which = channel // 3
            kind, shifts, sigma = self.kinds[which], self.shifts[which][sets].T, recording.whitening.sigma[part]
            step, origin = noise.lattice[channel] if channel < 3 and self.models is not None else (0.0, 0.0)
            if not shifts.any() and not step:
                continue
            rho = np.clip(kind.rho + shifts[1], 0.0, MOST_RHO)
            share = np.clip(kind.white + shifts[2], 0.0, MOST_WHITE)
            known, along = noise.reading(channel), noise.along[channel] if channel < 3 else 1.0
            sizes = np.exp(shifts[0]) * kind.sigma * along / (known.sigma if known else 1.0)  # over what rows are known by
            expected = np.zeros((1, 1))
            if step:
                aside = self.places.uniform(-0.5, 0.5, len(sets)) if recording.unknown else np.zeros(len(sets))
                expected = (self.models[index][part] - origin)[:, None] + step * aside
            noises = Noises(exponent_of(rho), share, sizes)
            readings = Readings(steps_between(recording.times[part], noise.step), sigma, float(step), expected)
            read_again(noises, readings, filter, np.zeros((3, len(sets))), white[part])


class Noises(NamedTuple):
    """Noise with parameters of its own in each of many columns, (count,) each."""

    exponent: np.ndarray  # logarithm of the correlation from step to step
    share: np.ndarray  # of the variance that is not correlated
    size: np.ndarray  # standard deviation, over what the readings are known by


class Readings(NamedTuple):
    """Readings of one channel, n of them in each of many columns."""

    gaps: np.ndarray  # to the next one [steps], (n,)
    sigma: np.ndarray  # standard deviation that they are known by [unit of the channel], (n,)
    step: float  # to which they are rounded, 0 = not [unit of the channel]
    expected: np.ndarray  # what they would be without noise [unit of the channel], (n, count); of no account where not rounded


@leaf
def read_again(noises, readings, filter, scratch, white):
    """Turn white noise (n, count), in place, into readings of other noises, and these into what a Filter makes of them; scratch:
    zeros (3, count)."""
    known, drawn, foreseen = scratch  # of the state that is drawn: how well; what is foreseen of it; what is of its reading
    for row in range(len(readings.gaps)):
        sigma = readings.sigma[row]
        for column in range(white.shape[1]):
            share = noises.share[column]
            unknown = 1.0 - share - known[column]
            variance = unknown + share
            part = unknown / variance
            new = np.sqrt(variance) * white[row, column]
            seen = noises.size[column] * sigma * (drawn[column] + new)
            if readings.step > 0.0:
                expected = readings.expected[row, column]
                seen = readings.step * np.rint((expected + seen) / readings.step) - expected
            lasting = readings.gaps[row] * noises.exponent[column]
            drawn[column] = np.exp(lasting) * (drawn[column] + part * new)
            known[column] = np.exp(2 * lasting) * (1.0 - share - share * part)
            left = seen / sigma - foreseen[column]
            white[row, column] = left / filter.deviation[row]
            foreseen[column] = filter.decay[row] * (foreseen[column] + filter.gain[row] * left)
