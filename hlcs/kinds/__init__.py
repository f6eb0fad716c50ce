"""The kinds of measurement, by their names in experiment files; each is one class that follows `kinds.protocol`."""

from hlcs.kinds.layers import Layers
from hlcs.kinds.outcomes import Outcomes
from hlcs.kinds.trajectories import Trajectories

KINDS = {kind.kind: kind for kind in (Trajectories, Outcomes, Layers)}
