"""What is sooner than freely or higher than it fell is refused with its remedy, and nothing that may be is."""

import warnings

import numpy as np
import pytest

import hlcs
from hlcs.data.frames import csv_of
from hlcs.data.free_falls import exchanged, free_times
from hlcs.data.outcome_tables import read_table
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


BODY = {"shape": "box", "size": [0.1, 0.1, 0.1], "mass": 1.0}
FALLS = np.repeat([0.5, 1.0, 1.5, 2.0], 3)
EXACTLY = {"fall_time_s": np.round(np.sqrt(2 * FALLS / G), 3)}  # repeats agree: the noise is unknown


def told(columns, **surroundings):
    """The warnings of a comparison of a table whose noise may be unknown."""
    around = {"friction": 0.3, "restitution": 0.9, "fluid_density": 0.0} | surroundings
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        hlcs.compare(hlcs.Experiment.from_frames(columns, kind="outcomes", body=BODY, surroundings=around))
    return [str(one.message) for one in said]


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"height_m": 100 * FALLS, **EXACTLY}, "a fall of 98. m/s2 .* look like centimetres, multiply them by 0.01, or let"),
        ({"height_m": 1000 * FALLS[:6], "fall_time_s": EXACTLY["fall_time_s"][:6]}, "millimetres, multiply them by 0.001"),
        ({"height_m": FALLS / 0.0254, **EXACTLY}, "look like inches, multiply them by 0.0254"),
        ({"height_m": FALLS, "fall_time_s": 1000 * EXACTLY["fall_time_s"]}, "milliseconds, divide them by 1000, or let"),
        ({"mark_1_m": 20 * FALLS, "mark_2_m": 60 * FALLS, "passage_time_s": 0.1 * FALLS}, "multiply centimetres by 0.01"),
        ({"height_m": 0 * FALLS, **EXACTLY}, "column height_m: 0 in all rows, where fall_time_s is up to 0.639 s"),
    ],
)
def test_units_that_cannot_be_are_refused_with_their_remedy_whether_the_noise_is_known_or_not(columns, words):
    with pytest.raises(InputError, match=words):
        told(columns)
    assert told({"height_m": FALLS, **EXACTLY}) == []


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.25])
def test_angles_in_radians_are_refused_and_slides_of_small_angles_are_not(friction, generator):
    """A block slides at g (sin a - mu cos a): an air track at one degree, a plank at 25 to 40, times to 10 ms."""
    angles, ways = np.repeat([25.0, 30.0, 35.0, 40.0], 4), np.tile([0.5, 1.0, 1.0, 0.5], 4)
    a = np.deg2rad(angles)
    times = np.sqrt(2 * ways / (G * (np.sin(a) - friction * np.cos(a)))) + 0.01 * generator.standard_normal(16)
    with pytest.raises(InputError, match="look like radians, multiply them by 57.2958"):
        told({"angle_deg": a, "distance_m": ways, "slide_time_s": times})
    assert told({"angle_deg": angles, "distance_m": ways, "slide_time_s": times}, friction=friction) == []
    slow = np.sqrt(2 * ways / (G * np.sin(a / 40))) + 0.01 * generator.standard_normal(16)
    assert told({"angle_deg": angles / 40, "distance_m": ways, "slide_time_s": slow}, friction=0.0) == []


def test_the_least_time_is_that_of_motion_through_nothing():
    """Uniformly accelerated motion at g sin a from a speed v: s = v t + g sin a t^2 / 2."""
    t, v, a = np.array([0.3, 0.7, 1.1]), 0.8, np.deg2rad(20.0)
    way = v * t + G * np.sin(a) * t**2 / 2
    slides = {"angle_deg": [20.0] * 3, "speed_m_s": [v] * 3, "distance_m": way, "slide_time_s": t}
    np.testing.assert_allclose(free_times(read_table(csv_of(slides, "rows")), G)[0], t)
    depth = [v * t + G * t**2 / 2 for t in (t, t + 0.2)]
    marks = {"start_speed_m_s": [v] * 3, "mark_1_m": depth[0], "mark_2_m": depth[1], "passage_time_s": [0.2] * 3}
    np.testing.assert_allclose(free_times(read_table(csv_of(marks, "rows")), G)[0], 0.2)


