"""Damaged mesh files: read, or refused in one line (the long run: python -m tests.fuzz.meshes)."""

import numpy as np
import pytest

from .meshes import mutant, originals, outcome, run


def test_the_files_that_are_damaged_are_read_whole(tmp_path):
    """Otherwise every mutant would be refused for the same reason."""
    for kind, data in originals():
        path = tmp_path / f"a.{kind}"
        path.write_bytes(data)
        assert outcome(path)[0] == "read", (kind, outcome(path))


def test_damaged_files_are_read_or_refused_in_one_line():
    counts, wrong, most = run(300, seed=1)
    assert not wrong
    assert counts["refused"] > 100 and counts["read"] > 10  # the damage is neither harmless nor always the same
    assert sum(counts.values()) == 300
    assert most[1] < 500  # MB: the interpreter has 130, a file of a few MB and what it is read into the rest


@pytest.mark.slow
def test_ten_thousand_damaged_files():
    assert not run(10_000, seed=2)[1]


def test_the_same_seed_makes_the_same_damage():
    _, data = originals()[1]
    one, same, other = (mutant(np.random.default_rng(seed), data) for seed in (1, 1, 2))
    assert one == same != other
