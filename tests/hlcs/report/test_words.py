"""Numbers as reports tell them: with units, to the digits that mean something, nothing rounded to more than it is."""

import pytest

from hlcs.report.words import chance, interval, joined, share, size, span, value


@pytest.mark.parametrize(
    ("number", "unit", "told"),
    [
        (0.124, "m", "124 mm"),
        (0.00315, "m", "3.15 mm"),
        (1.574, "m", "1.57 m"),
        (0.0123, "s", "12.3 ms"),
        (0.01383, "1", "1.38 %"),
        (0.0031, "rad", "0.0031 rad"),
        (0.0, "m", "0 mm"),
        (None, "m", "-"),
    ],
)
def test_an_error_has_its_unit_and_three_digits(number, unit, told):
    assert size(number, unit) == told


def test_a_number_shows_the_digits_that_its_interval_leaves():
    entry = {"value": 1.0300155, "low": 1.029624, "high": 1.030406, "unit": "1"}
    assert value(entry) == "1.03002 +- 0.00039" and interval(entry) == "1.02962 to 1.03041"
    assert value({"value": 2.0, "low": 1.0, "high": 6.0, "unit": "m/s"}) == "2.0 (1.0 to 6.0) m/s"  # not the same on both sides
    assert value({"value": 1.36e-6, "low": 1.02e-6, "high": 1.70e-6, "unit": "m/N"}) == "(1.36 +- 0.34)e-06 m/N"
    arm = {"value": 5.749e-5, "low": 5.669e-5, "high": 5.829e-5, "unit": "m"}  # one power of ten for a number and its interval
    assert value(arm) == "(5.749 +- 0.080)e-05 m" and interval(arm) == "5.669e-05 to 5.829e-05"
    scale = {"value": -0.8936612, "low": -0.8936676, "high": -0.8936548, "unit": "1"}  # many digits are no reason for a power
    assert value(scale) == "-0.8936612 +- 0.0000064" and interval(scale) == "-0.8936676 to -0.8936548"
    assert interval({"low": -1.2e-7, "high": 3.4e-7}) == "-1.2e-07 to 3.4e-07"
    assert value({"value": 1.0, "low": 1.0, "high": 1.0, "unit": "1"}) == "1"  # of a switch, which has no interval
    wind = {"value": 1.332, "low": -1.45, "high": 1.45, "unit": "m/s", "mirrored": -1.332}
    assert value(wind) == "1.3 or -1.3 (-1.4 to 1.4) m/s"  # either sign would do
    assert value({"value": None, "low": None, "high": None, "unit": "m"}) == "withheld"


def test_a_share_is_never_rounded_up_to_all():
    assert [share(part) for part in (0.5, 0.979, 0.9969, 0.99949, 0.99999, 1.0)] == [
        "50 %",
        "97 %",
        "99.6 %",
        "99.9 %",
        "more than 99.9 %",
        "more than 99.9 %",
    ]


@pytest.mark.parametrize("draws", [99, 600, 4000])
def test_no_probability_is_told_below_what_its_draws_can_show(draws):
    least = 1 / (draws + 1)
    assert float(chance(least, draws).split()[0]) >= 0.95 * least and f"none of {draws} draws" in chance(least, draws)
    assert chance(0.25, draws) == "0.25" and chance(None) == "unknown"


def test_lists_read_as_sentences():
    assert [joined(items) for items in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == ["", "a", "a and b", "a, b and c"]


def test_a_span_tells_its_unit_once_where_both_ends_have_it():
    assert span(("3 mm", "3 mm")) == "3 mm" and span(("13.2 mm", "14.5 mm")) == "13.2 to 14.5 mm"
    assert span(("900 mm", "1.2 m")) == "900 mm to 1.2 m" and span(("53 %", "more than 99.9 %")) == "53 to more than 99.9 %"
