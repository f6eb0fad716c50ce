"""A ball that rolls down a slope in a table of slides: the friction that stands in for its turning is not told alone."""

import numpy as np
import pytest

import hlcs

NOTE = "rolls without slipping"
BALL = {"shape": "sphere", "radius": 0.0125, "mass": 0.0637}


def told(slowed, body, friction=0.05, angles=(5.0,)):
    """(verdict, report in one line) of times over eight ways down slopes, four times each, 15 ms of scatter.

    slowed: angle -> acceleration as a part of g sin(angle).
    """
    way, angle = (part.ravel() for part in np.meshgrid(np.repeat(np.arange(0.25, 2.1, 0.25), 4), angles))
    pull = 9.81 * np.sin(np.deg2rad(angle)) * slowed(np.deg2rad(angle))
    times = np.sqrt(2 * way / pull) + 0.015 * np.random.default_rng(4).standard_normal(len(way))
    columns = {"angle_deg": angle, "distance_m": way, "slide_time_s": times}
    around = {"friction": friction, "fluid_density": 0.0}
    found = hlcs.diagnose(hlcs.Experiment.from_frames(columns, kind="outcomes", body=body, surroundings=around))
    return found.verdict, " ".join(str(found).split())


@pytest.mark.parametrize("friction", [0.05, 0.3])
def test_a_solid_ball_goes_with_five_sevenths_of_the_pull_whatever_the_friction(friction):
    """With a friction above the slope the model holds the ball, and nothing else is found; below it 2/7 of the slope is."""
    verdict, report = told(lambda angle: 5 / 7, BALL, friction)
    assert verdict == ("effect" if friction < np.tan(np.deg2rad(5)) else "unexplained")
    assert f"Or none of this: if the body {NOTE}" in report


def test_a_hollow_ball_goes_with_three_fifths_of_it():
    inertia = 2 / 3 * BALL["mass"] * BALL["radius"] ** 2
    assert NOTE in told(lambda angle: 3 / 5, BALL | {"inertia": [inertia] * 3})[1]
    assert NOTE not in told(lambda angle: 3 / 5, BALL)[1]  # as a solid one


def test_what_slides_is_no_ball_that_rolls():
    """A friction of 0.05 at two slopes: they tell it from rolling; a box slides, even where its friction is 2/7 of the slope."""
    assert NOTE not in told(lambda angle: 1 - 0.05 / np.tan(angle), BALL, 0.02, (5.0, 10.0))[1]
    assert NOTE not in told(lambda angle: 5 / 7, {"shape": "box", "size": [0.03, 0.03, 0.03], "mass": 0.06})[1]
