"""Draws of the noise as these data may hold it: what is not known of it, outliers that stayed and rounding included."""

import numpy as np

from hlcs.data.quantities import CHANNEL_UNITS
from hlcs.estimation.correlated_noise import MOST_RHO, MOST_WHITE, CorrelatedNoise, lower_factor
from hlcs.estimation.whitening import colour, kalman_filter, whiten, whitening_of_settings

PERTURBATIONS = 200  # sets of noise parameters that are drawn from their uncertainty: of 16, p kept an error of 0.1


class NoiseDraws:
    """White noise of recordings as it may be, given what is not known of a Noise."""

    def __init__(self, noise, recordings, models=None, doubt=0.0):
        """models: list of what is expected of every observation (n,), so that its rounded reading can be drawn; None: none is;
        doubt: standard deviation of the logarithm of errors that observations share."""
        self.noise, self.recordings, self.models = noise, recordings, models
        self.generator = np.random.default_rng(12345)  # a fixed stream of its own: the verdict never depends on the user's seed
        unknown = CorrelatedNoise(1.0, 0.0, 0.0, np.zeros((3, 3)))
        self.kinds = [kind or unknown for kind in (noise.positions, noise.orientations, noise.accelerations)]
        normal = self.generator.standard_normal
        self.shifts = [normal((PERTURBATIONS, 3)) @ lower_factor(kind.covariance).T for kind in self.kinds]
        self.shared = np.exp(doubt * normal(PERTURBATIONS)) if doubt else np.ones(PERTURBATIONS)
        self.drawn = {}  # index of a recording -> draws that were made of it: each takes the next set of noise parameters

    def __call__(self, index, count):
        """Draws of recording `index`, (n, count)."""
        first, n = self.drawn.get(index, 0), len(self.recordings[index].channel)
        self.drawn[index] = first + count
        white = self.generator.standard_normal((n, count))
        self.noise.tail.sprinkle(self.generator, white)
        for k in range(PERTURBATIONS):
            columns = slice((k - first) % PERTURBATIONS, count, PERTURBATIONS)
            if columns.start < count:
                read = self._as_read if self.recordings[index].whitening.common is None else self._with_shared
                read(index, white[:, columns], [shift[k] for shift in self.shifts], self.shared[k])
        return white

    def _with_shared(self, index, white, shifts, factor):
        """The same as `_as_read` where observations of a block share an error, `factor` times as large as it is taken to be."""
        whitening = self.recordings[index].whitening
        own = np.exp(shifts[0][0]) * np.sqrt(whitening.sigma**2 - whitening.common**2)
        shared = factor * whitening.common
        lengths = [part.stop - part.start for part, _ in whitening.blocks]
        actual = whitening_of_settings(np.repeat(np.arange(len(lengths)), lengths), own, shared)
        white[:] = whiten(whitening, colour(actual, white))

    def _as_read(self, index, white, shifts, factor):
        """Turn white noise (n, count), in place, into what readings with noise of other parameters look like when whitened.

        shifts: of (log sigma, rho, share) of positions, orientations and accelerations, (3,) each; factor: none shares an error.
        """
        recording, noise, filters = self.recordings[index], self.noise, {}
        for part, filter in recording.whitening.blocks:
            channel = int(recording.channel[part.start])
            which = channel // 3
            log_sigma, rho, share = shifts[which]
            step, origin = noise.lattice[channel] if channel < 3 and self.models is not None else (0.0, 0.0)
            if not shifts[which].any() and not step:
                continue
            key = which, recording.times[part].tobytes()
            if key not in filters:
                rho = float(np.clip(self.kinds[which].rho + rho, 0.0, MOST_RHO))
                share = float(np.clip(self.kinds[which].white + share, 0.0, MOST_WHITE))
                filters[key] = kalman_filter(recording.times[part], rho, share, noise.step)
            sigma = recording.whitening.sigma[part][:, None]
            relative = sigma / (noise.of_unit(CHANNEL_UNITS[which]) or 1.0)  # of a row of a table
            seen = filters[key].colour(np.exp(log_sigma) * self.kinds[which].sigma * relative * white[part])
            if step:
                expected = self.models[index][part][:, None] - origin
                seen = step * np.round((expected + seen) / step) - expected
            white[part] = filter.whiten(seen / sigma)
