"""Contact recordings cut into pieces with a start of their own, where a small change of the start grows from blow to blow.

After a few blows of a tumbling body the motion hangs on digits of its start that nobody measured: no fit of one start
follows it. Each piece is short enough for its start to be fitted (multiple shooting, Bock and Plitt, IFAC Proc. 17 (1984)
1603), and the starts are projected out like any other: what pieces no longer say is how one of them leads to the next.
"""

import numpy as np

from hlcs.data.rigid_body import solid
from hlcs.estimation.effort import cut
from hlcs.estimation.least_squares import Problem
from hlcs.estimation.multiple_shooting import shot_again
from hlcs.simulation.contact_motion import lies_on_a_face, support
from hlcs.simulation.initial_state import shifted
from hlcs.simulation.simulator import Shots
from minibullet import rotations

GROWTH = 8.0  # times by which a change of the start may grow over a recording before any of them is cut
CALM = 4.0  # the same over a piece; one blow gives two to four
NOISES = 3.0  # change of a start that is followed [sigma]
SHORTEST = 12  # samples of a piece: fewer do not tell its start and anything besides
LOST = 30.0  # chi2 per degree of freedom of a piece that is halved again
REST = 1.0  # of a body that has come to rest this much is kept [s]


def pieces(problem, model):
    """(Problem whose trials are pieces, sentences): where small changes grow, trials are halved until they do not.

    A problem without any such trial, and without a long rest at an end, comes back as it is.
    """
    shots, work, notes, done = problem.shots, [], [], []
    for trial, start_time, on_floor in zip(problem.trials, shots.start_time, shots.seated, strict=True):
        short, sentences = awake(trial, problem.noise)
        work.append((short, start_time, on_floor))
        notes += sentences
    short = _problem(problem, model, work) if notes else problem  # what is left out need not be simulated
    grown = growth(short, model)
    if grown.max() <= GROWTH:
        return short, notes
    while work:
        following = []
        for entry, much in zip(work, grown, strict=True):
            trial, start_time, on_floor = entry
            if much <= CALM and trial.times[-1] - trial.times[0] <= longest(trial) or len(trial.times) < 2 * SHORTEST:
                done.append(entry)
            else:
                first, second = halves(trial)
                following += [(first, start_time, on_floor), (second, second.times[0], _seated(second, problem.noise))]
        work = following
        if work:
            grown = growth(_problem(problem, model, work), model)
    order = {trial.name: place for place, trial in enumerate(problem.trials)}
    done.sort(key=lambda entry: (order[entry[0].recording or entry[0].name], entry[0].first_row))
    return _problem(problem, model, done), notes


def said(problem):
    """Sentences on what has been cut."""
    parts = [trial.recording for trial in problem.trials if trial.recording]
    if not parts:
        return []
    return [
        f"{len(set(parts))} recordings are cut into {len(parts)} pieces with a start of their own each: over a whole "
        f"recording a small change of the start grows more than {GROWTH:.0f}-fold from blow to blow"
    ]


def cut_again(problem, fit):
    """(Problem, its fit): pieces that no start follows are halved; the starts of the others are kept.

    A start in a wrong basin (the body tips over another edge) misses by far more than a missing effect does.
    """
    shots = problem.shots
    freedom = np.array(
        [max(len(r) - len(recording.unknown), 1) for r, recording in zip(fit.linear.r, problem.recordings, strict=True)]
    )
    entries, kept, changed = [], [], False
    for trial, start_time, on_floor, start, lost in zip(
        problem.trials, shots.start_time, shots.seated, fit.starts, fit.losses / freedom > LOST, strict=True
    ):
        if lost and cut(problem) and len(trial.times) >= 2 * SHORTEST:
            first, second = halves(trial)
            entries += [(first, start_time, on_floor), (second, second.times[0], _seated(second, problem.noise))]
            kept += [None, None]
            changed = True
        else:
            entries.append((trial, start_time, on_floor))
            kept.append(start)
    if not changed:
        return problem, fit
    finer = _problem(problem, fit.model, entries)
    starts = np.array([guess if start is None else start for guess, start in zip(finer.guess(), kept, strict=True)])
    return finer, shot_again(finer, finer.fit(fit.model, starts))


def _problem(problem, model, entries):
    """A Problem of [(trial, start time, starts on its floor)] with the noise of another."""
    trials, times, seated = (list(column) for column in zip(*entries, strict=True))
    old = problem.shots
    return Problem(trials, problem.noise, Shots(model, trials, times, old.contact, old.step, seated))


def longest(trial):
    """Longest piece of a tumble [s]: some two blows of a body that rocks on its floor."""
    return 3.0 * np.sqrt(solid(trial.body).shape.bounding_radius / max(trial.surroundings.gravity, 0.1))


