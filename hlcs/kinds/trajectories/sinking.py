"""The drag of a body that sinks or rises, read from its recordings without any fit: where a search for its law begins.

Far from free fall a small change of a model without drag says nothing of a drag that carries the weight.
"""

import numpy as np

from hlcs.data.rigid_body import known_body, rigid_body
from hlcs.effects.candidates import build
from hlcs.simulation.outcome_motion import state_of

STEPS = 40  # in which a number is found: a force that goes as its power p leaves 1 - p of the error in each, 1e-6 of 0.7 in all
LEAST = 5  # samples of a recording from which its motion is read
HELD = 0.5  # part of the weight that drag carries, from which the motion is nearer to its final speed than to free fall


def drags_shown(candidates, trials):
    """The number with which each drag of one number gives the mean drag on recordings, the median over them.

    {name of the candidate: {its number: value}}; {} where no body sinks or rises with a drag that carries HELD of its weight.
    """
    seen = [(trial, *held) for trial in trials if (held := _held_back(trial)) is not None]
    return numbers_shown([entry for entry in candidates if entry.is_drag], seen, _of_speed)


def drags_between_impacts(candidates, trials, drags, impacts):
    """The same of a body that bounces, from what flights between its impacts show.

    drags: {(body, density of the fluid): k of its deceleration k v^2 [1/m]}; impacts: at whose mean speed a law gives as much.
    """
    ways = [(trial, drags.get((trial.body, trial.surroundings.fluid_density), 0.0)) for trial in trials if known_body(trial.body)]
    speed = float(np.mean([impact.speed for impact in impacts] or [0.0]))
    seen = [(trial, _moved(trial) * k * speed**2, speed) for trial, k in ways if k > 0]
    return numbers_shown([entry for entry in candidates if entry.is_drag and not entry.setting], seen, _of_speed)


def numbers_shown(laws, seen, given):
    """{name: {its number: value}} of the laws of one number that may be missing and, growing with it, give what recordings show;
    the median over them.

    seen: [(trial, what it shows, ..)]; given: (the law at a number, *one of `seen`) -> (what is seen, what that law gives). A law
    that gives nothing, or the contrary, is left out.
    """
    found = {}
    for entry in laws:
        if not seen or not entry.absent or len(entry.free) != 1:
            continue
        (free,) = entry.free
        values = [_number_shown(entry.kind, free.name, given, trial, *shown) for trial, *shown in seen]
        if all(value is not None for value in values):
            found[entry.name] = {free.name: float(np.median(values))}
    return found


def _of_speed(law, trial, drag, speed):
    """(a drag that was seen at a speed of one recording, the drag that a law gives there) [N]."""
    return drag, law.forces(state_of([trial], np.array([[0.0, 0.0, -speed]])), 0.0)[0, 2]


def _moved(trial):
    """Mass of a body with half of the displaced mass, which is accelerated with it (H. Lamb, Hydrodynamics (1932), art. 92)."""
    body = rigid_body(trial.body)
    return body.mass + trial.surroundings.fluid_density * body.volume / 2


def _number_shown(kind, name, given, trial, *shown):
    """The number with which a law gives what one recording shows; None of one that gives nothing, or the contrary."""
    value = 1.0
    for _ in range(STEPS):
        seen, force = given(build(kind, {name: value}, trial.surroundings), trial, *shown)
        if not force > 0:
            return None
        value *= seen / force
    return float(value)


def _held_back(trial):
    """(mean drag [N], mean speed [m/s]) of one recording, of a parabola through its heights; None where the body is not known,
    goes against its weight in the fluid or farther aside than down, or drag carries less than HELD of that.

    Drag = weight less lift less mass times acceleration, downwards. What a spin lifts is thrown.
    """
    there = np.isfinite(trial.position[:, 2])
    if not known_body(trial.body) or there.sum() < LEAST:
        return None
    times, heights = trial.times[there], trial.position[there, 2]
    if not np.nanmax(np.abs(np.nan_to_num(trial.position[there] - trial.position[there][0]))) <= np.ptp(heights):
        return None
    bend = np.polyfit(times - times.mean(), heights, 2)[0]
    speed = (heights[0] - heights[-1]) / (times[-1] - times[0])
    body, around = rigid_body(trial.body), trial.surroundings
    weight = (body.mass - around.fluid_density * body.volume) * around.gravity
    drag = weight + _moved(trial) * 2 * bend
    return (abs(float(drag)), abs(float(speed))) if speed * weight > 0 and drag / weight > HELD else None
