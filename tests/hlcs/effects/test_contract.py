"""What every candidate that is no force has in common."""

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.effects.contract import Change, Scene, Setup

STILL = Scene(np.array([True]), None, 0.0, 1.0)


def test_a_change_that_overrides_nothing_changes_nothing():
    setup, inputs = Setup(Body(shape="sphere"), Surroundings()), {"height_m": np.ones(3)}
    seen = list
    assert Change().setup(setup) is setup and Change().look(seen, STILL) is seen
    assert Change().inputs(inputs, "s") is inputs and Change().outcome(3.0, "m") == 3.0
