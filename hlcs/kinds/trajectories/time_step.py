"""The error of the time step: how large it is in the prediction of a fit, and taken out of it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from hlcs.estimation.fitting import measured_errors
from hlcs.estimation.least_squares import least_squares
from hlcs.estimation.multiple_shooting import ROUNDS, improve_for, refit_initial_states
from hlcs.estimation.segment_profiles import profiled
from hlcs.estimation.segments import carried, split_lost
from hlcs.kinds.trajectories.observations import judge, recording_scale
from hlcs.simulation.simulator import Motion
from minibullet import rotations
from minibullet.errors import InputError

FINEST = 1 / 2000  # no step is halved below this [s]
SHORTER = (1 / 2, 1 / 4, 1 / 8)  # of the step of the search: from them the error of it is found
CORRECTIONS = 2  # of a fit by its error: the second looks whether the first still holds where it has led
SURE = 0.5  # part of a correction that halving the shortest step may move it by: else no step is the true one
ROUGH = 0.1  # RMS by which a correction may be wrong [sigma]: chi2 rises by 1 %
NEAR = 3.0  # RMS by which a shorter step leads a tumbling body [sigma]: one that is led farther goes another way
LITTLE = 0.02  # error of the step, part of the RMS that a fit leaves, below which it decides nothing: chi2 changes by 4 % at most
STILL = 0.02  # RMS by which a finer step may move the prediction through contacts [sigma]
MOVED = 0.1  # standard errors by which the error of the step may move a number that is told, at most


def refine(problem, fit):
    """Take the error of the time step out of the prediction; (fit, by how much halving the step still moves it [sigma]).

    In flight the step is halved until that moves no number by more than a tenth of its standard error, whatever the number is:
    until it moves all predictions together by so many sigma at most. With contacts, where that costs too much, what shorter steps
    would change at the fit is added to the predictions of all fits in its neighbourhood (defect correction: H. J. Stetter, Numer.
    Math. 29 (1978) 425), until fit and correction agree.
    """
    simulator = problem.simulator
    if simulator.contact:
        return corrected(problem, fit)
    while True:
        shift = in_sigma(changed_by_half(problem, fit), problem.recordings)
        if shift * np.sqrt(fit.count) < MOVED or simulator.time_step / 2 < FINEST:
            return fit, shift
        simulator.time_step /= 2
        fit = problem.fit(fit.model, fit.initial_states)


def corrected(problem, fit, final=False):
    """What `refine` gives of a fit through contacts; the Problem keeps the correction of its predictions, the Fit what is left.

    final: are its numbers told? They show less than predictions do: of many readings each may be off by little, and all alike.
    """
    simulator, owner = problem.simulator, np.arange(len(problem.trials))

    def noticed(change):
        seen = in_sigma(change, problem.recordings) > STILL
        return seen or final and np.any(np.abs(fit.moved_by(problem.whitened(change))) > MOVED * np.sqrt(np.diag(fit.covariance)))

    for _ in range(CORRECTIONS):
        runs = {1: fit.linearization.trajectories}
        for share in SHORTER:
            runs[share] = simulator.simulate(fit.model, fit.initial_states, owner, time_step=simulator.time_step * share)
            if problem.step_change is None and share == SHORTER[0]:
                half = problem.changes(runs[1], runs[share])
                if not noticed(half):
                    return _left(problem, fit, _first_order(problem, half)), 0.0
        runs = settling(problem, runs)
        best, unsure = finest(problem, runs)
        change = problem.changes(runs[1], best)
        known = problem.step_change or [0.0 * part for part in change]
        beyond = [new - old for new, old in zip(change, known, strict=True)]
        moved, rest = in_sigma(beyond, problem.recordings), in_sigma(unsure, problem.recordings)
        left = unsure if problem.step_change and rest < moved else beyond
        if not (noticed(beyond) and rest < SURE * moved):
            break
        problem.step_change, left = change, unsure
        former, fit = fit, problem.fit(fit.model, fit.initial_states)
        if len(fit.estimate) and np.all(np.abs(fit.estimate - former.estimate) < 0.1 * np.sqrt(np.diag(fit.covariance))):
            break
    return _left(problem, fit, left), in_sigma(left, problem.recordings)


def _left(problem, fit, change):
    """The Fit with what such an error of its predictions, list of (n_i,), does to its numbers."""
    return replace(fit, step_error=fit.moved_by(problem.whitened(change)))


def _first_order(problem, half):
    """What the error of the step still is in the predictions where halving it changes them by so much, lists of (n_i,)."""
    known = problem.step_change or [0.0 * part for part in half]
    return [2 * part - taken for part, taken in zip(half, known, strict=True)]


def each_in_its_steps(problem, fit):
    """A fit of segments, each in the step that it needs: halved until what halving it once more shows is left of its error, twice
    what that moves, leads it no other way."""
    simulator, states, asked = problem.simulator, fit.initial_states.copy(), np.arange(len(problem.trials))
    while len(asked):
        coarse, fine = (simulator.simulate(fit.model, states[asked], asked, simulator.time_step * share) for share in (1, 0.5))
        changes = [a - b for a, b in zip(*(problem.residuals_of(asked, runs) for runs in (coarse, fine)), strict=True)]
        left = [2 * in_sigma([change], [problem.recordings[k]]) for k, change in zip(asked, changes, strict=True)]
        shorter = simulator.time_step / 2.0 ** (simulator.halvings[asked] + 1) >= FINEST
        asked = asked[shorter & (np.array(left) > NEAR)]
        simulator.halvings[asked] += 1
        improve_for(ROUNDS, problem, fit.model, states, asked)
    return refit_initial_states(problem, problem.fit(fit.model, states)) if simulator.halvings.any() else fit


def in_shorter_steps(problem, fit):
    """A fit through contacts in the step that it needs: it is halved until what the correction leaves of its error is small."""
    fit, left = corrected(problem, fit, final=True)
    while left > ROUGH and problem.simulator.time_step / 2 >= FINEST:
        problem.simulator.time_step /= 2
        problem.step_change = None
        fit, left = corrected(problem, problem.fit(fit.model, fit.initial_states), final=True)
    return fit


def settling(problem, runs):
    """The runs {share of the step: trajectories}, those of a recording that does not come to rest with shorter steps replaced by
    that of the longest: a body that goes another way there, at an edge or from one impact to the next, has no true step."""
    steps = [1, *SHORTER]
    moved = []
    for coarse, fine in pairwise(steps):
        changes = problem.changes(runs[coarse], runs[fine])
        moved.append([in_sigma([part], [recording]) for part, recording in zip(changes, problem.recordings, strict=True)])
    rests = np.all(np.array(moved[1:]) <= np.maximum(moved[:-1], STILL), axis=0)
    if problem.segmented:  # a correction as large as that belongs to the path of this fit, not to those near it
        rests &= np.sum(moved, axis=0) < NEAR
    return {
        share: [run if rest else first for run, first, rest in zip(runs[share], runs[1], rests, strict=True)] for share in steps
    }


def finest(problem, runs):
    """(the best prediction from runs {share of the step: trajectories}, by what halving the step still moves it, list of (n_i,)):
    those of the shortest step, or extrapolated to none where that moves less."""
    a, b, c = (runs[share] for share in SHORTER)
    options = ((c, problem.changes(b, c)), (richardson(b, c), problem.changes(richardson(a, b), richardson(b, c))))
    return min(options, key=lambda option: in_sigma(option[1], problem.recordings))


def richardson(coarse, fine):
    """Trajectories at a step and at half of it -> at a step of zero.

    Richardson's extrapolation of an error of first order, Phil. Trans. R. Soc. A 210 (1911) 307.
    """
    return [
        Motion(
            2 * near.position - far.position,
            rotations.product(rotations.product(near.orientation, rotations.conjugate(far.orientation)), near.orientation),
            None if near.specific_force is None else 2 * near.specific_force - far.specific_force,
        )
        for far, near in zip(coarse, fine, strict=True)
    ]


def polished(problem, fit):
    """A final fit through contacts, the error of the time step at its own numbers taken out: that of the model under test may
    be another, since what was found may bring motion that this step spoils. Numbers of segments are profiled; intervals of others
    measured, where the model is adequate: of a wrong one they tell nothing."""
    if not problem.contact or not fit.model.terms:
        return fit
    if problem.segmented:
        return profiled(problem, fit)

    def better():
        final = in_shorter_steps(problem, fit)
        return measured_errors(problem, final) if judge(problem, final)[0].adequate else final

    return _aside(problem, fit, better)


def polisher(problem, best, on_all):
    """Function fit -> (Problem, final fit) on all rows, with the Problem as the best fit needs it (of segments see `split_lost`);
    on_all: (problem, fit) -> the same on all rows."""
    finer = split_lost(problem, best) if problem.segmented else problem

    def final(fit):
        judged, fit = on_all(finer, fit if finer is problem else carried(finer, problem, fit))
        return judged, polished(judged, fit)

    return final


def alone(problem, fit):
    """A fit through contacts with the error of the time step at its own numbers taken out, in place of that of the set that the
    search went to: what a step does to one law may be no error of another (a friction that goes with the load knows none in the
    first step). Not where it is LITTLE beside what the fit leaves."""
    if problem.step_change is None or problem.segmented:
        return fit
    if in_sigma(problem.step_change, problem.recordings) < LITTLE * np.sqrt(fit.chi2_per_freedom):
        return fit
    return _aside(problem, fit, lambda: corrected(problem, fit)[0])


def with_step_error(problem, fit):
    """A fit through contacts that is told beside the final one, with what the step does to its numbers as one run in half of it
    shows, of the recordings whose body does not go another way there."""
    if not problem.contact or not fit.model.terms or problem.segmented:
        return fit
    try:
        left = _first_order(problem, changed_by_half(problem, fit))
    except InputError:
        return fit
    near = [in_sigma([part], [recording]) < NEAR for part, recording in zip(left, problem.recordings, strict=True)]
    return _left(problem, fit, [np.where(stays, part, 0.0) for part, stays in zip(left, near, strict=True)])


def _aside(problem, fit, better):
    """The fit that better() gives, and the Problem with the step and the correction that it had before."""
    known = problem.simulator.time_step, problem.step_change
    try:
        return better()
    except InputError:
        return fit  # what a shorter step cannot simulate loses no finished fit
    finally:
        problem.simulator.time_step, problem.step_change = known


def misfit_by_step(problem, fit):
    """chi2 that the error of the time step leaves in a fit of flights, whose starts and numbers take the rest, as one run in half
    of the step shows; through contacts 0: there predictions are corrected for it."""
    if problem.contact:
        return 0.0
    try:
        white = problem.whitened(changed_by_half(problem, fit))
    except InputError:
        return 0.0  # what a shorter step cannot simulate no look would mend
    columns, change = map(np.concatenate, (fit.linearization.projected[1], fit.linearization.without_states(white)))
    return float(change @ change) - least_squares(columns, change).gain if np.isfinite(change).all() else 0.0


def changed_by_half(problem, fit):
    """What half a step changes in the predictions of a fit, list of (n_i,)."""
    simulator, owner = problem.simulator, np.arange(len(problem.trials))
    finer = simulator.simulate(fit.model, fit.initial_states, owner, time_step=simulator.time_step / 2)
    return problem.changes(fit.linearization.trajectories, finer)


def in_sigma(changes, recordings):
    """RMS of changes of the observations of recordings, list of (n_i,) [sigma]."""
    scaled = [part * recording_scale(recording) for part, recording in zip(changes, recordings, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(scaled) ** 2)))
