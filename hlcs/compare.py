"""Compare: where, and by how much, does the model miss the measurement; predict: what the model says of other experiments."""

import os
from dataclasses import replace

import numpy as np

from hlcs.data.outcome_tables import inputs_like, read_outcomes
from hlcs.effects import check_names, with_own
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.outcomes.checks import check_table
from hlcs.kinds.protocol import OpenExperiment, Options
from hlcs.placement.comparison import compare_layers
from hlcs.records import Comparison
from hlcs.simulation import outcome_motion
from hlcs.simulation.model import Model
from hlcs.simulation.row_setups import row_setups
from minibullet.errors import InputError


def compare(experiment, *others, effects=(), effects_file=None, seed=0, workers=None, progress=False, allow_outside=False):
    """Where and by how much a model misses a measurement: a Comparison.

    experiment: an Experiment, or the path of an experiment file; others: a model to be tried in place of its own, such as
    `diagnosis.model`; effects: values to be added to its model. With another model or effects, and where the file names effects
    that were added, the Comparison tells the error before and after. effects_file: Python file with effects of your own that
    the file names in its model, run as code; seed, workers, progress: of the simulations (layer data); allow_outside: let the
    experiment file name files outside its own folder. With a result and a laboratory table in place of an experiment, the table
    of layer coefficients beside each other. Raises InputError where the input is at fault.
    """
    if not isinstance(experiment, str | os.PathLike | Experiment) and others:
        return compare_layers(experiment, *others)
    nominal = Experiment.read(experiment, allow_outside, effects_file)
    changed = _with_other_model("compare", nominal, others, effects)
    before = nominal.before() if changed is nominal else nominal
    options = Options(changed.user_effects, seed, workers, progress)
    opened = changed.opened(options)
    comparison, aside = comparison_of(opened)
    if changed is nominal and comparison.adequate is False:  # a model that stands in no file can be named in no command
        comparison = replace(comparison, following=changed.typed("diagnose"))
    if before is None:
        return comparison
    known, there = with_own(changed.user_effects), {entry["name"] for entry in changed.file.replaced}
    there |= {name for name in known if known[name].replaces}  # the friction and the restitution of [surroundings]
    replaced = tuple(name for name in changed.file.added if name in there)
    former, _ = comparison_of(before.opened(options), aside)
    # one noise, as in the diagnosis: of layers it holds the scatter of a model's runs, that of the model before is told
    noise = {"noise": (comparison if opened.carried_noise else former).error["noise"]}
    comparison, former = (replace(each, error=each.error | noise) for each in (comparison, former))
    return replace(comparison, before=former, added=changed.file.added, replaced=replaced)


def comparison_of(experiment: OpenExperiment, aside=()):
    """(The Comparison of an OpenExperiment, the samples that it sets aside); aside: those of another model."""
    common = {"kind": experiment.kind, "title": experiment.title, "noise": experiment.noise}
    if not experiment.judgeable:
        error = {"rms": None, "noise": None, "unit": experiment.unit}
        nothing = {"adequate": None, "statistic": None, "p": None, "error": error, "where": ()}
        return Comparison(**common, **nothing, notes=experiment.notes, advice=experiment.advice), ()
    seen = (experiment.observe(aside) if aside else experiment.observe())._asdict()
    aside = seen.pop("aside")
    return Comparison(**common, **seen.pop("shown"), **seen), aside


def predict(experiment, inputs, model=None, effects=(), effects_file=None, allow_outside=False):
    """What a model says that a table of outcomes would read at other inputs: a pandas frame of the inputs and the outcome.

    experiment: an Experiment of kind "outcomes", or the path of its file; inputs: columns of the table without its outcome, such
    as {"height_m": [0.5, 1.0]}, as arrays or one number for all rows; model: to be taken in place of its own, such as
    `diagnosis.model`; effects: values to be added to its model; effects_file: Python file with effects of your own that the file
    names, run as code; allow_outside: let the experiment file name files outside its own folder. The outcome of a row stands in
    the column of its name, such as fall_time_s, nan where the model says that it never comes (a body that floats). Raises
    InputError where the input is at fault, or where the experiment is one of recordings or layers.
    """
    nominal = Experiment.read(experiment, allow_outside, effects_file)
    changed = _with_other_model("predict", nominal, () if model is None else (model,), effects)
    file, own = changed.file, changed.user_effects
    if file.kind != "outcomes":
        raise InputError(
            f'predict: kind = "{file.kind}"; only a table of outcomes (kind = "outcomes") can be asked at other inputs'
        )
    table = inputs_like(read_outcomes(file), inputs)
    setups = row_setups(file, table)
    check_names(file, own, setups)
    check_table(file, table, own)
    with np.errstate(all="ignore"):
        found = outcome_motion.outcomes(Model(fixed=file.effects, own=tuple(own)), setups, table.inputs, table.outcome)
    import pandas as pd

    return pd.DataFrame({**table.inputs, table.outcome: found})


def _with_other_model(caller, nominal, models, effects):
    """The Experiment with one other model, or with effects added; itself without both."""
    if len(models) + bool(effects) > 1:
        raise InputError(f"{caller}: give one model, or effects=[..], not several")
    if models:
        return nominal.with_model(models[0])
    return nominal.with_effects(effects) if effects else nominal
