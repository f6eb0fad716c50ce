"""Scatter of rows that grows with what they read: seen by the repeats, and each row then weighs by its own."""

from pathlib import Path

import numpy as np
import pytest

import hlcs
from hlcs.data.outcome_tables import OutcomeTable
from hlcs.kinds.outcomes.row_noise import growing

G = 9.81
SPEEDS = np.repeat([0.4, 0.7, 1.1, 1.6, 2.2, 3.0], 5)  # m/s
STOPS = SPEEDS**2 / (2 * 0.33 * G)  # where a block stops by Coulomb's law [m]


def table(values):
    each, setting = np.arange(len(values)), np.unique(SPEEDS, return_inverse=True)[1]
    nobody = np.full(len(values), "")
    return OutcomeTable(Path("t.csv"), "stop_distance_m", values, {"speed_m_s": SPEEDS}, nobody, setting, each, ())


def test_rows_that_scatter_alike_are_seldom_said_to_scatter_more():
    """At the level of 1 %, of 500 tables five are: fifteen at most (Poisson, one in ten thousand)."""
    normal = np.random.default_rng(1).standard_normal((500, len(STOPS)))
    assert sum(growing(table(STOPS + 0.01 * each)) is not None for each in normal) <= 15


def test_scatter_in_proportion_is_seen_and_its_size_told():
    """24 degrees of freedom know a standard deviation to 14 %; three times that."""
    for seed in range(10):
        found = growing(table(STOPS * (1 + 0.01 * np.random.default_rng(seed).standard_normal(len(STOPS)))))
        assert found.share > 0.95
        assert found.at(STOPS.max()) == pytest.approx(0.01 * STOPS.max(), rel=0.45)


def experiment(stops, friction, speeds=SPEEDS):
    body, frame = {"shape": "box", "size": [0.1, 0.06, 0.04], "mass": 0.15}, {"speed_m_s": speeds, "stop_distance_m": stops}
    return hlcs.Experiment.from_frames([frame], body, {"friction": friction}, kind="outcomes")


def test_repeats_that_agree_to_the_last_digit_scatter_as_it_leaves_them():
    """Three settings of five rows read to a centimetre: a right model agrees with them, but for one in a hundred."""
    speeds = np.repeat([0.4, 1.5, 3.0], 5)
    for seed in range(8):
        stops = speeds**2 / (2 * 0.3 * G) * (1 + 0.02 * np.random.default_rng(seed).standard_normal(len(speeds)))
        assert hlcs.compare(experiment(np.round(stops, 2), 0.3, speeds)).adequate


def test_rows_weigh_by_what_is_expected_of_them_and_not_by_what_was_read():
    """Two rows of each of thirty settings, 15 % off each: weights of their own means make friction 0.010 too large, 0.006 is one
    standard error; the mean of eight is told to 0.002, three times that."""
    speeds = np.repeat(np.linspace(0.6, 3.0, 30), 2)
    numbers = []
    for seed in range(8):
        stops = speeds**2 / (2 * 0.33 * G) * (1 + 0.15 * np.random.default_rng(seed).standard_normal(len(speeds)))
        found = hlcs.diagnose(experiment(stops, 0.25, speeds), candidates="friction")
        numbers.append(found.parameters["friction"]["coefficient"]["value"])
    assert np.mean(numbers) == pytest.approx(0.33, abs=0.006)


def test_the_numbers_of_proportional_scatter_are_inside_their_intervals():
    """Friction of 0.33 in place of 0.3: the truth is inside 90 % of the intervals, of ten at least six (binomial, 1 in 600)."""
    inside = 0
    for seed in range(10):
        stops = STOPS * (1 + 0.01 * np.random.default_rng(100 + seed).standard_normal(len(STOPS)))
        number = hlcs.diagnose(experiment(stops, 0.3), candidates="friction").parameters["friction"]["coefficient"]
        inside += number["low"] < 0.33 < number["high"]
    assert inside >= 6


def test_rows_scatter_as_what_they_read_and_not_as_what_a_wrong_model_foretells():
    """Friction of 1.5 in place of 0.33 stops the block after a fifth of the way: the noise stays the 1 % of what was read."""
    stops = STOPS * (1 + 0.01 * np.random.default_rng(3).standard_normal(len(STOPS)))
    wrong, right = (hlcs.compare(experiment(stops, friction)) for friction in (1.5, 0.33))
    assert right.adequate and not wrong.adequate
    for seen in (wrong, right):
        assert seen.error["noise"] == pytest.approx(0.01 * np.sqrt(np.mean(STOPS**2)), rel=0.3)
    assert wrong.error["noise"] == pytest.approx(right.error["noise"], rel=0.01)
