"""Signatures of candidates: what shows nothing nearby is looked at from afar."""

import pytest
from experiments import measured
from throws import write_drops

from hlcs.estimation.cross_validation import CrossValidation
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.selection.search import Search


def test_a_rebound_is_seen_from_a_model_that_has_none(tmp_path):
    """Heights go with e^2, so the derivative at e = 0 shows nothing; a look from afar shows a good part of what a refit gains."""
    measurement = measured(write_drops(tmp_path, 0.006))  # no single blow can be read in these
    prepared = prepare(measurement)
    entries, _ = candidates_for(measurement, True, ["restitution"])
    search = Search(prepared.problem, entries, CrossValidation(measurement.trials, measurement.file.hold_out))
    trial = search.round(prepared.base)["restitution"]
    assert trial.linear_gain > 0.2 * trial.gain > 40
    assert trial.fit.estimate[0] == pytest.approx(0.5, abs=0.03)  # four standard errors
