"""Candidates: which numbers they have for which body, where these begin, and what is filled in when they are made."""

from math import pi

import pytest

from hlcs.data.experiment_file import Surroundings
from hlcs.effects import Free, build, candidate
from hlcs.effects.measurement import ClockOffset
from minibullet import effects

FLOOR = Surroundings(floor_height=0.25, friction=0.35, restitution=0.6, fluid_density=998.0)


def test_drag_has_the_number_that_the_body_allows():
    known, unknown = (candidate(effects.QuadraticDrag, FLOOR, 0.1, body_known) for body_known in (True, False))
    assert [entry.name for entry in known.free] == ["drag_coefficient"]
    assert [entry.name for entry in unknown.free] == ["drag_per_metre"]


def test_bounds_in_radii_are_lengths():
    (arm,) = candidate(effects.RollingFriction, FLOOR, 0.2, True).free
    assert (arm.low, arm.high, arm.unit) == (0.0, pytest.approx(0.02), "m")


def test_a_coefficient_that_every_model_has_is_absent_at_the_stated_value():
    for kind, value in ((effects.Friction, 0.35), (effects.Restitution, 0.6)):
        entry = candidate(kind, FLOOR, 0.1, True)
        assert entry.absent == {"coefficient": value} and entry.views == ({"coefficient": value},)


def test_a_law_that_is_never_absent_begins_from_several_values():
    entry = candidate(effects.DragCrisis, FLOOR, 0.1, True)
    assert entry.absent is None and entry.views == ()
    assert [dict(values)["critical_reynolds"] for values in entry.starts] == [1e5, 2e5, 4e5]
    assert all(dict(values)["subcritical"] == 0.47 for values in entry.starts)


def test_a_number_without_meaning_while_absent_is_looked_at_from_several_values():
    entry = candidate(effects.AnisotropicFriction, FLOOR, 0.1, True)
    assert entry.views == tuple({"ratio": 1.0, "angle": pi * k / 4} for k in range(4))
    assert entry.starts == ((("ratio", 1.0), ("angle", 0.0)),)
    assert entry.group == "contact_tangential" and candidate(ClockOffset, FLOOR, 0.1, True).group == "measurement"


def test_values_stay_inside_bounds_and_angles_inside_a_period():
    assert Free("a", "1", 0.0, 2.0, 0.0, 0.0).inside(3.0) == 2.0
    assert Free("a", "rad", 0.0, pi, 0.0, 0.0, period=pi).inside(1.5 * pi) == pytest.approx(0.5 * pi)


def test_what_the_surroundings_say_is_filled_in_where_nothing_else_is_said():
    wall = build(effects.WallDrag, {"multiplier": 1.0}, FLOOR)
    assert (wall.multiplier, wall.wall_height, wall.wall_normal) == (1.0, 0.25, tuple(FLOOR.floor_normal))
    assert build(effects.Magnus, {}, FLOOR).fluid_density == 998.0
    assert build(effects.Magnus, {"fluid_density": 2.0}, FLOOR).fluid_density == 2.0
    assert build(effects.Buoyancy, {}, FLOOR).fluid_density == 0.0  # this one is to be found
    assert build(effects.DragCrisis, {}, Surroundings(fluid_density=0.0)).fluid_density == 1.2
