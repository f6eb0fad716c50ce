"""Recordings of another length than those that were made, at the same rate, as the model under test has them."""

from dataclasses import replace

import numpy as np

from hlcs.data.rigid_body import rigid_body
from hlcs.estimation.designs import with_samples
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.simulation.contact_motion import gap

FEWEST_SAMPLES = 4  # of a recording: as many as reading one asks for


def lasting(problem, base, factor):
    """The problem of recordings of so many times the length, at the same rate, as the model under test has them.

    None where they have too few samples, and where they go on with contacts or through a floor.
    """
    if problem.contact and factor > 1 or any(factor * len(trial.times) < FEWEST_SAMPLES for trial in problem.trials):
        return None
    empty = [with_samples(trial, int(factor * len(trial.times))) for trial in problem.trials]
    known = problem.simulator
    longer = known.for_trials(base.model, empty, *known.of_trials)
    runs = longer.simulate(base.model, base.initial_states, np.arange(len(empty)))
    trials = []
    for trial, (position, orientation, force) in zip(empty, runs, strict=True):
        if factor > 1 and trial.surroundings.floor_height is not None:
            shape = rigid_body(trial.body).shape
            if min(gap(shape, *pose, trial.surroundings) for pose in zip(position, orientation, strict=True)) < 0:
                return None
        read = trial.accelerations and trial.accelerations._replace(values=force + 0 * trial.accelerations.values)
        seen = {"position": position + 0 * trial.position, "orientation": orientation + 0 * trial.orientation}
        trials.append(replace(trial, **seen, accelerations=read))
    return TrajectoryProblem(trials, problem.noise, known.for_trials(base.model, trials, *known.of_trials))


def length_of(problem):
    """Median duration of the recordings of a problem [s]; None where it has none."""
    if not isinstance(problem, TrajectoryProblem):
        return None
    spans = {}
    for trial in problem.trials:
        spans[trial.whole] = spans.get(trial.whole, 0.0) + float(np.ptp(trial.times))
    return float(np.median(list(spans.values())))
