"""The loss of spin of a body in flight or on the spot, read from its recordings without a fit: where a search for its law begins.

Far from a steady spin a small change of a model without loss says nothing of a loss that stops the body within a recording.
"""

import numpy as np

from hlcs.data.rigid_body import known_body, rigid_body
from hlcs.data.turns import turned_since_first
from hlcs.kinds.trajectories.sinking import LEAST, numbers_shown
from hlcs.selection.thresholds import HELPS
from hlcs.simulation.outcome_motion import law_at, load_on, state_of
from minibullet.effects import Effect

RATES = np.geomspace(0.1, 100.0, 61)  # in units of one over the duration of a recording: an eighth apart


def spin_losses_shown(candidates, trials, contact):
    """The number with which each moment of one number gives the loss of spin on recordings, the median over those that show most.

    {name of the candidate: {its number: value}}; {} where no body spins ever slower about one axis. contact: do they lie on their
    floors? The spin is then that about the normal, which friction leaves alone.
    """
    lost = [(trial, *loss) for trial in trials if (loss := _loss(trial, contact)) is not None]
    most = max((shown for _, shown, *_ in lost), default=0.0)
    seen = [(trial, loss, spin) for trial, shown, loss, spin in lost if shown > most / 2]

    def given(law, trial, loss, spin):
        still, spinning = (state_of([trial], np.zeros((1, 3)), np.array([[0.0, 0.0, turn]])) for turn in (0.0, spin))
        moment = (law.forces(still, 0.0) - law.forces(spinning, 0.0))[0, 5]
        if contact:
            normal = np.array([trial.surroundings.floor_normal])
            arm = law_at([trial], (law,), spinning, np.zeros((1, 3)), normal).spinning_arm
            moment += (arm * load_on([trial], spinning, normal))[0]
        return loss, moment / spinning.inertia[0, 2]

    return numbers_shown([entry for entry in candidates if issubclass(entry.kind, Effect)], seen, given)


def _loss(trial, contact):
    """(sum of squares [rad2] that it explains, loss [rad/s2], spin [rad/s]) where half of the spin of one recording is lost, of
    the spin exp(-r t) that follows its orientations best; None where a steady spin does nearly as well.

    Its turn is (1 - exp(-r t))/r times the spin at first, about one axis where the inertia is alike about all.
    """
    there = np.isfinite(trial.orientation).all(axis=1)
    if not known_body(trial.body) or there.sum() < LEAST or np.ptp(inertia := rigid_body(trial.body).inertia) > 1e-6 * inertia[0]:
        return None
    times, orientation = trial.times[there] - trial.times[there][0], trial.orientation[there]
    turned = turned_since_first(orientation)
    if contact:
        turned = (turned @ trial.surroundings.normal)[:, None]
    rates = RATES / times[-1]
    fitted = [_fitted(-np.expm1(-rate * times) / rate, turned) for rate in rates]
    best = int(np.argmin([left for left, _ in fitted]))
    (left, spin), steady = fitted[best], _fitted(times, turned)[0]
    return (steady - left, float(rates[best]) * spin / 2, spin / 2) if left < (1 - HELPS) * steady else None


def _fitted(course, turned):
    """(sum of squares that a turn along a course (n,) leaves of the recorded turns (n, axes) [rad2], its spin)."""
    line = np.column_stack([np.ones(len(course)), course])
    numbers = np.linalg.lstsq(line, turned, rcond=None)[0]
    return float(np.sum((turned - line @ numbers) ** 2)), float(np.linalg.norm(numbers[1]))
