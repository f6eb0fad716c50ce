"""What impacts show without any engine: restitution against approach speed, and the friction that acted.

In free flight a coordinate less its share of gravity is a straight line in time. Lines through at least five samples on each
side of a kink meet at the moment of contact and give the velocities there. With P = m (v+ - v-), whatever the shape,
mu_eff = |P_t|/P_n; for a sphere e = -v_n+/v_n-, because its centre moves along the normal as its lowest point does.
"""

from dataclasses import asdict, dataclass

import numpy as np

LEAST = 5  # samples on each side [-]
LONGEST = 0.15  # how far from an impact samples are used, drag being left out [s]
UNSURE = 0.1  # standard error of a reading beyond which it tells no number to begin with [-]
MOST_AT_ONCE = 2_000_000  # numbers of overlapping lines that are held at a time (16 MB each)
CERTAIN = 6.0  # kinks below this many standard errors are no impacts [-]


@dataclass(frozen=True)
class Impact:
    """One impact with the floor, as the samples around it show it; SI units, one standard error beside each reading."""

    trial: str
    time: float  # of contact [s]
    speed: float  # of approach, along the normal, positive [m/s]
    restitution: float | None  # None for bodies that are no spheres
    restitution_error: float | None
    slip: float | None  # speed along the floor before, of the centre [m/s]; None where it was not recorded
    friction: float | None  # |P_t|/P_n
    friction_error: float | None


def line(times, values, moment):
    """(value at a moment, slope, covariance of the two for unit noise (2, 2)) of a straight line through samples."""
    design = np.column_stack([np.ones(len(times)), times - moment])
    inverse = np.linalg.inv(design.T @ design)
    return (*(inverse @ (design.T @ values)), inverse)


