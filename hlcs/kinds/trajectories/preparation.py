"""From the recordings of an experiment file to a fitted model: the problem set up, the noise known, odd samples set aside."""

import warnings
from dataclasses import replace

import numpy as np

from hlcs.data.combinations import fluids_told
from hlcs.data.quantities import CHANNELS, unit_of
from hlcs.data.recordings import Recordings
from hlcs.data.rigid_body import SIDES, rigid_body
from hlcs.estimation.multiple_shooting import refit_initial_states
from hlcs.estimation.noise_model import estimate_noise
from hlcs.estimation.outliers import isolated_in, spread_of
from hlcs.estimation.segments import SPLITS, segment_notes, split_further, split_into_segments, without_rest
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.kinds.protocol import Prepared
from hlcs.kinds.trajectories.release import release_notes
from hlcs.kinds.trajectories.time_step import STILL, corrected, each_in_its_steps, in_sigma, refine
from hlcs.simulation.contact_motion import gap
from hlcs.simulation.initial_state import UNSEEN
from hlcs.simulation.model import Model
from hlcs.simulation.simulator import Simulator
from minibullet import rotations
from minibullet.errors import InputError, InputWarning

SMALL = 0.1  # RMS of an error of the time step that no verdict notices [sigma]
LONG = 5000  # steps of a run through contacts (0.5 s) beyond which longer steps are tried first
LONGEST = 1 / 15  # step of such a run [s]: in a longer one a model of some centimetres falls by its own size
RUNS = 25  # runs that the fit of one model takes, its starts unknown: what a comparison is told to cost
A_STEP = 1e-4  # what a step of such runs costs [s]
ALONE_AGAIN = 3  # looks for samples that stand alone: what is set aside or taken back moves a fit, and shows or hides others
UNEVEN = 0.02  # part of its radius by which a body may be another than stated, and a floor uneven
NOTHING = None, None, 0.0, (), ()  # what `fitted` gives, where nothing could be fitted


def start_times(trials):
    """The moment each stated or fitted start belongs to, (trials,) [s].

    Time zero of the recording where something of the start is stated and the first sample follows within ten steps
    (dropped first frames); otherwise the first sample.
    """
    starts = []
    for trial in trials:
        first, step = trial.times[0], float(np.median(np.diff(trial.times)))
        at_zero = bool(trial.start) and 0 <= first <= 10 * step
        starts.append(0.0 if at_zero else first)
    return np.array(starts)


def touches(trials, noise):
    """Does any body come near its floor in these data?"""
    for trial in trials:
        if trial.surroundings.floor_height is None:
            continue
        if trial.seen_from_above or trial.unplaced:  # it may reach its floor, and no height tells that it does not
            return True
        shape = rigid_body(trial.body).shape
        there = above_floor(trial)
        if not len(there):  # where it is above its floor is not seen: only the stated start can tell
            if "position" in trial.start and starts_seated(trial, noise):
                return True
            continue
        position = np.nan_to_num(trial.position[there])
        gap = trial.surroundings.above_floor(position) - shape.bounding_radius
        reach = near_floor(noise, trial.surroundings.normal, shape.bounding_radius)
        if gap.min() < reach or rebounds(trial.times[there], gap, reach):
            return True
    return False


def near_floor(noise, normal, radius):
    """How far from its floor a body of this radius may be seen while it touches it [m]."""
    return noise.reaches(normal) + UNEVEN * radius


def above_floor(trial):
    """Samples (indices) that tell how far above its floor a body is: seen along all axes that its normal has a part along; where
    there is none, the heights."""
    seen = np.isfinite(trial.position)
    there = np.flatnonzero(seen[:, np.abs(trial.surroundings.floor_normal) > UNSEEN].all(axis=1))
    return there if len(there) else np.flatnonzero(seen[:, 2])


def rebounds(times, gap, reach):
    """Was a floor struck between two samples? The line through two of them meets it, and the body is next seen above that line.

    Gravity and drag leave a falling body below the line or far from the floor; slow cameras miss every impact of a drop.
    """
    if len(gap) < 3:
        return False
    step = np.diff(times)
    ahead = gap[1:-1] + np.diff(gap)[:-1] * step[1:] / step[:-1]
    return bool(np.any((ahead < reach) & (gap[2:] > ahead + 2.5 * reach)))  # the error of the line is 2.4 times a sample's


