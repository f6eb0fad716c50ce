"""Shared test settings: reproducible property tests and a seeded generator; markers are declared in pyproject.toml."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as hlcs does; NumPy reads it at its first import

import hypothesis
import numpy as np
import pytest

# the same examples in every run: a red test must be red again; no deadline, since the first call of a kernel compiles it
hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.load_profile("repeatable")


@pytest.fixture
def generator():
    """A fresh random generator with a fixed seed for each test."""
    return np.random.default_rng(20210601)
