"""Heights and times of falls in each other's column are refused, and no fall that may be, however slow, is taken for them."""

import numpy as np
import pytest

import hlcs
from hlcs.data.validation import exchanged
from minibullet.errors import InputError

G = 9.81


def falls(heights, times):
    """An Experiment of falls."""
    columns = {"height_m": heights, "fall_time_s": times}
    return hlcs.Experiment.from_frames(columns, kind="outcomes", body={"shape": "sphere"}, noise={"outcome": 0.01})


@pytest.mark.parametrize("drag", [0.0, 0.1])  # per metre: the times of a table tennis ball are up to 5 % longer
def test_heights_and_times_that_stand_in_each_others_column_are_refused(drag, generator):
    """Read with a stopwatch to 20 ms. As they stand they are right."""
    heights = np.repeat([0.5, 1.0, 1.5, 2.0, 2.5, 3.0], 4)
    times = np.arccosh(np.exp(drag * heights)) / np.sqrt(G * drag) if drag else np.sqrt(2 * heights / G)
    times = times + 0.02 * generator.standard_normal(len(heights))
    with pytest.raises(InputError, match="columns height_m and fall_time_s: .* are the columns mixed up?"):
        hlcs.compare(falls(times, heights))
    hlcs.compare(falls(heights, times))


@pytest.mark.parametrize("spread", [1.0, 1.5, 3.0, 10.0])
def test_no_fall_that_may_be_is_taken_for_one(spread, generator):
    """Falls from rest under v' = g - g (v/u)^n, n = 1, 2: filters, balloons, beads in glycerine, stones; times to a tenth.

    Heights and final speeds u take all sizes around those at which height and time are alike in number (0.2 m, 0.2 s)."""
    fractions = np.linspace(1.0, spread, 8)
    for low in np.geomspace(0.02, 5.0, 12):
        for u in np.geomspace(0.003, 30.0, 60):
            heights = low * fractions
            t = np.linspace(0.0, 3 * (heights.max() / u + u / G + np.sqrt(2 * heights.max() / G)), 60001)
            linear = u * t - u**2 / G * -np.expm1(-G * t / u)
            quadratic = u**2 / G * (np.logaddexp(G * t / u, -G * t / u) - np.log(2))
            for way in (linear, quadratic):
                times = np.interp(heights, way, t) * (1 + 0.1 * generator.uniform(-1, 1, len(heights)))
                assert not exchanged(heights, times, G), (low, u, spread)
