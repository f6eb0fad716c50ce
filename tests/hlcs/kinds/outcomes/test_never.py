"""Outcomes that never come: floating bodies, held blocks, balls that stay down; told in words, and no obstacle to a search."""

import numpy as np
import pytest

import hlcs
from hlcs.data.experiment_file import Body, Surroundings, read_experiment_file
from hlcs.data.outcome_tables import read_outcomes
from hlcs.effects.contract import Setup
from hlcs.kinds.outcomes.setting_errors import of_inputs
from hlcs.simulation.model import Model
from hlcs.simulation.outcome_motion import bounce_time, fall_time, rebound_height, slide_time, stop_distance
from minibullet.effects import Buoyancy, Friction, Gravity, Restitution

G = 9.81
SETUP = Setup(Body(radius=0.02, mass=0.04), Surroundings(fluid_density=0.0, friction=0.0))
BLOCK = Setup(Body(shape="box", size=(0.1, 0.1, 0.1), mass=0.04), Surroundings(fluid_density=0.0, friction=0.0))
BOX = {"shape": "box", "size": [0.1, 0.1, 0.1], "mass": 0.04}
BALL = {"shape": "sphere", "radius": 0.02, "mass": 0.04}


def measured(columns, body=None, **surroundings):
    return hlcs.Experiment.from_frames(columns, body or BALL, {"fluid_density": 0.0, **surroundings}, kind="outcomes")


def test_a_bounce_never_comes_where_the_body_stays_down():
    inputs = {"height_m": np.full(3, 0.8), "bounce": np.arange(1.0, 4.0)}
    found = bounce_time([SETUP] * 3, (Gravity(G), Restitution(0.0)), inputs)
    np.testing.assert_allclose(found, [np.sqrt(1.6 / G), np.nan, np.nan], rtol=1e-9)


@pytest.mark.parametrize("outcome", [fall_time, rebound_height, bounce_time])
def test_what_floats_never_strikes(outcome):
    """A ball of 1194 kg/m3 in a liquid of 2000 kg/m3."""
    inputs = {"height_m": np.full(2, 0.8), "bounce": np.array([1.0, 2.0])}
    assert np.isnan(outcome([SETUP] * 2, (Gravity(G), Restitution(0.8), Buoyancy(2000.0)), inputs)).all()


