"""The noise of a measurement: how large, how correlated in time, and how we know. Unknown is an answer."""

from dataclasses import dataclass, field

import numpy as np

from hlcs.data.validation import quantisation
from hlcs.estimation import inference
from hlcs.estimation.inference import Correlated
from minibullet import rotations

MOST_PIECES = 48  # of a flexible curve: some 900 degrees of freedom know rho to 0.03; of a body at rest: 7,000 know it to 0.01
PERTURBATIONS = 200  # sets of noise parameters that the adequacy test draws from their uncertainty: of 16, p kept an error of 0.1


@dataclass(frozen=True)
class Noise:
    """What is known of the noise of positions and of orientations."""

    positions: Correlated | None  # None = unknown
    orientations: Correlated | None
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

    def chain(self, channel, times):
        """How observations of one recording hang together: channel 0-2 position, 3-5 rotation, sorted by channel and time."""
        sigma = np.where(channel < 3, self.position or 1.0, self.orientation or 1.0)
        kinds = [self.positions] * 3 + [self.orientations] * 3
        correlations = {k: (kind.rho, kind.white) if kind else (0.0, 0.0) for k, kind in enumerate(kinds)}
        return inference.chain(channel, times, sigma, correlations, self.step)

    def drawer(self, recordings):
        """Function (index, count) -> white noise of a recording (n, count) as it may be, given what is not known of the noise."""
        generator = np.random.default_rng(12345)  # a fixed stream of its own: the verdict never depends on the user's seed
        known = [kind or Correlated(1.0, 0.0, 0.0, 1.0, np.zeros((3, 3))) for kind in (self.positions, self.orientations)]
        shifts = [generator.standard_normal((PERTURBATIONS, 3)) @ inference.lower_factor(kind.covariance).T for kind in known]

        drawn = {}  # index of a recording -> draws that were made of it: each takes the next set of noise parameters

        def draw(index, count):
            recording, first = recordings[index], drawn.get(index, 0)
            drawn[index], n = first + count, len(recording.channel)
            white = generator.choice(self.pool, (n, count)) if self.pool is not None else generator.standard_normal((n, count))
            blocks = [
                (part, filter, int(recording.channel[part.start] >= 3), recording.times[part].tobytes())
                for part, filter in recording.links.blocks
            ]
            for k in range(PERTURBATIONS):
                columns, filters = slice((k - first) % PERTURBATIONS, count, PERTURBATIONS), {}
                if columns.start >= count:
                    continue
                for part, filter, which, times in blocks:
                    log_sigma, rho, share = shifts[which][k]
                    if not shifts[which][k].any():
                        continue
                    if (which, times) not in filters:
                        filters[which, times] = inference.correlation(
                            recording.times[part],
                            float(np.clip(known[which].rho + rho, 0.0, 0.98)),
                            float(np.clip(known[which].white + share, 0.0, 0.9)),
                            self.step,
                        )
                    there = part, columns
                    white[there] = inference.whitened(
                        filter, inference.coloured(filters[which, times], np.exp(log_sigma) * white[there])
                    )
            return white

        return draw


def estimate_noise(measurement):
    """Noise of a trajectory measurement: stated, from the static recording, or from replicates; else unknown."""
    trials, stated, notes = measurement.trials, measurement.file.noise, []
    step = float(np.median(np.concatenate([np.diff(trial.times) for trial in trials])))
    source, pool, found = "unknown", None, {}
    if measurement.static is not None:
        for what in ("position", "orientation"):
            found[what], pool = _of_static(measurement.static, step, what, pool)
        source = "static recording" if any(found.values()) else "unknown"
        if source == "unknown":
            notes.append(
                f"{measurement.file.static.name}: every reading is the same: the noise lies below the last digit and "
                "stays unknown"
            )
    flexible = {what: _flexible(trials, step, what, stated.get(what)) for what in ("position", "orientation")}
    for what in ("position", "orientation"):
        if what in stated:
            base = found.get(what) or flexible[what]
            found[what] = Correlated(
                stated[what],
                base.rho if base else 0.0,
                base.white if base else 0.0,
                base.freedom if base else 0.0,
                _without_sigma(base),
            )
            source = "stated" if source == "unknown" else source
    if not any(found.values()):
        replicates = _of_replicates(trials, step)
        if replicates:
            found["position"], source = replicates, "replicates"
    position, orientation, curve = found.get("position"), found.get("orientation"), flexible["position"]
    if "position" in stated:
        curve = _flexible(trials, step, "position")  # found without what is stated, so that it can check it
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


def _without_sigma(base):
    covariance = np.zeros((3, 3)) if base is None else base.covariance.copy()
    covariance[0], covariance[:, 0] = 0.0, 0.0
    return covariance


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


def _spread(pieces):
    """At most MOST_PIECES of them, from beginning to end: what is known of the noise grows slowly beyond, the work does not."""
    return [pieces[k] for k in np.unique(np.linspace(0, len(pieces) - 1, min(len(pieces), MOST_PIECES)).astype(int))]


def _cleaned(times, values):
    keep = ~inference.isolated_outliers(values)
    return times[keep], values[keep]


def _flexible(trials, step, what, sigma=None, length=24, degree=5):
    """Noise of polynomial pieces through all recordings: no physics, only smoothness. Pieces that hold an impact are left out."""
    pieces, rounding = [], []
    for trial in trials:
        for times, values in _values(trial, what):
            rounding.append(quantisation(values))
            times, values = _cleaned(times, values)
            for part in np.array_split(np.arange(len(times)), max(len(times) // length, 1)):
                if len(part) >= degree + 4:
                    pieces.append((times[part], values[part], inference.polynomials(times[part], degree)))
    if not pieces:
        return None
    left = np.array([np.std(inference.project_out(inference.basis(columns), values)) for _, values, columns in pieces])
    seen = left > 0.1 * (sigma or np.median(left))  # a coordinate that somebody set to zero tells nothing
    left, pieces = (left[seen], [piece for piece, has in zip(pieces, seen, strict=True) if has]) if seen.any() else (left, pieces)
    calm = np.quantile(left, 0.25)  # an impact leaves many times the noise, and most pieces of a bouncing ball may hold one
    pieces = [piece for piece, size in zip(pieces, left, strict=True) if size <= 2.0 * calm]
    pieces = _spread(pieces)
    scale = sigma or float(calm)
    white = min(np.median(rounding) ** 2 / 12 / scale**2, 0.5) if scale > 0 else 0.0
    return inference.fit_noise(pieces, step, sigma=sigma, white=float(white))


def _of_static(static, step, what, pool, length=150):
    """(Correlated of a body at rest or None, whitened samples: of positions where there are any)."""
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
    found = inference.fit_noise(series, step)
    white = []
    for times, values, ones in series:
        filter = inference.correlation(times, found.rho, found.white, step)
        white.append(inference.project_out(inference.basis(inference.whitened(filter, ones)), inference.whitened(filter, values)))
    white = np.concatenate(white)
    return found, pool if pool is not None or len(white) < 200 else white / np.std(white)


def _of_replicates(trials, step):
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
                    series.append((times, values, inference.polynomials(times, 1)))
            break
    return inference.fit_noise(series, step) if series else None
