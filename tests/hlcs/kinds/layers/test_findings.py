"""What is said of each candidate of layers."""

import numpy as np
import pytest

from hlcs.effects import Free
from hlcs.kinds.layers.candidates import LayerCandidate
from hlcs.kinds.layers.findings import intervals, layer_findings
from hlcs.kinds.layers.judge import LayerTrial
from hlcs.records import Reason


def trial(name, switch=False, campaign="", amount=0.28):
    candidate = LayerCandidate(
        name, Free("offset", "Dn", -0.3, 0.3, 0.0, 0.1), switch=switch, campaign=campaign, family="physics"
    )
    slope = np.ones(4)
    return LayerTrial(candidate, slope, 0.0 * slope, amount, 0.1, 50.0, 50.0, 0.01, required_gain=8.0, relative_shift=2.0)


def test_intervals_of_90_percent_end_at_the_bounds_and_a_switch_has_none():
    told = intervals([trial("margin_offset", campaign="a"), trial("convex_hull_shape", switch=True)])
    number = told["margin_offset"]["offset"]
    assert (number["value"], number["high"], number["campaign"]) == (0.28, 0.3, "a")
    assert number["low"] == pytest.approx(0.28 - 0.1645)
    assert told["convex_hull_shape"]["offset"]["low"] == told["convex_hull_shape"]["offset"]["high"] == 0.28


def test_accepted_candidates_come_first_and_rivals_name_each_other():
    trials = [trial("plate_bias"), trial("settlement")]
    absent = LayerCandidate("adhesion", Free("offset", "Dn", 0.0, 1.0, 0.0, 0.1))
    candidates = [*(one.candidate for one in trials), absent]
    first, second, last = layer_findings(candidates, trials[1:], [trials], {"settlement": {"plate_bias": 0.99991}})
    assert (first.effect, first.accepted, first.same_as) == ("settlement", True, ("plate_bias",))
    assert "cannot be told from plate_bias (rest_height)" in first.why and first.cosines == {"plate_bias": 0.9999}
    assert second.reason is Reason.NOT_TOLD_APART and second.cosines == {"settlement": 0.9999}
    assert second.visible_from == "offset 0.14 Dn from 0"
    assert last.reason is Reason.NOT_SIMULATED and last.evidence is None
