"""Recordings of tumbling bodies are split where small changes grow, and every segment is followed."""

import numpy as np
from experiments import measured
from tosses import write_tosses

from hlcs.kinds.trajectories.preparation import prepare


def test_a_tumble_is_cut_and_every_piece_is_followed(tmp_path):
    recordings = measured(write_tosses(tmp_path, [1.8, 1.5]))
    prepared = prepare(recordings)
    problem, whole = prepared.problem, recordings.trials
    assert len(problem.trials) > len(whole) and any("split into" in note for note in prepared.notes)
    for trial in whole:
        its = [piece for piece in problem.trials if (piece.recording or piece.name) == trial.name]
        assert np.array_equal(np.concatenate([piece.times for piece in its]), trial.times)
        assert all(trial.times[piece.first_row] == piece.times[0] and piece.group == trial.group for piece in its)
    assert prepared.base.chi2 < 2 * prepared.base.freedom
