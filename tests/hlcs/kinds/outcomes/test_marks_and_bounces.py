"""Times between marks, times of the sounds of bounces, speeds about impacts: closed forms, and what is found in them."""

import numpy as np
import pytest
from scipy.optimize import brentq

import hlcs
from hlcs.data.experiment_file import Body, Surroundings
from hlcs.effects.contract import Setup
from hlcs.simulation.outcome_motion import bounce_interval, bounce_time, passage_time, rebound_speed
from minibullet.effects import Gravity, LinearDrag, Restitution, VelocityDependentRestitution
from minibullet.errors import InputError

G, BALL = 9.81, {"shape": "sphere", "radius": 0.02, "mass": 0.04}
LINES = ("mark_1_m", "mark_2_m")
MARKS = {"start_speed_m_s": [0.0, 1.0, 3.0], "mark_1_m": [0.0, 0.2, 0.0], "mark_2_m": [0.5, 0.6, 2.0]}
SETUP = Setup(Body(radius=0.02, mass=0.04), Surroundings(fluid_density=0.0))


def measured(columns, **surroundings):
    return hlcs.Experiment.from_frames(columns, BALL, {"fluid_density": 0.0, **surroundings}, kind="outcomes")


def test_a_passage_of_marks_is_that_of_a_throw_downwards():
    """t = (sqrt(v^2 + 2 g d) - v) / g at depth d."""
    inputs = {name: np.array(values) for name, values in MARKS.items()}
    found = passage_time([SETUP] * 3, (Gravity(G),), inputs)
    at = [(np.sqrt(inputs["start_speed_m_s"] ** 2 + 2 * G * inputs[mark]) - inputs["start_speed_m_s"]) / G for mark in LINES]
    np.testing.assert_allclose(found, at[1] - at[0], rtol=1e-9)


def test_the_nth_bounce_is_heard_after_n_flights():
    """t_n = t_1 (1 + 2 e + .. + 2 e^(n-1)) without air."""
    inputs = {"height_m": np.full(5, 0.8), "bounce": np.arange(1.0, 6.0)}
    found = bounce_time([SETUP] * 5, (Gravity(G), Restitution(0.9)), inputs)
    flights = np.r_[1.0, 2 * 0.9 ** np.arange(1, 5)]
    np.testing.assert_allclose(found, np.sqrt(2 * 0.8 / G) * np.cumsum(flights), rtol=1e-8)


def test_a_speed_after_an_impact_is_that_of_the_law():
    speeds = np.array([0.5, 1.0, 4.0])
    laws = Gravity(G), Restitution(0.8), VelocityDependentRestitution(exponent=0.2)
    found = rebound_speed([SETUP] * 3, laws, {"impact_speed_m_s": speeds})
    np.testing.assert_allclose(found, np.minimum(0.8 * speeds**-0.2, 1.0) * speeds, rtol=1e-12)


def test_the_restitution_is_heard_in_the_times_of_bounces():
    """Five bounces of each of four balls let go at 1 m, heard to 2 ms, where the model has none."""
    bounce = np.tile(np.arange(1.0, 6.0), 4)
    flights = np.cumsum(np.r_[1.0, 2 * 0.85 ** np.arange(1, 5)])
    times = np.sqrt(2 / G) * flights[bounce.astype(int) - 1] + 0.002 * np.random.default_rng(1).standard_normal(20)
    columns = {"height_m": np.ones(20), "bounce": bounce, "bounce_time_s": times}
    found = hlcs.diagnose(measured(columns), candidates=["restitution", "clock_offset", "time_scale"])
    assert (found.verdict, found.effects) == ("effect", ("restitution",))
    assert found.parameters["restitution"]["coefficient"]["value"] == pytest.approx(0.85, abs=0.002)


def test_the_restitution_is_heard_between_bounces_whenever_the_ball_was_let_go():
    """Impacts alone, 2 e^n sqrt(2 h/g) from the n-th to the next one, to 2 ms; a clock that starts late is no candidate."""
    height, bounce = np.repeat([0.6, 1.0, 0.6, 1.0], 5), np.tile(np.arange(1.0, 6.0), 4)
    exact = 2 * 0.85**bounce * np.sqrt(2 * height / G)
    inputs = {"height_m": height, "bounce": bounce}
    np.testing.assert_allclose(bounce_interval([SETUP] * 20, (Gravity(G), Restitution(0.85)), inputs), exact, rtol=1e-9)
    times = exact + 0.002 * np.random.default_rng(4).standard_normal(20)
    found = hlcs.diagnose(measured(inputs | {"bounce_interval_s": times}), candidates=["restitution", "time_scale"])
    assert (found.verdict, found.effects) == ("effect", ("restitution",))
    assert found.parameters["restitution"]["coefficient"]["value"] == pytest.approx(0.85, abs=0.003)


