"""Rows that repeat each other: which of them were misread, and what groups differ by. Normal scatter, seeds 0 to 199 or one."""

import numpy as np
import pytest

import hlcs
from hlcs.data.frames import csv_of
from hlcs.data.outcome_tables import off_means, read_table
from hlcs.kinds.outcomes.repeats import between_groups, groups_told, repeats_of, without_misread
from hlcs.kinds.outcomes.row_noise import between_repeats, to_know_it

HEIGHTS, SIGMA = np.repeat(np.linspace(0.5, 2.0, 7), 4), 0.01


def table(seed, wrong=(), groups=None, lag=0.0, sigma=SIGMA):
    """Falls without air, four to a height; wrong: [(row, by what)]; groups: a name for each row, those of "b" late by lag [s]."""
    times = np.sqrt(2 * HEIGHTS / 9.81) + sigma * np.random.default_rng(seed).standard_normal(len(HEIGHTS))
    for row, by in wrong:
        times[row] += by
    frame = {"height_m": HEIGHTS, "fall_time_s": times}
    if groups is not None:
        frame = {**frame, "group": groups, "fall_time_s": times + lag * (np.array(groups) == "b")}
    return read_table(csv_of(frame, "rows"))


def test_two_misread_rows_are_set_aside_and_named_and_leave_the_noise_as_it_is():
    kept, (note,) = without_misread(table(1, [(5, 0.3), (22, -0.2)]))
    assert len(kept.values) == 26 and "rows 5 (" in note and "22 (" in note
    assert between_repeats(kept).sigma == pytest.approx(SIGMA, rel=0.5)  # 19 degrees of freedom: 16 %, three times that
    assert between_repeats(table(1, [(5, 0.3), (22, -0.2)])).sigma > 5 * SIGMA


def test_of_tables_without_misreadings_one_in_a_hundred_loses_a_row_at_most():
    """1 % by the drawn distances, less by the rest of the setting; of 200 tables more than 5 have a chance of 2 %."""
    assert sum(bool(without_misread(table(seed))[1]) for seed in range(200)) <= 5


def test_of_two_rows_that_differ_none_is_misread():
    times = np.sqrt(2 * np.repeat(np.linspace(0.5, 2, 8), 2) / 9.81)
    times[3] += 1.0
    pairs = read_table(csv_of({"height_m": np.repeat(np.linspace(0.5, 2, 8), 2), "fall_time_s": times}, "rows"))
    assert without_misread(pairs)[1] == ()


def test_groups_that_differ_do_not_make_the_noise_larger():
    """Two persons, one late by ten times what each scatters by: their difference is told and is no noise of either."""
    names = np.tile(["a", "a", "b", "b"], 7)
    late, alike = table(3, groups=names, lag=0.1), table(3, groups=names)
    assert between_repeats(late).sigma == pytest.approx(SIGMA, rel=0.6)  # 14 degrees of freedom: 19 %, three times that
    assert between_groups(late).size == pytest.approx(0.1 / np.sqrt(2), rel=0.2)  # one sigma of two values 0.1 apart
    assert "from group to group" in groups_told(late)[0]
    assert "lie, in s, b +0.049, a -0.049" in groups_told(late)[0]  # half of 0.1, and what 14 rows scatter by
    assert groups_told(alike) == () and repeats_of(alike).freedom == 21  # then all rows of a height repeat each other


def test_a_misread_rebound_hides_no_restitution():
    """e = 0.785 where 0.8 is stated, five times what 28 rows tell it to; without the rows set aside the noise hid it."""
    speed = np.repeat(np.linspace(1, 4, 7), 4)
    rebound = 0.785 * speed + 0.015 * np.random.default_rng(2).standard_normal(28)
    rebound[9], rebound[17] = rebound[9] + 0.3, rebound[17] - 0.4
    experiment = hlcs.Experiment.from_frames(
        [{"impact_speed_m_s": speed, "rebound_speed_m_s": rebound}],
        {"shape": "sphere", "radius": 0.02, "mass": 0.26},
        {"restitution": 0.8},
        kind="outcomes",
    )
    found = hlcs.diagnose(experiment, candidates=["restitution"])
    assert (found.verdict, found.effects) == ("effect", ("restitution",)) and any("set aside" in note for note in found.notes)


def read_to(digit, sigma, seed=0):
    """Falls without air, four to a height, with normal scatter, read to a digit [s]."""
    times = table(seed, sigma=sigma).values
    return read_table(csv_of({"height_m": HEIGHTS, "fall_time_s": np.round(times / digit) * digit}, "rows"))


@pytest.mark.parametrize("digit", [0.1, 0.01])  # of four times 0.1 the sum over four is no 0.1 to the last bit, in some settings
def test_repeats_that_agree_to_the_last_digit_tell_no_noise_and_what_to_state_is_told(digit):
    agreeing = read_to(digit, 0.0)
    assert between_repeats(agreeing) is None
    assert f"fall_time_s = {digit / np.sqrt(12):.2g} }}, what the last digit ({digit:g} s) leaves" in to_know_it(agreeing)
    assert "so they were rounded or copied" in to_know_it(agreeing)
    assert "repeat some rows" in to_know_it(read_table(csv_of({"height_m": [1, 2, 3], "fall_time_s": [0.4, 0.6, 0.8]}, "rows")))
    two = read_table(csv_of({"height_m": [1, 1, 2, 2], "fall_time_s": [0.4, 0.41, 0.6, 0.62]}, "rows"))
    assert "3 repeats tell a noise, here are 2" in to_know_it(two)


@pytest.mark.parametrize("third", [3, 6, 9])  # rows: a mean of three times 0.7 is 0.7 less one in the last bit
def test_the_mean_of_equal_readings_is_that_reading(third):
    values = np.repeat([0.3, 0.7, 1.1], third)
    assert not off_means(values, np.repeat([4, 2, 9], third)).any()


@pytest.mark.parametrize("sigma", [0.001, 0.002, 0.005])
def test_the_noise_of_repeats_is_no_less_than_the_last_digit_leaves(sigma):
    """Most of the repeats agree, read to 10 ms: they differ by less than what rounding leaves, 10 ms over the root of 12."""
    for seed in range(5):
        rounded = between_repeats(read_to(0.01, sigma, seed))
        assert rounded is None or rounded.sigma > 0.0099 / np.sqrt(12)


def test_many_repeats_of_one_setting_are_not_cut_by_what_they_read():
    """Falls through nothing, two thirds of them from one height: rows of equal inputs are sorted by what they read, and a range
    of the main input that began among them held the long ones alone.
    """
    draw = np.random.default_rng(3)
    heights = np.concatenate([np.repeat([0.5, 1.0, 1.5, 2.0, 2.5], 4), np.full(40, 3.0)])
    frame = {"height_m": heights, "fall_time_s": np.sqrt(2 * heights / 9.81) + 0.02 * draw.standard_normal(len(heights))}
    noise, around = {"fall_time_s": 0.02}, {"fluid_density": 0.0}
    assert hlcs.compare(hlcs.Experiment.from_frames(frame, {}, around, noise=noise, kind="outcomes")).adequate
