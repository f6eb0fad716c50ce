"""The search: what a later term drives to its bound goes."""

import numpy as np
import pytest
from experiments import measured
from linear_models import RATE, Line

from hlcs.estimation.cross_validation import CrossValidation
from hlcs.estimation.linearization import CandidateTrial
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.selection.search import Search, explained
from hlcs.simulation.model import Model, Term

G = 9.81


BALL = '[body]\nshape = "sphere"\nradius = 0.02\nmass = 0.0027\n[surroundings]\nfluid_density = 1.2\n'


def test_what_a_later_term_drives_to_its_bound_goes(tmp_path):
    """A fall a fifth too fast asks for a clock 10 % slow, and 5 % is the most: however much it gains, it does not stay."""
    times = np.arange(60) / 60
    for k in range(4):
        fall = np.column_stack([k * times, 0 * times, 20.0 - 0.6 * G * times**2])
        rows = "".join(f"{t:.6f},{x:.6f},{y:.6f},{z:.6f}\n" for t, (x, y, z) in zip(times, fall, strict=True))
        (tmp_path / f"f{k}.csv").write_text("t_s,x_m,y_m,z_m\n" + rows)
    path = tmp_path / "e.toml"
    path.write_text(
        f'kind = "trajectory"\n{BALL}[measurement]\nnoise = {{ position = 0.004 }}\n'
        + "".join(f'[[trial]]\nfile = "f{k}.csv"\ngroup = "{k % 2}"\n' for k in range(4))
    )
    measurement = measured(path)
    prepared = prepare(measurement)
    entries, _ = candidates_for(measurement, False, ["time_scale", "linear_drag"])
    search = Search(prepared.problem, entries, CrossValidation(measurement.trials, measurement.file.hold_out))
    model = prepared.base.model
    for entry in reversed(entries):
        model = model.with_term(Term(entry, tuple(entry.absent.items())))
    fit = prepared.problem.fit(model)
    without = prepared.problem.fit(model.without(0))
    assert fit.model.names == ("time_scale", "linear_drag") and fit.at_bound[fit.numbers_of(0)] == (True,)
    assert without.chi2 - fit.chi2 > 1000
    assert search.prune(fit).model.names == ("linear_drag",)


def line(slope, sigma=0.1, noise=0.0, generator=None):
    """Four lines of one slope, in two groups, and the search over the one candidate that is their law."""
    times = [np.linspace(0.0, 1.0 + k, 10) for k in range(4)]
    values = [slope * t + (noise * generator.standard_normal(10) if noise else 0.0) for t in times]
    problem = Line(times, values, sigma, ["a", "b", "a", "b"])
    search = Search(problem, [RATE], CrossValidation(problem.trials, "group"))
    return search, problem.fit(Model()), sum((t - t.mean()) @ (t - t.mean()) for t in times)


def test_a_round_gains_what_the_regression_explains_and_asks_for_its_complexity():
    """chi2 falls by slope^2 Sxx / sigma^2; asked for are log n for the one number and 6 beside."""
    search, base, sxx = line(3.0)
    trial = search.round(base)["linear_drag"]
    assert trial.linear_gain == pytest.approx(9 * sxx / 0.1**2, rel=1e-6)
    assert trial.gain == pytest.approx(trial.linear_gain, rel=1e-4) and not trial.fails
    assert trial.required_gain == pytest.approx(np.log(40) + 6)
    assert trial.falls == pytest.approx(1.0, abs=1e-3) and trial.p < 1e-6


def test_a_run_ends_with_the_law_or_with_nothing_where_there_is_only_noise(generator):
    search, base, _ = line(3.0)
    fits, rounds = search.run(base)
    assert fits[-1].model.names == ("linear_drag",) and fits[-1].estimate[0] == pytest.approx(3.0, rel=1e-4)
    assert search.refit(base, RATE) is search.refit(base, RATE)  # made once
    search, base, _ = line(0.0, noise=0.1, generator=generator)
    fits, (trials,) = search.run(base)
    assert fits == [base] and explained(search.problem, base)
    assert trials["linear_drag"].linear_gain < trials["linear_drag"].required_gain


def test_holm_counts_the_candidates_that_could_be_seen():
    """Of p = 0.01, 0.02, 0.5 adjusted 3 p, 2 p and p, none below the one before; what is invisible is not counted."""
    search, base, _ = line(3.0)
    trials = [CandidateTrial(RATE, p=p, visible=visible) for p, visible in ((0.02, 1.0), (0.5, 1.0), (0.01, 1.0), (0.0, 0.0))]
    search.apply_rules(trials)
    assert [trial.holm for trial in trials] == pytest.approx([0.04, 0.5, 0.03, 1.0])
