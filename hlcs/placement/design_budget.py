"""What the height of a planned structure is uncertain by, and how surely it reaches a target.

Three parts, added as the Guide to the expression of uncertainty in measurement adds them (JCGM 100:2008, sections 5.1.2 and G.4):

seeds      how runs of one friction differ: the scatter about a straight line of height against friction; n - 2 degrees of freedom
friction   nobody knows it better than FRICTIONS: evenly spread between the two, the line's slope times (0.6 - 0.36) / sqrt(12)
model      the laboratory's heights over this model's, a ratio a campaign: their mean corrects the height, their scatter is the
           error of that

The probability is that of Student's distribution with the effective degrees of freedom of seeds and model (Welch-Satterthwaite),
averaged over the friction. Without the model's part and its correction it is what repeated runs should show.
"""

from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np
from scipy import optimize, special

from minibullet.errors import InputError

FRICTIONS = (0.36, 0.6)  # of a contact: what Bullet makes of the paper's 0.6, and 0.6 itself (docs/errata.md)
NODES = 41  # frictions that the probability is averaged over
BRACKET = 20.0  # standard deviations from the mean within which a promised height lies: Student's tails are fat


class Campaign(NamedTuple):
    """A campaign of the laboratory beside the model."""

    title: str  # what was measured
    source: str  # table, section, column
    measured: float  # total height [Dn]
    model: float  # mean total height of the model's runs [Dn]
    tests: float  # of the laboratory
    runs: int  # of the model


class Line(NamedTuple):
    """A straight line through heights against friction, by least squares."""

    mean: float  # height at the mean friction [m]
    slope: float  # [m] per unit of friction
    scatter: float  # standard deviation about the line [m]
    count: int
    middle: float  # mean friction

    @property
    def one_more(self):
        """Standard deviation of one more run about the line, s sqrt(1 + 1/n) [m]. What the slope may be wrong by is left out:
        over frictions spread as evenly as those of the runs it raises one half and lowers the other."""
        return self.scatter * np.sqrt(1.0 + 1.0 / self.count)

    def at(self, friction):
        """Expected heights at frictions (k,) [m]."""
        return self.mean + self.slope * (friction - self.middle)


class Promise(NamedTuple):
    """What one more run reaches, its friction drawn evenly over FRICTIONS; the model's own error has no part in it."""

    line: Line  # height or level of the crest against friction [m]
    share: float  # of the runs that left a structure

    def reaches(self, target):
        """Probability that it reaches a height or level `target` [m]."""
        return self.share * _exceeds(target, self.line, _nodes())

    def drawn(self, target, count, generator):
        """So many chances that a run reaches `target`, (count,): any may be the true one, as mean and scatter are known from few
        runs. Their errors are drawn from the laws that Student's distribution is made of."""
        line, degrees = self.line, self.line.count - 2
        scatter = line.scatter * np.sqrt(degrees / generator.chisquare(degrees, count))
        shift = scatter * generator.standard_normal(count) / np.sqrt(line.count)
        return self.share * special.ndtr((line.at(_nodes()) + (shift - target)[:, None]) / scatter[:, None]).mean(axis=1)

    def height_at(self, probability):
        """The height or level that it reaches with a probability below `share` [m]."""
        low, high = FRICTIONS
        deviation = float(np.sqrt(self.line.one_more**2 + self.line.slope**2 * (high - low) ** 2 / 12.0))
        far = BRACKET * deviation
        return float(
            optimize.brentq(lambda height: self.reaches(height) - probability, self.line.mean - far, self.line.mean + far)
        )


@dataclass(frozen=True)
class ModelRatio:
    """The laboratory's total heights over the model's."""

    campaigns: tuple[Campaign, ...]

    @property
    def ratios(self):
        """One a campaign (n,) [-]."""
        return np.array([campaign.measured / campaign.model for campaign in self.campaigns])

    @property
    def mean(self):
        """Their mean: what corrects a height of the model [-]."""
        return float(self.ratios.mean())

    @property
    def deviation(self):
        """Standard deviation of one more such ratio, s sqrt(1 + 1/n) [-]; `degrees` of freedom."""
        return float(np.std(self.ratios, ddof=1) * np.sqrt(1.0 + 1.0 / len(self.ratios)))

    @property
    def degrees(self):
        return len(self.ratios) - 1

    def to_dict(self):
        """Plain numbers."""
        rows = [campaign._asdict() | {"ratio": ratio} for campaign, ratio in zip(self.campaigns, self.ratios, strict=True)]
        return {"ratio": self.mean, "sd": self.deviation, "degrees_of_freedom": self.degrees, "campaigns": rows}


