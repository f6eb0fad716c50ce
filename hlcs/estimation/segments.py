"""Recordings with contacts in segments with an initial state of their own, where small changes grow from impact to impact.

After a few impacts of a tumbling body the motion hangs on digits of its initial state that nobody measured: no fit of one state
follows it. Each segment is short enough for its state to be fitted (multiple shooting, Bock and Plitt, IFAC Proc. 17 (1984)
1603), and the states are projected out like any other: what segments no longer say is how one of them leads to the next.
"""

from typing import NamedTuple

import numpy as np

from hlcs.data.rigid_body import rigid_body, support
from hlcs.estimation.fitting import chi2_of
from hlcs.estimation.multiple_shooting import chi2_over, grown_states, noise_leaves, regrown
from hlcs.estimation.trajectory_problem import TrajectoryProblem, flat
from hlcs.simulation.initial_state import UNSEEN, shifted
from minibullet import rotations

GROWTH = 8.0  # times by which a change of the initial state may grow over a recording before any of them is split
CALM = 4.0  # the same over a segment; one impact gives two to four
NOISES = 3.0  # change of an initial state that is followed [sigma]
SHORTEST = 12  # samples of a segment: fewer do not tell its initial state and anything besides
SHORT = 6  # the same of one that no initial state follows beside the best model: it is to tell nothing, and to mislead none
FEW = 0.2  # part of the segments that may be such: where more are, the model lacks a law
LOST = 2.0  # chi2 per degree of freedom of a segment that is halved again: noise of 72 readings leaves it once in a million
SPLITS = 4  # times that a segment may be: a sixteenth of one is shorter than SHORTEST
LAST = 9  # samples at the end that tell where a body rests
ASTIR = 6.0  # standard deviations off that place at which it still moves
REST = 1.0  # of a body that has come to rest this much is kept [s]


class Segment(NamedTuple):
    """A recording or a part of one, and how it starts."""

    trial: object  # a Trial
    start_time: float  # [s]
    seated: bool  # does it start on its floor?
    halvings: int  # of the time step

    def halved(self, noise, shortest=SHORTEST):
        """The two Segments of its halves, of so many samples at least."""
        first, second = halves(self.trial, shortest)
        later = Segment(second, second.times[0], _seated(second, noise), self.halvings)
        return [self._replace(trial=first), later]


def segments_of(problem):
    """The recordings of a problem, list of Segment."""
    return [Segment(*each) for each in zip(problem.trials, *problem.simulator.of_trials, strict=True)]


def _problem(problem, model, segments):
    """A TrajectoryProblem of segments with the noise of another."""
    trials, *others = (list(column) for column in zip(*segments, strict=True))
    return TrajectoryProblem(trials, problem.noise, problem.simulator.for_trials(model, trials, *others))


def split_into_segments(problem, model):
    """(Problem whose trials are segments, sentences): where small changes grow, trials are halved until they do not.

    A problem without any such trial, and without a long rest at an end, comes back as it is.
    """
    if any(trial.unplaced for trial in problem.trials):
        return problem, []  # nothing tells where a part of such a recording begins
    work, notes, done = [], [], []
    for segment in segments_of(problem):
        moving, sentences = without_rest(segment.trial, problem.noise)
        work.append(segment._replace(trial=moving))
        notes += sentences
    short = _problem(problem, model, work) if notes else problem  # what is left out need not be simulated
    grown = growth(short, model)
    if grown.max() <= GROWTH:
        return short, notes
    while work:
        following = []
        for segment, much in zip(work, grown, strict=True):
            trial = segment.trial
            if much <= CALM and trial.times[-1] - trial.times[0] <= longest(trial) or len(trial.times) < 2 * SHORTEST:
                done.append(segment)
            else:
                following += segment.halved(problem.noise)
        work = following
        if work:
            grown = growth(_problem(problem, model, work), model)
    order = {trial.name: place for place, trial in enumerate(problem.trials)}
    done.sort(key=lambda segment: (order[segment.trial.whole], segment.trial.first_row))
    return _problem(problem, model, done), notes


