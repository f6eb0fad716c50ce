"""A finished test looked at again: the fall starts where the units hang and ends where they rest; plates read what they read."""

from dataclasses import replace

import numpy as np
import pytest

from hlcs.placement import playback


@pytest.fixture(scope="module")
def fall(small_test):
    return playback.record_fall(small_test, 2, every=0.05, most=12)


def test_watching_changes_no_bit_and_the_last_frame_is_the_rest(fall, small_result):
    for ours, theirs in zip(fall.result.poses, small_result.poses, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(fall.poses[-1], small_result.poses[1])
    assert fall.poses.shape == (12, 4, 7) and fall.times[0] == 0.0 and np.all(np.diff(fall.times) > 0)


def test_units_fall_freely_until_they_touch(fall, small_test):
    """Frames 0.05 s apart, the first after one step: z falls by g (t + dt)^2 / 2, which takes 0.0123 m from the first to the
    second; the falling distance of 0.25 Dn lasts 0.23 s. 1e-9: rounding, the step is exact for a constant force."""
    step = small_test.time_step
    t = fall.times[:3] + step
    dropped = fall.poses[0, :, 2] - fall.poses[:3, :, 2]
    np.testing.assert_allclose(dropped, (4.905 * (t**2 - t[0] ** 2))[:, None] * np.ones(4), atol=1e-9)


@pytest.mark.parametrize("layer", [1, 2])
def test_plates_laid_again_read_the_same_heights(small_result, layer):
    found = playback.lay_plates(small_result, layer)
    np.testing.assert_array_equal(found.heights, small_result.readings[layer - 1])
    assert found.poses.shape == (9, 7) and found.carried_by == small_result.carried_by[layer - 1]


def test_a_margin_is_laid_again_too(small_test):
    result = replace(small_test, margin=0.01, plate_margin=0.01, layers=1).run()
    np.testing.assert_array_equal(playback.lay_plates(result, 1).heights, result.readings[0])