def test_a_drag_is_found_between_marks():
    """Thrown down at 2 m/s, timed between depths of 0.1 m and 0.5 to 2 m to 1 ms; v' = g - k v in closed form, k = 1.5."""
    depth, k, v = np.repeat([0.5, 0.8, 1.2, 1.6, 2.0], 4), 1.5, 2.0

    def sunk(t):
        return G / k * t - (G / k - v) * -np.expm1(-k * t) / k

    at = {d: brentq(lambda t, d=d: sunk(t) - d, 0.0, 10.0, xtol=1e-13) for d in {0.1, *depth}}
    exact = np.array([at[d] - at[0.1] for d in depth])
    same = np.ones(20)
    inputs = {"start_speed_m_s": v * same, "mark_1_m": 0.1 * same, "mark_2_m": depth}
    np.testing.assert_allclose(passage_time([SETUP] * 20, (Gravity(G), LinearDrag(k)), inputs), exact, rtol=1e-9)
    times = exact + 0.001 * np.random.default_rng(2).standard_normal(20)
    found = hlcs.diagnose(
        measured(inputs | {"passage_time_s": times}, fluid_density=1.2), candidates=["linear_drag", "length_scale"]
    )
    assert (found.verdict, found.effects) == ("effect", ("linear_drag",))
    number = found.parameters["linear_drag"]["rate"]
    assert number["low"] < k < number["high"] and number["high"] - number["low"] < 0.1


def test_a_restitution_is_found_from_speeds_before_and_after():
    before = np.repeat([0.5, 1.0, 2.0, 3.0, 4.0, 5.0], 4)
    after = 0.7 * before + 0.02 * np.random.default_rng(3).standard_normal(24)
    found = hlcs.diagnose(measured({"impact_speed_m_s": before, "rebound_speed_m_s": after}))
    assert (found.verdict, found.effects) == ("effect", ("restitution",))
    assert found.parameters["restitution"]["coefficient"]["value"] == pytest.approx(0.7, abs=0.005)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"height_m": [1, 1, 1], "bounce": [1, 1.5, 2], "bounce_time_s": [0.4, 1, 2]}, "row 1, column bounce: 1.5; bounces are"),
        ({"height_m": [1, 1, 1], "bounce": [1, 0, 2], "bounce_interval_s": [1, 1, 1]}, "column bounce: 0 cannot be right"),
        ({"height_m": [1, 1, 1], "bounce_interval_s": [1, 1, 1]}, "bounce_interval_s needs the column 'bounce'"),
        ({"height_m": [1, 1, 1], "bounce_time_s": [0.4, 1, 2]}, "bounce_time_s needs the column 'bounce'"),
        (
            {"mark_1_m": [0.2] * 3, "mark_2_m": [0.5, 0.1, 0.5], "passage_time_s": [1, 1, 1]},
            "column mark_2_m: 0.1 where the first",
        ),
        ({"mark_1_m": [0.2] * 3, "passage_time_s": [1, 1, 1]}, "passage_time_s needs the column 'mark_2_m'"),
        ({"impact_speed_m_s": [-1, 1, 1], "rebound_speed_m_s": [1, 1, 1]}, "column impact_speed_m_s: -1 cannot be right"),
    ],
)
def test_what_was_not_measured_so_is_refused(columns, message):
    with pytest.raises(InputError) as problem:
        hlcs.compare(measured(columns))
    assert message in str(problem.value)


def test_times_that_begin_at_the_first_impact_are_refused_with_what_is_to_be_added():
    """A list of sounds counts from the first one, which of a ball that is let go is its first impact."""
    columns = {"height_m": np.full(3, 0.3), "bounce": np.arange(1.0, 4.0), "bounce_time_s": np.array([0.0, 0.46, 0.88])}
    experiment = hlcs.Experiment.from_frames(columns, BALL, {"fluid_density": 0.0}, kind="outcomes", noise=0.001)
    with pytest.raises(hlcs.InputError, match="from the first impact, add the time of the fall to each"):
        hlcs.compare(experiment)


@pytest.mark.parametrize("first", [None, 0.1])
def test_a_late_release_shifts_what_is_timed_from_it_and_nothing_between_marks(first):
    """A magnet that lets go 35 ms late; sigma 1 ms."""
    depth = np.repeat([0.2, 0.4, 0.6, 0.8, 1.0, 1.3, 1.6], 5)
    times = np.sqrt(2 * depth / G) + 0.001 * np.random.default_rng(2).standard_normal(len(depth))
    columns = {"mark_2_m": depth, "passage_time_s": times + 0.035}
    if first:
        columns = {"mark_1_m": np.full(len(depth), first), "mark_2_m": depth, "passage_time_s": times - np.sqrt(2 * first / G)}
    found = hlcs.diagnose(measured(columns))
    if first:
        assert found.verdict == "complete" and "its clock starts at the first mark: clock_offset" in str(found)
    else:
        number = found.parameters["clock_offset"]["offset"]
        assert found.effects == ("clock_offset",) and number["low"] < 0.035 < number["high"]
