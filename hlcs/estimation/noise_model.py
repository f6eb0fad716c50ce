"""The noise of a measurement: how large, how correlated in time, and how we know. Unknown is an answer."""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from hlcs.data.experiment_file import OF_RECORDINGS
from hlcs.data.quantities import CHANNEL_UNITS, CHANNELS
from hlcs.data.rounded_readings import reading_step
from hlcs.data.turns import turned_since_first
from hlcs.estimation.correlated_noise import LEAST_CERTAIN, MOST_WHITE, CorrelatedNoise, excess_deviance, fit_correlated_noise
from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.noise_by_axis import SAME_NOISE, axes_of, made_alike, of_measured, unlike
from hlcs.estimation.outliers import NO_TAIL, Tail, isolated_outliers, robust_sigma, scatter_of, spread_of, tail_of
from hlcs.estimation.rounding import COARSE, FINE, before_rounding, lattice_of, noise_below_the_step, rounded, step_of
from hlcs.estimation.whitening import kalman_filter, whitening_of

MOST_SEGMENTS = 48  # of a flexible curve: some 900 degrees of freedom know rho to 0.03; of a body at rest: 7,000 know it to 0.01
NO_STEPS = np.zeros((3, 2))
MOSTLY = 0.5  # share of rounding in the variance beyond which curves show how rounding, not noise, hangs together in time
DRIFT = 2.0  # scatter over rms change from sample to sample: of nine samples that go on 2.6, of noise with rho = 0.8 1.6 at most
ELSEWHERE = 4.0  # standard deviations of where a body rests at which it is not yet there
KINK = 6.0  # usual deviations of a second difference beyond which a height is thrown back there, and no smooth curve goes on
SMOOTH, DEGREE = 24, 5  # samples of a flexible curve, and its degree
AT_REST = 150  # samples of a body at rest in one series
LEAST_OF_A_PART = 9  # samples of a piece of a series: a curve of degree 5 leaves three of them to judge by
BEYOND_CHANCE = 10.8  # chi-square of one number that chance exceeds once in a thousand
SURE = 4.0  # standard deviations of a reading that noise does not exceed
LEAST_OF_A_TAIL = 200  # whitened samples that tell how many outliers stayed: of one in a hundred they hold two


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
    curve = _from_flexible_curve(trials, step, "position", step_of(lattice))
    if static is not None:
        for what in OF_RECORDINGS:
            noise[what], tails[what] = _from_static(static, step, what, lattice, curve and curve[0])
    sources = {what: "static recording" for what, known in noise.items() if known} | dict.fromkeys(stated, "stated")
    for what in OF_RECORDINGS:
        if what in stated:
            if not noise.get(what):  # else a body at rest tells how it hangs together, and its tail
                curve_beside = _from_flexible_curve(trials, step, what, _rounding(what, lattice), stated[what])
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
        curves = (_from_flexible_curve(trials, noise.step, "position", 0.0) for trials in axes)
        along = unlike((curve and curve[0] for curve in curves), step_of(noise.lattice))
    trials, more = [made_alike(trial, along) for trial in measurement.trials], max(np.divide(along, noise.along))
    for what, unit in units.items():
        rounding = _rounding(what, noise.lattice)
        curve = _from_flexible_curve(trials, noise.step, what, rounding) if noise.of_unit(unit) else None
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
    segments, _ = _smooth_segments(trials, "position", rounding)
    white = float(min(rounding**2 / 12 / sigma**2, MOST_WHITE))
    _, clean = _without_outliers(_spread(segments), step, white)
    return excess_deviance(clean, step, sigma, white) > BEYOND_CHANCE


def _with_sigma(base, sigma, variance=0.0):
    """Noise of this sigma, variance of its logarithm, with the correlation of another, None = none is known."""
    base = base or CorrelatedNoise(sigma, 0.0, 0.0, np.zeros((3, 3)))
    covariance = base.covariance.copy()
    covariance[0], covariance[:, 0], covariance[0, 0] = 0.0, 0.0, variance
    return base._replace(sigma=sigma, covariance=covariance)


