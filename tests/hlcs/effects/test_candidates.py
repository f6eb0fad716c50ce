"""Candidates: which numbers they have for which body, where these begin, and what is filled in when they are made."""

from dataclasses import dataclass
from math import inf, log, pi

import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.rigid_body import rigid_body
from hlcs.effects import Free, build, candidate
from hlcs.effects.measurement import ClockOffset, TimeScale
from minibullet import effects, parameter

FLOOR = Surroundings(floor_height=0.25, friction=0.35, restitution=0.6, fluid_density=998.0, fluid_stated=True)
BALL = rigid_body(Body("sphere", radius=0.2, mass=1.0))


def test_drag_has_the_number_that_the_body_allows():
    known, unknown = (candidate(effects.QuadraticDrag, FLOOR, BALL, body_known) for body_known in (True, False))
    assert [entry.name for entry in known.free] == ["drag_coefficient"]
    assert [entry.name for entry in unknown.free] == ["drag_per_metre"]


def test_bounds_in_radii_are_lengths():
    (arm,) = candidate(effects.RollingFriction, FLOOR, BALL, True).free
    assert (arm.low, arm.high, arm.unit) == (0.0, pytest.approx(0.02), "m")


def test_a_coefficient_that_every_model_has_is_absent_at_the_stated_value():
    for kind, value in ((effects.Friction, 0.35), (effects.Restitution, 0.6)):
        entry = candidate(kind, FLOOR, BALL, True)
        assert entry.absent == {"coefficient": value} and entry.views == ({"coefficient": value},)


@dataclass(frozen=True)
class Hum(effects.Effect):
    """A law of a user, who says of no number at which value it is absent."""

    force: float = parameter(0.5, unit="N", low=0.1, high=1.0)
    period: float = parameter(2.0, unit="s", low=1.0, high=5.0, starts=(1.0, 2.0, 4.0))


def test_a_law_that_is_never_absent_begins_from_several_values():
    entry = candidate(Hum, FLOOR, BALL, True)
    assert entry.absent is None and entry.views == ()
    assert entry.valleys == tuple({"period": value} for value in (1.0, 2.0, 4.0))


def test_a_drag_whose_coefficient_falls_is_absent_without_coefficients_wherever_it_falls():
    entry = candidate(effects.DragCrisis, FLOOR, BALL, True)
    nothing = {"subcritical": 0.0, "supercritical": 0.0}
    assert entry.views == tuple(nothing | {"critical_reynolds": value} for value in (1e5, 2e5, 4e5))


def test_a_number_without_meaning_while_absent_is_looked_at_from_several_values():
    entry = candidate(effects.AnisotropicFriction, FLOOR, BALL, True)
    assert entry.views == tuple({"ratio": 1.0, "angle": pi * k / 4} for k in range(4))
    assert entry.valleys == tuple({"angle": pi * k / 4} for k in range(4))
    assert entry.group == "contact_tangential" and candidate(ClockOffset, FLOOR, BALL, True).group == "measurement"


def test_a_plausible_range_is_no_wall_but_where_a_law_ends_a_number_is_held():
    """A friction is never negative, a restitution never above 1, a scale never negative; a lift may have any sign."""
    friction, restitution, magnus, scale = (
        candidate(kind, FLOOR, BALL, True).free[0] for kind in (effects.Friction, effects.Restitution, effects.Magnus, TimeScale)
    )
    assert (friction.least, friction.most) == (0.0, inf) and (restitution.least, restitution.most) == (0.0, 1.0)
    assert (magnus.least, magnus.most) == (-inf, inf) and 0 < scale.least < 0.1
    assert magnus.inside(4.5) == 4.5 and not magnus.plausible(4.5) and restitution.inside(1.2) == 1.0
    assert Free("a", "rad", 0.0, pi, 0.0, 0.0, period=pi).inside(1.5 * pi) == pytest.approx(0.5 * pi)


