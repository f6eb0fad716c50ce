"""Pairs of candidates that hide each other, ranked by what they explain together."""

from types import SimpleNamespace

import numpy as np
import pytest

from hlcs.estimation.linearization import CandidateTrial
from hlcs.selection.pairs import pairs, passes

X, Y, Z = np.eye(3)


def trial(name, direction, r, required=5.0):
    """A candidate that moves the data along a direction (3,)."""
    gain = (direction @ r) ** 2 / (direction @ direction)
    candidate = SimpleNamespace(name=name, kind=SimpleNamespace(form_of=""))
    return CandidateTrial(candidate, linear_gain=gain, required_gain=required, signature=[direction[:, None]], visible=1.0)


def test_two_that_point_past_the_residual_alone_are_a_pair_where_they_span_it():
    """r = 10 y; x + 0.5 y and x - 0.5 y explain a fifth of it each (20 of 100) and all of it together; z adds nothing."""
    r = 10 * Y
    fit = SimpleNamespace(linearization=SimpleNamespace(residual=(r, np.zeros((3, 0)))), model=SimpleNamespace(terms=()))
    trials = [trial("a", X + 0.5 * Y, r), trial("b", X - 0.5 * Y, r), trial("c", Z + 0.5 * Y, r)]
    search = SimpleNamespace(same_form=lambda entry, terms: False)
    found = pairs(search, fit, {entry.candidate.name: entry for entry in trials})
    assert trials[0].linear_gain == pytest.approx(20)
    assert {entry.candidate.name for entry in found[0]} == {"a", "b"}
    alike = SimpleNamespace(same_form=lambda entry, terms: bool(terms))  # two forms of one law are no pair
    assert pairs(alike, fit, {entry.candidate.name: entry for entry in trials}) == []


def test_the_chance_of_one_among_many_counts_against_a_pair():
    judged = trial("a", X, X)
    judged.fit, judged.p = object(), 0.03
    search = SimpleNamespace(broken_rules=lambda trial: ["too likely"] if trial.holm >= 0.05 else [])
    assert passes(search, judged, 1) and judged.holm == 0.03
    assert not passes(search, judged, 2) and judged.holm == 0.06
