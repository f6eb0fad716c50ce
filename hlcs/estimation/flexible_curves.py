"""Noise beside flexible curves: polynomials through short parts of recordings, that assume nothing but smoothness."""

from functools import partial

import numpy as np

from hlcs.data.rounded_readings import reading_step
from hlcs.data.turns import turned_since_first
from hlcs.estimation.correlated_noise import LEAST_CERTAIN, CorrelatedNoise, fit_correlated_noise
from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.outliers import NO_TAIL, isolated_outliers, robust_sigma, scatter_of, spread_of, tail_of
from hlcs.estimation.rounding import before_rounding, share_of_rounding
from hlcs.estimation.whitening import kalman_filter

MOST_SEGMENTS = 48  # of a flexible curve: some 900 degrees of freedom know rho to 0.03; of a body at rest: 7,000 know it to 0.01
MOSTLY = 0.5  # share of rounding in the variance beyond which curves show how rounding, not noise, hangs together in time
DRIFT = 2.0  # scatter over rms change from sample to sample: of nine samples that go on 2.6, of noise with rho = 0.8 1.6 at most
ELSEWHERE = 4.0  # standard deviations of where a body rests at which it is not yet there
KINK = 6.0  # usual deviations of a second difference beyond which a height is thrown back there, and no smooth curve goes on
SMOOTH, DEGREE = 24, 5  # samples of a flexible curve, and its degree
LEAST_OF_A_PART = 9  # samples of a piece of a series: a curve of degree 5 leaves three of them to judge by
LEAST_OF_A_TAIL = 200  # whitened samples that tell how many outliers stayed: of one in a hundred they hold two


def flexible_curve(trials, step, what, rounding, sigma=None):
    """(CorrelatedNoise before rounding, Tail) beside polynomials through segments of all recordings, None where there are none.

    rounding: step of the readings; sigma: where it is known.
    """
    segments, calm = smooth_segments(trials, what, rounding, sigma)
    if not segments:
        return None
    scale = float(np.hypot(sigma, rounding / np.sqrt(12)) if sigma else calm)
    if rounding**2 / 12 > MOSTLY * scale**2:
        return before_rounding(CorrelatedNoise(scale, 0.0, 0.0, np.diag([0.0, LEAST_CERTAIN**2, 0.0])), rounding), NO_TAIL
    white = share_of_rounding(rounding, scale) if scale > 0 else 0.0
    noise, tail = cleaned(some_of(segments), step, float(white), scale if sigma else None)
    return before_rounding(noise, rounding), tail


def smooth_segments(trials, what, rounding, sigma=None):
    """([(times, values, function times -> polynomials)] of segments of all recordings, what the calm ones leave), ([], 0.0) where
    there are none.

    Only smoothness is assumed; no segment with an impact is used. rounding: step of the readings; sigma: where it is known.
    """
    segments, columns = [], partial(polynomials, degree=DEGREE)
    for trial in trials:
        thrown_back = impact_times(trial)
        for times, values in series_of(trial, what):
            kept = np.flatnonzero(~isolated_outliers(times, values))
            rests = resting_from(values[kept], rounding)  # no smooth curve goes from a slide to rest, or through an impact
            turns = turning_places(values[kept]) if trial.surroundings.floor_height is not None and not len(thrown_back) else ()
            for piece in np.split(kept, np.unique([rests, *turns, *np.searchsorted(times[kept], thrown_back)])):
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


def turning_places(values):
    """Where a series (n,) turns back: friction turns round with it, and what was slowed by more than its slope by less."""
    return sorted({int(np.argmin(values)), int(np.argmax(values))} - {0, len(values) - 1})


def resting_from(values, rounding):
    """Where a series (n,) begins to rest for the remainder, read in steps of `rounding`; n where it moves to the end, 0 where it
    never moves."""
    end = values[-LEAST_OF_A_PART:]
    spread = max(float(np.std(end)), rounding)
    if len(values) <= LEAST_OF_A_PART or spread > max(DRIFT * np.sqrt(np.mean(np.diff(end) ** 2)), rounding):
        return len(values)
    return int(np.flatnonzero(np.abs(values - np.mean(end)) > ELSEWHERE * spread).max(initial=-1)) + 1


def series_of(trial, what):
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


def some_of(segments):
    """At most MOST_SEGMENTS of them, from beginning to end: what is known of the noise grows slowly beyond, the work does not."""
    return [segments[k] for k in np.unique(np.linspace(0, len(segments) - 1, min(len(segments), MOST_SEGMENTS)).astype(int))]


def cleaned(series, step, white=None, sigma=None):
    """(CorrelatedNoise, Tail) of series [(times (n,), values (n,), function times -> columns)], isolated outliers left out.

    white, sigma: the share that is not correlated and the standard deviation where they are known.
    """
    noise, clean = without_outliers(series, step, white, sigma)
    left = np.concatenate([_white(noise, part, step) for part in clean])
    tail = tail_of(left) if len(left) >= LEAST_OF_A_TAIL else NO_TAIL
    return (noise if sigma else noise._replace(sigma=noise.sigma / np.sqrt(1 + tail.variance))), tail


def without_outliers(series, step, white=None, sigma=None):
    """(CorrelatedNoise of what is kept, [(times, values, columns)] that are kept) of series as in `cleaned`.

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


def polynomials(times, degree):
    """Legendre polynomials of degree 0..degree over the span of the times, (n, degree + 1)."""
    middle, half = (times[0] + times[-1]) / 2, max((times[-1] - times[0]) / 2, 1e-12)
    return np.polynomial.legendre.legvander((times - middle) / half, degree)
