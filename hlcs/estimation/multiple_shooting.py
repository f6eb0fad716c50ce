"""Initial states of recordings whose fit got stuck on its way through impacts, fitted anew over a growing stretch of each."""

import numpy as np

from hlcs.estimation.fitting import chi2_of
from hlcs.estimation.least_squares import least_squares
from hlcs.estimation.whitening import whiten
from hlcs.simulation.initial_state import stepped

BAD = 2.0  # chi2 per degree of freedom of a recording above which its initial state is fitted anew
STRETCHES = (0.3, 0.6, 1.0)  # parts of a recording that are fitted one after the other
DAMPINGS = (0.0, 1e-3, 0.03, 1.0)  # of Levenberg and Marquardt, tried in one batch
ROUNDS = 5  # steps on each stretch


def refit_initial_states(problem, fit):
    """The fit with better initial states for recordings that it explains poorly; itself where there are none."""
    better = regrown(problem, fit)
    return fit if better is fit.initial_states else problem.fit(fit.model, better)


def regrown(problem, fit):
    """The initial states of a fit, those of recordings that it explains poorly as `grown_states` has them where these are better;
    the same object where there are none."""
    known = zip(fit.linearization.white, fit.linearization.state_bases, strict=True)
    bad = np.flatnonzero(fit.chi2_per_recording > BAD * np.array([max(len(r) - q.shape[1], 1) for r, q in known]))
    if len(bad) == 0:
        return fit.initial_states
    states = grown_states(problem, fit.model, bad)
    better = fit.initial_states.copy()
    both = np.concatenate([fit.initial_states[bad], states[bad]])
    old, new = chi2_over(problem, fit.model, both, np.tile(bad, 2), dict.fromkeys(bad, slice(None))).reshape(2, -1)
    better[bad[new < old]] = states[bad[new < old]]
    return better


def grown_states(problem, model, which):
    """Initial states (trials, 13) of a model: first guesses, those of the recordings `which` fitted over growing stretches.

    Without shared numbers recordings do not know of each other, so each takes the step that is best for it. The first stretch
    ends before most impacts, where the way to the best state is straight; each stretch begins with what the one before found.
    """
    states = problem.initial_guess()
    times = {k: problem.recordings[k].times for k in which}
    for stretch in STRETCHES:
        stretches = {k: seen <= seen.min() + stretch * np.ptp(seen) for k, seen in times.items()}
        improve_for(ROUNDS, problem, model, states, stretches)
    return states


def improve_for(rounds, problem, model, states, stretches):
    """Up to so many rounds of `improve` for the recordings that have a stretch, in place."""
    active = np.array(sorted(stretches))
    for _ in range(rounds):
        if len(active):
            active = improve(problem, model, states, stretches, active)


def chi2_over(problem, model, states, owner, stretches):
    """chi2 of runs over the stretch of their recordings, (runs,); inf where a run fails."""
    with np.errstate(all="ignore"):
        trajectories = problem.simulator.simulate(model, states, owner)
        white = [
            whiten(problem.recordings[k].whitening, problem.residual(k, trajectory))[stretches[k]]
            for k, trajectory in zip(owner, trajectories, strict=True)
        ]
    return chi2_of(white)


def improve(problem, model, states, stretches, active):
    """Move the states of the active recordings, in place, by the best of the damped steps; those that are still on their way."""
    linear = problem.linearise(model, states, only=active)
    tried, before, owner = [], [], np.repeat(active, len(DAMPINGS))
    for k, r, n in zip(active, linear.white, linear.state_columns, strict=True):
        r, n = r[stretches[k]], n[stretches[k]]
        before.append(float(r @ r))
        size = np.linalg.norm(n, axis=0)
        size = np.where(size > 0, size, 1.0)
        for damping in DAMPINGS:
            rows = np.concatenate([n / size, np.sqrt(damping) * np.eye(n.shape[1])])
            move = least_squares(rows, np.concatenate([r, np.zeros(n.shape[1])])).estimate / size
            tried.append(stepped(states[k], problem.recordings[k].unknown, move))
    chi2 = chi2_over(problem, model, np.array(tried), owner, stretches).reshape(-1, len(DAMPINGS))
    moving = []
    for place, (k, old) in enumerate(zip(active, before, strict=True)):
        best = int(np.argmin(chi2[place]))
        if chi2[place, best] < old:
            states[k] = tried[place * len(DAMPINGS) + best]
            if chi2[place, best] < 0.98 * old - 0.3:
                moving.append(k)
    return np.array(moving, dtype=int)
