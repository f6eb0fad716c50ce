"""The noise of a measurement: how large, how correlated in time, and how we know. Unknown is an answer."""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from hlcs.data.experiment_file import OF_RECORDINGS
from hlcs.data.quantities import CHANNEL_UNITS, CHANNELS
from hlcs.estimation.correlated_noise import CorrelatedNoise, excess_deviance, fit_correlated_noise
from hlcs.estimation.flexible_curves import (
    LEAST_OF_A_PART,
    cleaned,
    flexible_curve,
    polynomials,
    series_of,
    smooth_segments,
    some_of,
    without_outliers,
)
from hlcs.estimation.noise_by_axis import SAME_NOISE, axes_of, made_alike, of_measured, unlike
from hlcs.estimation.outliers import NO_TAIL, Tail, isolated_outliers
from hlcs.estimation.rounding import (
    COARSE,
    FINE,
    before_rounding,
    lattice_of,
    noise_below_the_step,
    rounded,
    share_of_rounding,
    step_of,
)
from hlcs.estimation.whitening import whitening_of

NO_STEPS = np.zeros((3, 2))
AT_REST = 150  # samples of a body at rest in one series
BEYOND_CHANCE = 10.8  # chi-square of one number that chance exceeds once in a thousand
SURE = 4.0  # standard deviations of a reading that noise does not exceed