def _seated(piece, noise):
    """Does a piece start flat on its floor? A body on an edge or a corner tips: its start is free."""
    return (
        noise.orientation is not None
        and gaps(piece)[: SHORTEST // 2].max() < 4 * (noise.position or 0.0)
        and lies_on_a_face(piece.body, piece.surroundings.floor_normal, piece.orientation, noise.orientation)
    )


def gaps(trial):
    """Gap between body and floor at every sample (n,) [m], by the measured attitude or the bounding sphere; NaN = unknown."""
    around, shape = trial.surroundings, solid(trial.body).shape
    normal = np.asarray(around.floor_normal)
    lift = np.where(np.abs(normal) > 1e-9, trial.position, 0.0) @ normal - around.floor_height
    reach = np.array(
        [-support(shape, turn, normal).min() if np.isfinite(turn[0]) else shape.bounding_radius for turn in trial.orientation]
    )
    return lift - reach


def halves(trial):
    """The two parts of a recording, cut in its middle third where the body is farthest from its floor."""
    count = len(trial.times)
    inside = np.arange(max(count // 3, SHORTEST), min(count - count // 3, count - SHORTEST) + 1)
    height = np.nan_to_num(gaps(trial)[inside], nan=-np.inf)
    cut = int(inside[np.argmax(height - 1e-9 * np.abs(inside - count / 2))])
    return part(trial, 0, cut), part(trial, cut, count)


def part(trial, begin, end):
    """Samples begin .. end - 1 of a recording as a Trial of its own; only the first knows the stated start."""
    whole = trial.recording or trial.name
    name = f"{whole} from {trial.times[begin]:.3g} s" if trial.first_row + begin else whole
    start = {} if begin else trial.start
    return trial.at(slice(begin, end), name=name, start=start, recording=whole, first_row=trial.first_row + begin)


def awake(trial, noise):
    """(recording without the tail at rest beyond REST, sentences saying so)."""
    sigma = noise.position
    if sigma is None or not np.isfinite(trial.position).any():
        return trial, []
    far = np.zeros(len(trial.times))
    for values, size in ((trial.position, sigma), (_turns(trial), noise.orientation)):
        if size is not None:
            last = np.array(
                [np.median(column[np.isfinite(column)][-9:]) if np.isfinite(column).any() else np.nan for column in values.T]
            )
            far = np.fmax(far, np.nanmax(np.nan_to_num(np.abs(values - last) / size), axis=1))
    moving = np.flatnonzero(far > 6.0)
    still = trial.times[moving[-1]] if len(moving) else trial.times[0]
    end = int(np.searchsorted(trial.times, still + REST)) + 1
    if len(trial.times) - end < SHORTEST or end < 2 * SHORTEST:
        return trial, []
    left = trial.times[-1] - trial.times[end - 1]
    return trial.at(slice(end)), [
        f"{trial.name}: at rest from t_s = {still:.3g} on; the last {left:.3g} s are left out, they say nothing more"
    ]


def _turns(trial):
    """Rotation of every sample from the last one (n, 3) [rad]."""
    there = np.flatnonzero(np.isfinite(trial.orientation[:, 0]))
    if len(there) == 0:
        return np.full((len(trial.times), 3), np.nan)
    return rotations.logarithm(rotations.product(trial.orientation, rotations.conjugate(trial.orientation[there[-1]])))


def growth(problem, model):
    """By how much a small change of its start has grown at most over each trial, (trials,) [-]; in flight 1 to 2.

    The change is a few noises large, in each number of the start that is not known, one after the other; lengths are compared
    with turns through the bounding radius.
    """
    starts, noise = problem.guess(), problem.noise
    rows, owner, sizes = [], [], []
    for k, (trial, recording) in enumerate(zip(problem.trials, problem.recordings, strict=True)):
        radius, span = solid(trial.body).shape.bounding_radius, trial.times[-1] - trial.times[0]
        sizes.append(NOISES * min([noise.position or np.inf, (noise.orientation or np.inf) * radius]))
        units = (1.0, 1 / span, 1 / radius, 1 / (radius * span))
        rows += [starts[k], *(shifted(starts[k], unknown, sizes[k] * units[unknown[0]]) for unknown in recording.unknown)]
        owner += [k] * (1 + len(recording.unknown))
    owner = np.array(owner)
    with np.errstate(all="ignore"):
        answers = problem.shots.simulate(model, np.array(rows), owner)
    found = np.zeros(len(problem.trials))
    for k, trial in enumerate(problem.trials):
        radius, mine = solid(trial.body).shape.bounding_radius, np.flatnonzero(owner == k)
        x, q = answers[mine[0]]
        for y, turn in (answers[b] for b in mine[1:]):
            apart = np.linalg.norm(y - x, axis=1)
            if trial.body.shape != "sphere":
                turned = rotations.logarithm(rotations.product(turn, rotations.conjugate(q)))
                apart = np.maximum(apart, radius * np.linalg.norm(turned, axis=1))
            found[k] = max(found[k], float(np.nan_to_num(apart.max(), nan=np.inf)) / sizes[k])
    return found