def slopes(times, values, width):
    """Slopes, and their errors for unit noise, of the lines through each `width` samples in a row, (2, n + 1 - width)."""
    times, values = (np.lib.stride_tricks.sliding_window_view(part, width) for part in (times, values))
    found = []
    for rows in np.array_split(np.arange(len(times)), 1 + len(times) * width // MOST_AT_ONCE):
        away = times[rows] - times[rows].mean(axis=1, keepdims=True)
        spread = np.sum(away**2, axis=1)
        found.append((np.sum(away * values[rows], axis=1) / spread, 1 / np.sqrt(spread)))
    return np.concatenate(found, axis=1)


def kinks(times, height, sigma, width):
    """Places k where a line up to sample k and one from k + 1 on differ most in slope, upwards, by more than CERTAIN errors."""
    count, places = len(times), np.arange(LEAST - 1, len(times) - LEAST)
    before, after = np.empty((2, 2, count))  # slope and error of the line that ends at, and that follows after, each sample
    longest = min(width, count - LEAST)
    for size in range(LEAST, longest):  # near the ends
        before[:, size - 1 : size] = slopes(times[:size], height[:size], size)
        after[:, count - size - 1 : count - size] = slopes(times[-size:], height[-size:], size)
    every = slopes(times, height, longest)
    before[:, longest - 1 :], after[:, : count - longest] = every, every[:, 1:]
    before, after = before[:, places], after[:, places]
    strength = (after[0] - before[0]) / (sigma * np.hypot(after[1], before[1]))
    free, chosen = np.ones(count, bool), []
    for place in np.argsort(-strength, kind="stable"):
        if not strength[place] > CERTAIN:
            break
        if free[places[place]]:  # its neighbours see the same kink
            chosen.append(int(places[place]))
            free[max(chosen[-1] - width, 0) : chosen[-1] + width + 1] = False
    return sorted(chosen)


def read_trial(trial, sigma, rho=0.0):
    """The impacts of one recording, list of Impact; empty where it has no floor or no height above it.

    sigma, rho: noise of a position [m] and its correlation from sample to sample, which widens the errors of slopes.
    """
    around, normal = trial.surroundings, np.asarray(trial.surroundings.floor_normal, dtype=float)
    used = np.abs(normal) > 1e-9
    if around.floor_height is None or not sigma:
        return []
    there = np.isfinite(trial.position[:, used]).all(axis=1)
    t, x = trial.times[there], trial.position[there]
    if len(t) < 2 * LEAST:
        return []
    pull = np.array([0.0, 0.0, -around.gravity])
    straight = x - 0.5 * (t[:, None] - t[0]) ** 2 * pull
    height = straight[:, used] @ normal[used]
    width = max(LEAST, int(LONGEST / np.median(np.diff(t))))
    sigma = sigma * np.sqrt((1 + rho) / (1 - rho))
    short = max(LEAST, width // 3)
    places = kinks(t, height, sigma, short)
    found = []
    for number, k in enumerate(places):
        first = max(k + 1 - width, places[number - 1] + 1 if number else 0)
        last = min(k + 1 + width, places[number + 1] + 1 if number + 1 < len(places) else len(t))
        before, after = slice(first, k + 1), slice(k + 1, last)
        if k + 1 - first < LEAST or last - k - 1 < LEAST:
            continue
        found.append(_impact(trial, t, straight, height, before, after, normal, pull, sigma))
    return [impact for impact in found if impact is not None]


def _impact(trial, t, straight, height, before, after, normal, pull, sigma):
    """The Impact between two pieces of straight flight, None where they do not meet as a blow upwards."""
    middle = (t[before.stop - 1] + t[after.start]) / 2
    a, b = line(t[before], height[before], middle), line(t[after], height[after], middle)
    moment = middle - (b[0] - a[0]) / (b[1] - a[1])
    if not t[before.stop - 1] - (t[1] - t[0]) <= moment <= t[after.start] + (t[1] - t[0]):
        return None
    a, b = line(t[before], height[before], moment), line(t[after], height[after], moment)
    fall = (pull @ normal) * (moment - t[0])
    down, up = a[1] + fall, b[1] + fall
    if down >= 0.0:
        return None
    error_down, error_up = sigma * np.sqrt(a[2][1, 1]), sigma * np.sqrt(b[2][1, 1])
    restitution = error = None
    if trial.body.shape == "sphere":
        restitution = -up / down
        error = float(np.hypot(error_up, restitution * error_down) / -down)
    slip = friction = friction_error = None
    if np.isfinite(straight).all():
        slopes = [np.array([line(t[part], straight[part, axis], moment)[1] for axis in range(3)]) for part in (before, after)]
        blow = slopes[1] - slopes[0]
        along = slopes[0] + pull * (moment - t[0])
        slip = float(np.linalg.norm(along - (along @ normal) * normal))
        friction = float(np.linalg.norm(blow - (blow @ normal) * normal) / (up - down))
        friction_error = float(np.hypot(error_up, error_down) * np.hypot(1.0, friction) / (up - down))
    return Impact(
        trial.name,
        float(moment),
        float(-down),
        None if restitution is None else float(restitution),
        error,
        slip,
        friction,
        friction_error,
    )


def read_impacts(measurement, noise):
    """The impacts of all recordings of a measurement, tuple of Impact."""
    return tuple(impact for trial in measurement.trials for impact in read_trial(trial, noise.position, noise.rho))


def mean_and_trend(values, errors, speeds):
    """(weighted mean, its error, change per m/s, its error) of readings against speed; errors widened where the readings scatter
    more than they say; the trend is None for fewer than four readings."""
    values, weights, speeds = np.asarray(values), 1.0 / np.asarray(errors) ** 2, np.asarray(speeds)
    mean = float(weights @ values / weights.sum())
    wide = np.sqrt(max(1.0, float(weights @ (values - mean) ** 2) / max(len(values) - 1, 1)))
    if len(values) < 4 or np.ptp(speeds) < 1e-9:
        return mean, float(wide / np.sqrt(weights.sum())), None, None
    centred = speeds - weights @ speeds / weights.sum()
    slope = float((weights * centred) @ values / (weights @ centred**2))
    left = values - mean - slope * centred
    scatter = np.sqrt(max(1.0, float(weights @ left**2) / (len(values) - 2)))
    return mean, float(wide / np.sqrt(weights.sum())), slope, float(scatter / np.sqrt(weights @ centred**2))


def differing_from_model(impacts, surroundings):
    """{candidate: {number: value}} of restitution and friction where impacts show others than the model's; a place to begin.

    A contact that grips shows less than its friction, so the largest readings but one in five tell it; a restitution that
    falls with speed is read as a power of it.
    """
    found = {}
    for name, share in (("restitution", 0.5), ("friction", 0.8)):
        read = reliable(impacts, name)
        if len(read) < LEAST:
            continue
        values, errors, speeds = (np.array(column) for column in zip(*read, strict=True))
        value, error = float(np.quantile(values, share)), float(np.median(errors))
        if abs(value - getattr(surroundings, name)) > 3 * error:
            found[name] = {"coefficient": float(np.clip(value, 0.0, 1.0))}
        if name == "restitution" and (values > 0).all():
            _, _, trend, trend_error = mean_and_trend(values, errors, speeds)
            if trend is not None and trend < -3 * trend_error:
                exponent = -float(np.polyfit(np.log(speeds), np.log(values), 1, w=values / errors)[0])
                found["velocity_dependent_restitution"] = {"exponent": float(np.clip(exponent, 0.0, 0.3)), "threshold": 0.0}
    return found


def reliable(impacts, key):
    """[(reading, its error, speed of approach)] of restitution or friction, those with an error below UNSURE."""
    return [
        (getattr(one, key), getattr(one, f"{key}_error"), one.speed)
        for one in impacts
        if getattr(one, key) is not None and getattr(one, f"{key}_error") < UNSURE
    ]


def impact_lines(impacts, stated):
    """The printed table of impacts, list of lines. stated: restitution and friction of the model under test."""
    if not impacts:
        return []
    lines = [
        "",
        f"Impacts, read from the samples around them ({len(impacts)}; the model is not asked)",
        f"  {'trial':>24s} {'time':>9s} {'v_n m/s':>9s} {'e':>9s} {'+-':>7s} {'slip m/s':>9s} {'mu_eff':>9s} {'+-':>7s}",
    ]

    def cell(value, width):
        return f"{'-' if value is None else format(value, '.3g'):>{width}s}"

    for one in impacts[:12]:
        lines.append(
            f"  {one.trial[-24:]:>24s} {one.time:9.4g} {one.speed:9.3g} {cell(one.restitution, 9)} "
            f"{cell(one.restitution_error, 7)} {cell(one.slip, 9)} {cell(one.friction, 9)} "
            f"{cell(one.friction_error, 7)}"
        )
    if len(impacts) > 12:
        lines.append(f"  .. and {len(impacts) - 12} more")
    for name, key, against, what in (("e", "restitution", "speed", "approach speed"), ("mu_eff", "friction", "slip", "slip")):
        read = [one for one in impacts if getattr(one, key) is not None]
        if read:
            mean, error, slope, slope_error = mean_and_trend(
                [getattr(one, key) for one in read],
                [getattr(one, f"{key}_error") for one in read],
                [getattr(one, against) for one in read],
            )
            text = f"  {name} = {mean:.3g} +- {error:.2g} on average; the model has {stated[key]:.3g}"
            if slope is not None:
                seen = "changes" if abs(slope) > 3 * slope_error else "no change seen"
                text += f"; {seen} with {what}: {slope:+.2g} +- {slope_error:.2g} per m/s"
            lines.append(text)
    return lines + ["  a contact that grips shows a smaller mu_eff than its coefficient of friction"] * any(
        one.friction is not None for one in impacts
    )


def as_rows(impacts):
    """The impacts as plain dictionaries."""
    return [asdict(one) for one in impacts]