def test_a_number_off_the_plausible_range_is_told_with_its_side_and_with_digits_that_show_it():
    """47,000 is no more than 50,000; and 500,000.2 would read as the end that it exceeds."""
    (critical,) = (free for free in candidate(effects.DragCrisis, FLOOR, BALL, True).free if free.name == "critical_reynolds")
    assert (critical.low, critical.high) == (5e4, 5e5) and critical.beyond(5e4) == critical.beyond(2e5) == ""
    assert critical.beyond(47_000.0) == "47000 lies below what is plausible (50000 to 500000)"
    assert critical.beyond(500_000.2) == "500000.2 lies above what is plausible (50000 to 500000)"
    assert critical.beyond(49_999.0).startswith("49999 lies below")
    told = "0.3333 lies above what is plausible (0 to 0.333)"  # of ends as they are printed
    assert Free("a", "1", 0.0, 1 / 3, 0.0, 0.0).beyond(1 / 3 + 1e-12) == told
    rate = Free("rate", "1/s", 0.0, 0.110597, 0.0, 0.0)
    assert rate.beyond(0.25123) == "0.251 lies above what is plausible (0 to 0.111 1/s)"
    assert rate.beyond(0.11061) == "0.111 lies above what is plausible (0 to 0.1106 1/s)"


def test_surprise_is_minus_twice_the_log_of_a_cauchy_law():
    """One spread off costs 2 log 2; the spread is half the plausible range on its longer side."""
    free = Free("a", "1", -1.0, 4.0, 0.0, 0.0)
    assert free.spread == 2.0 and free.surprise(0.0) == 0.0
    assert free.surprise(2.0) == pytest.approx(2 * log(2)) and free.surprise(-6.0) == pytest.approx(2 * log(10))


def test_what_the_file_states_of_its_fluid_is_believed():
    """A stated density to 5 %, one left out as that of some gas."""
    (stated,) = candidate(effects.Buoyancy, FLOOR, BALL, True).free
    assert (stated.expected, stated.spread, stated.null) == (998.0, pytest.approx(0.05 * 998), 0.0)
    assert [stated.plausible(value) for value in (880.0, 910.0, 1090.0, 1110.0)] == [False, True, True, False]  # both ways
    assert stated.least == 0.0 and stated.usual == "898 to 1100 kg/m3"  # no wall: the law goes down to no fluid
    (left_out,) = candidate(effects.Buoyancy, Surroundings(), BALL, True).free
    assert left_out.expected == left_out.spread == 1.2 and left_out.surprise(870.0) > 25


def test_a_drag_in_proportion_to_speed_is_plausible_as_far_as_mass_size_and_fluid_allow():
    """Of a tennis ball at 1 m/s as a coefficient of 2.5; of a speck of dust in creeping flow 6 pi eta r/m (Stokes)."""
    tennis, speck = (rigid_body(Body("sphere", radius=r, mass=m)) for r, m in ((0.0335, 0.0577), (2e-5, 8.4e-11)))
    (slow,) = candidate(effects.LinearDrag, Surroundings(), tennis, True, speed=1.0).free
    per_metre = 0.5 * 1.2 * pi * 0.0335**2 / 0.0577
    assert slow.plausible(2.5 * per_metre) and not slow.plausible(10 * 0.47 * per_metre)
    (creeping,) = candidate(effects.LinearDrag, Surroundings(), speck, True, speed=1e-3).free
    assert creeping.plausible(6 * pi * 1.8e-5 * 2e-5 / 8.4e-11)


def test_what_the_surroundings_say_is_filled_in_where_nothing_else_is_said():
    wall = build(effects.WallDrag, {"multiplier": 1.0}, FLOOR)
    assert (wall.multiplier, wall.wall_height, wall.wall_normal) == (1.0, 0.25, tuple(FLOOR.floor_normal))
    assert build(effects.Magnus, {}, FLOOR).fluid_density == 998.0
    assert build(effects.Magnus, {"fluid_density": 2.0}, FLOOR).fluid_density == 2.0
    assert build(effects.Buoyancy, {}, FLOOR).fluid_density == 0.0  # this one is to be found
    assert build(effects.DragCrisis, {}, Surroundings(fluid_density=0.0)).fluid_density == 0.0  # a vacuum is not air


@pytest.mark.parametrize("density", [1.2, 6.2, 998.0])  # air, sulphur hexafluoride, water
def test_what_a_stated_fluid_implies_is_expected_in_a_gas_as_in_a_liquid(density):
    """Lift by the displaced mass, and half of it set in motion by a sphere (Lamb), whatever the fluid."""
    around = Surroundings(fluid_density=density, fluid_stated=True)
    (lift,) = candidate(effects.Buoyancy, around, BALL, True).free
    (moved,) = candidate(effects.AddedMass, around, BALL, True).free
    assert (lift.expected, moved.expected) == (density, pytest.approx(0.5, rel=1e-12)) and lift.certain and moved.certain


