"""Starts of recordings whose fit got stuck on its way through blows: fitted afresh, each by itself, over a growing stretch."""

import numpy as np

from hlcs.estimation import inference
from hlcs.simulation.initial_state import stepped

BAD = 2.0  # chi2 per degree of freedom of a recording above which its start is fitted afresh
STRETCHES = (0.3, 0.6, 1.0)  # parts of a recording that are fitted one after the other
DAMPINGS = (0.0, 1e-3, 0.03, 1.0)  # of Levenberg and Marquardt, tried side by side
ROUNDS = 5  # steps on each stretch


def bad_recordings(fit):
    """Indices of the recordings that a fit explains poorly."""
    freedom = np.array([max(len(r) - q.shape[1], 1) for r, q in zip(fit.linear.r, fit.linear.bases, strict=True)])
    return np.flatnonzero(fit.losses > BAD * freedom)


def shot_again(problem, fit):
    """The fit with better starts for recordings that it explains poorly; itself where there are none.

    Without shared numbers recordings do not know of each other, so each takes the step that is best for it. The first stretch
    ends before most blows, where the way to the best start is straight; each stretch starts from what the one before found.
    """
    bad = bad_recordings(fit)
    if len(bad) == 0:
        return fit
    model, starts = fit.model, problem.guess()
    for stretch in STRETCHES:
        keep = {}
        for k in bad:
            times = problem.recordings[k].times
            keep[k] = times <= times.min() + stretch * np.ptp(times)
        active = bad
        for _ in range(ROUNDS):
            active = _step(problem, model, starts, keep, active)
            if len(active) == 0:
                break
    better = fit.starts.copy()
    both = np.concatenate([fit.starts[bad], starts[bad]])
    old, new = _losses(problem, model, both, np.tile(bad, 2), dict.fromkeys(bad, slice(None))).reshape(2, -1)
    better[bad[new < old]] = starts[bad[new < old]]
    return problem.fit(model, better)


def _losses(problem, model, starts, owner, keep):
    """chi2 of runs over the stretch kept of their recordings, (runs,); inf where a run fails."""
    with np.errstate(all="ignore"):
        answers = problem.shots.simulate(model, starts, owner)
        white = [
            inference.whiten(problem.recordings[k].links, problem.residual(k, answer))[keep[k]]
            for k, answer in zip(owner, answers, strict=True)
        ]
    return np.nan_to_num([float(part @ part) for part in white], nan=np.inf)


def _step(problem, model, starts, keep, active):
    """Move the starts of the active recordings, in place, by the best of the damped steps; those that are still on their way."""
    linear = problem.linearise(model, starts, terms=False, only=active)
    tried, owner, before = [], [], []
    for k, r, n in zip(active, linear.r, linear.n, strict=True):
        r, n = r[keep[k]], n[keep[k]]
        before.append(float(r @ r))
        size = np.linalg.norm(n, axis=0)
        size = np.where(size > 0, size, 1.0)
        for damping in DAMPINGS:
            rows = np.concatenate([n / size, np.sqrt(damping) * np.eye(n.shape[1])])
            move = inference.least_squares(rows, np.concatenate([r, np.zeros(n.shape[1])])).estimate / size
            tried.append(stepped(starts[k], problem.recordings[k].unknown, move))
            owner.append(k)
    if not tried:
        return active[:0]
    losses = _losses(problem, model, np.array(tried), np.array(owner), keep).reshape(-1, len(DAMPINGS))
    going = []
    for place, (k, old) in enumerate(zip(active, before, strict=True)):
        best = int(np.argmin(losses[place]))
        if losses[place, best] < old:
            starts[k] = tried[place * len(DAMPINGS) + best]
            if losses[place, best] < 0.98 * old - 0.3:
                going.append(k)
    return np.array(going, dtype=int)
