"""What a plan promises: closed forms for lines, and as often found as foreseen where the data are then drawn."""

from types import SimpleNamespace

import numpy as np
import pytest
from linear_models import RATE, Line
from scipy import stats
from throws import csv, drag_per_metre, flight

import hlcs
from hlcs.estimation.cross_validation import FEW_RECORDINGS, CrossValidation
from hlcs.estimation.linearization import occam
from hlcs.kinds import open_experiment
from hlcs.kinds.protocol import Options, Prepared
from hlcs.selection.planning import MOST, Odds, Pilot, Signal, plan
from hlcs.selection.search import Search
from hlcs.selection.sets import FittedSets
from hlcs.selection.thresholds import ODDS, ODDS_ALONE
from hlcs.simulation.model import Model
from minibullet.errors import InputError

TIMES = np.linspace(0.0, 1.0, 12)
SXX = float(np.sum((TIMES - TIMES.mean()) ** 2))


def lines(count, slope=0.0, sigma=1.0, generator=None):
    """Lines of one slope, every second one in the other group."""
    noise = generator.normal(0.0, sigma, (count, len(TIMES))) if generator else np.zeros((count, len(TIMES)))
    problem = Line([TIMES] * count, list(slope * TIMES + noise), sigma, ["ab"[k % 2] for k in range(count)])
    for k, trial in enumerate(problem.trials):
        trial.name = str(k)
    problem.noise, problem.unit = SimpleNamespace(position=sigma), "m"
    return problem


def pilot(problem, hold_out=True):
    """An Experiment that has this problem for its pilot."""
    prepared = Prepared(None, problem, problem.fit(Model()), ())
    known = Pilot([RATE], {"gust": "no wind"}, lambda: prepared, hold_out, FEW_RECORDINGS, len(problem.trials))
    return SimpleNamespace(pilot=lambda effect: known)


def found(problem):
    """Is the slope in the best set?"""
    sets = FittedSets(Search(problem, [RATE], problem.fit(Model())).run(), CrossValidation(problem.trials, "group"))
    return bool(sets.best)


def test_the_noncentrality_of_a_slope_is_its_square_times_sxx_over_the_variance():
    told = plan(pilot(lines(4, sigma=0.5)), "linear_drag", {"rate": 2.0})
    assert told.noncentrality == pytest.approx(4 * 2.0**2 * SXX / 0.5**2, rel=1e-6)  # linear: only rounding stands between
    half = next(row for row in told.options if row["change"] == "half the noise")
    assert half["noncentrality"] == pytest.approx(4 * told.noncentrality / 4) and half["sigma"] == 0.25


def test_alone_the_power_is_that_of_the_noncentral_chi_square_beyond_the_price():
    """Nothing held out: paid are the odds, 2 log(1 + (2/5)^2), and log(1 + 25 Sxx) for the number, here less than log n."""
    told = plan(pilot(lines(4), hold_out=False), "linear_drag", {"rate": 2.0})
    least = ODDS_ALONE + 2 * np.log1p(0.4**2) + min(np.log1p(4 * 25 * SXX), np.log(4 * len(TIMES)))
    assert told.now["power"] == pytest.approx(stats.ncx2.sf(least, 1, 4 * 4 * SXX))
    assert "two groups" in told.notes[0]


@pytest.mark.parametrize("slope", [0.7, 1.3])  # some 24 recordings, and so few that each half must show a fall
def test_lines_are_found_as_often_as_planned(slope, generator):
    """300 draws: what is counted lies within three standard deviations of what is foreseen, and the smallest number that is foreseen
    to do has the power that was asked for, to 0.04 (the halves of odd numbers are not equal)."""
    told = plan(pilot(lines(4)), "linear_drag", {"rate": slope})
    count = told.needed["recordings"]
    hits = sum(found(lines(count, slope, generator=generator)) for _ in range(300))
    print(slope, count, hits)
    assert abs(hits / 300 - 0.9) < 3 * np.sqrt(0.9 * 0.1 / 300) + 0.04