def test_a_coefficient_that_the_model_states_is_expected_where_it_stands():
    """The file has 0.68, that of a cube; 0.5 is that of a ball. Its own number is no evidence against it."""
    (free,) = candidate(
        effects.AddedMass, Surroundings(fluid_density=998.0, fluid_stated=True), BALL, True, entry={"coefficient": 0.68}
    ).free
    assert free.expected == free.null == 0.68


def test_no_fluid_is_as_dense_as_steel_whatever_is_wrong_in_the_file():
    """Stated as glycerine it may be water, or what is twice as heavy as the heaviest that the law knows; steel it is not. What
    no file states is believed by the Cauchy law alone."""
    around = Surroundings(fluid_density=1260.0, fluid_stated=True)
    (lift,) = candidate(effects.Buoyancy, around, BALL, True).free
    assert not lift.plausible(998.0) and lift.possible(998.0) and lift.possible(2 * 1.1 * 1260.0)
    assert not lift.possible(7800.0) and not candidate(effects.AddedMass, around, BALL, True).free[0].possible(9.0)
    (left_out,) = candidate(effects.Buoyancy, Surroundings(), BALL, True).free
    assert left_out.possible(7800.0)


@pytest.mark.parametrize("around", [Surroundings(), Surroundings(fluid_density=0.0, fluid_stated=True)])
def test_nothing_is_certain_of_a_fluid_that_is_not_stated_or_not_there(around):
    for kind in (effects.Buoyancy, effects.AddedMass):
        assert not any(free.certain for free in candidate(kind, around, BALL, True).free)


def test_what_a_body_sets_in_motion_follows_from_how_wide_it_is():
    """0.68 of what a cube displaces (DNV-RP-C205), 8/3 rho r^3 by a thin disc that falls flat (Lamb, art. 108), a third
    of it in the mean over its attitudes: within the error of a half that is believed."""
    cube, disc = Body("box", size=(0.1, 0.1, 0.1), mass=1.0), Body("disc", radius=0.07, height=0.001, mass=0.001)
    flat, taken = Body("disc", radius=0.07, height=0.001, mass=0.001, drag_area=pi * 0.07**2), 8 / 3 * 0.07 / (pi * 0.001)
    for body, expected in ((cube, 0.68), (disc, taken / 3), (flat, taken)):
        (moved,) = candidate(effects.AddedMass, FLOOR, rigid_body(body), True).free
        assert abs(moved.expected - expected) < 0.25 * expected and moved.error == 0.5 * moved.expected
    rod, finned = Body("cylinder", radius=0.002, height=0.4, mass=0.04), Body("sphere", radius=0.05, mass=1.0, drag_area=0.035)
    for body in (rod, finned):  # two thirds in the mean over the attitudes of a rod, a half of a ball, whatever drags it
        (moved,) = candidate(effects.AddedMass, FLOOR, rigid_body(body), True).free
        assert 0.5 <= moved.expected <= 0.7


def test_what_is_plausible_of_a_stated_tilt_lies_about_it_and_a_coefficient_keeps_its_range():
    stated = candidate(effects.TiltedGravity, Surroundings(), BALL, True, entry={"angle_x": 0.0, "angle_y": -0.0524})
    usual = candidate(effects.TiltedGravity, Surroundings(), BALL, True)
    level, tilted = stated.free
    assert (level.low, level.high) == (usual.free[0].low, usual.free[0].high)
    assert tilted.plausible(-0.055) and not tilted.plausible(0.0) and tilted.spread == usual.free[1].spread
    for kind, number, value in (
        (effects.QuadraticDrag, "drag_coefficient", 0.5),
        (effects.Friction, "coefficient", 0.1),
        (effects.Restitution, "coefficient", 0.9),
        (effects.Magnus, "coefficient", 1.0),
    ):
        (own,), (free,) = (candidate(kind, Surroundings(), BALL, True, entry=entry).free for entry in ({number: value}, None))
        assert (own.low, own.high, own.null) == (free.low, free.high, value)