def segment_notes(problem):
    """Sentences on what has been split."""
    wholes = [trial.recording for trial in problem.trials if trial.recording]
    if not wholes:
        return []
    return [
        f"{len(set(wholes))} recordings are split into {len(wholes)} segments with an initial state of their own each: over a "
        f"whole recording a small change of it grows more than {GROWTH:.0f}-fold from impact to impact"
    ]


def lost_notes(problem, finer):
    """Sentences on the segments of a problem that `split_lost` has halved."""
    halved = len(finer.trials) - len(problem.trials)
    if not halved:
        return ()
    return (
        f"{halved} of {len(problem.trials)} segments are halved once more: no initial state follows them, as where two corners "
        "hit at once, which rigid bodies do not foresee",
    )


def split_further(problem, fit, likely):
    """(Problem, its fit): segments that no initial state follows are halved; the states of the others are kept.

    likely: models with what is read off the impacts directly. A segment that one of them follows is not lost, its model lacks
    something; one that none follows is in a wrong basin (the body tips over another edge), or did what no engine foresees.
    """
    freedom = np.array([recording.freedom for recording in problem.recordings])
    long = np.array([len(segment.trial.times) >= 2 * SHORTEST for segment in segments_of(problem)])
    lost = long & (fit.chi2_per_recording > LOST * freedom)
    for model in likely:
        which = np.flatnonzero(lost)
        if len(which):
            chi2 = chi2_over(problem, model, grown_states(problem, model, which)[which], which)
            lost[which] = chi2 > LOST * freedom[which]
    if not lost.any():
        return problem, fit
    finer = halved(problem, fit.model, lost)
    return finer, carried(finer, problem, fit, ~lost)


def split_lost(problem, best):
    """The Problem for final fits: the few segments that no initial state follows beside the best fit are halved, down to SHORT
    samples; the same where there are none.

    An impact at two corners at once has no one outcome that rigid bodies foresee, and asks for no law: with an initial state on
    either side of it nobody has to. Where many are lost the model lacks something, and nothing is halved.
    """
    lost = chi2_of(best.linearization.white) > [noise_leaves(recording) for recording in problem.recordings]
    long = np.array([len(trial.times) >= 2 * SHORT for trial in problem.trials])
    if np.sum(lost) > FEW * len(lost) or not (lost & long).any():
        return problem
    return halved(problem, best.model, lost & long, SHORT)


def halved(problem, model, which, shortest=SHORTEST):
    """A Problem with the segments `which`, (trials,) booleans, halved; shortest: as of `Segment.halved`."""
    segments, aside = [], []
    for segment, flags, halve in zip(segments_of(problem), problem.dropped, which, strict=True):
        parts = segment.halved(problem.noise, shortest) if halve else [segment]
        segments += parts
        aside += np.split(flags, [len(parts[0].trial.times)])[: len(parts)]
    finer = _problem(problem, model, segments)
    finer.leave_out(aside)
    return finer


def carried(finer, problem, fit, known=True):
    """A Fit of a problem on one that is split farther, its numbers as they are; known: of which segments its initial states are
    taken over where they begin alike, (trials,) booleans."""
    held = finer.fit(fit.model.held(), adopted(finer, problem, fit.initial_states, known))
    states = regrown(finer, held)
    return finer.fit_at(fit.model, states, fit.converged)


def adopted(problem, former, states, known=True):
    """Initial states (trials, 13) of a problem from those of one that was split less far: of segments that begin alike the same,
    of others guesses; known: of which they are taken, (trials,) booleans."""

    def beginning(trial):
        return trial.whole, trial.first_row

    of_former = zip(former.trials, states, np.broadcast_to(known, len(states)), strict=True)
    there = {beginning(trial): state for trial, state, its in of_former if its}
    return np.array(
        [there.get(beginning(trial), guess) for trial, guess in zip(problem.trials, problem.initial_guess(), strict=True)]
    )


def longest(trial):
    """Longest segment of a tumble [s]: some two impacts of a body that rocks on its floor."""
    return 3.0 * np.sqrt(rigid_body(trial.body).shape.bounding_radius / max(trial.surroundings.gravity, 0.1))


