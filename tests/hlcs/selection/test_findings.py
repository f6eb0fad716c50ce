"""What is told of every candidate of a search."""

import pytest
from linear_models import sets

from hlcs.effects import Candidate, classes
from hlcs.records import Reason
from hlcs.selection.findings import candidate_findings, set_label


def told(found, absent=()):
    return candidate_findings(found, found.alternatives(), dict(absent))


def test_what_is_accepted_comes_first_and_what_was_not_tried_last(generator):
    """With a bend of 0.3 the second law misses by far: -3 t^2 / 10 cannot be seen in its place."""
    first, second, last = told(sets(0.3, generator), {"magnus": "the spin is unknown"})
    assert first.effect == "linear_drag" and first.accepted and first.reason is Reason.ACCEPTED and first.same_as == ()
    assert "held-out error falls by" in first.why and first.evidence > 100
    assert (second.effect, second.accepted) == ("spin_decay", False)
    assert (last.effect, last.evidence) == ("magnus", None) and last.why == "not tried: the spin is unknown"


def test_what_does_as_well_is_named_on_both_sides_with_its_likeness(generator):
    found = sets(0.0, generator)
    first, second = told(found)
    assert first.accepted and first.same_as == (second.effect,) and f"cannot be told from {second.effect}" in first.why
    assert second.reason is Reason.NOT_TOLD_APART and second.same_as == (first.effect,)
    assert first.cosines == {second.effect: pytest.approx(1.0)} and second.cosines == {first.effect: pytest.approx(1.0)}


def test_the_smallest_value_that_the_data_would_have_shown_has_its_unit(generator):
    assert all(
        finding.visible_from.startswith("rate 0.") and " 1/s from 0" in finding.visible_from
        for finding in told(sets(0.3, generator))
    )


def test_sets_of_look_alikes_are_named_where_two_of_them_are_alike():
    buoyancy, clock, magnus = (Candidate(name, classes()[name], ()) for name in ("buoyancy", "time_scale", "magnus"))
    assert set_label(buoyancy, [clock]) == " (effective_gravity)" and set_label(buoyancy, [magnus]) == ""
