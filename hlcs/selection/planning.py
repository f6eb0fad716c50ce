"""Before the experiment: how many recordings, how long and how precise, find an effect of a stated size.

A pilot shows what the effect would change: the white difference of two simulations, initial states projected out, has the squared
length lambda. When the p numbers of the effect are fitted, chi2 falls by a number that follows the noncentral chi-square
distribution with p degrees of freedom and noncentrality lambda. The effect is found where that fall exceeds what a search asks:
the cost of the set (`Search.price`, `occam`, `Free.surprise`), and what held-out recordings must show (`HeldOut.broken`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy import optimize, special

from hlcs.estimation.least_squares import largest_cosine
from hlcs.estimation.linearization import occam
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.records import Plan
from hlcs.selection.eligibility import lacks_drag
from hlcs.selection.experiment_design import MOST_TESTS, tests_needed
from hlcs.selection.other_lengths import lasting, length_of
from hlcs.selection.search import Search
from hlcs.selection.thresholds import BY_CHANCE, FALL, ODDS, ODDS_ALONE
from hlcs.simulation.model import Term
from minibullet.errors import InputError, is_number

LOOK_ALIKE = 0.95  # cosine of two signatures from which a tenth of the noncentrality, or less, tells them apart: 1 - 0.95^2
SHARPEST = 1e-3  # noise, in parts of the pilot's, below which no tracker is looked for
QUANTILES = special.ndtri(0.5 + (np.arange(20) + 0.5) / 40)  # of the size of a normal deviate


@dataclass(frozen=True)
class Pilot:
    """Existing data of one kind, as what other experiments would be like."""

    candidates: list  # all that can act, by name
    absent: dict  # name -> why it cannot
    prepare: Callable[[], Any]  # -> kinds.protocol.Prepared
    hold_out: bool  # is there anything that could be held out?
    few_below: float  # recordings below which each half must show a fall of its own
    count: int  # recordings, or rows of a table
    what: str = "recordings"


class Signal(NamedTuple):
    """What an effect of a stated size does in one recording, on average over those of a pilot."""

    noncentrality: float
    information: np.ndarray  # on its numbers, in units of their spreads (p, p)
    count: float  # observations
    freedom: float  # observations less unknowns of the start
    raw: float  # squared length of the signature in units of sigma, over that of the white one

    def at_noise(self, share):
        """The same with so many times the noise."""
        return self._replace(noncentrality=self.noncentrality / share**2, information=self.information / share**2)


@dataclass(frozen=True)
class Odds:
    """What a search asks of an effect before it is found."""

    paid: float  # price and surprise
    by_chance: float | None  # squared deviation in which held-out recordings must agree; None = nothing is held out
    few_below: float

    def power(self, signal, count):
        """Probability that it is found in so many recordings (m,); their halves are taken to be equal."""
        count, numbers = np.asarray(count, dtype=float), len(signal.information)
        noncentrality = count * signal.noncentrality
        least = self.paid + np.array([occam(n * signal.information, n * signal.count) for n in count])[:, None]
        if self.by_chance is not None:
            least = np.maximum(least, self.held_out(count[:, None], signal, numbers))
        least = np.maximum(least, 0.0)  # what the file implies is there at any fall
        return np.mean(1 - special.chndtr(least, numbers, noncentrality[:, None]), axis=1)

    def held_out(self, count, signal, numbers):
        """The fall of chi2 with which the rules of `HeldOut.broken` are kept (m, quantiles).

        Let z be the sum and d the difference of what two equal halves say of the numbers, over sqrt(2): the fall is z^2, both
        have unit variance, and d has no mean. The fall on held-out halves is z^2 - 3 d^2 together and at least half of
        z^2 - 2 |z d| - 3 d^2 in each; the deviation by which it is told from chance is (z^2 - d^2) / sqrt(z^2 + d^2).
        """
        d2 = QUANTILES**2 + numbers - 1
        share = (1 - (1 - FALL) ** 2) * count * (signal.freedom / signal.raw + signal.noncentrality)
        by_chance = d2 + (self.by_chance + np.sqrt(self.by_chance**2 + 8 * self.by_chance * d2)) / 2
        together = np.maximum(share + 3 * d2, by_chance)
        each, any_fall = ((QUANTILES + np.sqrt(QUANTILES**2 + 3 * d2 + asked)) ** 2 for asked in (share, 0.0))
        return np.where(count < self.few_below, np.minimum(each, np.maximum(together, any_fall)), together)

    def recordings(self, signal, power):
        """The smallest number of recordings with this power; None beyond MOST_TESTS."""
        counts = np.arange(1 if self.by_chance is None else 2, MOST_TESTS + 1)
        enough = np.flatnonzero(self.power(signal, counts) >= power)
        return int(counts[enough[0]]) if len(enough) else None

    def noise(self, signal, count, power):
        """The largest noise, in parts of the pilot's, with which so many recordings have this power; None where none has."""
        ends = np.log(SHARPEST), np.log(1 / SHARPEST)

        def lacking(logarithm):
            return float(self.power(signal.at_noise(np.exp(logarithm)), [count])[0]) - power

        if lacking(ends[0]) < 0 or lacking(ends[1]) > 0:
            return None
        return float(np.exp(optimize.brentq(lacking, *ends, xtol=1e-3)))


