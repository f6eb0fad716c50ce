"""What a reader must know of the release: at which stamp a stated start is taken, and who was still held before."""

from dataclasses import replace

import numpy as np

from hlcs.data.accelerometers import STEADY
from hlcs.data.rigid_body import borne
from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.noise_model import BEYOND_CHANCE
from hlcs.estimation.whitening import whiten
from hlcs.kinds.trajectories.felt_release import LEAST, STRAY, over_gravity, samples_felt, samples_pushed, samples_until_impact

FEW = 4  # recordings that are named
FALLEN = 200.0  # standard deviations of a fall that tells its beginning: a drag bends a longer one in more ways
LEVEL = 1e-6  # slope of a floor that pulls nothing down [-]
PLACES = {  # of a body that is held: (is it read by an accelerometer alone, does it lie on its floor)
    (False, False): "in the air",
    (False, True): "on the slope",
    (True, False): "in the hand",
    (True, True): "on its floor, and is pushed,",
}
LOOKS = 100  # moments at which a fall may begin, looked at first
RESTS = {
    case: f"rests {where} at first, as if it were still held; what was recorded before the release is left out"
    for case, where in PLACES.items()
}
STRUCK = "strikes something, and no floor is stated; what was read from the impact on is left out"
BORNE = (
    "reads gravity, as a body that lies or slides, and is taken to fall, as no floor is stated; state surroundings.floor, or do "
    "not where it sinks as fast as it ever will"
)


def release_notes(trials, starts, seated, noise):
    """Sentences on recordings whose stated start is not at a first sample of stamp 0, and on those that rest in the air then.

    starts: moments at which the starts are taken (trials,) [s]; seated: does a body lie on its floor then (trials,).
    """
    stated = [
        (trial, start)
        for trial, start in zip(trials, starts, strict=True)
        if not (_holds_at_any_time(trial.start) or _at_zero(trial))
    ]
    taken_at_zero = [(trial.name, trial.times[0]) for trial, start in stated if start == 0.0]
    taken_at_first = [(trial.name, trial.times[0]) for trial, start in stated if start != 0.0]
    rests = [(trial.name, time_held(trial, noise, lies), lies) for trial, lies in zip(trials, seated, strict=True) if trial.start]
    held, on_slope = ([(name, rest) for name, rest, lies in rests if rest and lies == there] for there in (False, True))
    told = (
        (taken_at_zero, "the stated start is taken at t_s = 0, {:.3g} s before the first sample; count t_s from the release"),
        (
            taken_at_first,
            "the stated start is taken at the first sample, t_s = {:.4g}; where the body was let go later leave out the samples "
            "before, where it was let go earlier leave out the start: it is then fitted",
        ),
        *(
            (
                entries,
                f"rests {where} for the first {{:.2g}} s, as if it were still held; leave out the samples before the release",
            )
            for entries, where in ((held, PLACES[False, False]), (on_slope, PLACES[False, True]))
        ),
    )
    return [f"{_names([name for name, _ in entries])}: {text.format(entries[0][1])}" for entries, text in told if entries]


def may_hover(body, around):
    """Does a fluid bear a body, or much of it? A liquid may; a gas may where the body is known to be nearly as light."""
    return around.in_liquid or borne(body, around)


def _holds_at_any_time(start):
    """Is nothing stated but the attitude of a body that does not turn?"""
    return start.keys() <= {"orientation", "angular_velocity"} and not np.any(start.get("angular_velocity", 0.0))


def _at_zero(trial):
    """Does its clock begin at zero, to a hundredth of a step?"""
    return abs(trial.times[0]) <= 0.01 * np.median(np.diff(trial.times))


def _names(names):
    """Names of recordings, a few of them."""
    return ", ".join(names[:FEW]) + f" and {len(names) - FEW} more" * (len(names) > FEW)


def let_go(measurement, noise, seated):
    """The Recordings from the release on: what was recorded of a body still held is left out, and told, where the start is
    fitted; where it is stated, a clock offset tells when it was. A fall that is read by an accelerometer alone ends with its
    impact, where no floor is stated; where it is said to begin at rest, it does so in the hand.

    seated: does a body lie on its floor at the start (trials,).
    """
    told, trials = {text: [] for text in (*RESTS.values(), STRUCK, BORNE)}, []
    for trial, lies in zip(measurement.trials, seated, strict=True):
        trial = _from_release(trial, noise, lies, told)
        trials.append(_until_impact(trial, noise, told) if trial.unplaced and trial.surroundings.floor_height is None else trial)
    notes = [f"{_names(names)}: {text}" for text, names in told.items() if names]
    return replace(measurement, trials=tuple(trials), notes=(*measurement.notes, *notes)) if notes else measurement


