"""Sets that do as well as each other are told in as few words as they need, and none is lost."""

from itertools import product

import pytest

from hlcs.report.alternatives import crossed, crossing_told


@pytest.mark.parametrize(
    ("choices", "together"),
    [
        ([["a", "c"], ["b", "c"], ["a", "d"], ["b", "d"]], [(("a", "b"), ("c", "d"))]),
        ([["a"], ["b"], []], [(("a", "b"),), ()]),
        ([["a", "c"], ["b"]], [(("a",), ("c",)), (("b",),)]),
        # d stands with a alone: a is then no longer what b is
        ([["a", "c"], ["b", "c"], ["a", "d"]], [(("a",), ("c",)), (("c",), ("b",)), (("a",), ("d",))]),
        ([["a", "b"]], [(("a",), ("b",))]),
    ],
)
def test_what_may_stand_in_each_others_place_is_written_once(choices, together):
    assert crossed(choices) == together
    chosen = [set(one) for groups in crossed(choices) for one in product(*groups)]
    assert len(chosen) == len(choices) and all(set(choice) in chosen for choice in choices)


def test_a_crossing_is_read_as_a_choice_of_each():
    told = crossing_told((("linear_drag", "quadratic_drag"), ("tilted_frame",)))
    assert told == "Linear drag or quadratic drag, with tilted frame."
