"""Recordings of tumbling bodies are split where small changes grow, and every segment is followed."""

from dataclasses import replace

import numpy as np
import pytest
from experiments import measured
from tosses import write_tosses

from hlcs.estimation.multiple_shooting import noise_leaves
from hlcs.estimation.segments import SHORT, adopted, carried, segments_of, split_lost
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.kinds.trajectories.preparation import prepare

KICK = 0.5  # m/s


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    return measured(write_tosses(tmp_path_factory.mktemp("tosses"), [1.8, 1.5]))


@pytest.fixture(scope="module")
def prepared(recordings):
    return prepare(recordings)


def kicked(prepared, which):
    """(Problem, its fit) with a kick sideways in the middle of the segments `which`, such as no floor of the model gives."""
    problem, states = prepared.problem, prepared.base.initial_states
    segments = segments_of(problem)
    for k in which:
        trial = segments[k].trial
        late = np.maximum(trial.times - trial.times[len(trial.times) // 2], 0.0)
        moved = replace(trial, position=trial.position + KICK * late[:, None] * [0.0, 1.0, 0.0])
        segments[k] = segments[k]._replace(trial=moved)
    trials, *others = (list(column) for column in zip(*segments, strict=True))
    other = TrajectoryProblem(trials, problem.noise, problem.simulator.for_trials(prepared.base.model, trials, *others))
    other.leave_out(problem.dropped)
    return other, other.fit(prepared.base.model, states)


def test_a_tumble_is_cut_and_every_piece_is_followed(recordings, prepared):
    problem, whole = prepared.problem, recordings.trials
    assert len(problem.trials) > len(whole) and any("split into" in note for note in prepared.notes)
    for trial in whole:
        its = [piece for piece in problem.trials if piece.whole == trial.name]
        assert np.array_equal(np.concatenate([piece.times for piece in its]), trial.times)
        assert all(trial.times[piece.first_row] == piece.times[0] and piece.group == trial.group for piece in its)
    assert prepared.base.chi2 < 2 * prepared.base.freedom


def test_the_one_segment_that_no_state_follows_is_halved_and_its_halves_are_followed(prepared):
    longest = int(np.argmax([len(trial.times) for trial in prepared.problem.trials]))
    problem, fit = kicked(prepared, [longest])
    assert fit.chi2_per_recording[longest] > noise_leaves(problem.recordings[longest])
    finer = split_lost(problem, fit)
    better = carried(finer, problem, fit)
    assert len(finer.trials) == len(problem.trials) + 1
    assert all(
        map(np.array_equal, np.split(problem.dropped[longest], [len(finer.trials[longest].times)]), finer.dropped[longest:])
    )
    assert len(finer.trials[longest].times) + len(finer.trials[longest + 1].times) == len(problem.trials[longest].times)
    assert min(len(trial.times) for trial in finer.trials) >= SHORT
    halves = [better.chi2_per_recording[k] < noise_leaves(finer.recordings[k]) for k in (longest, longest + 1)]
    assert any(halves)  # the kick lies in one of them at most


def test_where_many_segments_are_not_followed_a_law_is_missing_and_none_is_halved(prepared):
    problem, fit = kicked(prepared, range(0, len(prepared.problem.trials), 2))
    assert split_lost(problem, fit) is problem


def test_a_segment_that_begins_like_one_before_takes_its_state(prepared):
    problem, states = prepared.problem, prepared.base.initial_states
    assert np.array_equal(adopted(problem, problem, states), states)
    none = adopted(problem, problem, states, np.zeros(len(states), bool))
    assert np.array_equal(none, problem.initial_guess())
