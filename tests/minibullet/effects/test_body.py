"""Gravity, level and tilted, against its formula."""

import numpy as np
import pytest
from one_ball import G, acceleration, ball

from minibullet import effects


def test_gravity_is_weight():
    assert np.allclose(acceleration([effects.Gravity(G)], ball()), [0, 0, -G], rtol=1e-15)
    assert np.allclose(acceleration([effects.Gravity(2.0, direction=(3, 0, 4))], ball()), [1.2, 0, 1.6], rtol=1e-15)


def test_tilted_gravity_turns_gravity_and_keeps_its_size():
    """About x by +a: towards +y; about y by +b: towards -x; |g| unchanged."""
    level = effects.Gravity(G)
    sine, cosine = G * np.sin(0.03), G * np.cos(0.03)
    assert np.allclose(acceleration([level, effects.TiltedGravity(angle_x=0.03)], ball()), [0, sine, -cosine], rtol=1e-13)
    assert np.allclose(acceleration([level, effects.TiltedGravity(angle_y=0.03)], ball()), [-sine, 0, -cosine], rtol=1e-13)
    both = acceleration([level, effects.TiltedGravity(0.04, -0.03)], ball())
    assert np.linalg.norm(both) == pytest.approx(G, rel=1e-14)
