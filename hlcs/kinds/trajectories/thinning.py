"""Recordings of many rows thinned out for a search: what says the same again is left out, what happens fast is kept.

A search holds dozens of fits, each with the columns of every start and every number, so its memory and time go with the rows. The
likelihood of the rows that are kept is exact: the noise between them is what it is over the time between them. What the search
found is then fitted to all rows and judged on them, so that nothing is missed for being fast or faint.
"""

from dataclasses import replace

import numpy as np

from hlcs.data.impacts import read_impacts
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.kinds.trajectories.preparation import without_isolated
from hlcs.kinds.trajectories.time_step import corrected

MOST_SEARCHED = 10_000  # rows of all recordings: a search then takes some 1 GB and minutes
BEGINNING = 12  # samples from which a start is read
AROUND = 6  # samples on each side of an impact: from as many it is read, and one more


def thinned(measurement, noise):
    """The Recordings with about MOST_SEARCHED rows at most, and a note that says so; itself where it has no more.

    Every k-th sample is kept, of all recordings alike, so that they count as much as before beside each other; the first
    BEGINNING samples, and AROUND samples on each side of an impact that the samples show, stay as they are.
    """
    trials = measurement.trials
    total = sum(len(trial.times) for trial in trials)
    every = -(-total // MOST_SEARCHED)
    if every == 1:
        return measurement
    seen = sorted(read_impacts(measurement, noise), key=lambda impact: -impact.speed)
    impacts = {}
    for impact in seen[: MOST_SEARCHED // (2 * AROUND)]:  # the slowest of very many tell no more than other samples do
        impacts.setdefault(impact.trial, []).append(impact.time)
    thin = []
    for trial in trials:
        keep = np.arange(len(trial.times)) % every == 0
        keep[:BEGINNING] = keep[-1] = True
        for place in np.searchsorted(trial.times, impacts.get(trial.name, ())):
            keep[max(place - AROUND, 0) : place + AROUND] = True
        thin.append(trial.at(np.flatnonzero(keep)))
    kept, step = sum(len(trial.times) for trial in thin), every * noise.step
    note = (
        f"{total:,} rows: the search uses {kept:,} of them, every {every}th (one in {step:.3g} s) and all around the "
        f"{sum(map(len, impacts.values()))} fastest of {len(seen)} impacts seen, to tell candidates apart; noise, impacts, "
        "the numbers of what was found and the verdict are of all rows"
    )
    return replace(measurement, trials=tuple(thin), notes=(*measurement.notes, note))


def on_all_rows(measurement):
    """Function (problem, fit) of thinned recordings -> (problem, fit) of the same on all rows of the measurement.

    Recordings end, are split and are simulated in the steps as in the search; isolated samples are looked for among all rows.
    """
    whole = {}  # problem of a search -> its problem on all rows

    def on_all(problem, fit):
        simulator, first = problem.simulator, problem not in whole
        if first:
            trials = [_filled(trial, measurement.trials) for trial in problem.trials]
            of_all = simulator.for_trials(fit.model, trials, *simulator.of_trials)
            whole[problem] = TrajectoryProblem(trials, problem.noise, of_all)
        full = whole[problem]
        full.overdispersion = problem.overdispersion
        fit = full.fit(fit.model, fit.initial_states)
        if first:
            fit, _ = without_isolated(full, fit)
            fit = corrected(full, fit)[0] if simulator.contact else fit
        return full, fit

    return on_all


def _filled(trial, trials):
    """A thinned recording, or a segment of one, with all rows between its first and its last."""
    (source,) = (read for read in trials if read.name == trial.whole)
    begin, end = np.searchsorted(source.times, trial.times[[0, -1]])
    return source.at(
        slice(begin, end + 1), name=trial.name, start=trial.start, recording=trial.recording, first_row=trial.first_row
    )