def _values(trial, what):
    """[(times, values)] of the measured channels of position, of acceleration, or of the rotation since the first orientation."""
    if what == "position":
        table = trial.position
    elif what == "acceleration":
        table = trial.accelerations.values if trial.accelerations else np.full((len(trial.times), 3), np.nan)
    else:
        there = np.flatnonzero(np.isfinite(trial.orientation[:, 0]))
        if len(there) == 0:
            return []
        table = np.full((len(trial.times), 3), np.nan)
        table[there] = turned_since_first(trial.orientation[there])
    seen = [np.isfinite(column) for column in table.T]
    return [(trial.times[good], table[good, axis]) for axis, good in enumerate(seen) if good.sum() >= LEAST_OF_A_PART]


def _rounding(what, lattice):
    """Step to which what is measured is rounded, 0 = none: that of positions is known alone."""
    return step_of(lattice) if what == "position" else 0.0


def _spread(segments):
    """At most MOST_SEGMENTS of them, from beginning to end: what is known of the noise grows slowly beyond, the work does not."""
    return [segments[k] for k in np.unique(np.linspace(0, len(segments) - 1, min(len(segments), MOST_SEGMENTS)).astype(int))]


def _cleaned(series, step, white=None, sigma=None):
    """(CorrelatedNoise, Tail) of series [(times (n,), values (n,), function times -> columns)], isolated outliers left out.

    white, sigma: the share that is not correlated and the standard deviation where they are known.
    """
    noise, clean = _without_outliers(series, step, white, sigma)
    left = np.concatenate([_white(noise, part, step) for part in clean])
    tail = tail_of(left) if len(left) >= LEAST_OF_A_TAIL else NO_TAIL
    return (noise if sigma else noise._replace(sigma=noise.sigma / np.sqrt(1 + tail.variance))), tail


def _without_outliers(series, step, white=None, sigma=None):
    """(CorrelatedNoise of what is kept, [(times, values, columns)] that are kept) of series as in `_cleaned`.

    What stands out is looked for twice: in the scatter of each series, then in what was found in all.
    """
    noise, keeps = None, []
    for _ in range(2):
        before = keeps
        keeps = [
            ~isolated_outliers(times, values, scatter_of([(times, values)], spread_of(noise, times, step)) if noise else 0.0)
            for times, values, _ in series
        ]
        if noise and all(np.array_equal(*pair) for pair in zip(before, keeps, strict=True)):
            break
        parts = [(times[keep], values[keep], columns) for (times, values, columns), keep in zip(series, keeps, strict=True)]
        clean = [(times, values, columns(times)) for times, values, columns in parts if len(times) >= LEAST_OF_A_PART]
        noise = fit_correlated_noise(clean, step, sigma=sigma, white=white)
    return noise, clean


def _white(noise, part, step):
    """Whitened values of one part of a series, what its columns fit taken out."""
    times, values, columns = part
    filter = kalman_filter(times, noise.rho, noise.white, step)
    return project_out(basis(filter.whiten(columns)), filter.whiten(values))


def _from_flexible_curve(trials, step, what, rounding, sigma=None):
    """(CorrelatedNoise before rounding, Tail) beside polynomials through segments of all recordings, None where there are none.

    rounding: step of the readings; sigma: where it is known.
    """
    segments, calm = _smooth_segments(trials, what, rounding, sigma)
    if not segments:
        return None
    scale = float(np.hypot(sigma, rounding / np.sqrt(12)) if sigma else calm)
    if rounding**2 / 12 > MOSTLY * scale**2:
        return before_rounding(CorrelatedNoise(scale, 0.0, 0.0, np.diag([0.0, LEAST_CERTAIN**2, 0.0])), rounding), NO_TAIL
    white = min(rounding**2 / 12 / scale**2, MOST_WHITE) if scale > 0 else 0.0
    noise, tail = _cleaned(_spread(segments), step, float(white), scale if sigma else None)
    return before_rounding(noise, rounding), tail


