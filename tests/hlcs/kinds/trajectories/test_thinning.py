"""Long recordings: a search keeps every k-th row, the verdict is of all rows."""

import numpy as np
from experiments import FLOOR, TOML, experiment, measured

import hlcs
from hlcs.estimation.noise_model import estimate_noise
from hlcs.kinds.trajectories.observations import judge
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.kinds.trajectories.thinning import on_all_rows, thinned


def test_a_search_keeps_every_kth_row_and_what_happens_fast(tmp_path, monkeypatch):
    """A bounce at 0.5 s: of 120 rows every sixth stays, all of the beginning, and all around the blow that the samples show."""
    monkeypatch.setattr("hlcs.kinds.trajectories.thinning.MOST_SEARCHED", 20)
    times = np.arange(120) / 120
    height = 0.03 + np.where(times < 0.5, 4.905 * (0.25 - times**2), 4.905 * (times - 0.5) * (1.5 - times) / 2)
    rows = "".join(f"{t:.6f},{z:.6f}\n" for t, z in zip(times, height, strict=True))
    toml = FLOOR.replace("position = 0.01", "position = 0.0001")
    measurement = measured(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=toml))
    assert thinned(measurement, estimate_noise(measurement)).trials[0].rows.tolist() == sorted(
        {*range(2, 14), *range(2, 122, 6), *range(2 + 54, 2 + 66), 121}
    )
    monkeypatch.setattr("hlcs.kinds.trajectories.thinning.MOST_SEARCHED", 120)
    assert thinned(measurement, estimate_noise(measurement)) is measurement


def test_what_thinning_hides_is_judged_on_all_rows(tmp_path, monkeypatch, generator):
    """Of every tenth row an oscillation of one turn in ten rows is a constant, which the start absorbs; all rows show it."""
    times = np.arange(3000) / 1000
    values = 1.0 + 0.05 * times + 0.001 * np.sin(2 * np.pi * 100 * times + 0.7) + 0.001 * generator.standard_normal(3000)
    path = experiment(
        tmp_path,
        csv="t_s,z_m\n" + "".join(f"{t:.4f},{z:.7f}\n" for t, z in zip(times, values, strict=True)),
        toml=TOML.replace("position = 0.01", "position = 0.001") + "[surroundings]\ngravity = 0.0\n",
    )
    monkeypatch.setattr("hlcs.kinds.trajectories.thinning.MOST_SEARCHED", 300)
    measurement = measured(path)
    prepared = prepare(thinned(measurement, estimate_noise(measurement)))
    few, _ = judge(prepared.problem, prepared.base)
    problem, fit = on_all_rows(measurement)(prepared.problem, prepared.base)
    every, _ = judge(problem, fit)
    assert few.adequate and not every.adequate and fit.count == 3000
    assert hlcs.diagnose(path, candidates=["linear_drag"]).verdict == "unexplained"
