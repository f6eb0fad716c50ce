"""What could be measured next: the experiments that a kind of measurement can make of those it has."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from hlcs.data.bodies import impossible_density
from minibullet import rotations

AT_REST = 0.3  # speed below which a body is dropped rather than thrown [m/s]
TURNING = 1.0  # rate of turning from which a spin can be reversed [rad/s]
QUARTER = rotations.exponential(np.array([0.0, 0.0, np.pi / 2]))


class Design(NamedTuple):
    """One experiment that could be made."""

    text: str  # what to do
    what: dict  # the same as {input: value}, for a program
    far: float = 0.0  # octaves from what was measured
    lead: str = ""  # first words of the text, which two designs may share


class Designs(NamedTuple):
    """Experiments that could be made, each one recording of a problem of their own (what it measures is of no account)."""

    problem: Any
    initial_states: np.ndarray  # (designs, 13)
    options: tuple[Design, ...]
    shared: list | None = None  # what all tests of a design are off by together: white columns per standard deviation (n_i, k)


def octaves(factor):
    """How far a factor is from 1, in doublings."""
    return float(abs(np.log2(factor)))


def other_bodies_tell(terms):
    """Would another body obey these terms with the same numbers? Not the errors of one body, nor a drag whose number has a unit:
    that holds its mass and size."""
    numbers = [(term.candidate, free) for term in terms for free in term.candidate.free]
    return not any(entry.group == "body" or (entry.is_drag and free.unit not in ("-", "1")) for entry, free in numbers)


def changes_of(trial, start, contact, seated, other_bodies):
    """[(Design, start (13,), Trial)]: a recording made again with one thing changed."""
    found = [(Design(f"repeat {trial.name} as it was", {"repeat": trial.name}), start, trial)]
    speed = float(np.linalg.norm(start[3:6]))
    if speed > AT_REST:
        for factor, word in (
            (0.25, "a quarter as fast"),
            (0.5, "half as fast"),
            (2.0, "twice as fast"),
            (4.0, "four times as fast"),
        ):
            design = Design(f"start {word} ({factor * speed:.2g} m/s)", {"speed_m_s": factor * speed}, octaves(factor))
            found.append((design, _with(start, velocity=factor), trial))
        turned = _turned(start, QUARTER)
        found.append((Design("turn the start by 90 degrees", {"heading_deg": 90}), turned, trial))
        found.append((Design("turn the start by 180 degrees", {"heading_deg": 180}), _turned(turned, QUARTER), trial))
    elif contact and not seated and trial.surroundings.floor_height is not None:
        above = float(start[2] - trial.surroundings.floor_height)
        design = Design(f"drop it from twice as high ({2 * above:.2g} m)", {"raise_m": above}, 1.0)
        found.append((design, np.concatenate([start[:2], [start[2] + above], start[3:]]), trial))
    if np.linalg.norm(start[10:13]) > TURNING:
        found.append((Design("reverse the spin", {"spin": "reversed"}), _with(start, spin=-1.0), trial))
    if not contact:
        found.append(
            (
                Design("let it fly twice as long (from higher)", {"duration": "twice"}, 1.0),
                start,
                with_samples(trial, 2 * len(trial.times)),
            )
        )
    if trial.body.mass is not None and other_bodies:
        for factor, word in ((1 / 3, "a third of"), (3.0, "three times")):
            mass = factor * trial.body.mass
            body = replace(trial.body, mass=mass, inertia=None)
            if not impossible_density(body):
                design = Design(f"use a body of the same size and {word} the mass", {"mass_kg": mass}, octaves(factor))
                found.append((design, start, replace(trial, body=body)))
    return found


def _with(start, velocity=1.0, spin=1.0):
    start = start.copy()
    start[3:6] *= velocity
    start[10:13] *= spin
    return start


def _turned(start, turn):
    start = start.copy()
    start[3:6], start[10:13] = rotations.rotate(turn, start[3:6]), rotations.rotate(turn, start[10:13])
    return start


def with_samples(trial, count):
    """A trial of so many samples at its rate, NaN where a sample is missing: positions zero, orientations some that were seen."""
    more = trial.times[-1] + np.median(np.diff(trial.times)) * np.arange(1, max(count - len(trial.times), 0) + 1)
    times = np.concatenate([trial.times, more])[:count]
    position, orientation = np.resize(0 * trial.position, (count, 3)), np.resize(trial.orientation, (count, 4))
    read = trial.accelerations and trial.accelerations._replace(values=np.resize(0 * trial.accelerations.values, (count, 3)))
    return replace(trial, times=times, position=position, orientation=orientation, accelerations=read, rows=None)
