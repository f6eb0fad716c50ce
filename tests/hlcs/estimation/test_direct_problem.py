"""The problem of a table whose model foretells every number at once."""

import numpy as np
import pytest
from linear_models import model

from hlcs.estimation.direct_problem import DirectProblem, Rows
from minibullet.errors import InputError

INPUTS = np.array([1.0, 2.0, 3.0])


class Wall(DirectProblem):
    """Values rate * input, of a rate that lies between two ends."""

    def __init__(self, least, most):
        self.least, self.most, self.values, self.trials = least, most, INPUTS, (Rows("a", np.arange(3)),)

    def predict(self, model):
        rate = model.terms[0].numbers["rate"]
        if not self.least <= rate <= self.most:
            raise InputError("no placement stands")
        return rate * INPUTS

    def whitened(self, raw):
        return raw


@pytest.mark.parametrize(("least", "most"), [(0.0, 5.0), (0.0, 1.0), (1.0, 5.0)])
def test_a_slope_is_taken_to_the_side_where_something_can_be(least, most):
    """At rate 1 the values rise by the inputs, whichever side is closed."""
    ((slope,),) = (part.T for part in Wall(least, most).linearise(model(1.0), None).parameter_columns)
    np.testing.assert_allclose(slope, INPUTS, rtol=1e-6)


def test_where_nothing_can_be_to_either_side_that_is_said():
    with pytest.raises(InputError, match="no placement stands"):
        Wall(1.0, 1.0).linearise(model(1.0), None)
