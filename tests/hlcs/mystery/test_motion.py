"""The motions that mysteries are made of, against closed forms. They are solved to nine digits, so micrometres are asked for."""

import numpy as np
import pytest

from hlcs.mystery import motion

MICRO = 1e-6  # m: a thousand times the error of the integration, a thousandth of the finest camera's noise
AIR, WATER, G = 1.2, 998.0, motion.GRAVITY
TIMES = np.linspace(0.0, 1.2, 40)
LEVEL = np.array([0.0, 0.0, 1.0])


def start(position=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0)):
    return motion.Start(*(np.array(part, float) for part in (position, velocity, (1, 0, 0, 0), spin)))


def test_fall_with_drag_added_mass_and_lift_is_the_logarithm_of_a_hyperbolic_cosine():
    """z = -ln cosh(t sqrt(a k)) / k; a, k: first acceleration and resistance over the inertia m + C_a rho V."""
    body = motion.ball(0.01, 0.005, WATER)
    laws = {
        "quadratic_drag": {"drag_coefficient": 0.47},
        "added_mass": {"coefficient": 0.5},
        "buoyancy": {"fluid_density": WATER},
    }
    volume = 4 / 3 * np.pi * 1e-6
    inertia = 0.005 + 0.5 * WATER * volume
    a, k = G * (0.005 - WATER * volume) / inertia, 0.5 * WATER * 0.47 * np.pi * 1e-4 / inertia
    found = motion.fly(body, laws, start(), TIMES)[0]
    assert found[:, 2] == pytest.approx(-np.log(np.cosh(TIMES * np.sqrt(a * k))) / k, abs=MICRO)
    assert not found[:, :2].any()


def test_a_ball_left_alone_in_a_flow_ends_at_its_speed():
    """Without weight (neutral in water) a ball takes on the velocity of the flow: v = u - u/(1 + k u t)."""
    volume = 4 / 3 * np.pi * 0.01**3
    body = motion.ball(0.01, WATER * volume, WATER)
    laws = {
        "quadratic_drag": {"drag_coefficient": 0.47},
        "buoyancy": {"fluid_density": WATER},
        "uniform_flow": {"velocity_y": 0.3},
    }
    k = 0.5 * WATER * 0.47 * np.pi * 0.01**2 / body.mass
    expected = 0.3 * TIMES - np.log1p(k * 0.3 * TIMES) / k
    assert motion.fly(body, laws, start(), TIMES)[0][:, 1] == pytest.approx(expected, abs=MICRO)


def test_spin_about_the_vertical_bends_a_weightless_flight_to_a_circle():
    """Magnus force C pi rho r3 omega v across the way: radius m v/(C pi rho r3 omega), anticlockwise for spin upwards."""
    volume = 4 / 3 * np.pi * 0.1**3
    body = motion.ball(0.1, AIR * volume, AIR)
    laws = {"magnus": {"coefficient": 0.4}, "buoyancy": {"fluid_density": AIR}}
    rate = 0.4 * np.pi * AIR * 0.1**3 * 20.0 / body.mass
    found = motion.fly(body, laws, start(velocity=(3, 0, 0), spin=(0, 0, 20)), TIMES)[0]
    circle = 3.0 / rate * np.stack([np.sin(rate * TIMES), 1 - np.cos(rate * TIMES)], axis=1)
    assert found[:, :2] == pytest.approx(circle, abs=MICRO)


def test_spin_dies_away_exponentially():
    """Angle turned: omega (1 - exp(-k t))/k; without the law omega t."""
    body = motion.ball(0.1, 0.4, AIR)
    for laws, angle in (({"spin_decay": {"rate": 0.5}}, 2.0 * -np.expm1(-0.5 * TIMES) / 0.5), ({}, 2.0 * TIMES)):
        turned = motion.fly(body, laws, start(spin=(0, 0, 2)), TIMES)[1]
        assert motion.turn_between(start().orientation, turned)[:, 2] == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize(("exponent", "share"), [(0.0, 0.75), (0.1, 0.75 * np.sqrt(2 * G) ** -0.1)])
