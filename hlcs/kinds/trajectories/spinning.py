"""The loss of spin of a body in flight, read from its recordings without any fit: where a search for its law begins.

Far from a steady spin a small change of a model without loss says nothing of a loss that stops the body within a recording.
"""

import numpy as np

from hlcs.data.rigid_body import known_body, rigid_body
from hlcs.kinds.trajectories.sinking import LEAST, numbers_shown
from hlcs.selection.thresholds import HELPS
from hlcs.simulation.outcome_motion import state_of
from minibullet import rotations
from minibullet.effects import Effect

RATES = np.geomspace(0.1, 100.0, 61)  # in units of one over the duration of a recording: an eighth apart


def spin_losses_shown(candidates, trials):
    """The number with which each moment of one number gives the loss of spin on recordings, the median over them.

    {name of the candidate: {its number: value}}; {} where no body spins ever slower about one axis.
    """
    seen = [(trial, rate) for trial in trials if (rate := _rate_of_loss(trial)) is not None]

    def given(law, trial, rate):
        still, spinning = (state_of([trial], np.zeros((1, 3)), np.array([[0.0, 0.0, spin]])) for spin in (0.0, 1.0))
        return rate, (law.forces(still, 0.0) - law.forces(spinning, 0.0))[0, 5] / spinning.inertia[0, 2]

    return numbers_shown([entry for entry in candidates if issubclass(entry.kind, Effect)], seen, given)


def _rate_of_loss(trial):
    """The rate r of a spin exp(-r t) that follows the orientations of one recording best [1/s], None where a steady spin does
    nearly as well. Its turn is (1 - exp(-r t))/r times the spin at first, about one axis where the inertia is alike about all."""
    there = np.isfinite(trial.orientation).all(axis=1)
    if not known_body(trial.body) or there.sum() < LEAST or np.ptp(inertia := rigid_body(trial.body).inertia) > 1e-6 * inertia[0]:
        return None
    times, orientation = trial.times[there] - trial.times[there][0], trial.orientation[there]
    steps = rotations.logarithm(rotations.product(orientation[1:], rotations.conjugate(orientation[:-1])))
    turned = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    rates = RATES / times[-1]
    left = [_left(-np.expm1(-rate * times), turned) for rate in rates]
    best = int(np.argmin(left))
    return float(rates[best]) if left[best] < (1 - HELPS) * _left(times, turned) else None


def _left(course, turned):
    """Sum of squares that a turn along a course (n,) leaves of the recorded turns (n, 3) [rad2]."""
    line = np.column_stack([np.ones(len(course)), course])
    return float(np.sum((turned - line @ np.linalg.lstsq(line, turned, rcond=None)[0]) ** 2))