@pytest.mark.parametrize(
    ("before", "after", "power"), [("height_m", "rebound_height_m", 2), ("impact_speed_m_s", "rebound_speed_m_s", 1)]
)
def test_rebounds_with_more_than_they_came_with_are_refused_and_lively_ones_are_not(before, after, power, generator):
    """Exchanged, a restitution of 0.8 gives back 1.56 times the energy; one of 0.9 is told. A superball of 0.98 may read more."""

    def table(restitution, exchange=False, noise=0.03):
        rebounds = restitution**power * FALLS * (1 + noise * generator.standard_normal(len(FALLS)))
        return {before: rebounds, after: FALLS} if exchange else {before: FALLS, after: rebounds}

    with pytest.raises(InputError, match=f"columns {before} and {after}: a rebound has .* are the columns mixed up"):
        told(table(0.78, True, 0.01))
    assert "are the columns mixed up" in told(table(0.9, True, 0.01))[0]
    assert told(table(0.9)) == told(table(0.98)) == told(table(0.2)) == []


def test_launches_in_radians_are_refused_and_steep_slopes_are_questioned():
    """Ranges through nothing from 0.5 to 0.9 rad; a slope is a rise over its run, and 5 is hardly one of 79 degrees."""
    angles, ball = np.linspace(0.5, 0.9, 6), {"shape": "sphere", "radius": 0.02, "mass": 0.05}
    shots = {"speed_m_s": 5.0, "angle_deg": angles, "range_m": 25 * np.sin(2 * angles) / G}
    with pytest.raises(InputError, match="column angle_deg: throws go .* these look like radians"):
        hlcs.compare(hlcs.Experiment.from_frames(shots, kind="outcomes", body=ball, noise={"outcome": 0.01}))
    hlcs.compare(
        hlcs.Experiment.from_frames(
            shots | {"angle_deg": np.rad2deg(angles)}, kind="outcomes", body=ball, noise={"outcome": 0.01}
        )
    )
    moon = {"speed_m_s": 5.0, "angle_deg": [1.0, 1.2, 1.4], "gravity_m_s2": 1.62}
    moon["range_m"] = 25 * np.sin(2 * np.deg2rad(moon["angle_deg"])) / 1.62
    hlcs.compare(hlcs.Experiment.from_frames(moon, kind="outcomes", body=ball, noise={"outcome": 0.01}))
    slides = {"slope": [5.0, 7.0, 9.0], "distance_m": 1.0, "slide_time_s": [3.0, 2.0, 1.6]}
    with pytest.warns(hlcs.InputWarning, match="column slope: 5 is hardly meant"):
        hlcs.compare(hlcs.Experiment.from_frames(slides, kind="outcomes", body=ball, noise={"outcome": 0.01}))


@pytest.mark.parametrize(("factor", "asked"), [(3.6, True), (1.0, False)])
def test_stops_that_no_friction_makes_ask_whether_speeds_are_in_kilometres_an_hour(factor, asked):
    """v^2/(2 mu g) with mu = 0.7, which 3.6 times the speeds would make 9."""
    speeds = np.array([5.0, 8.0, 11.0, 14.0])
    stops = {"speed_m_s": factor * speeds, "stop_distance_m": speeds**2 / (2 * 0.7 * G)}
    block = {"shape": "box", "size": [0.2, 0.1, 0.1], "mass": 1.0}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        hlcs.compare(hlcs.Experiment.from_frames(stops, block, {"friction": 0.5}, kind="outcomes", noise={"outcome": 0.01}))
    assert any("are these in km/h?" in str(each.message) for each in told) == asked