def test_a_fall_through_nothing_takes_no_time():
    assert fall_time([SETUP] * 2, (Gravity(G),), {"height_m": np.zeros(2)}) == pytest.approx([0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_block_slides_from_rest_only_where_the_slope_pulls_more_than_friction(friction):
    """t = sqrt(2 d / a), a = g (sin - mu cos), where a > 0."""
    angle = np.array([2.0, 5.0, 10.0, 16.0, 20.0])
    pull = G * (np.sin(np.deg2rad(angle)) - friction * np.cos(np.deg2rad(angle)))
    found = slide_time([BLOCK] * 5, (Gravity(G), Friction(friction)), {"angle_deg": angle, "distance_m": np.ones(5)})
    np.testing.assert_allclose(found, np.where(pull > 0, np.sqrt(2 / np.where(pull > 0, pull, 1.0)), np.nan), rtol=1e-4)


def test_a_mark_behind_the_stop_is_never_reached_and_without_friction_nothing_stops():
    """A block of 2 m/s stops after v^2 / (2 mu g) = 0.68 m at mu = 0.3."""
    inputs = {"speed_m_s": np.full(2, 2.0), "distance_m": np.array([0.67, 0.69])}
    assert np.isnan(slide_time([SETUP] * 2, (Gravity(G), Friction(0.3)), inputs)).tolist() == [False, True]
    assert np.isnan(stop_distance([SETUP] * 2, (Gravity(G), Friction(0.0)), inputs)).all()


def test_compare_says_of_which_rows_the_model_says_never():
    """Friction 0.3 holds a block up to atan 0.3 = 16.7 degrees: of the rows the first six."""
    angle = np.repeat([10.0, 15.0, 20.0, 30.0], 3)
    pull = G * (np.sin(np.deg2rad(angle)) - 0.1 * np.cos(np.deg2rad(angle)))
    times = np.sqrt(2 / pull) + 0.001 * np.tile([-1.0, 0.0, 1.0], 4)
    columns = {"angle_deg": angle, "distance_m": np.ones(12), "slide_time_s": times}
    seen = hlcs.compare(measured(columns, BOX, friction=0.3))
    (note,) = [note for note in seen.notes if "does not slide" in note]
    assert "6 of 12 rows, the first row 0 (angle_deg = 10, distance_m = 1)" in note
    frame = seen.to_dataframe()
    assert seen.adequate is False and seen.error["bias"] is None
    assert np.isnan(frame["model"]).tolist() == (frame["angle_deg"] < 16).tolist()
    held = frame["angle_deg"] < 16
    np.testing.assert_allclose(frame["residual"][held], frame["measured"][held])


def test_a_restitution_is_found_though_the_model_lets_the_ball_lie_and_buoyancy_could_lift_it():
    bounce, height = np.tile(np.arange(1.0, 5.0), 6), np.repeat([0.5, 1.0, 1.5], 8)
    flights = np.cumsum(np.r_[1.0, 2 * 0.8 ** np.arange(1, 4)])
    noise = 0.001 * np.random.default_rng(1).standard_normal(24)
    columns = {"height_m": height, "bounce": bounce, "bounce_time_s": np.sqrt(2 * height / G) * flights[bounce.astype(int) - 1]}
    columns["bounce_time_s"] = columns["bounce_time_s"] + noise
    heavy = BALL | {"mass": 7 * BALL["mass"]}  # the lift of the air that is stated does not show
    found = hlcs.diagnose(measured(columns, heavy, fluid_density=1.2), candidates=["restitution", "buoyancy", "mass_offset"])
    assert (found.verdict, found.effects) == ("effect", ("restitution",))
    assert found.parameters["restitution"]["coefficient"]["value"] == pytest.approx(0.8, abs=0.002)


@pytest.mark.parametrize("body, true", [(BOX, 0.1), (BOX, 0.3), (BALL, 0.06)])
def test_a_friction_is_found_though_the_stated_one_holds_every_row(body, true):
    """0.5 holds up to 26.6 degrees: no derivative there tells that less would let the body slide, in t = sqrt(2 d / a). A ball
    grips these slopes from 0.093 to 0.139 on, and slips with less."""
    angle, way = np.repeat([18.0, 22.0, 26.0], 6), np.tile([0.5, 1.0], 9)
    pull = G * (np.sin(np.deg2rad(angle)) - true * np.cos(np.deg2rad(angle)))
    times = np.sqrt(2 * way / pull) + 0.01 * np.random.default_rng(1).standard_normal(18)
    found = hlcs.diagnose(measured({"angle_deg": angle, "distance_m": way, "slide_time_s": times}, body, friction=0.5))
    assert (found.verdict, found.effects) == ("effect", ("friction",))
    assert found.parameters["friction"]["coefficient"]["value"] == pytest.approx(true, abs=0.002)


def test_an_error_of_a_slope_is_carried_from_the_side_on_which_the_block_slides(tmp_path):
    """A slope of 0.11 +- 0.02 beside a friction of 0.1: at 0.09 nothing slides, so the error is t(0.11) - t(0.13)."""
    (tmp_path / "t.csv").write_text("slope,distance_m,slide_time_s\n" + "0.11,1,4.5\n0.11,1,4.6\n0.11,1,4.4\n")
    (tmp_path / "e.toml").write_text(
        'kind = "outcomes"\n[body]\nshape = "box"\nsize = [0.1, 0.1, 0.1]\nmass = 0.04\n'
        "[surroundings]\nfluid_density = 0.0\nfriction = 0.1\n"
        '[measurement]\nfile = "t.csv"\ninput_sd = { slope = 0.02 }\n'
    )
    file = read_experiment_file(tmp_path / "e.toml")
    near, far = (np.sqrt(2 * np.hypot(1, slope) / (G * (slope - 0.1))) for slope in (0.11, 0.13))
    np.testing.assert_allclose(of_inputs(file, read_outcomes(file), Model()), near - far, rtol=1e-4)
