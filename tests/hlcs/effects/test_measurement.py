"""Errors of frames, clocks and trackers, each against its own definition: what they make of a motion that is known exactly."""

import numpy as np
import pytest

from hlcs.effects.contract import Scene
from hlcs.effects.measurement import ClockOffset, TiltedFrame, TrackerSmoothing
from minibullet import rotations

STILL = Scene(np.array([True]), None, 0.0, 1.0)
TIMES = np.linspace(0, 1, 7)[None]


def parabola(times):
    """A throw, seen exactly: positions and a steady turn about z."""
    position = np.stack([2 * times, 0 * times, 3 * times - 4.905 * times**2], axis=-1)
    return position, rotations.exponential(times[..., None] * np.array([0, 0, 2.0]))


def test_a_tilted_frame_turns_what_is_seen():
    """Rotated by both angles: lengths stay, and gravity seems to lean by -9.81 sin(angle) along x."""
    position, orientation = TiltedFrame(angle_x=0.0, angle_y=0.03).look(parabola, STILL)(TIMES)
    true, turned = parabola(TIMES)
    np.testing.assert_allclose(np.linalg.norm(position, axis=-1), np.linalg.norm(true, axis=-1), rtol=1e-12)
    assert 2 * np.polyfit(TIMES[0], position[0, :, 0], 2)[0] == pytest.approx(-9.81 * np.sin(0.03), rel=1e-9)
    lean = rotations.product(orientation, rotations.conjugate(turned))
    np.testing.assert_allclose(rotations.logarithm(lean)[0], np.tile([0, 0.03, 0], (7, 1)), atol=1e-12)


def test_a_smoothing_tracker_lowers_a_parabola_by_its_curvature():
    """The mean of a t^2 / 2 over a window w lies a w^2 / 24 beside it; a window of zero is none."""
    true = parabola(TIMES)[0]
    seen = TrackerSmoothing(window=0.1).look(parabola, STILL)(TIMES)[0]
    np.testing.assert_allclose(seen - true, np.broadcast_to([0, 0, -9.81 * 0.1**2 / 24], true.shape), atol=1e-13)
    np.testing.assert_array_equal(TrackerSmoothing(window=0.0).look(parabola, STILL)(TIMES)[0], true)


def test_a_late_clock_shows_the_motion_later_and_a_body_at_rest_until_then():
    position, _ = ClockOffset(0.25).look(parabola, STILL)(TIMES)
    expected, _ = parabola(np.maximum(TIMES - 0.25, 0.0))
    np.testing.assert_array_equal(position, expected)
