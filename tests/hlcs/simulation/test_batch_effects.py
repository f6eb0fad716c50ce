"""Runs of several models in one World give what each gives alone."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body
from hlcs.data.rigid_body import rigid_body
from hlcs.simulation import contact_motion
from minibullet.effects import AddedMass, Friction, Gravity, LinearDrag, Restitution, RollingFriction

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
