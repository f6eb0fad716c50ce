"""Many small runs in one World give what each gives alone; pieces of work that wait for one another end as they should."""

import time

import numpy as np
import pytest

from hlcs.data.experiment_file import Body
from hlcs.data.rigid_body import rigid_body
from hlcs.simulation import contact_motion
from hlcs.simulation.batching import current_task, run_tasks
from hlcs.simulation.simulator import richardson
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


def test_pieces_are_answered_together_in_order():
    asked = []

    def answer(requests):
        asked.append(list(requests))
        return [10 * request for request in requests]

    def piece(name, turns):
        total = 0
        for _ in range(turns):
            total += current_task().ask([name])[0]
        return total

    def nested():
        inner = run_tasks(lambda requests: current_task().ask(requests), [lambda: piece(7, 1), lambda: piece(8, 2)])
        return sum(inner)

    assert run_tasks(answer, [lambda: piece(1, 2), lambda: piece(2, 1), nested]) == [20, 20, 230]
    assert asked == [[1, 2, 7, 8], [1, 8]]
    assert current_task() is None


def test_one_failure_ends_all_pieces():
    ended = []

    def waits():
        try:
            while True:
                current_task().ask([0])
        finally:
            ended.append("waits")

    def fails():
        current_task().ask([0])
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        run_tasks(lambda requests: requests, [waits, fails])
    for _ in range(200):
        if ended:
            break
        time.sleep(0.01)
    assert ended == ["waits"]


def test_two_steps_are_carried_on_to_zero():
    """An error of first order vanishes, that of a turn too."""

    def answer(step):
        half = (0.4 + 2 * step) / 2
        return [(np.array([[1.0 + 3 * step, 0.0, 0.0]]), np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]]))]

    ((position, turn),) = richardson(answer(0.02), answer(0.01))
    np.testing.assert_allclose(position, [[1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(turn, [[np.cos(0.2), 0.0, 0.0, np.sin(0.2)]], atol=1e-12)
    error = ValueError("no")
    assert richardson(error, answer(0.01)) is error