def test_a_ball_rises_to_the_square_of_its_restitution(exponent, share):
    """Dropped 1 m it comes back to e2 m; e = e_1 v^-exponent of the speed of the impact, sqrt(2 g h)."""
    body, floor = motion.ball(0.03, 0.06, 0.0), motion.Floor(LEVEL, 0.5, 0.75)
    laws = {"velocity_dependent_restitution": {"exponent": exponent}}
    top = np.sqrt(2 / G) * (1 + share)
    found = motion.fly(body, laws, start(position=(0, 0, 1.03)), np.array([0.0, top, 1.05 * top]), floor)[0]
    assert found[1, 2] == pytest.approx(0.03 + share**2, abs=MICRO) and found[2, 2] < found[1, 2]


@pytest.mark.parametrize("slope", [0.0, 0.1])
def test_a_block_stops_where_its_friction_says(slope):
    """Way v2/(2 mu g), or with mu + s v: (v - mu/s ln(1 + s v/mu)) / (s g). It keeps lying there."""
    body, floor = motion.block([0.12, 0.08, 0.04], 0.3, 0.0), motion.Floor(LEVEL, 0.3, 0.0)
    way = 4.0 / (0.6 * G) if not slope else (2.0 - 0.3 / slope * np.log1p(slope * 2.0 / 0.3)) / (slope * G)
    laws = {"viscous_friction": {"slope": slope}}
    found = motion.slide(body, laws, start((0, 0, 0.02), (0, 2, 0)), np.array([0.0, 1.0, 3.0]), floor, 0.02)[0]
    assert found[2] == pytest.approx([0.0, way, 0.02], abs=MICRO)


def test_a_block_climbs_a_floor_that_rises():
    """Up a grade s along x it stops after v2/(2 g (mu cos + sin)), measured along the floor."""
    body, floor = motion.block([0.12, 0.08, 0.04], 0.3, 0.0), motion.Floor(LEVEL, 0.3, 0.0)
    angle = np.arctan(0.05)
    along = np.array([np.cos(angle), 0.0, np.sin(angle)])
    begin = start(0.02 * np.array([-np.sin(angle), 0.0, np.cos(angle)]), 2.0 * along)
    found = motion.slide(body, {"bottom_slope": {"grade_x": 0.05}}, begin, np.array([0.0, 3.0]), floor, 0.02)[0]
    way = 4.0 / (2 * G * (0.3 * np.cos(angle) + np.sin(angle)))
    assert (found[1] - found[0]) @ along == pytest.approx(way, abs=MICRO)


def test_a_ball_rolls_down_by_five_sevenths_and_turns_as_it_goes():
    """a = 5/7 g (sin - arm/r cos); it turns by way/r about the horizontal across its way."""
    slope, normal = np.deg2rad(3.0), np.array([np.sin(np.deg2rad(3.0)), 0.0, np.cos(np.deg2rad(3.0))])
    body, floor = motion.ball(0.02, 0.26, 0.0), motion.Floor(normal, 0.6, 0.0)
    position, orientation = motion.roll(body, {"rolling_friction": {"arm": 1e-4}}, start(0.02 * normal), TIMES, floor)
    way = 0.5 * 5 / 7 * G * (np.sin(slope) - 1e-4 / 0.02 * np.cos(slope)) * TIMES**2
    assert np.linalg.norm(position - position[0], axis=1) == pytest.approx(way, abs=MICRO)
    early = way / 0.02 < 3.0  # a rotation vector tells no more than half a turn
    assert motion.turn_between(orientation[0], orientation[early])[:, 1] == pytest.approx(way[early] / 0.02, abs=1e-4)


def test_before_the_release_nothing_moves():
    found = motion.fly(motion.ball(0.05, 4.0, AIR), {}, start(position=(0, 0, 3)), np.array([-0.1, 0.0, 0.1]))[0]
    assert found[:, 2] == pytest.approx([3.0, 3.0, 3.0 - 0.005 * G], abs=MICRO)
