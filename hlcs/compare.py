"""Compare: where, and by how much, does the model miss the measurement."""

from hlcs.effects import own_classes
from hlcs.kinds import open_experiment
from hlcs.kinds.protocol import Experiment, Options
from hlcs.placement.comparison import compare_layers
from hlcs.records import Comparison


def compare(path, *others, effects_file=None, seed=0, workers=None, progress=False, allow_outside=False):
    """Where and by how much a model misses a measurement: a Comparison of an experiment file.

    effects_file: Python file with effects of your own that the file names under [model], run as code; seed, workers, progress: of
    the simulations (layer data); allow_outside: let the experiment file name files outside its own folder. With a result and a
    laboratory table in place of a path, the table of layer coefficients beside each other. Raises InputError where the input
    is at fault.
    """
    if others or not isinstance(path, str) and not hasattr(path, "__fspath__"):
        return compare_layers(path, *others)
    _, experiment = open_experiment(path, Options(own_classes(None, effects_file), seed, workers, progress), allow_outside)
    return comparison_of(experiment)


def comparison_of(experiment: Experiment):
    """The Comparison of an Experiment."""
    common = {"kind": experiment.kind, "title": experiment.title, "noise": experiment.noise}
    if not experiment.judgeable:
        error = {"rms": None, "noise": None, "unit": experiment.unit}
        nothing = {"adequate": None, "statistic": None, "p": None, "error": error, "where": ()}
        return Comparison(**common, **nothing, notes=experiment.notes, advice=experiment.advice)
    seen = experiment.observe()._asdict()
    return Comparison(**common, **seen.pop("shown"), **seen)
