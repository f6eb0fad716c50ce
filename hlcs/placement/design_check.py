"""A design run again with new seeds and frictions: how often it reaches a height, beside how often the simulation promised.

The promise is that of one more run (`Budget.reaches_simulated`); the model's own error has no part in it, as runs of the model
cannot show that. All new runs share what mean and scatter of the first ones are wrong by. So beside the binomial interval of the
count stands one that has that in it; only what is outside of it speaks against the promise.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import stats

from hlcs.placement import run_queue
from hlcs.placement.design import checked, heights_of, row_of
from hlcs.placement.design_budget import FRICTIONS
from hlcs.placement.number_text import chance
from hlcs.placement.run_store import Store, key_of
from hlcs.placement.settings_table import settings_of
from hlcs.placement.single_run import result_of
from minibullet.errors import InputError

PROMISES = (0.95, 0.84, 0.5, 0.16, 0.05)  # what else is counted: heights that the simulation promises so often
INTERVAL = (0.025, 0.975)
DRAWS = 20_000


class Reached(NamedTuple):
    """A height, and how many of the new runs reached it."""

    height: float  # or level of the crest [m]
    promised: float  # probability that one more run reaches it
    runs: int
    reached: int
    binomial: tuple[int, int]  # 95 % of counts lie between, where each run has that probability
    expected: tuple[int, int]  # the same where mean and scatter are known from the first runs only

    @property
    def kept(self):
        """Whether so many reached it as was to be expected."""
        return self.expected[0] <= self.reached <= self.expected[1]


def new_tests(design, count):
    """So many tests of the chosen option: the seeds that follow the design's own, frictions drawn evenly over FRICTIONS."""
    if design.chosen is None:
        raise InputError("design: no option reaches the target, so there is none to be checked; leave out --check")
    wanted, test = design.wanted, design.options[design.chosen].test
    first = wanted.seed + wanted.repeats
    frictions = np.random.default_rng(first).uniform(*FRICTIONS, count)
    return [replace(test, friction=float(friction), seed=first + k) for k, friction in enumerate(frictions)]


def check(design, store_path, count, workers=None, progress=None):
    """Run the chosen option of a `Design` so many times more: a tuple of `Reached`, the wanted height first.

    store_path, workers, progress: as `hlcs.placement.design.design` has them. A run that leaves no structure reaches nothing.
    InputError where no option was chosen or the physics refuses a run.
    """
    tests = {key_of(settings_of(test)): test for test in new_tests(design, count)}
    with Store(store_path, row_of) as store:
        missing = {key: test for key, test in tests.items() if key not in store}
        kept = len(tests) - len(missing)
        done = progress(len(tests), kept) if progress else None
        run_queue.finish(store, missing, result_of, settings_of, workers, None, done, kept)
        stored = run_queue.results(store, tests)
    rows = [checked(row, test) for row, test in zip(stored, tests.values(), strict=True)]
    option = design.options[design.chosen]
    _, crests = heights_of(design.wanted, rows, option.nominal_diameter, option.layers)
    promises = [each for each in PROMISES if each < option.promise.share]
    heights = [design.wanted.target, *map(option.promise.height_at, promises)]
    return tuple(_reached(height, option.promise, crests) for height in heights)


def _reached(height, promise, crests):
    """The `Reached` of a height by a `Promise` and new runs' crests (n,), NaN of a run that left none [m]."""
    count, promised, generator = len(crests), promise.reaches(height), np.random.default_rng(0)
    binomial = stats.binom.ppf(INTERVAL, count, promised)
    expected = np.quantile(generator.binomial(count, promise.drawn(height, DRAWS, generator)), INTERVAL, method="nearest")
    reached = int(np.sum(crests >= height))
    return Reached(float(height), float(promised), count, reached, *(tuple(map(int, pair)) for pair in (binomial, expected)))


def check_lines(reached, noun):
    """What `hlcs design --check` adds to the report; noun: "height" or "level"."""
    first = reached[0]
    lines = [
        f"Checked with {first.runs} new runs of other seeds and frictions: how often a {noun} was reached, beside simulated P",
        f"  {noun + ' m':>10}  promised %  reached  binomial 95 %  with the error of the first runs",
    ]
    for each in reached:
        binomial, expected = (f"{low} to {high}" for low, high in (each.binomial, each.expected))
        row = f"  {each.height:>10.3f}  {chance(each.promised):>10}  {each.reached:>7}  {binomial:>13}  {expected:>13}"
        lines.append(row if each.kept else f"{row}   outside")
    return lines
