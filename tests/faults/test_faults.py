"""Faults in whole commands: a part of the points of `python -m tests.faults.run`, spread over all of them."""

import os

import pytest

from tests.faults import run

EVERY = {"once": 7, "full": 19, "killed": 19}  # a point takes a quarter of a second


@pytest.mark.parametrize("mode", [mode for mode in run.MODES if mode != "killed" or os.name == "posix"])
@pytest.mark.parametrize("scene", run.SCENES)
def test_a_fault_loses_nothing_and_leaves_nothing_half_done(scene, mode):
    trials = list(run.run(scene, [mode], EVERY[mode]))
    assert len(trials) > 3
    assert not [trial for trial in trials if trial[3]]
