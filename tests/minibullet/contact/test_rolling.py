"""The moment of rolling resistance within its disc."""

import numpy as np
import pytest

from minibullet.contact.rolling import moment_within_disc


@pytest.mark.parametrize("k12", [0.0, 3.0, 9.999])
@pytest.mark.parametrize("limit", [1e-120, 1e-30, 1e-3, 0.3, 10.0])
def test_the_moment_stops_the_rotation_or_opposes_what_is_left_of_it(k12, limit):
    """K m = c within the disc; at its edge m is along the rotation c - K m that is left, which is how much it dissipates most."""
    stiffness, c = np.array([[5.0, k12], [k12, 20.0]]), np.array([1.0, -2.0])
    m = np.array(moment_within_disc(5.0, k12, 20.0, tuple(c), limit))
    left = c - stiffness @ m
    size = np.hypot(*m)
    assert size <= limit * (1 + 1e-15)
    if size < limit * (1 - 1e-12) and limit > 1e-100:
        np.testing.assert_allclose(left, 0.0, atol=1e-13)
    elif limit > 1e-100:
        np.testing.assert_allclose(m / limit, left / np.hypot(*left), rtol=0, atol=1e-9)
    else:
        assert size == 0.0  # a load that dies away