@dataclass(frozen=True)
class Noise:
    """What is known of the noise of positions, of orientations and of accelerations."""

    positions: CorrelatedNoise | None  # before rounding; None = unknown
    orientations: CorrelatedNoise | None
    step: float  # typical sampling step, to which correlations refer [s]
    source: str  # "stated", "static recording", "replicates" or "unknown"
    notes: tuple[str, ...] = ()
    hint: float | None = None  # sigma of a flexible curve [m]: shown where the noise is unknown, never used
    tail: Tail = NO_TAIL  # outliers that no test of single samples finds
    lattice: np.ndarray = field(default_factory=NO_STEPS.copy, repr=False)  # step and one reading of x, y, z [m]; step 0 = none
    accelerations: CorrelatedNoise | None = None
    along: tuple = SAME_NOISE  # sigma of a position along x, y, z, over their root mean square, which `positions` has [-]

    @property
    def position(self):
        """One sigma of a reading of a position, the root mean square of the axes [m], None = unknown."""
        return rounded(self.positions, step_of(self.lattice)).sigma if self.positions else None

    @property
    def of_axes(self):
        """One sigma of a reading of x, y, z (3,) [m], None = unknown."""
        return np.array([self.reading(k).sigma for k in range(3)]) if self.positions else None

    @property
    def by_axis(self):
        """The same; None where they are alike, or unknown."""
        return None if self.along == SAME_NOISE else self.of_axes

    def towards(self, direction):
        """One sigma of a reading of a position along a direction, a unit vector (3,) [m]; None = unknown."""
        return self.position if self.by_axis is None else float(np.linalg.norm(self.by_axis * direction))

    def reaches(self, direction):
        """How far along a direction (3,) noise may lead a reading of a position astray [m]; 0 where it is unknown."""
        return SURE * (self.towards(direction) or 0.0)

    @property
    def orientation(self):
        """One sigma of a rotation about each axis [rad], None = unknown."""
        return self.orientations.sigma if self.orientations else None

    @property
    def rho(self):
        """Correlation of neighbouring samples of a position [-]."""
        return self.positions.rho * (1 - self.reading(0).white) if self.positions else 0.0

    @property
    def acceleration(self):
        """One sigma of a reading of an accelerometer along each axis [m/s2], None = unknown."""
        return self.accelerations.sigma if self.accelerations else None

    @property
    def known(self):
        """Is the noise of anything known?"""
        return any(self.of_unit(unit) is not None for unit in CHANNEL_UNITS)

    def of_unit(self, unit):
        """One sigma of the readings that have that unit, None = unknown; of a unit of tables, that of the outcome."""
        return {"rad": self.orientation, "m/s2": self.acceleration}.get(unit, self.position)

    def reading(self, channel):
        """The CorrelatedNoise of the readings of a channel, its number in CHANNELS; rounding included; None = unknown."""
        noise = (self.positions, self.orientations, self.accelerations)[channel // 3]
        if not noise or channel >= 3:
            return noise
        return rounded(noise._replace(sigma=noise.sigma * self.along[channel]), step_of(self.lattice))

    def to_dict(self):
        """What is told of it in results; rounding: the steps in which positions are read [m], where they count."""
        told = {
            "position": self.position,
            "orientation": self.orientation,
            "rho": self.rho,
            "source": self.source,
            "flexible": self.hint,
        }
        along = None if self.by_axis is None else self.by_axis.tolist()
        more = {"along_axes": along, "acceleration": self.acceleration, "rounding": step_of(self.lattice) or None}
        return told | {name: value for name, value in more.items() if value is not None}

    def whitening(self, channel, times):
        """Whitening of the observations of one recording: numbers in CHANNELS and times (n,) each, sorted by channel and time."""
        readings = [self.reading(k) for k in range(len(CHANNELS))]
        sigma = np.array([noise.sigma if noise else 1.0 for noise in readings])[np.asarray(channel)]
        correlations = {k: (noise.rho, noise.white) if noise else (0.0, 0.0) for k, noise in enumerate(readings)}
        return whitening_of(channel, times, sigma, correlations, self.step)


def estimate_noise(measurement):
    """Noise of a trajectory measurement: stated, from the static recording, or from replicates; else unknown."""
    trials, stated, notes = measurement.trials, measurement.file.noise, []
    step = float(np.median(np.concatenate([np.diff(trial.times) for trial in trials])))
    lattice, static = lattice_of(trials, measurement.static), measurement.static
    along, size = of_measured(measurement.file.noise_along, trials)
    stated = {what: sigma * (size if what == "position" else 1.0) for what, sigma in stated.items()}
    if static is not None and "position" not in stated:
        along = unlike((_from_static(each, step, "position", NO_STEPS, None)[0] for each in axes_of(static)), step_of(lattice))
    trials, static = [made_alike(trial, along) for trial in trials], static and made_alike(static, along)
    noise, tails = {}, {}
    curve = flexible_curve(trials, step, "position", step_of(lattice))
    if static is not None:
        for what in OF_RECORDINGS:
            noise[what], tails[what] = _from_static(static, step, what, lattice, curve and curve[0])
    sources = {what: "static recording" for what, known in noise.items() if known} | dict.fromkeys(stated, "stated")
    for what in OF_RECORDINGS:
        if what in stated:
            if not noise.get(what):  # else a body at rest tells how it hangs together, and its tail
                curve_beside = flexible_curve(trials, step, what, _rounding(what, lattice), stated[what])
                noise[what], tails[what] = curve_beside or (None, NO_TAIL)
            noise[what] = _with_sigma(noise[what], stated[what])
    if not any(noise.values()) and (replicates := _from_replicates(trials, step)):
        noise["position"], sources["position"] = before_rounding(replicates, step_of(lattice)), "replicates"
    source = next((sources[what] for what in OF_RECORDINGS if what in sources), "unknown")
    if static is not None and source == "unknown":
        notes.append(
            f"{measurement.file.static.name}: every reading is the same, or too few are given: the noise lies below the last "
            "digit, or stays unknown"
        )
    position, orientation = noise.get("position"), noise.get("orientation")
    if position is None or step_of(lattice) < FINE * position.sigma:
        lattice = NO_STEPS
    tail = next((tails[what] for what in OF_RECORDINGS if noise.get(what) and what in tails), NO_TAIL)
    hint = rounded(curve[0], step_of(lattice)).sigma if curve else None
    found = Noise(position, orientation, step, source, (), hint, tail, lattice, noise.get("acceleration"), along)
    if position and curve and not 1 / 1.5 < hint / found.position < 1.5 and _contradicts(trials, step, lattice, found.position):
        steps = f", rounding to steps of {step_of(lattice):.3g} m included" if step_of(lattice) else ""
        notes.append(
            f"a flexible curve through the data leaves {hint:.3g} m, the {source} noise is {found.position:.3g} m{steps}"
            ": more than a factor 1.5 apart; check it"
        )
    for what, unit, seen in zip(OF_RECORDINGS, CHANNEL_UNITS, (slice(0, 3), slice(3, 6), slice(6, 9)), strict=True):
        if found.known and found.of_unit(unit) is None and any(trial.measured[:, seen].any() for trial in trials):
            notes.append(f"noise of the {what} unknown: {what}s are not judged; state noise.{what} or record a body at rest")
    return replace(found, notes=tuple(notes))


def shown_by_curves(measurement, noise):
    """(what is noisy, its unit, the Noise with that of flexible curves in its place), where these leave most beyond what is
    known.

    The curves know no model, so what they leave is no misfit of one. None where they leave no more anywhere.
    """
    found, units, along = {}, dict(zip(OF_RECORDINGS, CHANNEL_UNITS, strict=True)), noise.along
    if along == SAME_NOISE and noise.positions:
        axes = zip(*map(axes_of, measurement.trials), strict=True)
        curves = (flexible_curve(trials, noise.step, "position", 0.0) for trials in axes)
        along = unlike((curve and curve[0] for curve in curves), step_of(noise.lattice))
    trials, more = [made_alike(trial, along) for trial in measurement.trials], max(np.divide(along, noise.along))
    for what, unit in units.items():
        rounding = _rounding(what, noise.lattice)
        curve = flexible_curve(trials, noise.step, what, rounding) if noise.of_unit(unit) else None
        if curve and rounded(curve[0], rounding).sigma * (more if what == "position" else 1.0) > noise.of_unit(unit):
            found[what] = curve
    if not found:
        return None
    other = replace(noise, **{f"{what}s": curve for what, (curve, _) in found.items()}, tail=next(iter(found.values()))[1])
    other = replace(other, along=along) if "position" in found else other
    most = max(found, key=lambda what: other.of_unit(units[what]) / noise.of_unit(units[what]))
    return most, units[most], other


def _contradicts(trials, step, lattice, sigma):
    """Do smooth curves leave another noise of the positions than this sigma of a reading, by more than chance?"""
    rounding = step_of(lattice)
    segments, _ = smooth_segments(trials, "position", rounding)
    white = float(share_of_rounding(rounding, sigma))
    _, clean = without_outliers(some_of(segments), step, white)
    return excess_deviance(clean, step, sigma, white) > BEYOND_CHANCE


def _with_sigma(base, sigma, variance=0.0):
    """Noise of this sigma, variance of its logarithm, with the correlation of another, None = none is known."""
    base = base or CorrelatedNoise(sigma, 0.0, 0.0, np.zeros((3, 3)))
    covariance = base.covariance.copy()
    covariance[0], covariance[:, 0], covariance[0, 0] = 0.0, 0.0, variance
    return base._replace(sigma=sigma, covariance=covariance)


def _rounding(what, lattice):
    """Step to which what is measured is rounded, 0 = none: that of positions is known alone."""
    return step_of(lattice) if what == "position" else 0.0


def _from_static(static, step, what, lattice, flexible):
    """(CorrelatedNoise of a body at rest before rounding or None, Tail); flexible: that of the recordings, where there is any.

    How its noise is correlated shows in the few steps of a body at rest too; where it shows a single one the recordings tell it.
    """
    readings = series_of(static, what)
    rounding = _rounding(what, lattice)
    constant = partial(polynomials, degree=0)
    series = [
        (times[part], values[part], constant)
        for times, values in readings
        for part in np.array_split(np.arange(len(times)), max(len(times) // AT_REST, 1))
    ]
    if not series or not rounding and all(np.ptp(values) == 0 for _, values, _ in series):
        return None, NO_TAIL
    scatter = np.sqrt(np.mean([np.var(values[~isolated_outliers(times, values)]) for times, values in readings]))
    if scatter < COARSE * rounding:
        changing = [(times, values, columns(times)) for times, values, columns in series if np.ptp(values) > 0]
        base = before_rounding(fit_correlated_noise(changing, step), rounding) if changing else flexible
        sigma, variance = noise_below_the_step([values for _, values in readings], rounding, base.rho if base else 0.0)
        return _with_sigma(base, sigma, variance), NO_TAIL
    white = share_of_rounding(rounding, scatter) if rounding > FINE * scatter else None
    noise, tail = cleaned(some_of(series), step, white)
    return before_rounding(noise, rounding), tail


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
                if good.sum() >= LEAST_OF_A_PART:
                    series.append((a.times[good], difference[good], partial(polynomials, degree=1)))
            break
    return cleaned(series, step)[0] if series else None
