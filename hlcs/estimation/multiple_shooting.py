"""Initial states of recordings whose fit got stuck on its way through impacts, fitted anew over a growing stretch of each."""

import numpy as np
from scipy import special

from hlcs.data.quantities import UNLIKELY
from hlcs.estimation.fitting import CLOSE_IN_CONTACT, chi2_of
from hlcs.estimation.least_squares import least_squares
from hlcs.estimation.whitening import whiten
from hlcs.simulation.initial_state import stepped

BAD = 2.0  # chi2 per degree of freedom of a recording above which its initial state is fitted anew
STRETCHES = (0.3, 0.6, 1.0)  # parts of a recording that are fitted one after the other
DAMPINGS = (0.0, 1e-3, 0.03, 1.0)  # of Levenberg and Marquardt, tried in one batch
ROUNDS = 5  # steps on each stretch
AROUND = 48  # states that are tried around one
SIZES = (0.5, 2.0, 6.0, 20.0)  # of the moves there, in standard errors by its columns
FAINT = 0.01  # of what the columns tell best: what they tell less of is moved by no more
NEAREST = 3  # of them from which steps are taken
SEARCHES = 4  # such rounds
WHOLE = {}  # stretches {recording: samples that are looked at}; all samples of a recording that is not there
GAIN = 0.98  # of chi2: what leaves more of it has gained nothing, a step or a round of such states


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
    old, new = chi2_over(problem, fit.model, both, np.tile(bad, 2)).reshape(2, -1)
    better[bad[new < old]] = states[bad[new < old]]
    return better


def grown_states(problem, model, which):
    """Initial states (trials, 13) of a model: first guesses, those of the recordings `which` fitted over growing stretches.

    Without shared numbers recordings do not know of each other, so each takes the step that is best for it. The first stretch
    ends before most impacts, where the way to the best state is straight; each stretch begins with what the one before found.
    """
    states = problem.initial_guess()
    times = {k: problem.recordings[k].times for k in which if len(problem.recordings[k].times)}
    for stretch in STRETCHES:
        stretches = {k: seen <= seen.min() + stretch * np.ptp(seen) for k, seen in times.items()}
        improve_for(ROUNDS, problem, model, states, list(times), stretches)
    return states


def improve_for(rounds, problem, model, states, which, stretches=WHOLE):
    """Up to so many rounds of `improve` for the recordings `which`, in place."""
    active = np.sort(which)
    for _ in range(rounds):
        if len(active):
            active = improve(problem, model, states, stretches, active)


def searched(problem, model, states, which):
    """Initial states (trials, 13), those of the recordings `which` that are still missed by more than noise sought around them.

    Where an impact passes from one corner to another, chi2 has a kink that no slope leads over, and minima on both sides of it.
    Of states drawn around the best one the nearest to the data begin steps of their own; the draws are the same for each.
    """
    states = states.copy()
    chi2 = dict(zip(which, chi2_over(problem, model, states[which], which), strict=True))
    generator = np.random.default_rng(0)
    draws = generator.normal(size=(SEARCHES, AROUND, 12)) * np.resize(SIZES, AROUND)[:, None]
    gaining = [k for k in which if problem.recordings[k].unknown]  # one that a round of draws gains nothing for is given up
    for draw in draws:
        stuck = np.array([k for k in gaining if chi2[k] > noise_leaves(problem.recordings[k])], dtype=int)
        if len(stuck) == 0:
            break
        before = dict(chi2)
        columns = problem.linearise(model, states, only=stuck).state_columns
        tried = np.concatenate(
            [around(states[k], problem.recordings[k].unknown, n, draw) for k, n in zip(stuck, columns, strict=True)]
        )
        found = chi2_over(problem, model, tried, np.repeat(stuck, AROUND)).reshape(-1, AROUND)
        nearest = np.argsort(found, axis=1)[:, :NEAREST]
        for place in range(NEAREST):
            begun = states.copy()
            begun[stuck] = tried.reshape(len(stuck), AROUND, -1)[np.arange(len(stuck)), nearest[:, place]]
            improve_for(ROUNDS, problem, model, begun, stuck)
            for k, left in zip(stuck, chi2_over(problem, model, begun[stuck], stuck), strict=True):
                if left < chi2[k]:
                    chi2[k], states[k] = left, begun[k]
        gaining = [k for k in stuck if chi2[k] < GAIN * before[k]]
    return states


def noise_leaves(recording):
    """chi2 that noise leaves of a recording, exceeded once in 1/UNLIKELY."""
    return special.chdtri(recording.freedom, UNLIKELY)


def around(state, unknown, columns, draws):
    """Initial states (draws, 13) around one, moved along what its columns (n, unknowns) tell by draws (draws, 12), in standard
    errors."""
    _, size, axes = np.linalg.svd(columns, full_matrices=False)
    errors = 1 / np.maximum(size, max(FAINT * size[0], 1e-300))
    moves = (draws[:, : len(size)] * errors) @ axes
    return np.array([stepped(state, unknown, move) for move in moves])


def chi2_over(problem, model, states, owner, stretches=WHOLE):
    """chi2 of runs over the stretch of their recordings, (runs,); inf where a run fails."""
    with np.errstate(all="ignore"):
        trajectories = problem.simulator.simulate(model, states, owner)
        white = [
            whiten(problem.recordings[k].whitening, residual)[stretches.get(k, slice(None))]
            for k, residual in zip(owner, problem.residuals_of(owner, trajectories), strict=True)
        ]
    return chi2_of(white)


def improve(problem, model, states, stretches, active):
    """Move the states of the active recordings, in place, by the best of the damped steps; those that are still on their way."""
    linear = problem.linearise(model, states, only=active)
    tried, before, owner = [], [], np.repeat(active, len(DAMPINGS))
    for k, r, n in zip(active, linear.white, linear.state_columns, strict=True):
        seen = stretches.get(k, slice(None))
        r, n = r[seen], n[seen]
        before.append(float(r @ r))
        size = np.linalg.norm(n, axis=0)
        size = np.where(size > 0, size, 1.0)
        for damping in DAMPINGS:
            rows = np.concatenate([n / size, np.sqrt(damping) * np.eye(n.shape[1])])
            move = least_squares(rows, np.concatenate([r, np.zeros(n.shape[1])])).estimate / size
            tried.append(stepped(states[k], problem.recordings[k].unknown, move))
    chi2 = chi2_over(problem, model, np.array(tried), owner, stretches).reshape(-1, len(DAMPINGS))
    least, before = chi2.min(axis=1), np.array(before)
    taken = np.array(tried).reshape(*chi2.shape, -1)[np.arange(len(active)), chi2.argmin(axis=1)]
    better = least < before
    states[active[better]] = taken[better]
    return active[better & (least < GAIN * before - CLOSE_IN_CONTACT)]
