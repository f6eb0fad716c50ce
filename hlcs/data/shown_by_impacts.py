"""What the impacts of a measurement show together, without any engine: its restitution, its friction, and a table of both."""

import numpy as np
from scipy import special

from hlcs.data.impacts import LEAST

UNSURE = 0.1  # standard error of a reading beyond which it tells no number to begin with [-]
BEDDED = 0.01  # by which a restitution is off where a floor goes on to push between the samples [-]
CURVED = 0.01  # part of its friction by which a sliding contact shows less, since its path bends [-]


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

    A restitution that falls with speed is read as a power of it.
    """
    candidates = {}
    for name in ("restitution", "friction"):
        readings = reliable(impacts, name)
        if len(readings) < LEAST:
            continue
        values, errors, speeds = (np.array(column) for column in zip(*readings, strict=True))
        value, error = (sliding_friction if name == "friction" else restitution_of_single_impacts)(values, errors)
        value = max(value, 0.0)
        if abs(value - getattr(surroundings, name)) > 3 * error:
            candidates[name] = {"coefficient": min(value, 1.0) if name == "restitution" else value}
        if name == "restitution" and len((rebounds := rebounds_among(values, errors, speeds))[0]) >= LEAST:
            _, _, trend, trend_error = mean_and_trend(*rebounds)
            if trend is not None and trend < -3 * trend_error:
                exponent, _ = power_of_speed(*rebounds)
                candidates["velocity_dependent_restitution"] = {"exponent": exponent, "threshold": 0.0}
    return candidates


def rebounds_among(values, errors, speeds):
    """The readings (n,) of impacts that a body leaves: an end in rest tells no power of speed. None whose error hides which."""
    shown = (values > 3 * errors) & (np.median(values) > 6 * errors)
    return values[shown], errors[shown], speeds[shown]


def power_of_speed(values, errors, speeds):
    """(exponent k, e_1) of restitutions e = e_1 v^-k that fall with the speed v [m/s] (n,)."""
    weights, heights, ways = (values / errors) ** 2, np.log(values), np.log(speeds)
    exponent = max(float(-np.polyfit(ways, heights, 1, w=values / errors)[0]), 0.0)
    return exponent, float(np.exp(weights @ (heights + exponent * ways) / weights.sum()))


def rebounds_shown(impacts, surroundings, drags):
    """[{candidate: {number: value}}] of what impacts show together, where each of its parts may hide another one.

    Rebounds that fall with speed: the restitution of an impact of 1 m/s beside the power, for no power is read without it; a
    restitution that is not the model's, beside each of the drags {candidate: {number: value}} that flights between impacts show.
    """
    shown = differing_from_model(impacts, surroundings)
    power, found = shown.get("velocity_dependent_restitution"), []
    if power is not None:
        readings = (np.array(column) for column in zip(*reliable(impacts, "restitution"), strict=True))
        at_one = min(power_of_speed(*rebounds_among(*readings))[1], 1.0)
        found.append({"restitution": {"coefficient": at_one}, "velocity_dependent_restitution": power})
    rebounds = found or [{"restitution": shown["restitution"]}] if "restitution" in shown else found
    return found + [numbers | {name: its} for numbers in rebounds for name, its in drags.items()]


def sliding_friction(values, errors):
    """(friction, its standard error) that readings |P_t|/P_n with their errors show, in units of 1.

    A contact that slides shows the friction, one that grips any share of it, all alike; where none slides, about the largest.
    A place to begin, and no datum beside the motion itself: of a cube that tumbles about all axes few contacts slide one way for
    as long as the lines span. 49 impacts of 20 tosses show 0.307 +- 0.004 of 0.35; the 3 or 4 of three tosses at 60 frames a
    second mostly grip, and two alike look like sliding: of 40 such readings the median is 0.12 too low, by 3 of its errors.
    """
    friction = np.linspace(0.0, 2 * max(values.max(), 0.01), 1001)[1:, None]
    error = np.hypot(errors, CURVED * friction)
    grips = (special.ndtr((friction - values) / error) - special.ndtr(-values / error)) / friction
    return _shown_by_some(friction, values, error, grips)


def restitution_of_single_impacts(values, errors):
    """(restitution, its standard error) that readings with their errors show, in units of 1.

    An impact of one point shows it; one that another point of the body follows at once shows anything, all alike.
    """
    restitution = np.linspace(min(values.min(), 0.0), max(values.max(), 1.0), 1001)[:, None]
    return _shown_by_some(restitution, values, np.hypot(errors, BEDDED), 1 / np.ptp(restitution))


def _shown_by_some(numbers, values, errors, others):
    """(number, its standard error) that some of the readings show, the rest follow the density `others`; numbers: (k, 1).

    The middle of the posterior law of the number, whatever the share of these readings is, and half of its middle 68 %.
    """
    shown = np.exp(-(((values - numbers) / errors) ** 2) / 2) / (errors * np.sqrt(2 * np.pi))
    share = (np.arange(20) + 0.5)[:, None, None] / 20
    logarithm = np.log(np.maximum(share * shown + (1 - share) * others, 1e-300)).sum(axis=-1)
    law = np.cumsum(np.exp(logarithm - logarithm.max()).sum(axis=0))
    low, middle, high = np.interp((0.16, 0.5, 0.84), law / law[-1], numbers[:, 0])
    return float(middle), float((high - low) / 2)


def reliable(impacts, key):
    """[(reading, its error, speed of approach)] of restitution or friction, those with an error below UNSURE."""
    readings = [(getattr(impact, key), getattr(impact, f"{key}_error"), impact.speed) for impact in impacts]
    return [reading for reading in readings if reading[0] is not None and reading[1] < UNSURE]


def impact_lines(impacts, of_model):
    """The printed table of impacts, list of lines. of_model: restitution and friction that the model under test has there."""
    if not impacts:
        return []
    lines = [
        "",
        f"Impacts, read from the samples around them ({len(impacts)}; the model is not asked)",
        f"  {'trial':>24s} {'time s':>9s} {'v_n m/s':>9s} {'e':>9s} {'+-':>7s} {'slip m/s':>9s} {'mu_eff':>9s} {'+-':>7s}",
    ]

    def cell(value, width):
        return f"{'-' if value is None else format(value, '.3g'):>{width}s}"

    for impact in impacts[:12]:
        lines.append(
            f"  {impact.trial[-24:]:>24s} {impact.time:9.4g} {impact.speed:9.3g} {cell(impact.restitution, 9)} "
            f"{cell(impact.restitution_error, 7)} {cell(impact.slip, 9)} {cell(impact.friction, 9)} "
            f"{cell(impact.friction_error, 7)}"
        )
    if len(impacts) > 12:
        lines.append(f"  .. and {len(impacts) - 12} more")
    for name, key, against, what in (("e", "restitution", "speed", "approach speed"), ("mu_eff", "friction", "slip", "slip")):
        readings = [impact for impact in impacts if getattr(impact, key) is not None]
        if readings:
            values, errors, speeds = (
                np.array([getattr(impact, each) for impact in readings]) for each in (key, f"{key}_error", against)
            )
            value, error, slope, slope_error = mean_and_trend(values, errors, speeds)
            where = "on average"
            if key == "friction":
                (value, error), where = sliding_friction(values, errors), "where a contact slides"
            text = f"  {name} = {value:.3g} +- {error:.2g} {where}; the model has {of_model[key]:.3g}"
            if slope is not None:
                seen = "changes" if abs(slope) > 3 * slope_error else "no change seen"
                text += f"; {seen} with {what}: {slope:+.2g} +- {slope_error:.2g} per m/s"
            lines.append(text)
    return lines + ["  a contact that grips shows a smaller mu_eff than its coefficient of friction"] * any(
        impact.friction is not None for impact in impacts
    )
