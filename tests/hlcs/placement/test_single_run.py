"""One run of a placement test: it ends with a result or with a complaint."""

import pytest

import hlcs
from hlcs.placement import single_run
from hlcs.placement.single_run import layer_coefficients_of
from minibullet.errors import InputError


def test_a_refused_placement_leaves_a_complaint_not_a_crash():
    # 15 degrees of friction angle cannot hold five layers on a grid this wide: no plate finds a bed
    test = hlcs.PlacementTest(grid="3.5,3.5", layers=2, rows=2, columns=2, friction=0.0, time_step=1 / 60, settle_time=2.0)
    result = layer_coefficients_of(test)
    assert set(result) in ({"error"}, {"k", "lost"})


def test_a_simulation_that_stalls_is_given_up_with_a_complaint(monkeypatch):
    monkeypatch.setattr(single_run, "LIMIT", 0.05)
    result = layer_coefficients_of(hlcs.PlacementTest(layers=3, rows=6, columns=6, time_step=1 / 480))
    assert "processor time" in result["error"]
    monkeypatch.setattr(single_run, "LIMIT", 60.0)
    assert (
        len(layer_coefficients_of(hlcs.PlacementTest(layers=1, rows=2, columns=2))["k"]) == 1
    )  # no clock of the last one is running


def test_a_limit_that_strikes_inside_compiled_code_is_the_same_complaint():
    """Compiled code hands on what a signal raised inside of it as SystemError; one that no limit caused stays what it is."""
    with pytest.raises(InputError, match="processor time"), single_run.at_most(0.01):
        try:
            while True:
                pass
        except InputError as problem:
            raise SystemError("returned a result with an exception set") from problem
    with pytest.raises(SystemError, match="another"), single_run.at_most(60.0):
        raise SystemError("another")


def test_a_limit_that_strikes_inside_a_check_of_numbers_is_the_same_complaint():
    """A check that takes every ValueError for wrong numbers, as the complaint is one, would blame the input."""
    with pytest.raises(InputError, match="processor time"), single_run.at_most(0.01):
        try:
            while True:
                pass
        except ValueError:
            raise InputError("it needs 3 numbers") from None
    with pytest.raises(InputError, match="3 numbers"), single_run.at_most(60.0):
        raise InputError("it needs 3 numbers")


def test_a_limit_whose_complaint_was_lost_strikes_again():
    with pytest.raises(InputError, match="processor time"), single_run.at_most(0.01):
        try:
            while True:
                pass
        except InputError:
            pass  # as in a callback of a C library, which can only print it
        while True:
            pass
