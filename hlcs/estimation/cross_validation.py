"""Cross-validation: numbers fitted to one half of the recordings predict the other."""

from collections import Counter

import numpy as np

from hlcs.estimation.correlated_noise import lower_factor
from hlcs.estimation.least_squares import least_squares, whitening_beside

FEW_RECORDINGS = 6


class CrossValidation:
    """Two halves of the recordings, by group: of each session every second group, so that both tell the numbers of it."""

    def __init__(self, trials, hold_out, few=None):
        """few: so few that each half must show a fall; None: as the recordings of each body tell."""
        groups = {}  # name -> the first of its sessions
        for trial in trials:
            session = getattr(trial, "session", "")
            groups[trial.group] = min(groups.get(trial.group, session), session)
        groups = sorted(groups, key=lambda group: (groups[group], group))
        self.possible = hold_out != "none" and len(groups) >= 2
        half = np.array([groups.index(trial.group) % 2 for trial in trials])
        self.halves = [np.flatnonzero(half == which) for which in (0, 1)]  # recordings of each
        recordings = {(trial.body, trial.whole) for trial in trials}
        counts = Counter(body for body, _ in recordings)
        self.few = min(counts.values()) < FEW_RECORDINGS if few is None else few

    def residuals(self, fit):
        """White, projected residuals of every recording, numbers taken from the other half (list of (n_i,)).

        What acts on no recording of the other half, such as a clock of a session that is one group, no other recording can
        foretell: it is fitted where it acts, as initial states are.
        """
        r, s = fit.linearization.projected
        held_out = [None] * len(r)
        for inside, train, trained in self._trained(fit):
            own, change = ~np.any([s[k].any(axis=0) for k in train], axis=0), trained.estimate.copy()
            if own.any():
                left = [r[k] - s[k][:, ~own] @ np.clip(change, *fit.ends)[~own] for k in inside]
                change[own] = _fitted(left, [s[k][:, own] for k in inside], *(row[own] for row in fit.belief)).estimate
            change = np.clip(change, *fit.ends)
            for k in inside:
                held_out[k] = r[k] - s[k] @ change
        return held_out

    def foretold(self, fit):
        """(what the other half foretells wrongly in one row (n,), white for what it leaves unknown of the numbers too, log
        determinant of that).

        The squares of the row and the logarithm make -2 log of the density that each half foretells of the other: r is normal
        with the covariance 1 + J C J^T, C that of the numbers and J their columns.
        """
        r, s = fit.linearization.projected
        rows, logarithm = [], 0.0
        for inside, _, trained in self._trained(fit):
            change, unknown = np.clip(trained.estimate, *fit.ends), lower_factor(trained.covariance)
            white, more = whitening_beside(np.concatenate([s[k] @ unknown for k in inside]))
            rows.append(white(np.concatenate([r[k] - s[k] @ change for k in inside])))
            logarithm += more
        return np.concatenate(rows), logarithm

    def _trained(self, fit):
        """[(recordings of a half, those of the other, LinearFit of the numbers to those, from where they stand)]"""
        r, s = fit.linearization.projected
        pairs = zip(self.halves, self.halves[::-1], strict=True)
        return [(inside, train, _fitted([r[k] for k in train], [s[k] for k in train], *fit.belief)) for inside, train in pairs]


def _fitted(residuals, columns, believed, slopes):
    """LinearFit of numbers to the residuals of recordings [(n_i,)] on their columns [(n_i, p)] and to what is believed of them,
    rows (p,) that change by their slopes."""
    return least_squares(np.concatenate([*columns, np.diag(slopes)]), np.concatenate([*residuals, -believed]))
