"""What the residuals that a model leaves look like: how they go with time, height and speed, and whether they swing."""

from typing import NamedTuple

import numpy as np
from scipy import special

from hlcs.data.quantities import CHANNELS, INPUTS, UNLIKELY, have_unit
from hlcs.report.words import joined
from hlcs.report.words import share as told_share

BINS = 12  # of a variable, in which a misfit that all recordings share is looked for
SHOWN = 0.25  # share of the mean square that a pattern must hold to be told of
MOST = 0.9  # share of what is more than noise that a few recordings must hold to be named alone
NAMED = 4  # recordings that are named one by one; of more the count is told
ALIKE = 0.3  # correlation of neighbouring residuals from which they are said to drift
CYCLES = 3.0  # that a recording must hold of a period: fewer are a drift
MOST_FREQUENCIES = 2000
WORDS = {"time": "time", "height": "height", "speed": "speed", "input": "the main input", "layer": "the layer"}


class Spectrum(NamedTuple):
    """The periodogram of white residuals of one channel, summed over recordings, in units of their own mean."""

    channel: int
    frequency: np.ndarray  # (k,) [Hz]
    power: np.ndarray  # (k,) 1 = as white noise of the same size
    peak: float  # frequency of the largest [Hz]
    p: float  # of a peak as high in white noise, all frequencies and channels counted
    amplitude: float  # of the swing at the peak, root mean square over recordings, in the unit of the channel
    slowest: float  # frequency of which a recording holds enough periods to tell it from a drift [Hz]

    @property
    def hides_a_period(self):
        """Is the peak more than chance, and no end of a slow drift?"""
        return self.p < UNLIKELY and self.peak >= self.slowest


def spectrum(table):
    """The Spectrum of the channel with the clearest peak in a table of observations; None where there are too few samples."""
    return next(iter(spectra(table)), None)


def spectra(table):
    """The Spectrum of each channel of a table of observations, the clearest peak first; without those of too few samples.

    Lomb's periodogram (N. R. Lomb, Astrophys. Space Sci. 39 (1976) 447) of each recording, normalised by its own mean square, so
    that in white noise the sum over M recordings follows a gamma law of shape M.
    """
    if "time" not in table:
        return []
    found = [each for channel in np.unique(table["channel"]) if (each := _channel_spectrum(table, channel))]
    counted = [each._replace(p=min(1.0, each.p * len(found))) for each in found]
    return sorted(counted, key=lambda each: (each.p, -each.power.max()))


def _channel_spectrum(table, channel):
    from scipy import signal  # here: it takes as long to load as all other parts of a report

    parts = []
    for trial in np.unique(table["trial"]):
        inside = (table["trial"] == trial) & (table["channel"] == channel)
        if inside.sum() >= 16:
            parts.append((table["time"][inside], table["white"][inside], table["residual"][inside]))
    if not parts:
        return None
    longest = max(np.ptp(times) for times, _, _ in parts)
    step = min(float(np.median(np.diff(times))) for times, _, _ in parts)
    lowest, highest = 1 / longest, 0.5 / step
    if not CYCLES * lowest < highest:
        return None
    count = min(int(2 * (highest - lowest) * longest) + 2, MOST_FREQUENCIES)
    frequency = np.linspace(lowest, highest, count)
    total, swing = np.zeros(count), np.zeros(count)
    for times, white, residual in parts:
        white, residual = white - white.mean(), residual - residual.mean()
        total += signal.lombscargle(times, white, 2 * np.pi * frequency) / max(np.mean(white**2), 1e-300)
        swing += 4 * signal.lombscargle(times, residual, 2 * np.pi * frequency) / len(times)  # squares of amplitudes
    place = int(np.argmax(total))
    p = min(1.0, count * float(special.gammaincc(len(parts), total[place])))
    amplitude = float(np.sqrt(swing[place] / len(parts)))
    return Spectrum(int(channel), frequency, total / len(parts), float(frequency[place]), p, amplitude, CYCLES * lowest)


def common_pattern(table):
    """(variable, share): the variable that residuals go with most in all recordings alike, and what share of their mean square
    its bins hold beyond what chance puts there; None where there is none."""
    angles_alone = "time" in table and have_unit(table["channel"], "rad").all()
    inputs = [name for name in table if name in INPUTS] or ["input"]
    variables = ["time"] if angles_alone else ["time", "height", "speed", "layer", *inputs]
    found = [(name, _binned(table, name)) for name in variables if name in table]
    return max(found, key=lambda each: each[1], default=None)


