"""Numbers that a diagnosis found, as they are written into an experiment file."""

import pytest

from hlcs.data.model_entries import FILL_IN, found_entry, withheld


@pytest.mark.parametrize("value", [0.4618487231, -123.456789, 3.2e-7, 0.0])
@pytest.mark.parametrize("width", [1e-9, 3e-4, 0.02, 7.0])
def test_rounding_moves_a_number_by_less_than_a_hundredth_of_its_interval(value, width):
    entry = found_entry("drag", {"rate": {"value": value, "low": value - width / 2, "high": value + width / 2, "unit": "1"}})
    assert abs(entry["rate"] - value) <= 0.0051 * width and entry["name"] == "drag"  # half of the last digit, and its rounding


def test_a_number_without_an_interval_keeps_all_digits():
    for low, high in ((0.1234567, 0.1234567), (float("-inf"), float("inf"))):
        assert found_entry("drag", {"rate": {"value": 0.1234567, "low": low, "high": high}})["rate"] == 0.1234567


def test_a_withheld_number_is_never_written_as_if_it_were_known():
    numbers = {"coefficient": {"value": None, "low": None, "high": None, "unit": "1", "why": "one segment alone tells it"}}
    assert found_entry("friction", numbers) == {"name": "friction", "coefficient": FILL_IN}
    assert withheld(["friction"], {"friction": numbers}, False) == {"friction.coefficient": "one segment alone tells it"}
    assert withheld(["friction"], {"friction": numbers}, True) == {}


def test_what_the_data_do_not_show_is_left_out_of_the_model_and_told():
    numbers = {"velocity_x": {"value": 2.0, "low": 2.0, "high": 2.0, "unit": "m/s"}}
    numbers["velocity_y"] = {"value": None, "low": None, "high": None, "unit": "m/s", "why": "not shown", "left_out": 0.0}
    assert found_entry("uniform_flow", numbers) == {"name": "uniform_flow", "velocity_x": 2.0}
    assert withheld(["uniform_flow"], {"uniform_flow": numbers}, True) == {"uniform_flow.velocity_y": "not shown"}
    assert withheld(["uniform_flow"], {"uniform_flow": numbers}, False) == {}
