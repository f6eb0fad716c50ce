"""A ball that rolls down a slope in a table of slides: the friction that stands in for its turning is not told alone."""

import numpy as np
import pytest

import hlcs
import minibullet as mb
from hlcs.data.experiment_file import Body, Surroundings
from hlcs.effects.contract import Setup
from hlcs.simulation.outcome_motion import slide_time

NOTE = "rolls without slipping"
BALL = {"shape": "sphere", "radius": 0.0125, "mass": 0.0637}


def told(slowed, body, friction=0.02, angles=(5.0,), whole=False):
    """(verdict, report in one line) of times over eight ways down slopes, four times each, 15 ms of scatter; or all of it.

    slowed: angle -> acceleration as a part of g sin(angle).
    """
    way, angle = (part.ravel() for part in np.meshgrid(np.repeat(np.arange(0.25, 2.1, 0.25), 4), angles))
    pull = 9.81 * np.sin(np.deg2rad(angle)) * slowed(np.deg2rad(angle))
    times = np.sqrt(2 * way / pull) + 0.015 * np.random.default_rng(4).standard_normal(len(way))
    columns = {"angle_deg": angle, "distance_m": way, "slide_time_s": times}
    around = {"friction": friction, "fluid_density": 0.0}
    found = hlcs.diagnose(hlcs.Experiment.from_frames(columns, kind="outcomes", body=body, surroundings=around))
    return found if whole else (found.verdict, " ".join(str(found).split()))


@pytest.mark.parametrize("friction", [0.02, 0.03, 0.3])
def test_a_solid_ball_goes_with_five_sevenths_of_the_pull_whatever_the_friction(friction):
    """A friction of 2/7 of the slope, 0.025, makes the ball grip, and it rolls; with less it slips, and that friction is
    found, or one that is as large at first."""
    verdict, report = told(lambda angle: 5 / 7, BALL, friction)
    if friction > 2 / 7 * np.tan(np.deg2rad(5)):
        assert verdict == "complete" and f"so it {NOTE}" in report
    else:
        assert verdict in ("effect", "ambiguous") and "Friction is 0.02" in report
        assert f"Or none of this: if the body {NOTE}" in report


def test_resistance_to_rolling_takes_its_arm_over_the_radius_of_the_slope():
    """a = (5/7) g (sin - arm/r cos); an arm of 0.25 mm on a ball of 12.5 mm is a slope of 0.02."""
    found = told(lambda angle: 5 / 7 * (1 - 0.02 / np.tan(angle)), BALL, 0.3, (3.0, 6.0), whole=True)
    number = found.parameters["rolling_friction"]["arm"]
    assert found.effects == ("rolling_friction",) and number["low"] < 2.5e-4 < number["high"] and number["high"] < 2.6e-4


@pytest.mark.parametrize(("degrees", "friction"), [(10.0, 0.5), (30.0, 0.2), (30.0, 0.12)])
def test_the_engine_rolls_a_ball_in_the_same_time(degrees, friction):
    """A World of its own: a ball let go at rest that grips its slope, one that grips a slope steeper than its friction, and one
    that slips as it turns (it would grip 30 degrees from 0.165 on)."""
    angle, radius, step = np.deg2rad(degrees), 0.1, 1 / 960
    world = mb.World(
        effects=[mb.Gravity(9.81, (np.sin(angle), 0.0, -np.cos(angle)))], settings=mb.Settings(time_step=step, friction=friction)
    )
    world.add_plane()
    ball = world.add(mb.Sphere(radius), mass=1.0, position=(0.0, 0.0, radius))
    for _ in range(round(1.3 / step)):
        world.step()
    setup = Setup(Body(radius=radius, mass=1.0), Surroundings(fluid_density=0.0, friction=friction))
    inputs = {"angle_deg": np.array([degrees]), "distance_m": np.array([ball.position[0]])}
    assert slide_time([setup], (mb.Gravity(9.81),), inputs) == pytest.approx(1.3, rel=1e-3)  # the engine is a step late, at most