def _from_release(trial, noise, lies, told):
    """A Trial from its release on, if it was held at first and its start is to be fitted; its name under what is told of it."""
    fitted = not np.any(trial.start.get("velocity", 0.0)) if trial.unplaced else not trial.start
    count = samples_held(trial, noise, lies) if fitted else 0
    if not count:
        return trial
    told[RESTS[trial.unplaced, lies]].append(f"{trial.name} ({trial.times[count - 1] - trial.times[0]:.2g} s)")
    return trial.at(slice(count, None), start={key: value for key, value in trial.start.items() if key != "velocity"})


def _until_impact(trial, noise, told):
    """A fall that is read by an accelerometer alone, up to where it strikes; its name under what is told of it."""
    count = samples_until_impact(trial, noise)
    if count < len(trial.times):
        told[STRUCK].append(f"{trial.name} ({trial.times[count]:.3g} s)")
        trial = trial.at(slice(count))
    if np.abs(np.median(over_gravity(trial)) - 1) < STEADY:
        told[BORNE].append(trial.name)
    return trial


def time_held(trial, noise, lies=False):
    """How long a body rests at the beginning of a Trial before it falls, or goes down [s]; 0.0 where that is not certain."""
    return float(trial.times[max(samples_held(trial, noise, lies) - 1, 0)] - trial.times[0])


def _heights(trial, lies):
    """(heights (n,) that a body loses when it is let go [m], the axis that tells most of them); (None, 2) where nothing pulls it.

    lies: on its floor, down whose slope it goes: its way up there, by the axes that were measured, stands for the height.
    """
    if not lies:
        return trial.position[:, 2], 2
    normal = trial.surroundings.normal / np.linalg.norm(trial.surroundings.normal)
    uphill = (np.array([0.0, 0.0, 1.0]) - normal[2] * normal) * np.isfinite(trial.position).any(axis=0)
    size = np.linalg.norm(uphill)
    if size < LEVEL:
        return None, 2
    told = uphill != 0
    return trial.position[:, told] @ (uphill[told] / size), int(np.argmax(np.abs(uphill)))


def samples_held(trial, noise, lies=False):
    """How many samples of a Trial were taken of a body still held in the air, or, where it lies there, on a slope; 0 where that
    is not certain.

    Two paths of four numbers each are fitted to the first heights: a level until a moment, then a fall from rest; and a fall or
    throw from the first sample on; the acceleration of both may change with time, as a drag makes it. It was held where the first
    one leaves less, by more than chance gives. What floats, or moves before it falls, is not held.
    """
    if trial.unplaced:
        return samples_pushed(trial, noise) if lies else samples_felt(trial, noise)
    around, (heights, axis) = trial.surroundings, _heights(trial, lies)
    if noise.position is None or around.planar or heights is None or may_hover(trial.body, around) and not lies:
        return 0
    there = np.flatnonzero(np.isfinite(heights))
    if len(there) < 2 * LEAST:
        return 0
    times, heights = trial.times[there] - trial.times[there[0]], heights[there]
    fallen = np.flatnonzero(np.maximum.accumulate(heights) - heights > FALLEN * noise.reading(axis).sigma)
    end = int(np.argmin(heights[: fallen[0] + 1 if len(fallen) else None])) + 1
    if end < 2 * LEAST:
        return 0
    times, heights = times[:end], heights[:end]
    whitening = noise.whitening(np.full(end, axis), times)

    def left(since, first):
        columns = whiten(whitening, np.column_stack([np.ones(end), *first, since**2, since**3, heights]))
        return float(np.sum(project_out(basis(columns[:, :-1]), columns[:, -1]) ** 2))

    def rested(k):
        return left(np.maximum(times - times[k], 0.0), [])

    looked, step = range(LEAST - 1, end - LEAST), max(end // LOOKS, 1)
    near = min(looked[::step], key=rested)
    best = min((k for k in looked if abs(k - near) < step), key=rested)
    rest = trial.position[: there[best]]  # a throw from the hand is no rest, though the fall from its top begins with one
    seen = np.isfinite(rest).any(axis=0)
    rest = (rest / noise.of_axes)[:, seen]
    still = np.all(np.abs(rest - np.nanmean(rest, axis=0))[np.isfinite(rest)] < STRAY)
    return int(there[best]) + 1 if still and left(times, [times]) - rested(best) > BEYOND_CHANCE else 0