def _smooth_segments(trials, what, rounding, sigma=None):
    """([(times, values, function times -> polynomials)] of segments of all recordings, what the calm ones leave), ([], 0.0) where
    there are none.

    Only smoothness is assumed; no segment with an impact is used. rounding: step of the readings; sigma: where it is known.
    """
    segments, columns = [], partial(polynomials, degree=DEGREE)
    for trial in trials:
        thrown_back = impact_times(trial)
        for times, values in _values(trial, what):
            kept = np.flatnonzero(~isolated_outliers(times, values))
            rests = resting_from(values[kept], rounding)  # no smooth curve goes from a slide to rest, or through an impact
            for piece in np.split(kept, np.unique([rests, *np.searchsorted(times[kept], thrown_back)])):
                for part in np.array_split(piece, max(len(piece) // SMOOTH, 1)):
                    if len(part) >= LEAST_OF_A_PART:
                        segments.append((times[part], values[part], columns))
    if all(np.ptp(values) == 0 for _, values, _ in segments):  # somebody set all of them: they tell nothing
        return [], 0.0
    left = np.array([np.std(project_out(basis(columns(times)), values)) for times, values, _ in segments])
    seen = left > 0.1 * (sigma or np.median(left))  # a coordinate that somebody set to zero tells nothing
    if seen.any():
        left, segments = left[seen], [segment for segment, has in zip(segments, seen, strict=True) if has]
    calm = np.quantile(left, 0.25)  # an impact leaves many times the noise, and most segments of a bouncing ball may hold one
    return [segment for segment, size in zip(segments, left, strict=True) if size <= 2.0 * calm], calm


def impact_times(trial):
    """Moments between samples at which a body over a floor is thrown back, as far as its heights show it (k,) [s].

    Between these its way is smooth. There the second difference of the heights is far above that of most samples, each in units
    of its own noise; with two such samples beside each other the impact lies between them.
    """
    seen = np.isfinite(trial.position[:, 2])
    if trial.surroundings.floor_height is None or seen.sum() < LEAST_OF_A_PART:
        return np.zeros(0)
    times, heights = trial.times[seen], trial.position[seen, 2]
    kept = ~isolated_outliers(times, heights)
    times, heights = times[kept], heights[kept]
    steps = np.diff(times)
    before, after = steps[:-1], steps[1:]
    bend = 2 * np.diff(np.diff(heights) / steps) / (before + after)
    noise = 2 * np.sqrt(1 / before**2 + 1 / after**2 + (1 / before + 1 / after) ** 2) / (before + after)
    aside = (bend - np.median(bend)) / noise
    kinks = 1 + np.flatnonzero(aside > KINK * max(robust_sigma(np.abs(aside)), reading_step(heights)))
    runs = np.split(kinks, 1 + np.flatnonzero(np.diff(kinks) > 1)) if len(kinks) else []
    cuts = [place for run in runs for place in (run[0], max(run[-1] - 1, run[0]))]
    return np.unique((times[cuts] + times[np.array(cuts, int) + 1]) / 2) if cuts else np.zeros(0)


def resting_from(values, rounding):
    """Where a series (n,) begins to rest for the remainder, read in steps of `rounding`; n where it moves to the end, 0 where it
    never moves."""
    end = values[-LEAST_OF_A_PART:]
    spread = max(float(np.std(end)), rounding)
    if len(values) <= LEAST_OF_A_PART or spread > max(DRIFT * np.sqrt(np.mean(np.diff(end) ** 2)), rounding):
        return len(values)
    return int(np.flatnonzero(np.abs(values - np.mean(end)) > ELSEWHERE * spread).max(initial=-1)) + 1


def _from_static(static, step, what, lattice, flexible):
    """(CorrelatedNoise of a body at rest before rounding or None, Tail); flexible: that of the recordings, where there is any.

    How its noise is correlated shows in the few steps of a body at rest too; where it shows a single one the recordings tell it.
    """
    readings = _values(static, what)
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
    white = rounding**2 / 12 / scatter**2 if rounding > FINE * scatter else None
    noise, tail = _cleaned(_spread(series), step, white)
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
    return _cleaned(series, step)[0] if series else None


def polynomials(times, degree):
    """Legendre polynomials of degree 0..degree over the span of the times, (n, degree + 1)."""
    middle, half = (times[0] + times[-1]) / 2, max((times[-1] - times[0]) / 2, 1e-12)
    return np.polynomial.legendre.legvander((times - middle) / half, degree)