def _seated(trial, noise):
    """Does a segment start flat on its floor? A body on an edge or a corner tips: its initial state is free."""
    if noise.orientation is None:
        return False
    near = trial.seen_from_above or np.fmax.reduce(gaps(trial)[: SHORTEST // 2]) < noise.reaches(trial.surroundings.normal)
    return near and flat(trial, noise)


def gaps(trial):
    """Gap between body and floor at every sample (n,) [m], by the measured attitude or the bounding sphere; NaN = unknown, inf =
    there is no floor."""
    around, shape = trial.surroundings, rigid_body(trial.body).shape
    if around.floor_height is None:
        return np.full(len(trial.times), np.inf)
    normal = around.normal
    lift = around.above_floor(np.where(np.abs(normal) > UNSEEN, trial.position, 0.0))
    reach = np.array(
        [-support(shape, turn, normal).min() if np.isfinite(turn[0]) else shape.bounding_radius for turn in trial.orientation]
    )
    return lift - reach


def halves(trial, shortest=SHORTEST):
    """The two parts of a recording, of so many samples at least, split in its middle third where the body is farthest from its
    floor."""
    count = len(trial.times)
    inside = np.arange(max(count // 3, shortest), min(count - count // 3, count - shortest) + 1)
    height = np.nan_to_num(gaps(trial)[inside], nan=-np.inf, posinf=0.0)
    middle = int(inside[np.argmax(height - 1e-9 * np.abs(inside - count / 2))])
    return part_of(trial, 0, middle), part_of(trial, middle, count)


def part_of(trial, begin, end):
    """Samples begin .. end - 1 of a recording as a Trial of its own; only the first knows the stated start."""
    whole = trial.whole
    name = f"{whole} from {trial.times[begin]:.3g} s" if trial.first_row + begin else whole
    start = {} if begin else trial.start
    return trial.at(slice(begin, end), name=name, start=start, recording=whole, first_row=trial.first_row + begin)


def without_rest(trial, noise):
    """(recording without the tail at rest beyond REST, sentences saying so)."""
    sigma = noise.of_axes
    if sigma is None or not np.isfinite(trial.position).any():
        return trial, []
    far = np.zeros(len(trial.times))
    for values, size in ((trial.position, sigma), (_turns(trial), noise.orientation)):
        if size is not None:
            seen = [column[np.isfinite(column)] for column in values.T]
            last = [np.median(column[-LAST:]) if len(column) else np.nan for column in seen]
            far = np.maximum(far, np.nan_to_num(np.abs(values - last) / size).max(axis=1))
    moving = np.flatnonzero(far > ASTIR)
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
    """By how much a small change of its initial state has grown at most over each trial, (trials,) [-]; in flight 1 to 2.

    The change is a few noises large, in each unknown of the state, one after the other; lengths are compared with turns through
    the bounding radius.
    """
    states, noise = problem.initial_guess(), problem.noise
    perturbed, owner, sizes = [], [], []
    for k, (trial, recording) in enumerate(zip(problem.trials, problem.recordings, strict=True)):
        radius, span = rigid_body(trial.body).shape.bounding_radius, trial.times[-1] - trial.times[0]
        sizes.append(NOISES * min([noise.position or np.inf, (noise.orientation or np.inf) * radius]))
        units = (1.0, 1 / span, 1 / radius, 1 / (radius * span))
        perturbed += [states[k], *(shifted(states[k], unknown, sizes[k] * units[unknown[0]]) for unknown in recording.unknown)]
        owner += [k] * (1 + len(recording.unknown))
    owner = np.array(owner)
    with np.errstate(all="ignore"):
        trajectories = problem.simulator.simulate(model, np.array(perturbed), owner)
    largest = np.zeros(len(problem.trials))
    for k, trial in enumerate(problem.trials):
        first, *others = np.flatnonzero(owner == k)
        for b in others:
            apart = np.nan_to_num(distance(trial.body, trajectories[first], trajectories[b]).max(), nan=np.inf)
            largest[k] = max(largest[k], float(apart) / sizes[k])
    return largest


def distance(body, trajectory, other):
    """Distance of two trajectories, each a Motion, of a body at every sample (n,) [m]; turns count too."""
    apart = np.linalg.norm(other[0] - trajectory[0], axis=1)
    if body.shape == "sphere":
        return apart
    turned = rotations.logarithm(rotations.product(other[1], rotations.conjugate(trajectory[1])))
    return np.maximum(apart, rigid_body(body).shape.bounding_radius * np.linalg.norm(turned, axis=1))
