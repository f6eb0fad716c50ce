"""What could be measured next: recordings made again with one thing changed."""

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.effects import Candidate, Free, class_named
from hlcs.estimation.designs import changes_of, other_bodies_tell
from hlcs.simulation.model import Term

BALL = Body("sphere", radius=0.03, mass=0.1)
START = np.array([0, 0, 1.0, 2.0, 0, 0, 1, 0, 0, 0, 0, 0, 5.0])


def made(start, contact=False, other_bodies=True):
    times = np.arange(5) / 10
    surroundings = Surroundings(floor_height=0.0 if contact else None)
    trial = Trial("a", "a", times, np.zeros((5, 3)), np.full((5, 4), np.nan), {}, BALL, surroundings)
    return {
        tuple(design.what.items())[0]: (state, new)
        for design, state, new in changes_of(trial, start, contact, False, other_bodies)
    }


def test_a_throw_is_made_faster_turned_and_longer():
    found = made(START)
    assert np.allclose(found["speed_m_s", 4.0][0][3:6], [4, 0, 0]) and np.allclose(found["heading_deg", 90][0][3:6], [0, 2, 0])
    assert found["spin", "reversed"][0][12] == -5.0 and len(found["duration", "twice"][1].times) == 10
    assert sorted(value for name, value in found if name == "mass_kg") == [0.1 / 3, 0.1 * 3]


def test_a_drop_is_made_from_higher_and_no_body_is_changed_that_brings_its_own_errors():
    still = np.where(np.arange(13) < 3, START, 0.0)
    found = made(still, contact=True, other_bodies=False)
    assert found["raise_m", 1.0][0][2] == 2.0 and {name for name, _ in found} == {"repeat", "raise_m"}


def test_a_rate_of_drag_holds_for_one_body_and_friction_for_all():
    def term(name, number, unit):
        return Term(Candidate(name, class_named(name), (Free(number, unit, 0.0, 1.0, 0.0, 0.5),)), ((number, 0.5),))

    assert other_bodies_tell([term("friction", "coefficient", "-"), term("quadratic_drag", "drag_coefficient", "-")])
    assert not other_bodies_tell([term("linear_drag", "rate", "1/s")])
    assert not other_bodies_tell([term("mass_offset", "relative", "-")])
