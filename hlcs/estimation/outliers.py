"""Outliers of a tracker: samples that stand alone are set aside, once and for all models; how many stay is told to the draws."""

from operator import le
from typing import NamedTuple

import numpy as np
from scipy import special

STANDS_OUT = 4.0  # standard deviations of a second difference: of 10,000 samples of normal noise less than one lies beyond
FORETOLD_OUT = 3.0  # the same of an end from what is foretold of it, where it stands out from its neighbours as well
PASSES = 3  # neighbours of outliers are outliers too: of three per cent, one in 1,000 stands third in a row
ROUGHER = 5  # looks at most at the scatter of what is left: each raises it where it was too small, the second nearly to its end
UNSURE = 3.0  # over the root of their number: by so much the scatter of normal noise seems larger than it is once in 40 series
END = 1.29  # scatter of white noise about what the next four samples foretell, that about the line through two neighbours being 1
AT_ONE_PLACE = 1e-4  # chance of as many outliers at one end, or in a row, of the series: of nine channels of each set of data
LEAST_OF_A_SCATTER = 10  # samples of which a scatter can be told
CORE = 3.3  # standard deviations within which 99.9 % of normal noise lies: what is beyond is counted as outliers that stayed
BEYOND_CORE = 0.000967  # part of normal noise that lies beyond it all the same
CORE_VARIANCE = 0.98865  # of normal noise that is cut there


class Tail(NamedTuple):
    """Outliers too small to be told from noise one by one."""

    share: float  # of all samples
    sizes: np.ndarray  # of such as were seen [standard deviations of the noise without them]

    @property
    def variance(self):
        """What they add to the variance of the noise [part of it]."""
        return self.share * (float(np.mean(self.sizes**2)) - 1) if self.share else 0.0

    def sprinkle(self, generator, white):
        """Put outliers into white noise (n, count), in place."""
        if self.share:
            wild = generator.random(white.shape) < self.share
            white[wild] = generator.choice(self.sizes, int(wild.sum()))


NO_TAIL = Tail(0.0, np.zeros(0))


def tail_of(white):
    """The Tail of whitened samples (n,) of any scale."""
    core = np.std(white)
    for _ in range(10):  # a scale and what lies within it: settles in some steps
        core = np.sqrt(np.mean(white[np.abs(white) <= CORE * core] ** 2) / CORE_VARIANCE)
    beyond = white[np.abs(white) > CORE * core] / core
    share = max(len(beyond) / len(white) - BEYOND_CORE, 0.0)
    return Tail(share, beyond) if share else NO_TAIL


def robust_sigma(distances):
    """Standard deviation of normal noise, of which these are distances from the middle (n,)."""
    return 1.4826 * float(np.median(distances))


def scatter_of(series, spread):
    """Scatter of the values of series [(times (n,), values (n,))] about their neighbours, where that is more than noise of such a
    `spread` has by chance, else that spread."""
    near = np.concatenate([_off_the_line(*one, 1)[1:-1] for one in series if len(one[0]) > 2] or [np.zeros(0)])
    own = robust_sigma(near) if len(near) else 0.0
    return own if own > spread * (1 + UNSURE / np.sqrt(len(near) or 1)) else spread


def isolated_in(series, spreads):
    """`isolated_outliers` of each of the series [(times (n,), values (n,))] of one channel; spreads: of noise alone in each.

    Rough series are measured in the scatter of what is left, of all or their own where that is larger: first in the noise, as
    samples that stand alone make all look rougher than they are, then again, as in rough ones many seem to stand alone.
    """
    scales, noise = list(spreads), max(spreads, default=0.0)
    for _ in range(ROUGHER):
        alone = [isolated_outliers(*one, scale) for one, scale in zip(series, scales, strict=True)]
        kept = [(times[~its], values[~its]) for (times, values), its in zip(series, alone, strict=True)]
        rough = scatter_of(kept, noise) / noise if noise else 1.0
        own = [max(scatter_of([one], spread), rough * spread) for one, spread in zip(kept, spreads, strict=True)]
        if rough == 1.0 or all(map(le, own, scales)):
            break
        scales = list(map(max, own, scales))
    return anywhere(alone)


def anywhere(alone):
    """Flags of samples that stand alone, one (n,) for each series, without those that lie where chance does not put so many,
    changed in place: first ones, last ones, and PASSES in a row.

    What a tracker loses lies anywhere. Series begin and end where the motion does: what stands alone there in most of them is
    part of the motion, as of a spin that ends within a sample. So is what stands out in a row in more than one of them, as all
    of a fall of three samples before a long rest.
    """
    long = [flags for flags in alone if len(flags) >= LEAST_OF_A_SCATTER]
    count, total = sum(map(np.sum, long)), sum(map(len, long))
    for end in (0, -1):
        there = sum(bool(flags[end]) for flags in long)
        if special.bdtrc(there - 1, len(long), (count - there + 1) / (total + 1)) < AT_ONE_PLACE:
            for flags in long:
                flags[end] = False
    rows = [in_a_row(flags) for flags in long]
    there = sum(bool(row.any()) for row in rows)
    share = (sum(map(np.sum, long)) - sum(map(np.sum, rows)) + 1) / (total + 1)
    if there > 1 and special.bdtrc(there - 1, len(long), min(share**PASSES * total / len(long), 1.0)) < AT_ONE_PLACE:
        for flags, row in zip(long, rows, strict=True):
            flags[row] = False
    return alone


