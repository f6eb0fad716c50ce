"""Figures that every kind of measurement tells in the same way."""

import numpy as np
import pytest

from hlcs.kinds import KINDS
from hlcs.kinds.protocol import OpenExperiment, misfit, misses


def test_an_error_has_its_sign_from_the_model():
    told = misfit(np.array([3.0, -4.0, 1.0, 2.0]), "m", 0.1)
    assert told == {"rms": pytest.approx(np.sqrt(7.5)), "unit": "m", "noise": 0.1, "bias": -0.5}


def test_misses_are_of_the_observations_inside():
    table = {"residual": np.array([3.0, 4.0, 100.0]), "sigmas": np.array([6.0, 8.0, 200.0])}
    told = misses(table, np.array([True, True, False]))
    assert told == {"rms": pytest.approx(np.sqrt(12.5)), "sigma": pytest.approx(np.sqrt(50.0))}


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_each_kind_has_the_methods_of_the_protocol(kind):
    methods = [name for name, value in vars(OpenExperiment).items() if callable(value) and not name.startswith("_")]
    assert methods and all(callable(getattr(kind, name)) for name in methods)