def _binned(table, name):
    """Share of the mean square of residuals that the means of bins of a variable hold, channel by channel, less chance."""
    values = np.asarray(table[name], float)
    edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)[1:-1]))
    return _held_by_means(np.asarray(table["channel"]) * (BINS + 1) + np.searchsorted(edges, values), table)


def own_offset(table):
    """Share of the mean square of residuals that one offset of each recording and channel holds, less chance [-]."""
    return _held_by_means(table["trial"] * len(CHANNELS) + table["channel"], table)


def _by_setting(table):
    """Share of the mean square of residuals that the means of rows of equal inputs hold, less chance [-]."""
    inputs = [values for name, values in table.items() if name in INPUTS]
    if not inputs:
        return 0.0
    _, label = np.unique(np.column_stack(inputs), axis=0, return_inverse=True)
    return _held_by_means(label.reshape(-1), table)


def _held_by_means(label, table):
    """Share of the mean square of residuals that the mean of each label (n,) holds, less chance; 0 where chance alone may do as
    much to white ones (F test) [-]."""
    _, index, counts = np.unique(label, return_inverse=True, return_counts=True)
    freedom = len(index) - len(counts)

    def within(residuals):
        """Part of the sum of squares that the means leave."""
        means, total = np.bincount(index, residuals) / counts, float(np.sum(residuals**2))
        return max(float(np.sum((residuals - means[index]) ** 2)) / total, 1e-12) if total > 0 else 1.0

    beside = within(_white(table)) if freedom > 0 else 1.0
    if special.fdtrc(len(counts), max(freedom, 1), (1 / beside - 1) * freedom / len(counts)) > UNLIKELY:
        return 0.0
    return max(0.0, 1 - within(table["sigmas"]) * len(index) / freedom)


def _white(table):
    """The white residuals of a table of observations (n,); those in sigmas where nothing correlates them."""
    return table.get("white", table["sigmas"])


def neighbours(table):
    """Correlation of each white residual with the next one of its recording and channel [-]."""
    chain, white = table["trial"] * len(CHANNELS) + table["channel"], _white(table)
    pairs = chain[1:] == chain[:-1]
    here, following = white[:-1][pairs], white[1:][pairs]
    return float(here @ following / max(np.sqrt((here @ here) * (following @ following)), 1e-300))


def few_recordings(table):
    """(indices of the recordings, share) that hold MOST of what is more than noise, where these are at most half of all, and each
    of them holds more a sample than the others by more than chance (F test); None where it is spread over more, or there is no
    more than noise."""
    trials, index, counts = np.unique(table["trial"], return_inverse=True, return_counts=True)
    squares = np.bincount(index, _white(table) ** 2)
    order, more = np.argsort(-squares / counts, kind="stable"), float(np.sum(squares - counts))
    if not (special.chdtrc(len(index), squares.sum()) < UNLIKELY and more < np.inf):
        return None
    held = np.cumsum((squares - counts)[order]) / more
    few, others = np.split(order, [int(np.argmax(held >= MOST)) + 1])
    if len(few) > len(others):
        return None
    rest = counts[others].sum()
    ratio = squares[few] / counts[few] / max(squares[others].sum() / rest, 1e-300)
    apart = special.fdtrc(counts[few], rest, ratio) < UNLIKELY / len(trials)
    return (trials[np.sort(few)], min(float(held[len(few) - 1]), 1.0)) if apart.all() else None


def one_level(table):
    """(input, its value, share) where MOST of what is more than noise is in the rows of one value of an input alone, as
    `few_recordings` tells it, of three values or more; None elsewhere."""
    for name in (name for name in table if name in INPUTS):
        values, index = np.unique(table[name], return_inverse=True)
        few = few_recordings(table | {"trial": index.reshape(-1)}) if len(values) > 2 else None
        if few and len(few[0]) == 1:
            return name, float(values[few[0][0]]), few[1]
    return None


