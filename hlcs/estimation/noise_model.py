"""The noise of a measurement: how large, how correlated in time, and how we know. Unknown is an answer."""

from dataclasses import dataclass, field

import numpy as np

from hlcs.data.validation import quantisation
from hlcs.estimation.correlated_noise import MOST_RHO, MOST_WHITE, CorrelatedNoise, fit_correlated_noise, lower_factor
from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.whitening import colour_series, kalman_filter, whiten_series, whitening_of
from minibullet import rotations

MOST_SEGMENTS = 48  # of a flexible curve: some 900 degrees of freedom know rho to 0.03; of a body at rest: 7,000 know it to 0.01
KINDS = ("position", "orientation")
PERTURBATIONS = 200  # sets of noise parameters that the adequacy test draws from their uncertainty: of 16, p kept an error of 0.1


@dataclass(frozen=True)
class Noise:
    """What is known of the noise of positions and of orientations."""

    positions: CorrelatedNoise | None  # None = unknown
    orientations: CorrelatedNoise | None
    step: float  # typical sampling step, to which correlations refer [s]
    source: str  # "stated", "static recording", "replicates" or "unknown"
    notes: tuple[str, ...] = ()
    hint: float | None = None  # sigma of a flexible curve [m]: shown where the noise is unknown, never used
    pool: np.ndarray | None = field(default=None, repr=False)  # whitened static samples

    @property
    def position(self):
        """One sigma of a position [m], None = unknown."""
        return self.positions.sigma if self.positions else None

    @property
    def orientation(self):
        """One sigma of a rotation about each axis [rad], None = unknown."""
        return self.orientations.sigma if self.orientations else None

    @property
    def rho(self):
        """Correlation of neighbouring samples of a position [-]."""
        return self.positions.rho * (1 - self.positions.white) if self.positions else 0.0

    def to_dict(self):
        """What is told of it in results."""
        return {
            "position": self.position,
            "orientation": self.orientation,
            "rho": self.rho,
            "source": self.source,
            "flexible": self.hint,
        }

    def whitening(self, channel, times):
        """Whitening of the observations of one recording: channel 0-2 position, 3-5 rotation, sorted by channel and time."""
        sigma = np.where(channel < 3, self.position or 1.0, self.orientation or 1.0)
        known = [self.positions] * 3 + [self.orientations] * 3
        correlations = {k: (noise.rho, noise.white) if noise else (0.0, 0.0) for k, noise in enumerate(known)}
        return whitening_of(channel, times, sigma, correlations, self.step)

    def drawer(self, recordings):
        """Function (index, count) -> white noise of a recording (n, count) as it may be, given what is not known of the noise."""
        generator = np.random.default_rng(12345)  # a fixed stream of its own: the verdict never depends on the user's seed
        known = [noise or CorrelatedNoise(1.0, 0.0, 0.0, np.zeros((3, 3))) for noise in (self.positions, self.orientations)]
        shifts = [generator.standard_normal((PERTURBATIONS, 3)) @ lower_factor(noise.covariance).T for noise in known]
        drawn = {}  # index of a recording -> draws that were made of it: each takes the next set of noise parameters

        def draw(index, count):
            recording, first = recordings[index], drawn.get(index, 0)
            drawn[index], n = first + count, len(recording.channel)
            white = generator.choice(self.pool, (n, count)) if self.pool is not None else generator.standard_normal((n, count))
            for k in range(PERTURBATIONS):
                columns = slice((k - first) % PERTURBATIONS, count, PERTURBATIONS)
                if columns.start < count:
                    self._perturb(white[:, columns], recording, known, [shift[k] for shift in shifts])
            return white

        return draw

    def _perturb(self, white, recording, known, shifts):
        """Turn white noise (n, count) of a recording, in place, into what noise of other parameters looks like when whitened.

        known: CorrelatedNoise of positions and of orientations; shifts: of their (log sigma, rho, share), (3,) each.
        """
        filters = {}
        for part, filter in recording.whitening.blocks:
            which = int(recording.channel[part.start] >= 3)
            log_sigma, rho, share = shifts[which]
            if not shifts[which].any():
                continue
            key = which, recording.times[part].tobytes()
            if key not in filters:
                rho = float(np.clip(known[which].rho + rho, 0.0, MOST_RHO))
                share = float(np.clip(known[which].white + share, 0.0, MOST_WHITE))
                filters[key] = kalman_filter(recording.times[part], rho, share, self.step)
            white[part] = whiten_series(filter, colour_series(filters[key], np.exp(log_sigma) * white[part]))


def estimate_noise(measurement):
    """Noise of a trajectory measurement: stated, from the static recording, or from replicates; else unknown."""
    trials, stated, notes = measurement.trials, measurement.file.noise, []
    step = float(np.median(np.concatenate([np.diff(trial.times) for trial in trials])))
    source, pool, noise = "unknown", None, {}
    if measurement.static is not None:
        for what in KINDS:
            noise[what], pool = _from_static(measurement.static, step, what, pool)
        source = "static recording" if any(noise.values()) else "unknown"
        if source == "unknown":
            notes.append(
                f"{measurement.file.static.name}: every reading is the same: the noise lies below the last digit and "
                "stays unknown"
            )
    flexible = {what: _from_flexible_curve(trials, step, what, stated.get(what)) for what in KINDS}
    for what in KINDS:
        if what in stated:
            noise[what] = _with_sigma(noise.get(what) or flexible[what], stated[what])
            source = "stated" if source == "unknown" else source
    if not any(noise.values()):
        replicates = _from_replicates(trials, step)
        if replicates:
            noise["position"], source = replicates, "replicates"
    position, orientation, curve = noise.get("position"), noise.get("orientation"), flexible["position"]
    if "position" in stated:
        curve = _from_flexible_curve(trials, step, "position")  # without what is stated, so that it can check it
    if position and curve and not 1 / 1.5 < curve.sigma / position.sigma < 1.5:
        notes.append(
            f"a flexible curve through the data leaves {curve.sigma:.3g} m, the {source} noise is {position.sigma:.3g} m"
            ": more than a factor 1.5 apart; check it"
        )
    if any("rx" in trial.columns for trial in trials) and orientation is None and position is not None:
        notes.append(
            "noise of the orientation unknown: orientations are not judged; state noise.orientation or record a body at rest"
        )
    return Noise(position, orientation, step, source, tuple(notes), curve.sigma if curve else None, pool)


