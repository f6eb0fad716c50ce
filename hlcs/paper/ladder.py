"""The paper's own tables as a first case: from the naive model, step by step, to what brings the error down.

The naive model is one convex hull a unit, with the friction and the collision margin as they would be typed. The flat tables
(Table 2) are diagnosed; the 4 % slope (Table 3) is held out: no number is fitted to it, every model on the way is placed on it.
"""

from dataclasses import replace

import numpy as np

from hlcs.data.experiment_file import read_experiment_file
from hlcs.diagnose import diagnosis_of
from hlcs.files import folders
from hlcs.files.spreadsheets import csv_text
from hlcs.files.versions import versions
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.layers import Layers
from hlcs.kinds.layers.data import read_layer_sets
from hlcs.kinds.layers.model import PlacementSimulator, coefficients
from hlcs.kinds.protocol import Options
from hlcs.placement import statistics
from hlcs.placement.comparison import repeated
from hlcs.placement.printed_tables import laboratory
from hlcs.placement.settings_table import placement_table

NAIVE = {"shape": "hull", "friction": 0.6, "margin": 0.008}
FLAT, SLOPE = (("table2", "RPG"), ("table2", "TPG")), (("table3", "TPG"),)
SEEDS = 8  # simulated tests of a model on each table


def write_case(folder, settings):
    """The paper's tables and three experiment files of the naive model: flat.toml, slope.toml, and all.toml with both."""
    import pandas as pd

    for name, tables in (("flat", FLAT), ("slope", SLOPE), ("all", FLAT + SLOPE)):
        frame = pd.concat([laboratory(table, grid=grid).to_dataframe() for table, grid in tables])
        folders.write_text(folder / f"{name}.csv", csv_text(frame.to_dict("list")))
        title = {"flat": "Table 2", "slope": "Table 3", "all": "Tables 2 and 3"}[name] + " against the naive model"
        document = {
            "kind": "layers",
            "title": title,
            "placement": {**NAIVE, **settings},
            "measurement": {"file": f"{name}.csv"},
            "diagnose": {"hold_out": "campaign"},
        }
        folders.write_toml(folder / f"{name}.toml", document)


def ladder(plan, folder, progress=False, simulator=None):
    """(document, Diagnosis of flat.toml) of a `reproduce.Plan`, whose settings win over NAIVE; the files go into `folder`, which
    may be moved afterwards."""
    write_case(folder, plan.settings)
    simulator, seeds = simulator or PlacementSimulator(workers=plan.workers, progress=progress), plan.repeats or SEEDS
    file = read_experiment_file(folder / "flat.toml")
    diagnosis = diagnosis_of(Layers(file, Options(seed=plan.seed - 1), simulator, 2 * seeds))
    flat, (slope,) = read_layer_sets(folder / "flat.csv"), read_layer_sets(folder / "slope.csv")
    terms = {term.name: term for term in diagnosis.model.terms}
    models = [replace(diagnosis.model, terms=tuple(map(terms.get, step["effects"]))) for step in diagnosis.steps]
    numbers = range(plan.seed, plan.seed + seeds)
    steps = []
    tables = coefficients(simulator, models, [*flat, slope], list(numbers), "tables")
    for step, of_model in zip(diagnosis.steps, tables, strict=True):
        *means, model = [repeated(runs[np.isfinite(runs).all(axis=1)]).mean for runs in of_model]
        errors = [statistics.mean_relative_error(one.sample.mean, mean) for one, mean in zip(flat, means, strict=True)]
        steps.append(
            {
                "effects": step["effects"],
                "fitted": float(np.average(errors, weights=[one.layers for one in flat])),
                "by_table": dict(zip([one.name for one in flat], errors, strict=True)),
                "held_out": statistics.mean_relative_error(slope.sample.mean, model),
                "held_out_bias": statistics.signed_bias(slope.sample.mean, model),
            }
        )
        floor = statistics.perfect_model_error(slope.sample, repeated(of_model[-1]), draws=20_000)
    document = {
        "format": 1,
        "table": "ladder",
        "repeats": seeds,
        "seeds": list(numbers),
        "steps": steps,
        "floor": {"fitted": diagnosis.error["fitted"]["noise"], "held_out": floor.mean, "held_out_95": floor.quantile},
        "diagnosis": diagnosis.to_json(),
        "settings": placement_table(diagnosis.model.base),
        "versions": versions(),
    }
    return document, replace(diagnosis, experiment=Experiment(file))


def ladder_text(document):
    """What `hlcs reproduce ladder` prints before the report."""
    steps = document["steps"]
    tables = list(steps[0]["by_table"])
    lines = [
        "From the naive model to the tables of the paper: mean relative error eps_R [%]",
        f"{'':38}" + "".join(f"{name:>12}" for name in (*tables, "fitted", "slope 4 %")) + "   (slope held out)",
    ]
    for step in steps:
        name = "+ " + step["effects"][-1] if step["effects"] else "the naive model"
        errors = (*(step["by_table"][table] for table in tables), step["fitted"], step["held_out"])
        lines.append(
            f"{name:38}" + "".join(f"{100 * error:>12.2f}" for error in errors) + f"   bias {100 * step['held_out_bias']:+.2f}"
        )
    floor = document["floor"]
    lines.append(
        f"{'a perfect model, on these data':38}"
        + " " * 12 * len(tables)
        + f"{100 * floor['fitted']:>12.2f}{100 * floor['held_out']:>12.2f}   "
        f"below {100 * floor['held_out_95']:.2f} in 95 of 100"
    )
    lines.append(f"{document['repeats']} simulated tests of each model on each table")
    return "\n".join(lines)