def in_a_row(flags):
    """Which of flags (n,) stand beside others, PASSES of them or more."""
    starts = np.flatnonzero(np.convolve(flags, np.ones(PASSES), "valid") > PASSES - 0.5)
    row = np.zeros(len(flags), bool)
    row[(starts[:, None] + np.arange(PASSES)).ravel()] = True
    return row


def isolated_outliers(times, values, spread=0.0):
    """Samples of a series that stand alone: boolean (n,).

    Each sample is compared with the line through its two neighbours; smooth misfit of a model leaves little mark on that. What
    is left is measured in `spread`, that of noise, or in its own robust scatter where none is known. The largest go first and
    their neighbours are looked at again. A kink, as an impact leaves in the residuals of a wrong model, stands out however many
    samples are taken from it, so there none is; nor are PASSES in a row at an end that rise or fall steadily, and go on to: there
    a wrong drag leaves a bend.
    """
    kept = np.arange(len(values))
    for _ in range(PASSES):
        flags = _standing_out(times[kept], values[kept], spread)
        if not flags.any():
            break
        kept = kept[~flags]
    isolated = np.ones(len(values), bool)
    isolated[kept] = False
    for place in kept[_standing_out(times[kept], values[kept], spread)]:
        isolated[max(place - PASSES, 0) : place + PASSES + 1] = False
    for flags, seen in ((isolated, values), (isolated[::-1], values[::-1])):
        steady = abs(np.sign(np.diff(seen[: PASSES + 2])).sum()) == PASSES + 1
        if steady and flags[:PASSES].all():
            flags[: np.argmin(flags)] = False
    return isolated


def _standing_out(times, values, spread):
    """Samples farther from the line through their neighbours than noise is, and the farthest there: boolean (n,)."""
    flags = np.zeros(len(values), bool)
    if len(values) < LEAST_OF_A_SCATTER:
        return flags
    near, far = _off_the_line(times, values, 1), _off_the_line(times, values, 2)
    unknown = spread <= 0
    if unknown:
        spread = robust_sigma(near[1:-1])
    if spread <= 0:
        return flags
    far[[0, 1, -2, -1]] = near[[0, 1, -2, -1]]
    size = near + far  # of two outliers beside each other, and of the good samples beside them, `near` is the same
    around = np.maximum(np.r_[0, size[:-1]], np.r_[size[1:], 0])
    flags = (near > STANDS_OUT * spread) & (size >= around)
    for along in (slice(None), slice(None, None, -1)):
        _judge_end(flags[along], near[along], far[along], times[along], values[along], spread, unknown)
    return flags


def _judge_end(flags, near, far, times, values, spread, unknown):
    """Flag the first sample, in place, where it and not its neighbour stands out.

    It marks `near` of the second sample and `far` of the third, the second sample if it is the outlier `near` of the third and
    `far` of the fourth. A smaller one stands out from the samples after it, and from what their slope foretells too.
    """
    if flags[1]:
        flags[0] = far[2] > near[2] + far[3]
        flags[1] = not flags[0]
    elif not flags[2:5].any():
        ahead = _foretold(times, values)
        own = robust_sigma(ahead) if unknown else 0.0
        apart = abs(values[0] - np.median(values[1:5])) > STANDS_OUT * spread
        flags[0] = apart and ahead[0] > FORETOLD_OUT * max(own, END * spread)


def _foretold(times, values):
    """Distance of samples from what those after them foretell: the next one, and the slope from the second to the fourth after;
    less the median of all, (n - 4,)."""
    slope = (values[4:] - values[2:-2]) / (times[4:] - times[2:-2])
    off = values[:-4] - values[1:-3] + slope * (times[1:-3] - times[:-4])
    return np.abs(off - np.median(off))


def _off_the_line(times, values, away):
    """Distance of samples from the line through those `away` before and after, less the median of all, (n,); 0 at the ends."""
    first, last, inner = slice(None, -2 * away), slice(2 * away, None), slice(away, -away)
    after = (times[inner] - times[first]) / (times[last] - times[first])
    off = values[inner] - (1 - after) * values[first] - after * values[last]
    return np.r_[np.zeros(away), np.abs(off - np.median(off)), np.zeros(away)]


def spread_of(noise, times, step):
    """Standard deviation of the second differences of a CorrelatedNoise at these times; step: to which its rho refers."""
    apart = float(np.median(np.diff(times))) / step
    near, far = ((1 - noise.white) * noise.rho ** (away * apart) for away in (1, 2))
    return noise.sigma * np.sqrt(1.5 - 2 * near + far / 2)
