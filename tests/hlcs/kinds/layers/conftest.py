"""The stand-in for the simulations of placement tests, with a store of its own for each test."""

import pytest
from layer_tables import emulate

from hlcs.kinds.layers.model import PlacementSimulator


@pytest.fixture
def simulator(tmp_path):
    return PlacementSimulator(tmp_path / "store" / "runs.sqlite", workers=1, function=emulate)
