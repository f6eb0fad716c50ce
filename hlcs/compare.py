"""Compare: where, and by how much, does the model miss the measurement."""

import os
from dataclasses import replace

from hlcs.kinds.experiment import Experiment
from hlcs.kinds.protocol import OpenExperiment, Options
from hlcs.placement.comparison import compare_layers
from hlcs.records import Comparison
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
    if not isinstance(experiment, str | os.PathLike | Experiment):
        return compare_layers(experiment, *others)
    if len(others) + bool(effects) > 1:
        raise InputError("compare: give one model, or effects=[..], not several")
    nominal = changed = Experiment.read(experiment, allow_outside, effects_file)
    if others:
        changed = nominal.with_model(others[0])
    elif effects:
        changed = nominal.with_effects(effects)
    before = nominal.before() if changed is nominal else nominal
    options = Options(changed.user_effects, seed, workers, progress)
    comparison = comparison_of(changed.opened(options))
    if before is None:
        return comparison
    return replace(comparison, before=comparison_of(before.opened(options)), added=changed.file.added)


def comparison_of(experiment: OpenExperiment):
    """The Comparison of an OpenExperiment."""
    common = {"kind": experiment.kind, "title": experiment.title, "noise": experiment.noise}
    if not experiment.judgeable:
        error = {"rms": None, "noise": None, "unit": experiment.unit}
        nothing = {"adequate": None, "statistic": None, "p": None, "error": error, "where": ()}
        return Comparison(**common, **nothing, notes=experiment.notes, advice=experiment.advice)
    seen = experiment.observe()._asdict()
    return Comparison(**common, **seen.pop("shown"), **seen)