def plan(experiment, effect, at, power=0.9):
    """The Plan to find an effect of numbers {name: value} with this power, from an OpenExperiment that serves as the pilot."""
    if not 0 < power < 1:
        raise InputError(f"power = {power:g}; it is a probability between 0 and 1, such as 0.9")
    pilot = experiment.pilot(effect)
    if effect in pilot.absent:
        raise InputError(f"{effect} cannot act in these data: {pilot.absent[effect]}")
    (entry,) = (each for each in pilot.candidates if each.name == effect)
    numbers = stated_numbers(entry, at)
    prepared = pilot.prepare()
    problem, base = prepared.problem, prepared.base
    if problem is None:
        raise InputError(f"the noise of the pilot is unknown, so nothing can be planned: {experiment.advice}")
    if lacks_drag(entry, base.model.kinds):
        raise InputError(f"{effect} acts through a drag alone, and the model has none; state one in [model] effects")
    plus = base.model.with_term(Term(entry, tuple(numbers.items())))
    signal = signal_of(problem, base, plus, pilot.count)
    if not np.isfinite(signal.noncentrality):
        raise InputError(f"{effect} with {_told(numbers)}: with these numbers the pilot cannot be simulated")
    search = Search(problem, pilot.candidates, base, ODDS if pilot.hold_out else ODDS_ALONE)
    look_alikes = beside(search, plus)
    odds = _odds(search, entry, numbers, pilot)
    options = _options(odds, power, pilot, problem, list(_signals(problem, base, plus, pilot.count, signal)))
    first = options[0]
    return Plan(
        effect=effect,
        at=numbers,
        power=power,
        what=pilot.what,
        noncentrality=pilot.count * signal.noncentrality,
        now={"recordings": pilot.count, "power": first["power"]},
        needed={name: first[name] for name in ("recordings", "length_s", "sigma", "unit")},
        options=options,
        look_alikes=tuple(
            {"effect": name, "cosine": cosine, "recordings": tests_needed(signal.noncentrality * (1 - cosine**2))}
            for name, cosine in look_alikes.items()
        ),
        notes=tuple(_notes(pilot, search, odds, signal, entry, at)),
    )


def stated_numbers(entry, at):
    """All numbers of a Candidate {name: value}: those of `at`, the others where a fit begins; InputError where one cannot be."""
    frees = {free.name: free for free in entry.free}
    for name, value in at.items():
        if name not in frees:
            raise InputError(f"{entry.name} has no parameter '{name}' to be found; it has {', '.join(frees)}")
        if not is_number(value):
            raise InputError(f"{entry.name}: {name} = {value!r} must be a finite number")
        free = frees[name]
        if free.period is None and free.inside(value) != value:
            raise InputError(f"{entry.name}: {name} = {value:g}; its law holds {_range(free)}")
    numbers = entry.start | {name: float(value) for name, value in at.items()}
    if entry.absent is not None and all(free.null in (None, numbers[free.name]) for free in entry.free):
        raise InputError(f"{entry.name} with {_told(numbers)} is absent; state a size that you want to find")
    return numbers


# --- what the effect does in recordings of this and of other lengths ---------------------------------------------------------


def signal_of(problem, base, plus, count):
    """The Signal of what the model `plus` has more than that of the Fit `base`; count: of recordings."""
    changes = problem.signature(base.model, base.initial_states, plus)
    linear = problem.linearise(plus, base.initial_states)
    left = linear.without_states(changes)
    size, raw = (float(sum(part @ part for part in parts)) for parts in (left, problem.in_sigmas(left)))
    spread = np.array([free.spread for free in plus.terms[-1].candidate.free])
    columns = np.concatenate(linear.projected[1])[:, -len(spread) :] * spread
    observations = sum(map(len, left))
    free = observations - sum(q.shape[1] for q in linear.state_bases)
    ratio = raw / size if size > 0 else 1.0
    return Signal(size / count, columns.T @ columns / count, observations / count, max(free, 1) / count, ratio)


