"""What is told of every candidate, in any kind of measurement."""

from hlcs.effects import Free
from hlcs.records import Reason
from hlcs.selection.findings import error_record, findings, set_label, smallest_visible

ALTERNATIVES = {"drag": {}, "buoyancy": {"time_scale": 0.99996, "length_scale": 0.98}}


def described(name, same):
    evidence = {"drag": 30.0, "buoyancy": 50.0, "magnus": None}.get(name, 40.0)
    return {"fitted": 0.1, "held_out": None, "evidence": evidence, **Reason.INVISIBLE()._asdict()}


def test_accepted_candidates_come_first_and_what_has_no_evidence_last():
    names = ["added_mass", "buoyancy", "drag", "length_scale", "magnus", "time_scale"]
    told = {finding.effect: finding for finding in findings(names, ALTERNATIVES, described)}
    assert list(told) == ["buoyancy", "drag", "added_mass", "length_scale", "time_scale", "magnus"]
    assert [name for name, finding in told.items() if finding.accepted] == ["buoyancy", "drag"]


def test_rivals_of_one_effect_cannot_be_told_from_each_other_either():
    names = ["buoyancy", "drag", "length_scale", "time_scale"]
    told = {finding.effect: finding for finding in findings(names, ALTERNATIVES, described)}
    assert told["time_scale"].same_as == ("buoyancy", "length_scale") and told["drag"].same_as == ()
    assert told["buoyancy"].cosines == {"time_scale": 1.0, "length_scale": 0.98}
    assert told["length_scale"].cosines == {"buoyancy": 0.98} and told["drag"].cosines == {}


def test_words_for_sizes_sets_and_errors():
    assert smallest_visible(Free("offset", "Dn", -1.0, 1.0, 0.0, 0.1), 0.1234) == "offset 0.12 Dn from 0"
    assert smallest_visible(Free("factor", "1", 0.5, 2.0, 1.0, 1.1), 0.1) == "factor 0.1 from 1"
    assert set_label("buoyancy", ("time_scale",)) == " (effective_gravity)" and set_label("buoyancy", ("magnus",)) == ""
    record = error_record("rms", "m", 0.1, (2.0, 1.0), None)
    assert record["fitted"] == {"before": 2.0, "after": 1.0, "noise": 0.1} and record["held_out"] is None
