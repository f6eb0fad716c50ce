"""Holding recordings out: numbers fitted to one half of them predict the other."""

import numpy as np

from hlcs.estimation import inference
from hlcs.estimation.least_squares import towards_null

FEW_RECORDINGS = 6


class Folds:
    """Two halves of the recordings, by group."""

    def __init__(self, trials, hold_out):
        groups = sorted({trial.group for trial in trials})
        self.possible = hold_out != "none" and len(groups) >= 2
        half = {name: index % 2 for index, name in enumerate(groups)}
        self.side = np.array([half[trial.group] for trial in trials])
        bodies = {}
        for trial in trials:
            bodies.setdefault(trial.body, set()).add(trial.recording or trial.name)
        self.few = min(len(names) for names in bodies.values()) < FEW_RECORDINGS

    def residuals(self, fit):
        """White, projected residuals of every recording, numbers taken from the other half (list of (n_i,))."""
        r, s = fit.linear.projected
        frees = [free for term in fit.model.terms for free in term.candidate.free]
        prior, aim = towards_null(fit.estimate, frees)
        held = [None] * len(r)
        for side in (0, 1):
            train = np.flatnonzero(self.side != side)
            rows, aims = np.concatenate([*(s[k] for k in train), prior]), np.concatenate([*(r[k] for k in train), aim])
            step = inference.least_squares(rows, aims).estimate
            for k in np.flatnonzero(self.side == side):
                held[k] = r[k] - s[k] @ step
        return held