def _signals(problem, base, plus, count, now):
    """[(what is changed, length in parts of the pilot's, noise likewise, Signal)], the pilot as it is first."""
    yield "as now", 1.0, 1.0, now
    yield "half the noise", 1.0, 0.5, now.at_noise(0.5)
    if isinstance(problem, TrajectoryProblem) and not problem.segmented:
        for factor, change in ((2.0, "twice as long"), (0.5, "half as long")):
            other = lasting(problem, base, factor)
            signal = other and signal_of(other, base, plus, count)
            if signal and np.isfinite(signal.noncentrality):
                yield change, factor, 1.0, signal


# --- what a search asks ------------------------------------------------------------------------------------------------------


def beside(search, plus):
    """{look-alike of the newest effect of the model `plus`: cosine in the pilot}; what the file implies is then known."""
    problem, base, effect = search.problem, search.base, plus.terms[-1].name
    views, linear = search.linear_at(base, list(search.candidates.values()))

    def projected(parts):
        return np.concatenate(base.linearization.without_states(parts))

    its = projected(problem.signature(base.model, base.initial_states, plus))[:, None]
    cosines = {
        entry.name: max(largest_cosine(its, projected(columns)) for _, columns in choices)
        for entry, choices in views.items()
        if entry.name != effect and entry.name in linear.entries and linear.visible(entry.name)
    }
    search.implied_alone, search.implied = linear.certain(search.odds, search.candidates)
    return {name: cosine for name, cosine in cosines.items() if cosine > LOOK_ALIKE}


def _range(free):
    """Where the law of a number holds, in words."""
    if np.isfinite([free.least, free.most]).all():
        return f"from {free.least:g} to {free.most:g}"
    return f"from {free.least:g} on" if np.isfinite(free.least) else f"up to {free.most:g}"


def _odds(search, entry, numbers, pilot):
    """The Odds of an effect at these numbers, in a search over all candidates."""
    price = search.price(search.implied | {entry.name}) - search.price(search.implied - {entry.name})
    held_out = pilot.hold_out and entry.name not in search.implied
    deviation = -special.ndtri(min(BY_CHANCE / len(pilot.candidates), 0.5))
    return Odds(price + entry.surprise(numbers), float(deviation**2) if held_out else None, pilot.few_below)


# --- what is told ------------------------------------------------------------------------------------------------------------


def _options(odds, power, pilot, problem, signals):
    """Rows {change, recordings, length_s, sigma, unit, noncentrality, power}; the pilot as it is first."""
    sigma, length = problem.noise_level, length_of(problem)

    def row(change, factor, share, signal, needed):
        return {
            "change": change,
            "recordings": needed,
            "length_s": None if length is None else factor * length,
            "sigma": share * sigma,
            "unit": problem.unit,
            "noncentrality": signal.noncentrality,
            "power": float(odds.power(signal, [pilot.count])[0]),
        }

    rows = [row(*each, odds.recordings(each[-1], power)) for each in signals]
    now = signals[0][-1]
    share = odds.noise(now, pilot.count, power)
    if share is not None:
        rows.append(row("as many as now", 1.0, share, now.at_noise(share), pilot.count))
    return tuple(rows)


def _notes(pilot, search, odds, signal, entry, at):
    """Sentences on what the plan rests on."""
    if not pilot.hold_out:
        yield (
            f"nothing can be held out of the pilot, so the odds against an effect are {ODDS_ALONE:g} in place of {ODDS:g}: give "
            "the recordings at least two groups, and hold one of them out"
        )
    else:
        yield f"the {pilot.what} must stand in at least two groups, of about equal size, so that one is held out"
    left = {free.name: entry.start[free.name] for free in entry.free if free.name not in at}
    if left:
        yield f"not stated, and taken as {_told(left)}"
    if not signal.noncentrality > 1e-9:
        yield f"{entry.name} of this size changes nothing here that the unknown starts do not absorb: state the starts"
    elif odds.by_chance is not None and signal.raw * signal.noncentrality < (1 / (1 - FALL) ** 2 - 1) * signal.freedom:
        yield (
            f"an effect of this size lowers the held-out error by less than {100 * FALL:g} %, which is never accepted, however "
            "many there are: only less noise or other experiments help"
        )
    if not search.noise_alone(search.base):
        yield "the pilot already holds more than noise that the model under test does not explain: see hlcs diagnose"


def _told(numbers):
    return ", ".join(f"{name} = {value:g}" for name, value in numbers.items())
