"""Tables of layer coefficients beside simulated placement tests."""

from hlcs.kinds.layers.experiment import Layers
