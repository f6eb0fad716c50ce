"""What a search may cost: few recordings are screened where all cost too much."""

from experiments import measured
from tosses import write_tosses

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
