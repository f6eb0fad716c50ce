"""Layer data for tests: tables, experiment files of them, and a stand-in for the simulations.

The stand-in answers a PlacementTest in microseconds with layer coefficients like the laboratory's, moved by shape, margin,
friction and scatter of the aims as simulations move them (hull +10 %, two margins a layer), with scatter between seeds of 1.2 %.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

import hlcs
from hlcs.compare import comparison_of
from hlcs.data.experiment_file import read_experiment_file
from hlcs.diagnose import diagnosis_of
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.layers import Layers
from hlcs.kinds.protocol import Options

PAPER = [("table2", "RPG"), ("table2", "TPG"), ("table3", "TPG")]
HEADER = "grid,spacing_x,spacing_y,bottom_slope,layer,mean,cv,tests,campaign"


def emulate(test):
    """Layer coefficients of a test without its physics."""
    layers = test.layers
    k = np.array([1.298, 1.08, 0.98, 0.97, 0.975] if test.grid.triangular else [1.298, 1.05, 0.96, 0.95, 0.94])[:layers]
    upper = np.arange(layers) > 0
    k = k * np.where(upper & (test.shape == "hull"), 1.10, 1.0) + 2.0 * test.margin
    k = k + upper * (0.1 * (test.friction - 0.36) - 0.1 * test.placement_scatter)
    case = [test.seed, int(test.grid.triangular), int(1e4 * abs(test.bottom.height(0.0, 1.0)))]
    shared = np.random.default_rng(case).standard_normal(layers)  # common random numbers: the same with and without an effect
    own = np.random.default_rng([*case, int(1e5 * test.margin), int(test.shape == "hull"), int(1e4 * test.friction)])
    wide = 1.0 + 5.0 * test.placement_scatter  # 2.5 times the scatter at 0.3 Dn, as units that miss their places give
    return {"k": [float(v) for v in k + wide * upper * (0.012 * shared + 0.006 * own.standard_normal(layers))], "lost": 0}


def experiment(folder, tables, placement="", diagnose=""):
    """An experiment file of tables (data frames with the columns of a layers file)."""
    pd.concat(tables).to_csv(folder / "layers.csv", index=False)
    parts = ['kind = "layers"', "[placement]", placement, "[measurement]", 'file = "layers.csv"', "[diagnose]", diagnose, ""]
    (folder / "layers.toml").write_text("\n".join(parts))
    return read_experiment_file(folder / "layers.toml")


def measured(grid, seed, campaign, tests=5, shift=0.0, **settings):
    """Repeated tests of the stand-in as a laboratory would report them, `shift` [Dn] added to the first layer."""
    runs = [emulate(hlcs.PlacementTest(grid=grid, seed=1000 * seed + number, **settings))["k"] for number in range(tests)]
    runs = np.array(runs)
    runs[:, 0] += shift
    mean = runs.mean(axis=0)
    test = hlcs.PlacementTest(grid=grid)
    return pd.DataFrame(
        {
            "grid": grid,
            "spacing_x": test.grid.spacing_x,
            "spacing_y": test.grid.spacing_y,
            "bottom_slope": 0.0,
            "layer": np.arange(1, 6),
            "mean": mean.round(3),
            "cv": (runs.std(axis=0, ddof=1) / mean).round(3),
            "tests": tests,
            "campaign": campaign,
        }
    )


def compare_layers(file, **settings):
    return comparison_of(Layers(file, Options(), **settings))[0]


def diagnose_layers(file, candidates=None, **settings):
    return replace(diagnosis_of(Layers(file, Options(), **settings), candidates), experiment=Experiment(file))
