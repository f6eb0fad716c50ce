"""Cross-validation: numbers fitted to one half of the recordings predict the other."""

from collections import Counter

import numpy as np

from hlcs.estimation.least_squares import belief, least_squares
from hlcs.estimation.linearization import free_numbers

FEW_RECORDINGS = 6


class CrossValidation:
    """Two halves of the recordings, by group."""

    def __init__(self, trials, hold_out):
        groups = sorted({trial.group for trial in trials})
        self.possible = hold_out != "none" and len(groups) >= 2
        self.half = np.array([groups.index(trial.group) % 2 for trial in trials])  # of each recording, 0 or 1
        recordings = {(trial.body, trial.recording or trial.name) for trial in trials}
        counts = Counter(body for body, _ in recordings)
        self.few = min(counts.values()) < FEW_RECORDINGS  # so few that each half must show a fall

    def residuals(self, fit):
        """White, projected residuals of every recording, numbers taken from the other half (list of (n_i,))."""
        r, s = fit.linearization.projected
        believed, slopes = belief(fit.estimate, free_numbers(fit.model))
        held_out = [None] * len(r)
        for half in (0, 1):
            train = np.flatnonzero(self.half != half)
            rows, aims = (
                np.concatenate([*(s[k] for k in train), np.diag(slopes)]),
                np.concatenate([*(r[k] for k in train), -believed]),
            )
            step = least_squares(rows, aims).estimate
            for k in np.flatnonzero(self.half == half):
                held_out[k] = r[k] - s[k] @ step
        return held_out
