"""What a plan promises: closed forms for lines, and as often found as foreseen where the data are then drawn."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from linear_models import RATE, Line
from scipy import special, stats
from throws import csv, drag_per_metre, flight

import hlcs
from hlcs.estimation.cross_validation import FEW_RECORDINGS, CrossValidation
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.protocol import Options, Prepared
from hlcs.selection.experiment_design import MOST_TESTS
from hlcs.selection.held_out import held_out
from hlcs.selection.planning import Odds, Pilot, Signal, plan
from hlcs.selection.search import Search
from hlcs.selection.sets import FittedSets
from hlcs.selection.thresholds import BY_CHANCE, ODDS_ALONE
from hlcs.simulation.model import Model, Term
from minibullet.errors import InputError

TIMES = np.linspace(0.0, 1.0, 12)
SXX = float(np.sum((TIMES - TIMES.mean()) ** 2))


def lines(count, slope=0.0, sigma=1.0, generator=None):
    """Lines of one slope, every second one in the other group."""
    noise = generator.normal(0.0, sigma, (count, len(TIMES))) if generator else np.zeros((count, len(TIMES)))
    problem = Line([TIMES] * count, list(slope * TIMES + noise), sigma, ["ab"[k % 2] for k in range(count)])
    for k, trial in enumerate(problem.trials):
        trial.name = str(k)
    problem.noise, problem.unit = SimpleNamespace(position=sigma, of_unit=lambda unit: sigma), "m"
    return problem


def pilot(problem, hold_out=True):
    """An OpenExperiment that has this problem for its pilot."""
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


@pytest.mark.parametrize("slope", [1.0, 2.4])  # some 23 recordings, and so few that each half must show a fall
def test_lines_are_found_as_often_as_planned(slope, generator):
    """What is counted in 100 draws lies within three standard deviations of what is foreseen; 0.03 for halves of unequal size."""
    known = pilot(lines(4))
    count = plan(known, "linear_drag", {"rate": slope}).needed["recordings"]
    assert (count < FEW_RECORDINGS) == (slope == 2.4)
    hits = sum(found(lines(count, slope, generator=generator)) for _ in range(100))
    foreseen = plan(pilot(lines(count)), "linear_drag", {"rate": slope}).now["power"]
    assert foreseen >= 0.9 and abs(hits / 100 - foreseen) < 3 * np.sqrt(foreseen * (1 - foreseen) / 100) + 0.03


def test_few_recordings_keep_the_rules_of_held_out_ones_as_often_as_planned(generator):
    """Four lines, 400 draws within three standard deviations: each half shows a fall of 2 %, or both any fall beyond chance."""
    slope, draws, kept = 2.0, 400, 0
    for _ in range(draws):
        problem = lines(4, slope, generator=generator)
        cross_validation = CrossValidation(problem.trials, "group")
        before, after = problem.fit(Model()), problem.fit(Model().with_term(Term(RATE, (("rate", 1.0),))))
        kept += held_out(problem, cross_validation, before, after).broken(cross_validation.few, 1) is None
    noncentrality = slope**2 * SXX
    signal = Signal(noncentrality, np.array([[25 * SXX]]), len(TIMES), len(TIMES) - 1.0, noncentrality)
    least = Odds(0.0, special.ndtri(1 - BY_CHANCE) ** 2, FEW_RECORDINGS).held_out(np.array([[4.0]]), signal, 1)
    foreseen = np.mean(stats.ncx2.sf(least, 1, 4 * noncentrality))
    assert abs(kept / draws - foreseen) < 3 * np.sqrt(foreseen * (1 - foreseen) / draws)


def test_what_held_out_recordings_can_never_show_is_infeasible():
    """An effect of 0.1 sigma rms lowers the error by half a per cent, whatever the number of recordings; at a third of the noise
    it does by more than 2 %."""
    slope = 0.1 * np.sqrt(len(TIMES) / SXX)
    told = plan(pilot(lines(4)), "linear_drag", {"rate": slope})
    assert told.needed["recordings"] is None and told.now["power"] < 0.01
    assert any("2 %" in note for note in told.notes)
    sharper = next(row for row in told.options if row["change"] == "as many as now")
    again = plan(pilot(lines(4, sigma=sharper["sigma"])), "linear_drag", {"rate": slope})
    assert again.now["power"] == pytest.approx(0.9, abs=0.005)  # the noise is found to a part in a thousand


def test_more_power_needs_more_and_less_noise_needs_less():
    signal = Signal(2.0, np.array([[3.0]]), 12.0, 11.0, 1.0)
    for odds in (Odds(7.0, 9.0, 6.0), Odds(13.0, None, 6.0)):
        needed = [odds.recordings(signal, power) for power in (0.5, 0.9, 0.99)]
        assert needed == sorted(needed) and needed[0] < needed[2] <= MOST_TESTS
        assert odds.recordings(signal.at_noise(0.5), 0.9) < needed[1] < (odds.recordings(signal.at_noise(1.2), 0.9) or MOST_TESTS)


@pytest.mark.parametrize(
    ("effect", "at", "power", "words"),
    [
        ("linear_drag", {"rat": 1.0}, 0.9, "no parameter 'rat' to be found; it has rate"),
        ("linear_drag", {"rate": np.nan}, 0.9, "rate = nan must be a finite number"),
        ("linear_drag", {"rate": -1.0}, 0.9, "rate = -1; its law holds from 0"),
        ("linear_drag", {"rate": 0.0}, 0.9, "absent"),
        ("linear_drag", {"rate": 1.0}, 1.0, "between 0 and 1"),
        ("linear_drag", {"rate": 1.0}, np.nan, "between 0 and 1"),
        ("gust", {"speed": 1.0}, 0.9, "gust cannot act in these data: no wind"),
    ],
)
def test_what_cannot_be_planned_is_refused_in_words(effect, at, power, words):
    with pytest.raises(InputError, match=re.escape(words)):
        plan(pilot(lines(2)), effect, at, power)


# --- flights and tables ------------------------------------------------------------------------------------------------------


def throws(folder, count, coefficient, seed=0, candidates=()):
    """Throws at 5 m/s in four headings, 20 Hz, noise of 1 cm, by a solver of this test's own."""
    folder.mkdir(exist_ok=True)
    times, entries = np.arange(0, 1.0, 1 / 20), []
    for k in range(count):
        heading = np.pi / 2 * (k % 4) + 0.2
        velocity = 5.0 * np.array([0.8 * np.cos(heading), 0.8 * np.sin(heading), 0.6])
        seen = flight(np.array([0.0, 0.0, 1.5]), velocity, times, drag_per_metre(coefficient), step=0.01)
        seen += 0.01 * np.random.default_rng([seed, k]).standard_normal(seen.shape)
        (folder / f"throw_{k}.csv").write_text(csv(times, seen))
        entries.append(f'[[trial]]\nfile = "throw_{k}.csv"\ngroup = "day {k // 2 % 2}"\n')
    names = f"[diagnose]\ncandidates = {list(candidates)!r}\n" if candidates else ""
    (folder / "throws.toml").write_text(
        'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.0335\nmass = 0.0577\n[surroundings]\nfluid_density = 1.2\n'
        "[measurement]\nnoise = { position = 0.01 }\n" + names + "".join(entries)
    )
    return folder / "throws.toml"


