"""The noise of a measurement: how large, how correlated in time, and how we know. Unknown is an answer."""

from dataclasses import dataclass

import numpy as np

from minibullet import rotations

from . import inference


@dataclass(frozen=True)
class Noise:
    """One sigma of the samples and their correlation at one time step."""

    position: float | None  # [m], None = unknown
    orientation: float | None  # [rad], None = unknown
    rho: float  # correlation of positions over `step`
    rho_orientation: float
    step: float  # typical sampling step [s]
    freedom: float  # samples that fixed sigma; inf where it is stated
    freedom_rho: float  # samples that fixed rho
    source: str  # "stated", "static recording", "replicates" or "unknown"
    notes: tuple[str, ...] = ()
    hint: float | None = None  # sigma of a flexible curve [m]: shown where the noise is unknown, never used
    pool: np.ndarray | None = None  # whitened static samples

    def errors(self):
        """Standard errors of log sigma and of rho."""
        spread = (1 + self.rho**2) / (1 - self.rho**2)
        return (float(np.sqrt(spread / (2 * self.freedom))) if np.isfinite(self.freedom) else 0.0,
                float(np.sqrt((1 - self.rho**2) / max(self.freedom_rho, 1.0))))


def estimate_noise(measurement):
    """Noise of a trajectory measurement: stated, from the static recording, or from replicates; else unknown."""
    trials, stated, notes = measurement.trials, measurement.file.noise, []
    step = float(np.median(np.concatenate([np.diff(trial.times) for trial in trials])))
    flexible = _flexible(trials, step, "position", stated.get("position"))
    turning = _flexible(trials, step, "orientation", stated.get("orientation"))
    sigma, rho, freedom, freedom_rho, source, pool = None, None, np.inf, 0.0, "unknown", None
    turn_sigma, turn_rho = None, None
    if measurement.static is not None:
        found, pool = _of_static(measurement.static, step, "position")
        if found:
            sigma, rho, freedom, freedom_rho, source = found.sigma, found.rho, found.freedom, found.freedom, "static recording"
        found_turn, _ = _of_static(measurement.static, step, "orientation")
        if found_turn:
            turn_sigma, turn_rho = found_turn.sigma, found_turn.rho
            source = "static recording"
    if "position" in stated:
        sigma, freedom = stated["position"], np.inf
        source = "stated" if source == "unknown" else f"stated, correlation from the {source}"
    if "orientation" in stated:
        turn_sigma = stated["orientation"]
        source = "stated" if source == "unknown" else source
    if sigma is None:
        found = _of_replicates(trials, step)
        if found:
            sigma, rho, freedom, freedom_rho, source = found.sigma, found.rho, found.freedom, found.freedom, "replicates"
    if rho is None and flexible:
        rho, freedom_rho = flexible.rho, flexible.freedom
    if turn_rho is None:
        turn_rho = turning.rho if turning else (rho or 0.0)
    if sigma and flexible and not 1 / 1.5 < flexible.sigma / sigma < 1.5:
        notes.append(f"a flexible curve through the data leaves {flexible.sigma:.3g} m, the {source} noise is {sigma:.3g} m: "
                     "more than a factor 1.5 apart; check it")
    measured_turn = any("rx" in trial.columns for trial in trials)
    if measured_turn and turn_sigma is None and sigma is not None:
        notes.append("noise of the orientation unknown: orientations are not judged; state noise.orientation or record a body "
                     "at rest")
    return Noise(sigma, turn_sigma, rho or 0.0, turn_rho, step, freedom, freedom_rho, source, tuple(notes),
                 flexible.sigma if flexible else None, pool)


def _values(trial, what):
    """[(times, values)] of the measured channels of position or of the rotation since the first orientation."""
    if what == "position":
        table = trial.position
    else:
        there = np.flatnonzero(np.isfinite(trial.orientation[:, 0]))
        if len(there) == 0:
            return []
        steps = rotations.logarithm(rotations.product(trial.orientation[1:], rotations.conjugate(trial.orientation[:-1])))
        table = np.full((len(trial.times), 3), np.nan)
        table[there] = np.cumsum(np.vstack([np.zeros(3), np.nan_to_num(steps[there[1:] - 1])]), axis=0)
    return [(trial.times[good], table[good, axis]) for axis in range(3) if (good := np.isfinite(table[:, axis])).sum() >= 8]


def _cleaned(times, values):
    keep = ~inference.isolated_outliers(values)
    return times[keep], values[keep]


def _flexible(trials, step, what, sigma=None, length=24, degree=5):
    """Noise of polynomial pieces through all recordings: no physics, only smoothness. Pieces that hold an impact are left out."""
    pieces = []
    for trial in trials:
        for times, values in _values(trial, what):
            times, values = _cleaned(times, values)
            count = max(len(times) // length, 1)
            for part in np.array_split(np.arange(len(times)), count):
                if len(part) >= degree + 4:
                    pieces.append((times[part], values[part], inference.polynomials(times[part], degree)))
    if not pieces:
        return None
    spread = np.array([np.std(np.diff(values, 3)) for _, values, _ in pieces])
    pieces = [piece for piece, size in zip(pieces, spread, strict=True) if size <= 2.0 * np.median(spread)]
    return inference.fit_noise(pieces, step, sigma=sigma)


def _of_static(static, step, what):
    """(Correlated, pool of whitened samples) of a body at rest, or (None, None)."""
    series = []
    for times, values in _values(static, what):
        times, values = _cleaned(times, values)
        series.append((times, values, np.ones((len(times), 1))))
    if not series:
        return None, None
    found = inference.fit_noise(series, step)
    white = []
    for times, values, ones in series:
        links = inference.chain(np.zeros(len(times), int), times, np.full(len(times), found.sigma), found.rho, step)
        white.append(inference.project_out(inference.basis(inference.whiten(links, ones)), inference.whiten(links, values)))
    white = np.concatenate(white)
    return found, (white / np.std(white) if len(white) >= 200 else None)


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
