"""Cross-validation: numbers fitted to one half of the recordings predict the other."""

from collections import Counter

import numpy as np

from hlcs.estimation.correlated_noise import lower_factor
from hlcs.estimation.least_squares import belief, least_squares
from hlcs.estimation.linearization import free_numbers

FEW_RECORDINGS = 6


class CrossValidation:
    """Two halves of the recordings, by group: of each session every second group, so that both tell the numbers of it."""

    def __init__(self, trials, hold_out):
        groups = {}  # name -> the first of its sessions
        for trial in trials:
            session = getattr(trial, "session", "")
            groups[trial.group] = min(groups.get(trial.group, session), session)
        groups = sorted(groups, key=lambda group: (groups[group], group))
        self.possible = hold_out != "none" and len(groups) >= 2
        self.half = np.array([groups.index(trial.group) % 2 for trial in trials])  # of each recording, 0 or 1
        recordings = {(trial.body, trial.recording or trial.name) for trial in trials}
        counts = Counter(body for body, _ in recordings)
        self.few = min(counts.values()) < FEW_RECORDINGS  # so few that each half must show a fall

    def residuals(self, fit):
        """White, projected residuals of every recording, numbers taken from the other half (list of (n_i,))."""
        held_out = [None] * len(self.half)
        for inside, left, _ in self._halves(fit):
            for k, part in zip(inside, left, strict=True):
                held_out[k] = part
        return held_out

    def foretold(self, fit):
        """(the same in one row (n,), white for what the other half leaves unknown of the numbers too, log determinant of that).

        The squares of the row and the logarithm make -2 log of the density that each half foretells of the other: r is normal
        with the covariance 1 + J C J^T, C that of the numbers and J their columns.
        """
        rows, logarithm = [], 0.0
        for _, left, columns in self._halves(fit):
            left = np.concatenate(left)
            u, size, _ = np.linalg.svd(np.concatenate(columns), full_matrices=False)
            rows.append(left - u @ ((1 - 1 / np.hypot(1, size)) * (u.T @ left)))
            logarithm += float(np.sum(np.log1p(size**2)))
        return np.concatenate(rows), logarithm

    def _halves(self, fit):
        """[(recordings of a half, what the other leaves of each (n_i,), its columns in units of what that leaves unknown)]"""
        r, s = fit.linearization.projected
        believed, slopes = belief(fit.estimate, free_numbers(fit.model))
        halves = []
        for half in (0, 1):
            train, inside = np.flatnonzero(self.half != half), np.flatnonzero(self.half == half)
            rows = np.concatenate([*(s[k] for k in train), np.diag(slopes)])
            found = least_squares(rows, np.concatenate([*(r[k] for k in train), -believed]))
            change, unknown = np.clip(found.estimate, *fit.ends), lower_factor(found.covariance)
            halves.append((inside, [r[k] - s[k] @ change for k in inside], [s[k] @ unknown for k in inside]))
        return halves
