"""Small placement tests, run once for all tests of the laboratory."""

import sys
from pathlib import Path

import pytest

from hlcs import PlacementTest

sys.path.insert(0, str(Path(__file__).resolve().parent))  # so that tests can share `throws`


@pytest.fixture(scope="session")
def small_test():
    """Two layers, 9 + 4 units: seconds, and yet everything that a placement test does."""
    return PlacementTest(layers=2, rows=3, columns=3, seed=3)


@pytest.fixture(scope="session")
def small_result(small_test):
    return small_test.run()
