"""The record of a learned law, as JSON and as a sentence."""

import json

import numpy as np

from hlcs.learning.laws import Ranges, one_law
from hlcs.learning.learned import Learned, sentence


def number(value, half=0.1, unit="m"):
    return {"value": value, "low": value - half, "high": value + half, "unit": unit}


def law(variable, form, way):
    return one_law(variable, form, way, np.linspace(0.5, 3.0, 20), Ranges(np.array([[0.0] * 3, [1.0] * 3]), 1.0, 1.5, 12.0))


def test_json_is_as_the_contract_has_it():
    held_out = {"before": 1.0, "after": 0.1}
    learned = Learned("height", "power", {"exponent": number(2.0)}, "..", "text", held_out, {"grid": np.arange(3.0)}, ("x",))
    told = json.loads(json.dumps(learned.to_json()))
    assert told["effect_file"] == "learned_effect.py" and told["held_out"] == held_out
    assert {"variable", "form", "numbers"} <= set(told) and told["numbers"]["exponent"]["value"] == 2.0
    assert Learned("time", "oscillation", {}, "..", "", held_out, {}, ()).to_json()["effect_file"] is None


def test_the_numbers_of_a_table_are_told_with_where_they_stand():
    """By the grid of its band, in the unit of its variable."""
    numbers = {"value_1": number(2.0, unit="m/s2"), "value_2": number(1.0, unit="m/s2")}
    held_out = {"before": 1.0, "after": 0.1}
    learned = Learned("speed", "table", numbers, "..", "text", held_out, {"grid": np.array([0.5, 2.25])}, ())
    assert "value_1, at speed 0.5 m/s" in learned.summary() and "value_2, at speed 2.25 m/s" in learned.summary()


def test_sentences():
    point = {f"point_{axis}": number(value) for axis, value in zip("xyz", (2.0, 0.0, 1.0), strict=True)}
    pull = {"strength": number(1.5, unit="m/s2"), "exponent": number(-2.0)} | point
    assert sentence(law("distance", "power", "point"), pull, None, ()) == (
        "A pull towards (2.00, 0.00, 1.00) m that falls as distance^-2.00 +- 0.10, 1.50 +- 0.10 m/s2 at distance 1.8 m"
    )
    drag = {"strength": number(-1.5, unit="m/s2"), "exponent": number(1.5)}
    assert sentence(law("speed", "power", "velocity"), drag, None, ["height"]) == (
        "A force against the velocity that grows as speed^1.50 +- 0.10, 1.50 +- 0.10 m/s2 at speed 1.8 m/s "
        "(a law of height does as well)"
    )
    times = {"start_s": number(0.35, 0.01, "s"), "end_s": number(0.8, 0.01, "s")}
    fan = times | {f"strength_{axis}": number(size, 0.05, "m/s2") for axis, size in zip("xyz", (3.0, 0.0, 4.0), strict=True)}
    assert sentence(law("time", "switch", "axes"), fan, np.array([0.6, 0.0, 0.8]), ()) == (
        "A force along (0.60, 0.00, 0.80) that acts from 0.35 +- 0.01 s to 0.80 +- 0.01 s, 5.000 +- 0.050 m/s2"
    )
    shake = {"frequency_hz": number(4.6)} | {f"amplitude_{axis}": number(0.002) for axis in "xyz"}
    assert sentence(law("time", "oscillation", "axes"), shake, None, ()) == (
        "An oscillation of 4.6 Hz in x, y and z (2, 2, 2 mm): the camera shakes, or a force swings"
    )
    turning = {"mean": number(-1.0)} | {name: number(0.8) for name in ("cos_1", "sin_1", "cos_2", "sin_2")}
    assert sentence(law("heading", "table", "velocity"), turning, None, ()) == (
        "A force against the velocity that follows a table of the heading"
    )


def test_of_a_direction_and_a_place_only_what_was_measured_is_told():
    """Where z alone was measured, no data say where along x and y a force points."""
    along, table = np.array([-0.27, 0.0, 0.96]), {"mean": number(1.0)}
    one = law("time", "table", "direction")
    assert sentence(one, table, along, (), "z").startswith("A force along z that follows")
    assert sentence(one, {"mean": number(-1.0)}, along, (), "z").startswith("A force along -z that follows")
    assert sentence(one, table, along, (), "xz").startswith("A force along (-0.27, 0.96) in x and z that follows")
    assert sentence(one, table, along, ()).startswith("A force along (-0.27, 0.00, 0.96) that follows")
    pull = {"strength": number(1.5), "exponent": number(-2.0)} | {f"point_{axis}": number(2.0) for axis in "xyz"}
    assert sentence(law("distance", "power", "point"), pull, None, (), "xz").startswith(
        "A pull towards (2.00, 2.00) m in x and z"
    )


def test_a_force_along_one_axis_is_told_with_its_sign():
    ranges = Ranges(np.array([[0.0] * 3, [1.0] * 3]), 1.0, 1.5, 12.0, "z")
    for strength, along in ((2.0, "along z"), (-2.0, "along -z")):
        found = one_law("height", "power", "axes", np.linspace(0.5, 3.0, 20), ranges, "z").at([strength], [1.0])
        numbers = {each.name: number(each.value, unit=each.unit) for each in found.fitted}
        assert sentence(found, numbers, found.direction, (), "z").startswith(f"A force {along} ")
