"""Ranges of throws: the law against an integration of its own, and what a table of them tells."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import hlcs
from hlcs.data.experiment_file import Body, Surroundings
from hlcs.effects.contract import Setup
from hlcs.simulation.outcome_motion import throw_range
from minibullet import effects

G, RADIUS, MASS, DENSITY = 9.81, 0.02, 0.0027, 1.2
BALL = {"shape": "sphere", "radius": RADIUS, "mass": MASS}
ANGLES = np.repeat([15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0], 5)
SPEED, HEIGHT, NOISE = 6.0, 0.3, 0.01


def thrown(speed, angle, height, drag_coefficient=0.0, wind=0.0):
    """Range of a ball with quadratic drag alone, in a wind along the throw, to 1e-9 of it."""
    k = DENSITY * drag_coefficient * np.pi * RADIUS**2 / (2 * MASS)

    def rates(t, state):
        along = state[2] - wind
        return [*state[2:], -k * np.hypot(along, state[3]) * along, -G - k * np.hypot(along, state[3]) * state[3]]

    def down(t, state):
        return state[1] + height if t > 0 else 1.0

    down.terminal, down.direction = True, -1
    begin = [0.0, 0.0, speed * np.cos(np.deg2rad(angle)), speed * np.sin(np.deg2rad(angle))]
    return solve_ivp(rates, (0.0, 20.0), begin, events=down, rtol=1e-10, atol=1e-12).y_events[0][0][0]


@pytest.mark.parametrize(("speed", "height"), [(3.0, 0.0), (6.0, 0.3), (20.0, 2.0)])
def test_a_throw_with_drag_comes_as_far_as_another_integrator_says(speed, height):
    """160 steps of fourth order over half as much again as a throw through nothing takes, a polynomial between them: 1e-5."""
    setup = Setup(Body(**BALL), Surroundings(gravity=G, fluid_density=DENSITY))
    laws, angles = (effects.Gravity(G), effects.QuadraticDrag(0.47, DENSITY)), np.array([10.0, 45.0, 80.0])
    inputs = {"speed_m_s": np.full(3, speed), "angle_deg": angles, "height_m": np.full(3, height)}
    expected = [thrown(speed, angle, height, 0.47) for angle in angles]
    np.testing.assert_allclose(throw_range([setup] * 3, laws, inputs), expected, rtol=1e-5)


def diagnosed(speed=SPEED, angle=0.0, drag_coefficient=0.0):
    """Diagnosis of throws stated at 6 m/s, made at a speed and at angles that are so much larger, 35 rows of 10 mm."""
    ranges = np.array([thrown(speed, stated + angle, HEIGHT, drag_coefficient) for stated in ANGLES])
    rows = {"angle_deg": ANGLES, "speed_m_s": np.full(35, SPEED), "height_m": np.full(35, HEIGHT)}
    rows["range_m"] = ranges + NOISE * np.random.default_rng(3).standard_normal(35)
    return hlcs.diagnose(hlcs.Experiment.from_frames([rows], BALL, {"fluid_density": DENSITY}, kind="outcomes"))


def test_the_drag_of_thrown_balls_is_told_and_nothing_where_there_is_none():
    found = diagnosed(drag_coefficient=0.45)
    number = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert (found.verdict, found.effects) == ("effect", ("quadratic_drag",))
    assert number["low"] < 0.45 < number["high"]
    assert diagnosed().verdict == "complete"


@pytest.mark.parametrize(("change", "name", "off"), [({"speed": 6.2}, "speed_m_s", 0.2), ({"angle": 2.0}, "angle_deg", 2.0)])
def test_a_launcher_that_is_off_alike_in_all_rows_is_named(change, name, off):
    told = re.search(
        rf"[Ii]f {name} is ([\d.]+) (?:m/s|degrees) \+- ([\d.]+) .*more than stated in all rows", str(diagnosed(**change))
    )
    value, error = map(float, told.groups())
    assert value == pytest.approx(off, abs=3 * error) and error < 0.05 * off


def test_a_headwind_is_among_what_shortens_a_throw():
    """1 m/s against balls thrown at 6 m/s whose drag the model states: within twice its interval of 90 %."""
    ranges = np.array([thrown(SPEED, angle, HEIGHT, 0.45, wind=-1.0) for angle in ANGLES])
    rows = {"angle_deg": ANGLES, "speed_m_s": np.full(35, SPEED), "height_m": np.full(35, HEIGHT)}
    rows["range_m"] = ranges + NOISE * np.random.default_rng(3).standard_normal(35)
    model = {"effects": [{"name": "quadratic_drag", "drag_coefficient": 0.45}]}
    found = hlcs.diagnose(hlcs.Experiment.from_frames([rows], BALL, {"fluid_density": DENSITY}, model=model, kind="outcomes"))
    assert any("uniform_flow" in names for names in (found.effects, *found.ambiguous))  # beside what the stated air implies
    number = found.parameters["uniform_flow"]["velocity_x"]
    reach = number["high"] - number["low"]
    assert number["value"] == pytest.approx(-1.0, abs=reach) and reach < 0.5


def test_throws_that_never_come_down_are_told():
    """A balloon of 1 g floats: its range never comes."""
    rows = {"speed_m_s": [1.0, 2.0, 3.0], "range_m": [0.3, 0.6, 0.9], "height_m": [1.0] * 3}
    balloon, air = {"shape": "sphere", "radius": 0.1, "mass": 0.001}, {"fluid_density": DENSITY}
    model = {"effects": [{"name": "buoyancy", "fluid_density": DENSITY}]}
    experiment = hlcs.Experiment.from_frames([rows], balloon, air, model=model, kind="outcomes", noise=0.01)
    assert any("floats and never comes down" in note for note in hlcs.compare(experiment).notes)


def turned(speed, angle, height, turn):
    """Range of a body whose velocity gravity bends and a side force turns at a rate [rad/s], upwards where it is positive.

    u = v_x + i v_z: u' = -i g + i turn u, so u = g / turn + (u_0 - g / turn) exp(i turn t), and its integral is the way.
    """
    drift, begin = G / turn, speed * np.exp(1j * np.deg2rad(angle))

    def way(t):
        return drift * t + (begin - drift) * (np.exp(1j * turn * t) - 1) / (1j * turn)

    times = np.linspace(1e-3, 2 * np.pi / abs(turn), 20_000)
    first = int(np.flatnonzero(way(times).imag < -height)[0])
    return way(brentq(lambda t: way(t).imag + height, times[first - 1], times[first])).real


def test_a_backspin_carries_a_throw_on_and_a_topspin_brings_it_down():
    """Steps as above, 1e-5. With the largest backspin the ball still rises where the first track that is computed of it ends."""
    setup = Setup(Body(**BALL), Surroundings(gravity=G, fluid_density=DENSITY))
    laws, spins = (effects.Gravity(G), effects.Magnus(0.5, DENSITY)), np.array([-400.0, -100.0, 100.0, 250.0])
    inputs = {"speed_m_s": np.full(4, 8.0), "angle_deg": np.full(4, 15.0), "height_m": np.full(4, 0.3), "spin_rad_s": spins}
    rates = 0.5 * np.pi * DENSITY * RADIUS**3 / MASS * spins
    expected = [turned(8.0, 15.0, 0.3, rate) for rate in rates]
    assert np.all(np.diff(expected) > 0)
    np.testing.assert_allclose(throw_range([setup] * 4, laws, inputs), expected, rtol=1e-5)


def test_a_throw_ends_where_it_first_comes_down_however_long_others_fly():
    """A backspin turns the path of the first ball up again 2 m below its launch, and several times back above it while the second
    one is in the air. Its steps are those of the second, 20 times as long as its own: 5e-5."""
    setup, turn = Setup(Body(**BALL), Surroundings(gravity=G, fluid_density=DENSITY)), 2.0
    laws, spin = (effects.Gravity(G), effects.Magnus(0.5, DENSITY)), turn * MASS / (0.5 * np.pi * DENSITY * RADIUS**3)
    columns = ("speed_m_s", "angle_deg", "height_m", "spin_rad_s")
    inputs = dict(zip(columns, np.array([[3.0, 20.0, 0.3, spin], [60.0, 45.0, 0.3, 0.0]]).T, strict=True))
    expected = [turned(3.0, 20.0, 0.3, turn), thrown(60.0, 45.0, 0.3)]
    np.testing.assert_allclose(throw_range([setup] * 2, laws, inputs), expected, rtol=5e-5)


def test_the_side_force_on_balls_thrown_with_a_spin_is_told_and_not_tried_without():
    spins = np.tile([-150.0, 0.0, 75.0, 150.0, 0.0], 7)
    rates = 0.5 * np.pi * DENSITY * RADIUS**3 / MASS * spins
    ranges = [turned(SPEED, a, HEIGHT, r) if r else thrown(SPEED, a, HEIGHT) for a, r in zip(ANGLES, rates, strict=True)]
    rows = {"angle_deg": ANGLES, "speed_m_s": np.full(35, SPEED), "height_m": np.full(35, HEIGHT), "spin_rad_s": spins}
    rows["range_m"] = ranges + NOISE * np.random.default_rng(4).standard_normal(35)
    found = hlcs.diagnose(hlcs.Experiment.from_frames([rows], BALL, {"fluid_density": DENSITY}, kind="outcomes", noise=NOISE))
    number = found.parameters["magnus"]["coefficient"]
    assert (found.verdict, found.effects) == ("effect", ("magnus",))
    assert number["low"] < 0.5 < number["high"]
    assert "the spin is neither measured nor stated: magnus" in str(diagnosed())


def test_a_spin_beside_an_outcome_that_is_computed_without_is_refused():
    rows = {"height_m": [0.5, 1.0, 1.5], "spin_rad_s": [10.0] * 3, "fall_time_s": [0.32, 0.45, 0.55]}
    experiment = hlcs.Experiment.from_frames([rows], BALL, {"fluid_density": DENSITY}, kind="outcomes", noise=0.01)
    with pytest.raises(hlcs.InputError, match="spin_rad_s: fall_time_s does not depend on it"):
        hlcs.compare(experiment)
