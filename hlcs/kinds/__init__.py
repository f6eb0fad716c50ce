"""The kinds of measurement, by their names in experiment files; each is one class that follows `kinds.protocol`."""

from hlcs.data.experiment_file import read_experiment_file
from hlcs.kinds.layers import Layers
from hlcs.kinds.outcomes import Outcomes
from hlcs.kinds.trajectories import Trajectories

KINDS = {kind.kind: kind for kind in (Trajectories, Outcomes, Layers)}


def open_experiment(path, options, allow_outside=False):
    """(ExperimentFile, its Experiment): a file read and checked by its kind; InputError where the input is at fault."""
    file = read_experiment_file(path, allow_outside, {name: kind.layout for name, kind in KINDS.items()})
    return file, KINDS[file.kind](file, options)
