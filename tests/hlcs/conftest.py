"""Small placement tests, run once for all tests of the laboratory, and the command as these type it."""

import sys
from pathlib import Path

import pytest

from hlcs import PlacementTest
from hlcs.cli import commands

sys.path.insert(0, str(Path(__file__).resolve().parent))  # so that tests can share `throws`


@pytest.fixture(scope="session")
def small_test():
    """Two layers, 9 + 4 units: seconds, and yet everything that a placement test does."""
    return PlacementTest(layers=2, rows=3, columns=3, seed=3)


@pytest.fixture(scope="session")
def small_result(small_test):
    return small_test.run()


@pytest.fixture
def hlcs(capsys, tmp_path, monkeypatch):
    """Run the command in an empty folder; returns (status, stdout, stderr)."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        status = commands.main(list(arguments))
        output = capsys.readouterr()
        return status, output.out, output.err

    return run
