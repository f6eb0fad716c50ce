"""Damaged CSV files: read, or refused in one line (the long run: python -m tests.fuzz.csvs)."""

import random

import pytest

from .csvs import KINDS, mutant, outcome, run


@pytest.mark.parametrize("kind", KINDS)
def test_the_files_that_are_damaged_are_read_whole(kind, tmp_path):
    """Otherwise every mutant would be refused for the same reason."""
    text, reader = KINDS[kind]
    (tmp_path / "a.csv").write_text(text)
    assert outcome(reader, tmp_path / "a.csv") == ("read", "")


def test_damaged_files_are_read_or_refused_in_one_line(tmp_path):
    counts, wrong = run(200, tmp_path)
    assert not wrong
    assert counts["refused"] > 100 and counts["read"] > 10  # the damage is neither harmless nor always the same


def test_the_same_seed_makes_the_same_damage():
    text, _ = KINDS["survey"]
    assert mutant(text, random.Random("1")) == mutant(text, random.Random("1")) != mutant(text, random.Random("2"))
