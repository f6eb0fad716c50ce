"""A model asked at other inputs: outcomes by the closed laws of a fall, a rebound and a slide."""

import numpy as np
import pandas as pd
import pytest
from throws import write_throws

import hlcs
import minibullet as mb

GRAVITY = 9.81
BALL = {"shape": "sphere", "radius": 0.05, "mass": 2.0}
HEIGHTS = np.array([0.3, 0.5, 1.0, 2.0, 5.0])


def table(outcome, values, surroundings=None, **columns):
    """An Experiment of a table of that outcome, in a vacuum."""
    place = {"gravity": GRAVITY, "fluid_density": 0.0, **(surroundings or {})}
    frame = {**columns, outcome: values}
    return hlcs.Experiment.from_frames(frame, kind="outcomes", body=BALL, surroundings=place, noise={outcome: 0.001})


@pytest.fixture(scope="module")
def falls():
    return table("fall_time_s", [0.452, 0.4515, 0.639], height_m=[1.0, 1.0, 2.0])


def test_a_fall_in_a_vacuum_takes_the_root_of_two_heights_over_gravity(falls):
    """t = sqrt(2 h / g) at heights that were never measured, in the order given; 1e-9: bisection of a parabola."""
    frame = hlcs.predict(falls, {"height_m": HEIGHTS[::-1]})
    assert list(frame.columns) == ["height_m", "fall_time_s"] and frame["height_m"].tolist() == HEIGHTS[::-1].tolist()
    assert frame["fall_time_s"].to_numpy() == pytest.approx(np.sqrt(2 * HEIGHTS[::-1] / GRAVITY), rel=1e-9)


def test_an_input_of_its_own_replaces_what_the_file_states(falls):
    """On the Moon, 1.62 m/s2, beside one height for all rows."""
    frame = hlcs.predict(falls, pd.DataFrame({"gravity_m_s2": [1.62, 9.81]}).assign(height_m=1.0))
    assert frame["fall_time_s"].to_numpy() == pytest.approx(np.sqrt(2 / np.array([1.62, 9.81])), rel=1e-9)


def test_an_effect_that_is_added_slows_the_fall_as_its_law_says(falls):
    """Linear drag, a = g - c v: h = g t/c - g (1 - exp(-c t))/c^2, of the time that is foretold; 1e-6: of 160 steps."""
    rate = 0.8
    t = hlcs.predict(falls, {"height_m": HEIGHTS}, effects=[mb.LinearDrag(rate=rate)])["fall_time_s"].to_numpy()
    assert GRAVITY * t / rate - GRAVITY * (1 - np.exp(-rate * t)) / rate**2 == pytest.approx(HEIGHTS, rel=1e-6)


def test_a_model_that_was_found_foretells_what_the_law_behind_the_data_does():
    """Lengths read 2 % too short, so that times are longer by 1.01: what a diagnosis finds is asked as its model, and as applied.

    At 20 m, four times beyond the data, the true law says sqrt(2 x 20/(0.98 x 9.81)); 0.2 %: the interval of the found scale.
    """
    heights = np.repeat(HEIGHTS, 4)
    noise = np.random.default_rng(1).normal(0.0, 0.001, len(heights))
    seen = table("fall_time_s", np.sqrt(2 * heights / (0.98 * GRAVITY)) + noise, height_m=heights)
    found = hlcs.diagnose(seen, candidates=["length_scale"])
    assert found.effects == ("length_scale",)
    far = hlcs.predict(seen, {"height_m": 20.0}, model=found.model)
    assert far["fall_time_s"][0] == pytest.approx(np.sqrt(2 * 20.0 / (0.98 * GRAVITY)), rel=2e-3)
    applied = hlcs.predict(found.apply(seen), {"height_m": 20.0})["fall_time_s"][0]
    assert applied == pytest.approx(far["fall_time_s"][0], rel=1e-4)  # an entry is written with the digits of its interval


def test_rebounds_and_slides_are_foretold_by_their_laws():
    """e^2 h, and v^2/(2 mu g)."""
    bounce = table("rebound_height_m", [0.64, 0.63, 0.65], {"restitution": 0.8}, height_m=[1.0, 1.0, 1.0])
    assert hlcs.predict(bounce, {"height_m": 2.0})["rebound_height_m"][0] == pytest.approx(0.64 * 2.0, rel=1e-6)
    slide = table("stop_distance_m", [0.2, 0.21, 0.19], {"friction": 0.4}, speed_m_s=[1.25, 1.26, 1.24])
    speeds = np.array([0.5, 2.0])
    found = hlcs.predict(slide, {"speed_m_s": speeds})["stop_distance_m"].to_numpy()
    assert found == pytest.approx(speeds**2 / (2 * 0.4 * GRAVITY), rel=1e-6)


def test_a_prediction_at_the_measured_inputs_is_the_model_of_the_comparison(falls):
    seen = hlcs.compare(falls).to_dataframe()
    again = hlcs.predict(falls, {"height_m": seen["height_m"].to_numpy()})
    np.testing.assert_allclose(again["fall_time_s"], seen["model"], rtol=1e-12)


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        ({"heigth_m": [1.0]}, "inputs: unknown column 'heigth_m'; the nearest known column is 'height_m'"),
        ({"friction": [0.5]}, "fall_time_s needs the column 'height_m'"),
        ({"height_m": [-1.0]}, "inputs, row 0, column height_m: -1 cannot be right; it must be between 0 and 1000"),
        ({"height_m": [1.0, None]}, "inputs, row 1: blank; every row needs its inputs"),
        ({"height_m": [1.0], "fall_time_s": [0.4]}, "unknown column 'fall_time_s'"),
        ([1.0, 2.0], "inputs: list has no columns by name"),
    ],
)
def test_inputs_that_cannot_be_are_refused_by_row_and_column(falls, inputs, words):
    with pytest.raises(hlcs.InputError, match=words):
        hlcs.predict(falls, inputs)


def test_what_is_no_table_is_not_asked(falls, tmp_path):
    with pytest.raises(hlcs.InputError, match='predict: kind = "trajectory"; only a table of outcomes'):
        hlcs.predict(write_throws(tmp_path, count=2), {"height_m": 1.0})
    with pytest.raises(hlcs.InputError, match="predict: give one model, or effects"):
        hlcs.predict(falls, {"height_m": 1.0}, model=object(), effects=[mb.LinearDrag(rate=0.8)])