def likeness(table, channels=(), units=(), trials=()):
    """What the residuals of a table of observations look like, in a sentence without its full stop; trials: names of the
    recordings."""
    few = few_recordings(table) if "time" in table and trials else None
    if few:
        inside, names = np.isin(table["trial"], few[0]), [trials[index] for index in few[0]]
        which = joined(names) if len(names) <= NAMED else f"{len(names)} of {len(trials)} recordings"
        there = likeness({name: values[inside] for name, values in table.items()}, channels, units)
        alone = f"{told_share(few[1])} of what is more than noise is in {which} alone"
        return f"{alone}: look for what was different there; in {'it' if len(names) == 1 else 'them'} {there}"
    if "time" not in table and (level := one_level(table)):
        name, value, part = level
        rows = f"{told_share(part)} of what is more than noise is in rows of {name} = {value:g} alone"
        return f"{rows}: look for what was different there, and for what is stated of them"
    swings, held = _swings(table)
    if swings and max(held) <= SHOWN:  # seen beyond doubt, and little of what is left: no cause of it
        where = f" in {channels[swings[0].channel]}" if channels else ""
        beside = f"beside it a swing of {swings[0].peak:.2g} times a second{where} holds {told_share(held[0])} of it"
        return f"{_unswinging(table)}; {beside}"
    swings = [each for each, part in zip(swings, held, strict=True) if part > SHOWN]
    if swings:
        found = swings[0]
        alike = [each.channel for each in swings if abs(each.peak - found.peak) < found.slowest / CYCLES]
        channel = f" in {joined(channels[each] for each in sorted(alike))}" if channels else ""
        widest = max(each.amplitude for each in swings if each.channel in alike)
        size = f", {1e3 * widest:.2g} mm to either side" if units and all(units[each] == "m" for each in alike) else ""
        return f"it swings {found.peak:.2g} times a second{channel} (a period of {1 / found.peak:.2g} s{size})"
    return _unswinging(table)


def _swings(table):
    """([Spectrum of each channel where a period hides], [what share of what is left in its channel it holds])."""
    swings = [each for each in spectra(table) if each.hides_a_period]
    return swings, [_held_by(table, each) for each in swings]


def camera_swings(table, channels):
    """How often a second positions swing where that is a good part of what is left in them [Hz], as a camera that shakes makes
    them do; None where they do not."""
    seen = [
        each.peak
        for each, part in zip(*_swings(table), strict=True)
        if part > SHOWN and channels and channels[each.channel] in ("x", "y", "z")
    ]
    return seen[0] if seen else None


def turns_missed(pictures):
    """(before, after): root mean square of what is missed of rotations [rad] that are measured beside positions, else None."""
    found = []
    if not pictures or not pictures.channels:
        return None
    for table in (pictures.before, pictures.after):
        turns = have_unit(table["channel"], "rad")
        if turns.all() or not turns.any():
            return None
        found.append(float(np.sqrt(np.mean(np.square(table["residual"][turns])))))
    return tuple(found)


def _held_by(table, swing):
    """Share of the mean square of the residuals of its channel that a swing of a Spectrum holds [-]."""
    residual = table["residual"][table["channel"] == swing.channel]
    return min(1.0, swing.amplitude**2 / 2 / max(float(np.mean(residual**2)), 1e-300))


def _unswinging(table):
    """What residuals look like, periods aside."""
    common = common_pattern(table)
    if common and common[1] > SHOWN:
        alike = "recordings" if "time" in table else "sets" if "layer" in table else "groups"
        together = f" in the same way in all {alike}" if len(np.unique(table["trial"])) > 1 else ""
        return f"{100 * common[1]:.0f} % of it goes with {WORDS.get(common[0], common[0])}{together}"
    tabulated = "time" not in table
    if tabulated and _by_setting(table) > SHOWN:
        return "it goes with the settings of the rows, and not with one input alone: rows of equal inputs miss alike"
    offset = own_offset(table)
    if offset > SHOWN:
        return f"{100 * offset:.0f} % of it is an offset that each {'group of rows' if tabulated else 'recording'} has of its own"
    if tabulated:
        return "it goes with no input: rows scatter more than the noise says"
    drift = neighbours(table)
    if drift > ALIKE:
        return (
            f"it drifts slowly, in each recording in a way of its own (neighbouring residuals are alike to {100 * drift:.0f} %)"
        )
    return "it has no pattern that could be named: it scatters from sample to sample, more than the noise says"
