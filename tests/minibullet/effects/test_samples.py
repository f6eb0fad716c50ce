"""Units in words, as exponents of metre, kilogram, second."""

import pytest

from minibullet.effects import samples


@pytest.mark.parametrize(
    ("unit", "dimensions"),
    [
        ("kg/m3", (-3, 1, 0)),
        ("1/s", (0, 0, -1)),
        ("Pa s", (-1, 1, -1)),
        ("m/s2", (1, 0, -2)),
        ("-", (0, 0, 0)),
        ("N/m", (0, 1, -2)),
        ("s/m", (-1, 0, 1)),
        ("bananas", None),
    ],
)
def test_units_are_read(unit, dimensions):
    assert samples.dimensions_of(unit) == dimensions