def test_a_hollow_ball_goes_with_three_fifths_of_it():
    inertia = 2 / 3 * BALL["mass"] * BALL["radius"] ** 2
    assert NOTE in told(lambda angle: 3 / 5, BALL | {"inertia": [inertia] * 3})[1]
    assert NOTE not in told(lambda angle: 3 / 5, BALL)[1]  # as a solid one


def test_a_ball_that_grips_and_goes_otherwise_has_another_inertia():
    """A shell, 3/5 of the pull, stated as a solid ball: I/(m r^2) is 2/3 in place of 2/5, 1.67 times as much."""
    found = told(lambda angle: 3 / 5, BALL, 0.3, (5.0, 10.0), whole=True)
    told_sets = [found.effects, *found.ambiguous]
    assert any("inertia_error" in names for names in told_sets) and "factor y 1.6" in " ".join(str(found).split())


def test_a_cylinder_that_rolls_is_named_beside_what_does_as_well():
    """A solid one, 2/3 of the pull; stated as a ball of that inertia it rolls."""
    cylinder = {"shape": "cylinder", "radius": 0.0125, "height": 0.04, "mass": 0.06}
    assert f"Or none of this: if the body {NOTE}" in told(lambda angle: 2 / 3, cylinder, 0.3, (5.0, 10.0))[1]
    inertia = 0.5 * cylinder["mass"] * cylinder["radius"] ** 2
    ball = {"shape": "sphere", "radius": 0.0125, "mass": 0.06, "inertia": [inertia] * 3}
    assert told(lambda angle: 2 / 3, ball, 0.3, (5.0, 10.0))[0] == "complete"


def test_what_slides_is_no_ball_that_rolls():
    """A friction of 0.05 lets a ball slip at 20 and 30 degrees; a box slides, even where its friction is 2/7 of the slope."""
    assert NOTE not in told(lambda angle: 1 - 0.05 / np.tan(angle), BALL, 0.02, (20.0, 30.0))[1]
    assert NOTE not in told(lambda angle: 5 / 7, {"shape": "box", "size": [0.03, 0.03, 0.03], "mass": 0.06})[1]


def test_the_note_on_rolling_speaks_of_the_model_under_test():
    """A friction of 0.1 in the model in place of the stated 0.5 lets a ball slip at 20 degrees: it would grip from 0.104 on."""
    columns = {"angle_deg": [20.0] * 4, "distance_m": [1.0] * 4, "slide_time_s": [1.8, 1.82, 1.84, 1.81]}
    experiment = hlcs.Experiment.from_frames(columns, BALL, {"friction": 0.5, "fluid_density": 0.0}, kind="outcomes")
    assert any(NOTE in note for note in hlcs.compare(experiment).notes)
    assert not any(NOTE in note for note in hlcs.compare(experiment, effects=[mb.Friction(0.1)]).notes)


def test_a_ball_that_rolls_to_its_stop_is_stopped_by_no_friction():
    """g (b/r) 5/7 with b/r = 0.05: the friction that does the same is 0.0357, the arm 0.05 r = 1.07 mm."""
    speed = np.repeat([0.6, 0.9, 1.2, 1.5, 1.8, 2.1], 4)
    way = speed**2 / (2 * 9.81 * 0.05 * 5 / 7) + 0.01 * np.random.default_rng(1).standard_normal(len(speed))
    ball = {"shape": "sphere", "radius": 0.0214, "mass": 0.0459}
    columns = {"speed_m_s": speed, "stop_distance_m": way}
    found = hlcs.diagnose(hlcs.Experiment.from_frames(columns, ball, {"friction": 0.4, "fluid_density": 0.0}, kind="outcomes"))
    (note,) = (note for note in found.notes if "rolls to its stop" in note)
    assert float(note.split("an arm of ")[1].split(" mm")[0]) == pytest.approx(1.07, abs=0.01)