def planned(path, *arguments):
    return plan(Experiment.read(path).opened(Options()), *arguments)


def alike(told):
    return {entry["effect"]: entry for entry in told.look_alikes}


def test_a_flight_is_cut_and_prolonged_and_its_look_alike_is_named(tmp_path):
    """What a force does to a flight grows as the square of its duration at least, so chi2 sixteenfold for twice the time."""
    told = planned(throws(tmp_path, 2, 0.0), "quadratic_drag", {"drag_coefficient": 0.2})
    rows = {row["change"]: row for row in told.options}
    assert rows["twice as long"]["length_s"] == pytest.approx(1.9) and rows["half as long"]["length_s"] == pytest.approx(0.475)
    size = [rows[change]["noncentrality"] for change in ("half as long", "as now", "twice as long")]
    assert size[1] > 16 * size[0] and size[2] > 16 * size[1]
    assert told.now["recordings"] == 2 and "linear_drag" in alike(told)


def test_a_flight_is_not_prolonged_through_its_floor(tmp_path):
    path = throws(tmp_path, 2, 0.0)
    path.write_text(path.read_text().replace("[measurement]", "floor = { height = -3.0 }\n[measurement]"))
    told = planned(path, "quadratic_drag", {"drag_coefficient": 0.2})
    assert {row["change"] for row in told.options} >= {"as now", "half as long"}
    assert "twice as long" not in {row["change"] for row in told.options}


@pytest.mark.slow
def test_throws_are_found_as_often_as_planned(tmp_path):
    """Twenty experiments as planned from a pilot: as often found as the binomial law of 0.9 has it in 99 of 100 cases."""
    pilot_file = throws(tmp_path / "pilot", 4, 0.0, candidates=("quadratic_drag",))
    count = planned(pilot_file, "quadratic_drag", {"drag_coefficient": 0.2}).needed["recordings"]
    files = [throws(tmp_path / str(seed), count, 0.2, seed) for seed in range(1, 21)]
    hits = sum("quadratic_drag" in hlcs.diagnose(path, candidates=["quadratic_drag"]).effects for path in files)
    assert stats.binom.ppf(0.005, 20, 0.9) <= hits


def table(folder, heights):
    """Times of fall from some heights, six rows each, noise 2 ms."""
    generator = np.random.default_rng(3)
    rows = [f"{h},{np.sqrt(2 * h / 9.81) + 0.002 * generator.standard_normal():.5f}" for h in heights for _ in range(6)]
    (folder / "falls.csv").write_text("\n".join(["height_m,fall_time_s", *rows]) + "\n")
    (folder / "falls.toml").write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.1\n[surroundings]\nfluid_density = 0.0\n'
        '[measurement]\nfile = "falls.csv"\nnoise = { fall_time_s = 0.002 }\n'
    )
    return folder / "falls.toml"


def test_rows_of_a_table_are_planned_as_recordings_are(tmp_path):
    """A late clock shifts every row by one offset: noncentrality (offset / sigma)^2 each. From like heights a wrong rate of the
    clock does the same, from unlike ones it does not."""
    told = planned(table(tmp_path, (1.0, 1.1)), "clock_offset", {"offset": 0.001})
    assert told.what == "rows" and told.now["recordings"] == 12 and told.needed["length_s"] is None
    assert told.noncentrality == pytest.approx(12 * 0.25) and alike(told)["time_scale"]["recordings"] is None
    unlike = planned(table(tmp_path, (0.1, 4.0)), "clock_offset", {"offset": 0.001})
    assert "time_scale" not in alike(unlike)
