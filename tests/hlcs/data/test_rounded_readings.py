"""The step of rounded readings is found in motion and at rest, and none where there is none."""

import numpy as np
import pytest

from hlcs.data.rounded_readings import reading_step


@pytest.mark.parametrize("step", [0.001, 0.00073, 0.0125])
def test_the_step_is_found_though_no_reading_repeats(generator, step):
    values = np.round(step * generator.integers(-3000, 3000, 240), 6)  # as a CSV with six decimals has them
    assert reading_step(values) == pytest.approx(step, rel=1e-4)


def test_the_step_is_found_where_no_two_neighbours_were_read(generator):
    values = 0.37 + 0.001 * np.unique(2 * generator.integers(0, 400, 60) + 3 * generator.integers(0, 400, 60))
    assert reading_step(values) == pytest.approx(0.001, rel=1e-6)


def test_a_body_at_rest_that_shows_two_values_tells_the_step(generator):
    assert reading_step(0.3 + 0.001 * generator.integers(0, 2, 40)) == pytest.approx(0.001)


def test_readings_that_are_not_rounded_have_no_step(generator):
    assert reading_step(generator.standard_normal(300)) == 0.0
    assert reading_step(generator.standard_normal(6)) == 0.0
    assert reading_step(np.full(600, 0.3)) == 0.0


def test_the_step_of_a_fast_motion_is_found_though_neighbours_lie_many_steps_apart():
    """A throw at 15 frames a second, 25 to 40 pixels from sample to sample, in a CSV with six decimals."""
    times = np.arange(40) / 15
    for step in (0.0113, 0.00731):
        values = np.concatenate([step * np.round((v * times + 0.3 * v) / step) for v in (5.81, -4.37, 7.003)])
        assert reading_step(np.round(values, 6)) == pytest.approx(step, rel=1e-3)


def test_the_last_decimal_is_a_step_too(generator):
    assert reading_step(np.round(3 * generator.standard_normal(60), 3)) == pytest.approx(0.001)


def test_small_readings_are_no_multiples_of_a_large_step():
    """Noise of 0.1 mm about zero, written with six decimals: steps of a micrometre, not of a metre."""
    values = np.round(1e-4 * np.random.default_rng(2).standard_normal(40), 6)
    assert reading_step(values) == pytest.approx(1e-6, rel=1e-6)


def test_two_heights_far_apart_are_no_two_multiples_of_their_distance(generator):
    """A block that topples at 0.1 m and the same mark at rest at 1 m, both read to a millimetre: few readings, one wide gap."""
    values = np.concatenate([0.1 + 0.001 * generator.integers(0, 7, 200), 1.0 + 0.001 * generator.integers(0, 4, 200)])
    assert reading_step(np.round(values, 6)) == pytest.approx(0.001)
