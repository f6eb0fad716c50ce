"""Reasons are values with a sentence each; no two share one, and numbers find their places."""

import json
from dataclasses import replace

from hlcs.kinds.trajectories.experiment import on_fewer
from hlcs.records import Diagnosis, Finding, Reason, untested
from hlcs.selection.reasons import Rule


def test_sentences_are_distinct():
    for reasons in (Reason, Rule):
        assert len(reasons) == len(reasons.__members__)


def test_an_explanation_carries_reason_and_sentence():
    fall = Rule.HELD_OUT_ERROR(percent=1.23)
    assert fall.reason is Rule.HELD_OUT_ERROR and fall.why == "held-out error falls by 1.2 % only"


def diagnosis(*findings):
    return Diagnosis(
        kind="trajectory",
        title="t",
        verdict="complete",
        effects=(),
        parameters={},
        ambiguous=(),
        error={"unit": "m"},
        steps=(),
        adequate={"before": None, "after": None},
        candidates=findings,
        where=(),
        next_experiment=None,
    )


def test_a_finding_keeps_its_reason_and_the_result_file_its_sentence():
    finding = untested("magnus", Reason.NOT_TRIED(why="there is no floor"))
    assert finding.reason is Reason.NOT_TRIED and finding.why == "not tried: there is no floor"
    (entry,) = json.loads(json.dumps(diagnosis(finding).to_json()))["candidates"]
    assert "reason" not in entry and entry["why"] == finding.why


def test_the_report_gathers_what_was_not_tried_by_its_reason_not_by_its_words():
    absent = [untested(name, Reason.NOT_TRIED(why="there is no floor")) for name in ("a", "b")]
    fewer = on_fewer(Finding("c", None, None, None, False, **Reason.INVISIBLE()._asdict()), 3)
    quoted = Finding("d", None, None, None, False, why="not tried: so says the user", reason=Reason.NOT_SEEN)
    text = str(diagnosis(*absent, fewer, quoted))
    assert "- not tried, there is no floor: a, b\n" in text
    assert "- c: tried on fewer recordings" in text and "- d: not seen" in text
    details = diagnosis(*absent, fewer, quoted).summary(details=True)
    assert "on 3 recordings: cannot be seen" in details and "  not tried: so says the user" in details


def test_what_was_not_tried_on_fewer_recordings_was_not_tried_at_all():
    absent = untested("a", Reason.NOT_TRIED(why="there is no floor"))
    assert on_fewer(absent, 3) == absent


def test_the_report_says_why_a_number_is_withheld():
    entry = {"value": None, "low": None, "high": None, "unit": "1", "why": "too few segments tell it"}
    held = replace(diagnosis(), parameters={"friction": {"coefficient": entry}})
    lines = [line.split() for line in str(held).splitlines() if "coefficient" in line]
    assert lines[0] == ["friction", "coefficient", "withheld"]
    assert lines[1] == ["friction", "coefficient", "withheld:", *entry["why"].split()]
    assert json.loads(json.dumps(held.to_json()))["parameters"]["friction"]["coefficient"] == entry