@dataclass(frozen=True)
class Budget:
    """How high, how surely, and why not more surely. Lengths in m; a level where a level of the crest was asked for."""

    height_m: float  # expected: the mean of the runs, corrected by the mean ratio
    height_sd_m: float  # root of the sum of the three variances
    reaches: float  # probability that the target is reached
    height_at_probability_m: float  # what is reached with the wanted probability
    simulated_height_m: float  # mean of the runs
    reaches_simulated: float  # probability that one more run, of a friction drawn evenly, reaches the target
    standing_share: float  # of the runs that left a structure whose top could be measured; both probabilities count it
    variance_shares: dict  # of seeds, friction and model in the square of height_sd_m

    def to_dict(self):
        """The fields by their names; None where no run stands."""
        return {name: _plain(value) for name, value in asdict(self).items()}


def model_ratio(campaigns):
    """The ModelRatio of (LayerTable, total heights [Dn] of the model's runs) pairs; InputError where no run left a height."""
    found = []
    for table, heights in campaigns:
        known = np.array(heights, dtype=float)
        known = known[np.isfinite(known)]
        if not len(known):
            raise InputError(f"design: no run beside '{table.title}' left a height, so the model's error is not known")
        mean, tests = float(known.mean()), float(np.nanmax(table.tests))
        found.append(Campaign(table.title, table.source, table.height_over_dn, mean, tests, len(known)))
    return ModelRatio(tuple(found))


def line_through(friction, heights):
    """The Line of heights (n,) against friction (n,), n >= 3."""
    away = friction - friction.mean()
    spread = float(away @ away)
    slope = float(away @ heights) / spread
    left = heights - heights.mean() - slope * away
    scatter = float(np.sqrt(left @ left / (len(heights) - 2)))
    return Line(float(heights.mean()), slope, scatter, len(heights), float(friction.mean()))


def budget_of(wanted, friction, heights, crests, ratio):
    """The Budget of an option.

    wanted: `target` [m] and `probability`; friction, heights above the bed, crests: heights or levels that count (n,) of its runs
    [m], NaN of a run that left none; ratio: ModelRatio, which corrects the height and leaves the bed where it is.
    """
    known = np.isfinite(heights) & np.isfinite(crests)
    share = float(known.mean())
    if known.sum() < 3:
        return Budget(*[np.nan] * 2, 0.0, np.nan, np.nan, 0.0, share, dict.fromkeys(("seeds", "friction", "model"), np.nan))
    friction, heights, crests = friction[known], heights[known], crests[known]
    promise = Promise(line_through(friction, crests), share)
    corrected = line_through(friction, crests + (ratio.mean - 1.0) * heights)
    error = float(heights.mean()) * ratio.deviation
    low, high = FRICTIONS
    nodes = _nodes()
    variances = {"seeds": corrected.one_more**2, "friction": corrected.slope**2 * (high - low) ** 2 / 12.0, "model": error**2}
    whole = sum(variances.values())

    def reached(target):
        return share * _exceeds(target, corrected, nodes, error, ratio.degrees)

    return Budget(
        corrected.mean,
        float(np.sqrt(whole)),
        reached(wanted.target),
        _height_at(reached, wanted.probability, corrected.mean, float(np.sqrt(whole))) if share >= wanted.probability else np.nan,
        promise.line.mean,
        promise.reaches(wanted.target),
        share,
        {name: variance / whole if whole > 0.0 else np.nan for name, variance in variances.items()},
    )


def _nodes():
    """Frictions that a probability is averaged over, evenly spread over FRICTIONS, (NODES,)."""
    low, high = FRICTIONS
    return low + (high - low) * (np.arange(NODES) + 0.5) / NODES


def _exceeds(target, line, nodes, error=0.0, degrees=1):
    """Probability that a height is above target [m], averaged over frictions `nodes`; error: a standard deviation that all
    heights share [m], of so many degrees of freedom."""
    above, variance = line.at(nodes) - target, line.one_more**2 + error**2
    if variance == 0.0:
        return float(np.mean(above >= 0.0))
    effective = variance**2 / (line.one_more**4 / (line.count - 2) + error**4 / degrees)
    return float(special.stdtr(effective, above / np.sqrt(variance)).mean())


def _height_at(reached, probability, mean, deviation):
    """The height that is reached with a probability [m]."""
    if deviation == 0.0:
        return mean
    far = 1.0
    while reached(mean - far * deviation) < probability:
        far *= 2.0
    return float(optimize.brentq(lambda height: reached(height) - probability, mean - far * deviation, mean + far * deviation))


def _plain(value):
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    return float(value) if np.isfinite(value) else None
