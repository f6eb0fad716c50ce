"""Tasks that wait for one another are answered in one batch, and end as they should."""

import time

import numpy as np
import pytest

from hlcs.simulation.batching import current_task, run_tasks


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


def test_a_task_treats_an_overflow_as_its_caller_does():
    def treated():
        return np.geterr()["over"]

    with np.errstate(over="raise"):
        assert run_tasks(lambda requests: requests, [treated, treated]) == ["raise", "raise"]
