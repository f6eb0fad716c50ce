"""The simulator: shares of a batch, and what becomes of a batch in which one run cannot be."""

from types import SimpleNamespace

import numpy as np
import pytest
from experiments import measured
from throws import write_throws
from tosses import write_tosses

from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.simulation.model import Model, Term
from hlcs.simulation.simulator import Simulator, partition, step_of_flights
from minibullet.errors import InputError


def test_a_batch_is_parted_so_that_each_part_is_held_at_once():
    """Length times the largest size stays within the limit; what fits together stays together, in its order."""
    sizes = np.array([5, 1, 4, 1, 3, 1])
    assert partition(range(6), sizes, 30) == [[0, 1, 2, 3, 4, 5]]
    parts = partition(range(6), sizes, 8)
    assert sorted(b for part in parts for b in part) == list(range(6))
    assert all(len(part) == 1 or len(part) * max(sizes[part]) <= 8 for part in parts)
    assert [list(sizes[part]) for part in parts] == [[1, 1, 1], [3, 4], [5]]


def test_a_request_at_fault_spoils_its_own_answer_only():
    """Of 64 requests in one World two leave the finite numbers: both get their error, the others their answers, in their order,
    after a number of simulations that grows with the logarithm of 64 and not with 64."""
    simulator, asked = Simulator.__new__(Simulator), []
    simulator.contact = True

    def batch(requests):
        asked.append(len(requests))
        wrong = [model for model, *_ in requests if model in (20, 50)]
        if wrong:
            raise InputError(f"model {wrong[0]} is at fault")
        return [[f"motion {model}"] for model, *_ in requests]

    simulator._batch = batch
    answers = simulator._batch_or_errors([(model, np.zeros((1, 13)), np.zeros(1, int), None) for model in range(64)])
    assert [str(answers[k]) for k in (20, 50)] == ["model 20 is at fault", "model 50 is at fault"]
    assert all(answers[k] == [f"motion {k}"] for k in range(64) if k not in (20, 50))
    assert len(asked) <= 1 + 2 * 2 * 6


def test_models_asked_for_together_fly_as_each_does_alone(tmp_path):
    """Eight throws: gravity, drags, a scale of time, and drags whose flights begin with short steps. The same bits, whoever flies
    beside."""
    measurement = measured(write_throws(tmp_path))
    problem = prepare(measurement).problem
    simulator, owner, states = problem.simulator, np.arange(len(problem.trials)), problem.initial_guess()
    entries = {entry.name: entry for entry in candidates_for(measurement, False)[0]}
    chosen = [("linear_drag", 0.1), ("linear_drag", 0.2), ("quadratic_drag", 0.1), ("time_scale", 1.01), ("linear_drag", 40.0)]
    chosen += [("quadratic_drag", 2000.0)]
    models = [Model(), *(Model((Term(entries[name], ((entries[name].free[0].name, value),)),)) for name, value in chosen)]
    together = simulator.simulate_all([(model, states, owner, None) for model in models])
    for model, answer in zip(models, together, strict=True):
        for mine, its in zip(simulator.simulate(model, states, owner), answer, strict=True):
            assert np.array_equal(mine.position, its.position)


@pytest.mark.parametrize(("spacings", "step"), [((1 / 60, 1.0), 1 / 15), ((1.0, 3.0), 1.0)])
def test_flights_are_followed_in_steps_as_long_as_between_readings_and_in_no_shorter_ones_than_usual(spacings, step):
    """Of several recordings the one read most often says it."""
    trials = [SimpleNamespace(times=spacing * np.arange(9)) for spacing in spacings]
    assert step_of_flights(trials) == step


@pytest.mark.parametrize("offset", [0.2, -0.05, -0.5])
def test_a_clock_that_is_late_shows_what_came_after_the_recording_was_to_end(tmp_path, offset):
    """Throws of one second seen through a clock half a second late: the parabola goes on, and not straight from its end."""
    problem = prepare(measured(write_throws(tmp_path))).problem
    states, model = problem.initial_guess(), Model(fixed=({"name": "clock_offset", "offset": offset},))
    seen = problem.simulator.simulate(model, states, np.arange(len(states)))
    for trial, state, motion in zip(problem.trials, states, seen, strict=True):
        t = (trial.times - offset)[:, None]
        expected = state[:3] + state[3:6] * t + [0.0, 0.0, -9.81 / 2] * t**2
        within = t[:, 0] >= 0  # before its start a body is not simulated
        np.testing.assert_allclose(motion.position[within], expected[within], atol=1e-9)


def test_a_trial_in_steps_of_its_own_moves_as_it_does_in_these_alone(tmp_path):
    trials = measured(write_tosses(tmp_path, [1.8, 1.5])).trials
    simulator = Simulator(Model(), trials, [0.0, 0.0], True, 1 / 240)
    states = np.array([[0, 0, 0.15, speed, 0, 0, 1, 0, 0, 0, 0, 5.0, 0] for speed in (1.8, 1.5)], dtype=float)
    alone = [simulator.simulate(Model(), states[[k]], np.array([k]), step) for k, step in ((0, 1 / 240), (1, 1 / 960))]
    simulator.halvings[1] = 2
    together = simulator.simulate(Model(), states, np.arange(2))
    assert all(np.array_equal(one.position, its.position) for one, (its,) in zip(together, alone, strict=True))
    again = simulator.for_trials(Model(), trials, *simulator.of_trials).simulate(Model(), states, np.arange(2), 1 / 480)
    (half,) = simulator.simulate(Model(), states[[1]], np.array([1]), 1 / 480)
    assert np.array_equal(again[1].position, half.position) and not np.array_equal(half.position, together[1].position)