def _with_sigma(base, sigma):
    """Noise of a stated sigma, which is certain, with the correlation of another, None = none is known."""
    if base is None:
        return CorrelatedNoise(sigma, 0.0, 0.0, np.zeros((3, 3)))
    covariance = base.covariance.copy()
    covariance[0], covariance[:, 0] = 0.0, 0.0
    return base._replace(sigma=sigma, covariance=covariance)


def _values(trial, what):
    """[(times, values)] of the measured channels of position or of the rotation since the first orientation."""
    if what == "position":
        table = trial.position
    else:
        there = np.flatnonzero(np.isfinite(trial.orientation[:, 0]))
        if len(there) == 0:
            return []
        steps = rotations.logarithm(
            rotations.product(trial.orientation[there[1:]], rotations.conjugate(trial.orientation[there[:-1]]))
        )
        table = np.full((len(trial.times), 3), np.nan)
        table[there] = np.cumsum(np.vstack([np.zeros(3), steps]), axis=0)
    return [(trial.times[good], table[good, axis]) for axis in range(3) if (good := np.isfinite(table[:, axis])).sum() >= 8]


def _spread(segments):
    """At most MOST_SEGMENTS of them, from beginning to end: what is known of the noise grows slowly beyond, the work does not."""
    return [segments[k] for k in np.unique(np.linspace(0, len(segments) - 1, min(len(segments), MOST_SEGMENTS)).astype(int))]


def _cleaned(times, values):
    keep = ~isolated_outliers(values)
    return times[keep], values[keep]


def _from_flexible_curve(trials, step, what, sigma=None, length=24, degree=5):
    """Noise beside polynomials through segments of all recordings: only smoothness is assumed; none with an impact is used."""
    segments, rounding = [], []
    for trial in trials:
        for times, values in _values(trial, what):
            rounding.append(quantisation(values))
            times, values = _cleaned(times, values)
            for part in np.array_split(np.arange(len(times)), max(len(times) // length, 1)):
                if len(part) >= degree + 4:
                    segments.append((times[part], values[part], polynomials(times[part], degree)))
    if not segments:
        return None
    left = np.array([np.std(project_out(basis(columns), values)) for _, values, columns in segments])
    seen = left > 0.1 * (sigma or np.median(left))  # a coordinate that somebody set to zero tells nothing
    if seen.any():
        left, segments = left[seen], [segment for segment, has in zip(segments, seen, strict=True) if has]
    calm = np.quantile(left, 0.25)  # an impact leaves many times the noise, and most segments of a bouncing ball may hold one
    segments = _spread([segment for segment, size in zip(segments, left, strict=True) if size <= 2.0 * calm])
    scale = sigma or float(calm)
    white = min(np.median(rounding) ** 2 / 12 / scale**2, 0.5) if scale > 0 else 0.0
    return fit_correlated_noise(segments, step, sigma=sigma, white=float(white))


def _from_static(static, step, what, pool, length=150):
    """(CorrelatedNoise of a body at rest or None, whitened samples: of positions where there are any)."""
    series = []
    for times, values in _values(static, what):
        times, values = _cleaned(times, values)
        for part in np.array_split(np.arange(len(times)), max(len(times) // length, 1)):
            series.append((times[part], values[part], np.ones((len(part), 1))))
    if not series:
        return None, pool
    if all(np.ptp(values) == 0 for _, values, _ in series):
        return None, pool
    series = _spread(series)
    noise = fit_correlated_noise(series, step)
    white = []
    for times, values, ones in series:
        filter = kalman_filter(times, noise.rho, noise.white, step)
        white.append(project_out(basis(whiten_series(filter, ones)), whiten_series(filter, values)))
    white = np.concatenate(white)
    return noise, pool if pool is not None or len(white) < 200 else white / np.std(white)


def _from_replicates(trials, step):
    """Noise from trials that repeat the same set-up and the same stated start: half the variance of their differences."""
    series = []
    for second in range(len(trials)):
        for first in range(second):
            a, b = trials[first], trials[second]
            same = (a.body, a.surroundings, a.start) == (b.body, b.surroundings, b.start)
            if not (same and "velocity" in a.start) or len(a.times) != len(b.times) or not np.allclose(a.times, b.times):
                continue
            for axis in range(3):
                difference = (a.position[:, axis] - b.position[:, axis]) / np.sqrt(2)
                good = np.isfinite(difference)
                if good.sum() >= 8:
                    times, values = _cleaned(a.times[good], difference[good])
                    series.append((times, values, polynomials(times, 1)))
            break
    return fit_correlated_noise(series, step) if series else None


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