def starts_seated(trial, noise):
    """Does the body lie on its floor at the start? By the stated position, else by the first six samples' gap within their
    noise: one that a tracker lost says nothing, nor does a first one from where no body that is let go, or has the stated
    velocity, falls to its floor before the next."""
    if trial.surroundings.floor_height is None:
        return False
    if trial.seen_from_above:
        return True
    shape = rigid_body(trial.body).shape
    there = above_floor(trial)
    orientation = first_attitude(trial)
    orientation = np.array([1.0, 0.0, 0.0, 0.0]) if orientation is None else orientation
    if "position" in trial.start:
        lift = gap(shape, np.asarray(trial.start["position"]), orientation, trial.surroundings)
        return abs(lift) < 1e-3 * shape.bounding_radius + 1e-5
    if len(there) == 0:
        return False
    first = there[:6]
    lifts = np.array([gap(shape, position, orientation, trial.surroundings) for position in np.nan_to_num(trial.position[first])])
    tolerance = near_floor(noise, trial.surroundings.normal, shape.bounding_radius)
    off, within = np.abs(lifts) >= tolerance, np.diff(trial.times[first[:2]]).sum()
    down = max(-float(trial.surroundings.normal @ np.asarray(trial.start.get("velocity", np.zeros(3)))), 0.0)
    fell = off[0] and 0 < lifts[0] < tolerance + down * within + trial.surroundings.gravity * within**2 / 2
    return bool(not fell and np.sum(off) <= len(off) // 6)


def rolling_notes(trials, noise):
    """Sentences on discs and cylinders that begin on their round side: there they are prisms here, which rock where a round one
    rolls. Raises InputError where no attitude is known: such a body would be taken to stand."""
    notes = []
    for trial in trials:
        body, around, there = trial.body, trial.surroundings, above_floor(trial)[:6]
        if body.shape not in ("disc", "cylinder") or around.floor_height is None or not len(there):
            continue
        normal = around.normal
        height = around.above_floor(np.nan_to_num(trial.position[there]))
        tolerance = near_floor(noise, normal, body.radius)
        turn = first_attitude(trial)
        upright = abs(rotations.rotate((1.0, 0.0, 0.0, 0.0) if turn is None else turn, np.array([0.0, 0.0, 1.0])) @ normal)
        stands = abs(body.height / 2 - body.radius) < tolerance if turn is None else upright**2 > 0.5  # nearer to upright
        if stands or np.any(np.abs(height - body.radius) > tolerance):
            continue
        said = (
            f"{trial.name}: this {body.shape} begins {height[0]:.3g} m above its floor, its radius: on its round side, where it "
            f'is a prism of {SIDES} sides here, which rocks. State a ball that rolls alike under [body]: shape = "sphere", '
            f"radius = {body.radius:g}, inertia = [I, I, I], I = mass x radius^2 / 2 of a solid one, and no height"
        )
        if turn is None:
            raise InputError(f"{said}; where it stands, state start.orientation")
        notes.append(said)
    return notes[:1]


def first_attitude(trial):
    """The orientation (4,) that is stated of a start, else the first that is measured; None where there is neither."""
    stated, measured = trial.start.get("orientation"), np.flatnonzero(np.isfinite(trial.orientation[:, 0]))
    found = stated if stated is not None else trial.orientation[measured[0]] if len(measured) else None
    return None if found is None else np.asarray(found, dtype=float)


def prepare(measurement: Recordings, own=(), noise=None, likely=()):
    """Noise, problem and the fit of the model under test; noise: where it is known already; likely: [terms beside those of the
    model under test that impacts point to] (see `split_further`)."""
    noise = noise or estimate_noise(measurement)
    notes = list(measurement.notes) + list(noise.notes)
    trials = measurement.trials
    contact = touches(trials, noise)
    if not noise.known:
        return Prepared(noise, None, None, tuple(notes))
    notes += [*rolling_notes(trials, noise), *fluids_told(measurement.file, trials)]
    model = Model(fixed=measurement.file.effects, own=tuple(own), time_step=measurement.file.time_step)
    model.changes(trials[0].surroundings)  # a wrong name or number in [model] effects is the user's to mend, before any work
    notes += release_notes(trials, start_times(trials), [starts_seated(trial, noise) for trial in trials], noise)
    above = [trial.name for trial in trials if trial.seen_from_above and not trial.surroundings.planar]  # there it is stated
    if above:
        notes.append("no height is measured: taken to move on the floor: " + ", ".join(above[:4]) + (" .." if above[4:] else ""))
    problem, base, shift, sentences, aside = in_long_steps(measurement, noise, model) if contact else NOTHING
    if problem is None:
        problem, base, shift, sentences, aside = fitted(posed(measurement, noise, model, contact), model, likely)
    if not np.isfinite(base.chi2):
        raise InputError(
            f"{measurement.file.place('model.effects')}: with these the motion does not stay finite; check their numbers, the "
            "mass and size of the body, and its start"
        )
    if shift > SMALL:
        sentences = (*sentences, f"numerics: halving the time step still moves the prediction by {shift:.2g} sigma")
    return Prepared(noise, problem, base, (*notes, *sentences), tuple(aside))


def posed(measurement, noise, model, contact, step=None):
    """The Problem of all recordings as they are read; step: of the simulation [s], None = the model's."""
    trials = measurement.trials
    seated = [contact and starts_seated(trial, noise) for trial in trials]
    return TrajectoryProblem(trials, noise, Simulator(model, trials, start_times(trials), contact, step, seated))


def in_long_steps(measurement, noise, model):
    """What `fitted` gives of recordings with contacts that last long, in steps as long as LONG of them need, where the
    prediction stands still in these; NOTHING where it does not, or where no recording is so long.

    A body that rolls or slides for minutes moves smoothly, and no step of 1/240 s is needed to follow it. One that hits, tips or
    sticks on its way does not stand still in steps so long, and is computed in the model's own.
    """
    span = max(float(np.ptp(without_rest(trial, noise)[0].times)) for trial in measurement.trials)
    step = min(model.time_step * 2.0 ** np.ceil(np.log2(span / (LONG * model.time_step))), LONGEST)
    if step <= model.time_step:
        return NOTHING
    try:
        problem, base, shift, sentences, aside = fitted(posed(measurement, noise, model, True, step), model)
        near = problem.step_change is None or in_sigma(problem.step_change, problem.recordings) < SMALL  # holds nearby alone
        if shift < STILL and near and not problem.segmented:
            sentences.append(
                f"numerics: motion of {span:.3g} s is computed in steps of {step:.3g} s where the file says "
                f"{model.time_step:.3g} s: shorter ones move the prediction by {shift:.1g} sigma only"
            )
            return problem, base, shift, sentences, aside
    except InputError:
        pass  # what cannot be simulated in long steps may be in the model's own, or is told from there
    count = span / model.time_step
    warnings.warn(
        f"{measurement.file.path}: a motion of {span:.4g} s with contacts takes {count:.3g} steps, and cannot be "
        f"followed in longer ones: {RUNS} runs, for one fit, take {RUNS * count * A_STEP / 60:.2g} min, a search many "
        "times that; keep the seconds that matter of each recording",
        InputWarning,
        stacklevel=2,
    )
    return NOTHING


def fitted(problem, model, likely=()):
    """(Problem, its fit, by how much halving the step still moves it [sigma], sentences, those on samples set aside) of the model
    under test.

    The Problem is another where recordings were split into segments, rest at the end or isolated samples left out.
    """
    notes = []
    if problem.contact:
        problem, notes = split_into_segments(problem, model)
    base = problem.fit(model)
    if problem.segmented:
        base = each_in_its_steps(problem, refit_initial_states(problem, base))
        base, _ = without_isolated(problem, base)  # what has lost a sample is not lost itself
        models = [replace(model, terms=(*model.terms, *terms)) for terms in likely]
        for _ in range(SPLITS):
            before, (problem, base) = problem, split_further(problem, base, models)
            if problem is before:
                break
        notes += segment_notes(problem)
    base, aside = without_isolated(problem, base)
    base, shift = refine(problem, base)
    return problem, base, shift, notes, aside


def beside(prepared, better):
    """A Prepared with what the misfit of a worse model had hidden or spoilt found anew beside a better fit: samples that stand
    alone, none of those that stood alone beside the worse one kept aside, and the error of the time step; None where both stay as
    they were."""
    problem = prepared.problem
    known, aside = problem.step_change, problem.dropped
    flags, better = alone_beside(problem, better)
    same = all(map(np.array_equal, flags, aside))
    if same:
        problem.step_change = known
    before, step = problem.step_change, problem.simulator.time_step
    try:
        refine(problem, better)
    except InputError:
        problem.step_change, problem.simulator.time_step = before, step  # what shorter ones cannot simulate loses no fit
    if same and problem.step_change is known and problem.simulator.time_step == step:
        return None
    base = problem.fit(prepared.base.model, prepared.base.initial_states)
    effects = [term.name for term in better.model.terms]
    if same:
        return replace(prepared, base=base)
    here, there = (sum(int(np.sum(flag)) for flag in one) for one in (flags, aside))
    differs = (
        f"samples that stray are left out: {here} of them here, by what is left with {' and '.join(effects)}; `hlcs compare` of "
        f"the model as it is leaves out {there}, not the same ones, so its error differs a little"
    )
    return replace(prepared, base=base, aside=(*set_aside(problem.trials, flags, effects), *[differs] * bool(effects)))


def without(prepared, flags):
    """A Prepared without the samples of `flags`, (n, 9) booleans of each recording, in place of those that stood alone; itself
    where these are the same, or its recordings are split otherwise."""
    problem, base = prepared.problem, prepared.base
    alike = [flag.shape for flag in flags] == [flag.shape for flag in problem.dropped]
    if not alike or all(map(np.array_equal, flags, problem.dropped)):
        return prepared
    corrects = problem.step_change is not None
    problem.leave_out(flags)
    base = problem.fit(base.model, base.initial_states)
    if corrects and problem.step_change is None:
        base, _ = corrected(problem, base)
    return replace(prepared, base=base, aside=tuple(set_aside(problem.trials, flags)))


def without_isolated(problem, fit):
    """(fit without the samples that stand alone, sentences); the problem leaves them out for every model alike."""
    flags, fit = alone_beside(problem, fit)
    return fit, set_aside(problem.trials, flags)


def alone_beside(problem, fit):
    """(Samples that stand alone beside a fit, of all that were recorded, as `isolated` has them; the fit without them): one that
    lost samples have spoilt hides others. The problem leaves them out."""
    flags = problem.dropped
    for _ in range(ALONE_AGAIN):
        problem.leave_out([np.zeros_like(flag) for flag in flags])
        found = isolated(problem, problem.residuals(fit.model, fit.initial_states))
        problem.leave_out(found)
        if all(map(np.array_equal, found, flags)):
            break
        flags, fit = found, problem.fit(fit.model, fit.initial_states)
    return flags, fit


def isolated(problem, raw):
    """[(n, 9) booleans] of each recording: samples and channels whose residual stands alone, far from its neighbours'.

    No accelerations through contacts: where a slide stops or an impact comes a little late, a good reading stands alone too.
    """
    flags = [np.zeros((len(trial.times), len(CHANNELS)), bool) for trial in problem.trials]
    judged = [k for k, name in enumerate(CHANNELS) if not (problem.contact and unit_of(name, "m") == "m/s2")]
    for channel in judged:
        readings = [recording.channel == channel for recording in problem.recordings]
        series = [
            (recording.times[here], residual[here])
            for recording, residual, here in zip(problem.recordings, raw, readings, strict=True)
        ]
        spreads = [
            spread_of(problem.noise.reading(channel), times, problem.noise.step) if len(times) > 2 else 0.0 for times, _ in series
        ]
        alone = isolated_in(series, spreads)
        for flag, recording, here, its in zip(flags, problem.recordings, readings, alone, strict=True):
            flag[recording.sample[here][its], channel] = True
    return flags


def set_aside(trials, flags, effects=()):
    """Sentences, one for each recording as it was read, on the samples set aside; effects: that the model had beside them."""
    rows_of = {}  # recording -> {channel: rows of its file}
    for trial, flag in zip(trials, flags, strict=True):
        for row, channel in zip(*np.nonzero(flag), strict=True):
            channels = rows_of.setdefault(trial.whole, {})
            channels.setdefault(CHANNELS[channel], []).append(int(trial.rows[row]))
    notes, beside = [], ", seen beside " + " + ".join(effects) if effects else ""
    for name, channels in rows_of.items():
        parts = [
            f"{channel} row{'s' * (len(rows) > 1)} " + ", ".join(map(str, rows[:4])) + " .." * (len(rows) > 4)
            for channel, rows in channels.items()
        ]
        count = sum(map(len, channels.values()))
        notes.append(f"{name}: {count} isolated sample{'s' * (count > 1)} set aside for all models{beside}: " + "; ".join(parts))
    return notes
