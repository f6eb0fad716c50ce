"""What could be measured next: recordings made again with one thing changed."""

from dataclasses import replace

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.effects import Candidate, Free, class_named
from hlcs.estimation.designs import changes_of, other_bodies_tell
from hlcs.simulation.model import Term
from minibullet import rotations

BALL = Body("sphere", radius=0.03, mass=0.1)
START = np.array([0, 0, 1.0, 2.0, 0, 0, 1, 0, 0, 0, 0, 0, 5.0])


def made(start, contact=False, other_bodies=True, seated=False, body=BALL, **around):
    """{(input, value): (start, Trial, text)} of what is offered beside a recording that starts so."""
    times = np.arange(5) / 10
    around = {"floor_height": 0.0 if contact else None} | around
    position = around.pop("position", np.zeros((5, 3)))
    trial = Trial("a", "a", times, position, np.full((5, 4), np.nan), {}, body, Surroundings(**around))
    return {
        tuple(design.what.items())[0]: (state, new, design.lead + design.text)
        for design, state, new in changes_of(trial, start, contact, seated, other_bodies)
    }


def inputs(found):
    return {name for name, _ in found}


def test_a_throw_is_made_faster_turned_and_longer():
    found = made(START)
    assert np.allclose(found["speed_m_s", 4.0][0][3:6], [4, 0, 0]) and np.allclose(found["heading_deg", 90][0][3:6], [0, 2, 0])
    assert found["spin", "reversed"][0][12] == -5.0 and len(found["duration", "twice"][1].times) == 10
    assert sorted(value for name, value in found if name == "mass_kg") == [0.1 / 3, 0.1 * 3]
    assert found["speed_m_s", 4.0][2] == "make a again, started twice as fast (4 m/s)"


def test_no_arm_throws_faster_than_20_m_s():
    """12 m/s is made slower, and neither twice nor four times as fast; who has thrown at 30 m/s may do so again, not faster."""
    fast = np.where(np.arange(13) == 3, 12.0, START)
    assert {value for name, value in made(fast) if name == "speed_m_s"} == {3.0, 6.0}


def test_what_falls_is_not_thrown_nor_turned():
    """A camera that looks further down sees it faster; in a liquid it has the speed that the liquid gives it."""
    falling = np.array([0, 0, 1.0, 0, 0, -2.0, 1, 0, 0, 0, 0, 0, 0])
    air, water = made(falling), made(falling, fluid_density=1000.0, body=replace(BALL, mass=0.2))
    assert "falls twice as fast (4 m/s)" in air["speed_m_s", 4.0][2]
    assert "heading_deg" not in inputs(air) and inputs(water) == {"repeat", "duration", "mass_kg"}


def test_a_camera_that_sees_one_way_sideways_is_not_asked_for_a_quarter_of_a_turn():
    aside, height = np.zeros((5, 3)), np.zeros((5, 3))
    aside[:, 1], height[:, :2] = np.nan, np.nan
    assert [value for name, value in made(START, position=aside) if name == "heading_deg"] == [180]
    assert "heading_deg" not in inputs(made(START, position=height))


def test_a_body_that_sank_sinks_still():
    """The ball has 884 kg/m3: in water it rises; a third of the mass rises too, three times the mass would sink."""
    rising = made(START, fluid_density=1000.0)
    assert [value for name, value in rising if name == "mass_kg"] == [0.1 / 3]
    assert sorted(value for name, value in made(START, fluid_density=1.2) if name == "mass_kg") == [0.1 / 3, 0.1 * 3]


def test_a_drop_is_made_from_other_heights_and_no_body_is_changed_that_brings_its_own_errors():
    """Half and twice the gap of 0.97 m between the ball of 3 cm and its floor."""
    still = np.where(np.arange(13) < 3, START, 0.0)
    still[6] = 1.0
    found = made(still, contact=True, other_bodies=False)
    raised = sorted(value for name, value in found if name == "raise_m")
    assert np.allclose(raised, [-0.485, 0.97]) and inputs(found) == {"repeat", "raise_m"}
    assert found["raise_m", raised[1]][0][2] == 1.0 + raised[1] and "(1.9 m between" in found["raise_m", raised[1]][2]


def test_what_stands_on_its_floor_is_not_dropped():
    slab = np.array([0, 0, 0.05, 0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0])
    box = Body("box", size=(0.3, 0.1, 0.1), mass=1.0)
    for seated in (True, False):
        assert inputs(made(slab, contact=True, other_bodies=False, body=box, seated=seated)) == {"repeat"}


def test_no_stairwell_is_higher_than_10_m():
    tower = np.array([0, 0, 8.0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0])
    assert [value < 0 for name, value in made(tower, contact=True) if name == "raise_m"] == [True]


def test_a_ball_that_rolls_keeps_rolling_and_its_spin_is_not_reversed():
    """v = omega x r: half the speed has half the spin."""
    rolling = np.array([0, 0, 0.03, 0.6, 0, 0, 1.0, 0, 0, 0, 0, 20.0, 0])
    found = made(rolling, contact=True, seated=True)
    assert {"spin", "raise_m", "duration"}.isdisjoint(inputs(found))
    assert np.allclose(found["speed_m_s", 0.3][0][[3, 11]], [0.3, 10.0])


def test_a_board_is_tilted_and_what_lies_on_it_goes_along():
    """Half and twice 10 degrees; the gap of the body and the angle of its axes to the board stay what they were."""
    normal = np.array([np.sin(np.radians(10)), 0, np.cos(np.radians(10))])
    lying = rotations.exponential(np.array([0, np.radians(10), 0]))
    start = np.concatenate([0.03 * normal + [0, 0.2, 0], np.zeros(3), lying, np.zeros(3)])
    found = made(start, contact=True, seated=True, floor_normal=tuple(normal))
    tilts = {round(value): new for (name, value), new in found.items() if name == "angle_deg"}
    assert set(tilts) == {5, 20}
    for degrees, (state, trial, _) in tilts.items():
        tilted = np.array(trial.surroundings.floor_normal)
        assert np.allclose(tilted, [np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))], atol=1e-12)
        assert np.isclose(state[:3] @ tilted, 0.03) and np.allclose(rotations.rotate(state[6:10], np.eye(3)[2]), tilted)
    assert "angle_deg" not in inputs(made(START, contact=True, seated=True))  # a level floor is no board


def test_a_puck_on_a_board_is_turned_within_the_board():
    normal = np.array([np.sin(0.2), 0, np.cos(0.2)])
    along = np.array([0, 0, 0.0, np.cos(0.2), 0, -np.sin(0.2), 1, 0, 0, 0, 0, 0, 0])
    found = made(along, contact=True, seated=True, floor_normal=tuple(normal))
    assert all(abs(found["heading_deg", angle][0][3:6] @ normal) < 1e-12 for angle in (90, 180))


def test_a_rate_of_drag_holds_for_one_body_and_friction_for_all():
    def term(name, number, unit):
        return Term(Candidate(name, class_named(name), (Free(number, unit, 0.0, 1.0, 0.0, 0.5),)), ((number, 0.5),))

    assert other_bodies_tell([term("friction", "coefficient", "-"), term("quadratic_drag", "drag_coefficient", "-")])
    assert not other_bodies_tell([term("linear_drag", "rate", "1/s")])
    assert not other_bodies_tell([term("mass_offset", "relative", "-")])
