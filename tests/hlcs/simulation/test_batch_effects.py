"""Runs of several models in one World give what each gives alone."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body
from hlcs.data.rigid_body import rigid_body
from hlcs.simulation import contact_motion
from minibullet.effects import AddedMass, Friction, Gravity, LinearDrag, Restitution, RollingFriction, ViscousFriction

BALL = rigid_body(Body(shape="sphere", radius=0.03, mass=0.02))


FLAT, LEANING = ((0.0, 0.0, 1.0), 0.0), ((np.sin(0.1), 0.0, np.cos(0.1)), 0.01)


MODELS = (
    (Gravity(9.81),),
    (Gravity(9.81), LinearDrag(0.5)),
    (Gravity(9.81), AddedMass(0.5, 100.0)),
    (Gravity(9.81), Restitution(0.4), Friction(0.1)),
    (Gravity(9.81), RollingFriction(1e-3), LinearDrag(0.2)),
)


def thrown(models, floors):
    start = np.zeros((len(models), 13))
    start[:, 2], start[:, 3], start[:, 6], start[:, 11] = 0.2, 1.0, 1.0, 5.0
    runs = [
        contact_motion.Run(BALL, BALL.shape, state, floor, effects, 0.3, 0.7)
        for state, floor, effects in zip(start, floors, models, strict=True)
    ]
    return contact_motion.simulate(runs, 0.42, 1 / 240)  # before the small bounces, which the engine counts over all bodies


@pytest.mark.parametrize("floors", ([FLAT] * 5, [FLAT, LEANING, FLAT, LEANING, FLAT]))
def test_runs_side_by_side_are_the_runs_alone(floors):
    """Forces, added mass and contact laws of one model reach no other model's run, on one floor or on one each."""
    beside = thrown(list(MODELS), floors)
    for number, (model, floor) in enumerate(zip(MODELS, floors, strict=True)):
        alone = thrown([model], [floor])
        np.testing.assert_allclose(beside.position[:, number], alone.position[:, 0], atol=1e-9)
        np.testing.assert_allclose(beside.spin[:, number], alone.spin[:, 0], atol=1e-6)
    ends = beside.position[-1]
    assert min(np.linalg.norm(ends[a] - ends[b]) for a in range(5) for b in range(a)) > 1e-4  # five different models


def test_a_law_is_asked_once_for_all_runs_that_have_the_same_laws_before_it(monkeypatch):
    """Lists of laws that begin alike, mixed up among the runs: each law is asked once a step for all of them, what differs is
    asked of each by itself, and every run is what it is alone."""
    asked, law, viscous = [], ViscousFriction.contact_law, ViscousFriction(0.1)
    lists = (
        (viscous, RollingFriction(1e-3)),
        (Friction(0.2), viscous),
        (viscous,),
        (),
        (Friction(0.2),),
        (viscous, RollingFriction(2e-3)),
    )
    start = np.zeros((len(lists), 13))
    start[:, 2], start[:, 3], start[:, 6], start[:, 11] = 0.03, 1.0, 1.0, 5.0
    runs = [
        contact_motion.Run(BALL, BALL.shape, state, FLAT, (Gravity(9.81), *laws), 0.3, 0.0)
        for state, laws in zip(start, lists, strict=True)
    ]
    monkeypatch.setattr(ViscousFriction, "contact_law", lambda self, *given: asked.append(len(given[0].gap)) or law(self, *given))
    beside = contact_motion.simulate(runs, 20 / 240, 1 / 240)
    assert sorted(asked) == 20 * [1] + 20 * [3]
    for number, run in enumerate(runs):
        alone = contact_motion.simulate([run], 20 / 240, 1 / 240)
        np.testing.assert_allclose(beside.position[:, number], alone.position[:, 0], atol=1e-12)
        np.testing.assert_allclose(beside.spin[:, number], alone.spin[:, 0], atol=1e-9)
    assert len(set(beside.spin[-1, :, 1].tolist())) == len(runs)
