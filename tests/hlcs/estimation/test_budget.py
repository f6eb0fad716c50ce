"""What a search may cost: few recordings are screened where all cost too much."""

from types import SimpleNamespace

from experiments import measured
from tosses import write_tosses

from hlcs.estimation import budget
from hlcs.estimation.budget import SEARCH_LINEARISATIONS, SEGMENTED_LIMIT, linearisation_cost, screening_subset


def test_few_recordings_are_screened_where_all_cost_too_much(tmp_path):
    measurement = measured(write_tosses(tmp_path, [1.0] * 9))
    few, many, notes = screening_subset(measurement, contact=True)
    assert (
        1 <= len(few.trials) < len(many.trials) <= 9
        and linearisation_cost(few.trials, 1 / 240) * SEARCH_LINEARISATIONS <= SEGMENTED_LIMIT
    )
    assert {trial.group for trial in few.trials} == {"day 0", "day 1"} and "t0.csv" in notes[0] and "9 recordings" in notes[0]
    assert screening_subset(measurement, contact=False)[0] is measurement


def test_the_time_left_is_what_the_rest_of_the_limit_takes_at_the_rate_so_far(monkeypatch):
    """A quarter of the limit took 20 s: three quarters take 60 s. Nothing can be told at the start, nor beyond the limit."""
    clock = [100.0]
    monkeypatch.setattr(budget, "perf_counter", lambda: clock[0])
    simulator = SimpleNamespace(contact=False, body_steps=7.0)
    spent = budget.Budget(SimpleNamespace(simulator=simulator, contact=False))
    told = [spent.time_left()]
    clock[0] = 120.0
    for share in (0.25, 1.5):
        simulator.body_steps = 7.0 + share * budget.FLIGHT_LIMIT
        told.append(spent.time_left())
    assert told == ["", ", at most 60 s left", ""]


def test_of_fits_of_segments_those_too_dear_are_passed_over_and_cheaper_ones_made():
    """Two numbers took 0.4 of the limit, 0.2 each: of 0.6 left two numbers and one are affordable, seven and one more are not."""
    simulator = SimpleNamespace(contact=True, body_steps=0.0)
    spent = budget.Budget(SimpleNamespace(simulator=simulator, contact=True, segmented=True))
    simulator.body_steps = 0.4 * spent.limit
    spent.fitted(2, 0.0)
    assert spent.affordable([7, 2, 1, 1], most=4) == [1, 2]
    assert spent.affordable([1, 1, 1, 1], most=2) == [0, 1]
