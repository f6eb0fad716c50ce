"""What a reader must know of the release: at which stamp a stated start is taken, and who was still held before."""

import numpy as np

from hlcs.data.rigid_body import known_body, rigid_body

FEW = 4  # recordings that are named
STRAY = 4.0  # standard deviations of the noise that samples of a body at rest stray, at most
LIGHT = 10.0  # densities of the fluid, below which a body falls much more slowly than freely from the first: bubbles, balloons
BOW = 16  # a parabola of curvature g leaves any level by g T^2/16 at least over a time T


def release_notes(trials, starts, seated, sigma):
    """Sentences on recordings whose stated start is not at a first sample of stamp 0, and on those that begin at rest in the air.

    starts: moments at which the starts are taken (trials,) [s]; seated: does a body lie on its floor then (trials,); sigma: noise
    of a position [m], None where it is unknown.
    """
    stated = [(trial, start) for trial, start in zip(trials, starts, strict=True) if trial.start and not _at_zero(trial)]
    taken_at_zero = [(trial.name, trial.times[0]) for trial, start in stated if start == 0.0]
    taken_at_first = [(trial.name, trial.times[0]) for trial, start in stated if start != 0.0]
    rests = [(trial.name, time_held(trial, sigma)) for trial, lies in zip(trials, seated, strict=True) if not lies]
    held = [(name, rest) for name, rest in rests if rest]
    told = (
        (taken_at_zero, "the stated start is taken at t_s = 0, {:.3g} s before the first sample; count t_s from the release"),
        (
            taken_at_first,
            "the stated start is taken at the first sample, t_s = {:.4g}; where the body was let go later leave out the samples "
            "before, where it was let go earlier leave out the start: it is then fitted",
        ),
        (held, "rests in the air for the first {:.2g} s, as if it were still held; leave out the samples before the release"),
    )
    return [f"{_names(entries)}: {text.format(entries[0][1])}" for entries, text in told if entries]


def may_hover(body, around):
    """Does a fluid bear a body, or much of it? A liquid may; a gas may where the body is known to be nearly as light."""
    if around.in_liquid or not known_body(body):
        return around.in_liquid
    known = rigid_body(body)
    return known.mass < LIGHT * around.fluid_density * known.volume


def _at_zero(trial):
    """Does its clock begin at zero, to a hundredth of a step?"""
    return abs(trial.times[0]) <= 0.01 * np.median(np.diff(trial.times))


def _names(entries):
    """Names of recordings, a few of them."""
    names = [name for name, _ in entries]
    return ", ".join(names[:FEW]) + f" and {len(names) - FEW} more" * (len(names) > FEW)


def time_held(trial, sigma):
    """How long a body rests in the air at the beginning of a Trial before it falls, by its heights [s]; 0.0 where that is not
    certain.

    It is where no flight under gravity stays so near to one level: samples at rest stray by STRAY sigma, and a parabola leaves
    that band. sigma: noise of a position [m]. What floats or moves sideways is not held.
    """
    around, there = trial.surroundings, np.isfinite(trial.position[:, 2])
    times, heights = trial.times[there], trial.position[there, 2]
    if not sigma or around.planar or may_hover(trial.body, around) or len(times) < 2:
        return 0.0
    level = np.cumsum(heights) / np.arange(1, len(heights) + 1)
    moving = np.flatnonzero(np.abs(heights - level) > STRAY * sigma)
    if not len(moving) or heights.min() > level[moving[0] - 1] - 2 * STRAY * sigma:  # it stays, or does not fall
        return 0.0
    rest = float(times[moving[0] - 1] - times[0])
    sideways = trial.position[trial.times <= times[moving[0] - 1], :2]
    sideways = sideways[:, np.isfinite(sideways).any(axis=0)]
    if np.any(np.abs(sideways - np.nanmean(sideways, axis=0)) > STRAY * sigma):
        return 0.0
    return rest if around.gravity * rest**2 / BOW > 2 * STRAY * sigma else 0.0
