"""What an accelerometer alone tells of a release: when a hand let go of a body or stopped pushing it; when it strikes."""

import numpy as np

from hlcs.data.accelerometers import FREE, STEADY, felt, ways_through_air
from hlcs.simulation.initial_state import gained

LEAST = 3  # samples of a rest, and of a fall: one or two that lie aside may do so by themselves
STRAY = 4.0  # standard deviations of the noise that samples of a body at rest stray, at most
HIT = 1.5  # of gravity: what falls reads so much at an impact alone
SETTLED = 0.02  # of gravity by which two readings of a fall differ, at most


def over_gravity(trial):
    """What the accelerometer of a Trial reads, over gravity (n,)."""
    return felt(trial.accelerations.values, trial.surroundings.gravity)


def _close(trial, noise, of=1):
    """By how much readings of a Trial that are much the same differ at most, each made of so many [m/s2]."""
    return max(SETTLED * trial.surroundings.gravity, STRAY * np.sqrt(of) * (noise.acceleration or 0.0))


def _settled(trial, noise):
    """Between which samples of a Trial its accelerometer reads much the same, boolean (n - 1,): not while a hand lets it go, nor
    while it strikes something."""
    steps = np.abs(np.diff(np.nan_to_num(trial.accelerations.values), axis=0)).max(axis=1)
    return steps < _close(trial, noise, of=2)


def _steady(moments, settled, otherwise=0):
    """The first of these moments from which on LEAST steps are settled."""
    return next((k for k in moments if settled[k : k + LEAST].all()), otherwise)


def samples_felt(trial, noise):
    """How many samples an accelerometer was held or thrown for: it read gravity at first, and of all ways through the air, where
    it reads nearly nothing, the longest began all of a sudden; 0 where it did not."""
    reads, settled = over_gravity(trial), _settled(trial, noise)
    begun, ended = ways_through_air(reads)
    if not len(begun) or np.any(np.abs(reads[:LEAST] - 1) > STEADY):
        return 0
    longest = int(np.argmax(ended - begun))
    first, last = int(begun[longest]), int(ended[longest])
    if first < LEAST or settled[first - 1]:
        return 0
    return _steady(range(first + 1, last - LEAST), settled)


def samples_pushed(trial, noise):
    """How many samples a body on its floor rested and was pushed for, by its accelerometer: it read at first what it reads when
    it has stopped, and slides by itself once it is fastest; 0 where it did not."""
    values, times = np.nan_to_num(trial.accelerations.values), trial.times - trial.times[0]
    aside = np.abs(values - np.median(values[:LEAST], axis=0)).max(axis=1)
    close = _close(trial, noise)
    rest = int(np.argmax(np.append(aside > close, True)))
    if not LEAST < rest < len(times) or np.any(aside[-LEAST:] > close):
        return 0
    way = gained(trial, trial.times[0])
    speed = np.linalg.norm(way - np.outer(times, way[rest - 1] / times[rest - 1]), axis=1)  # without what it reads at rest
    fastest = int(np.argmax(speed))
    if speed[-1] > STEADY * speed[fastest]:
        return 0
    return _steady(range(fastest, len(times) - 1 - LEAST), _settled(trial, noise))


def samples_until_impact(trial, noise):
    """How many samples a fall takes that is read by an accelerometer alone, up to where it begins to strike something. All of
    them where nothing is struck."""
    reads, count = over_gravity(trial), len(trial.times)
    near = (
        k for k in range(LEAST, count) if reads[k] > FREE and reads[k : k + LEAST].max() > HIT > 1 > reads[k - LEAST : k].max()
    )
    end = next(near, None)
    return count if end is None else LEAST + _steady(range(end - LEAST, 0, -1), _settled(trial, noise), end - LEAST)
