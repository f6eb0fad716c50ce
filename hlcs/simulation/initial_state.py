"""The initial state of a recording: what of it is unknown, a first guess from the samples, and steps of the unknowns.

An initial state is (13,): position of the centre of mass, velocity, orientation (w, x, y, z), angular velocity; world frame. One
of its unknowns is (slot, direction): the slot counts SLOTS, the direction is a unit vector (3,).
"""

import numpy as np

from hlcs.data.rigid_body import rigid_body, support
from hlcs.simulation import contact_motion
from minibullet import rotations

SLOTS = ("position", "velocity", "orientation", "angular_velocity")
UNSEEN = 1e-6  # part of a unit vector, a way along the floor or its normal, on some axes, below which it is rounding
PLACES = (slice(0, 3), slice(3, 6), slice(6, 10), slice(10, 13))


def unknowns(trial, measured, seated, flat, contact):
    """What of an initial state is neither stated nor fixed by lying on the floor: ((slot, direction), ...).

    measured: which of CHANNELS are (9,); seated: it lies on its floor; flat: on a face of it.
    """
    seen = np.asarray(measured[:3])
    axes = list(np.eye(3)[seen])
    if seated:
        normal = trial.surroundings.normal
        first = np.eye(3)[np.argmin(np.abs(normal))]
        first = first - (first @ normal) * normal
        first /= np.linalg.norm(first)
        ways = [first, np.cross(normal, first)]
        shown = [trial.unplaced or np.linalg.norm(way[seen]) > UNSEEN for way in ways]
        axes = [way for way, shows in zip(ways, shown, strict=True) if shows]
    aside = (
        (axes if seated else list(np.eye(3)))
        if trial.unplaced
        else axes
        if seated or measured[2] or not axes or contact or trial.surroundings.planar
        else [*axes, np.array([0.0, 0.0, 1.0])]
    )
    turns = [normal] if flat else list(np.eye(3)) if measured[3] else []
    rolls = turns
    if seated and trial.body.shape == "sphere" and not measured[3] and "velocity" not in trial.start:
        # a ball that turns about one way moves along the other
        rolls = [way for way, shows in zip(ways, reversed(shown), strict=True) if shows]
    found, placed = [], [] if trial.unplaced else axes  # no acceleration tells where it begins
    for slot, directions in enumerate((placed, aside, turns, rolls)):  # drag shows an unseen vertical speed
        if SLOTS[slot] not in trial.start:
            found += [(slot, direction) for direction in directions]
    return tuple(found)


def initial_guess(trial, start_time, seated, flat, contact):
    """The initial state (13,) read off the first samples; what the file states is taken from there."""
    state = np.zeros(13)
    state[6] = 1.0
    for axis in range(3):
        there = np.flatnonzero(np.isfinite(trial.position[:, axis]))
        if len(there) == 0:
            if axis == 2 and not contact and not trial.surroundings.planar and not trial.unplaced:
                state[5] = trial.surroundings.gravity * (trial.times[-1] - start_time) / 2  # unseen: back to its height
            continue
        first = there[: max(4, min(9, len(there) // 3))]
        t = trial.times[first] - start_time
        fall = -0.5 * trial.surroundings.gravity * t**2 if axis == 2 and trial.surroundings.floor_height is None else 0.0
        state[3 + axis], state[axis] = np.polyfit(t, trial.position[first, axis] - fall, 1)
    there = np.flatnonzero(np.isfinite(trial.orientation[:, 0]))
    if len(there) >= 2:
        steady = not contact and trial.body.shape == "sphere"
        there = there if steady else there[:12]
        state[10:13], state[6:10] = steady_turn(trial.times[there] - start_time, trial.orientation[there])
    for name, place in zip(SLOTS, PLACES, strict=True):
        if name in trial.start:
            state[place] = trial.start[name]
    if trial.unplaced and seated and "velocity" not in trial.start:
        state[3:6] = slid_from(trial, start_time)
    if flat:  # a face on the floor stays there: only turns about the normal are free
        normal = trial.surroundings.normal
        if "orientation" not in trial.start:
            state[6:10] = contact_motion.flattened(state[6:10], normal, contact_motion.faces(trial.body))
        if "angular_velocity" not in trial.start:
            state[10:13] = (state[10:13] @ normal) * normal
    return on_floor(state, trial) if seated else state


def gained(trial, start_time):
    """Velocity that a body has gained since its start at every sample by its accelerometer alone, world frame (n, 3) [m/s].

    On a floor without what acts along its normal.
    """
    around, times = trial.surroundings, trial.times - start_time
    acceleration = _along_floor(felt(trial, start_time) - np.array([0.0, 0.0, around.gravity]), around)
    steps = np.diff(times, prepend=0.0)[:, None]
    return np.cumsum(steps * (acceleration + np.concatenate([acceleration[:1], acceleration[:-1]])) / 2, axis=0)


def felt(trial, start_time):
    """What an accelerometer reads, along the axes of the world (n, 3) [m/s2]: all forces but gravity over the mass.

    A body is taken to turn steadily as at its start; a missing reading is 0 m/s2.
    """
    read = trial.accelerations
    force = np.nan_to_num(read.values)
    if not read.in_body:
        return force
    turns = rotations.exponential((trial.times - start_time)[:, None] * np.asarray(trial.start["angular_velocity"]))
    return rotations.rotate(rotations.product(turns, np.asarray(trial.start["orientation"])), force)


def _along_floor(vectors, surroundings):
    """Vectors (n, 3) without their part along the normal of the floor, where there is one."""
    if surroundings.floor_height is None:
        return vectors
    normal = surroundings.normal
    return vectors - (vectors @ normal)[:, None] * normal


def slid_from(trial, start_time):
    """Velocity with which a body on its floor began by its accelerometer alone, (3,) [m/s]: such that it ends at rest, or at rest
    where the floor would then have pushed it on in place of holding it back: it slides down ever faster."""
    gain = gained(trial, start_time)
    work = np.sum(_along_floor(felt(trial, start_time), trial.surroundings) * (gain - gain[-1]))
    return np.zeros(3) if work > 0 else -gain[-1]


def fastest_slide(trial):
    """The highest speed of a body on its floor by its accelerometer alone [m/s]."""
    begun = np.asarray(trial.start["velocity"]) if "velocity" in trial.start else slid_from(trial, trial.times[0])
    return float(np.max(np.linalg.norm(gained(trial, trial.times[0]) + begun, axis=1)))


def height_on_floor(trial):
    """Height of the centre of mass of a body that lies on its floor in the attitude that is stated, else upright [m]."""
    turn = np.asarray(trial.start.get("orientation", (1.0, 0.0, 0.0, 0.0)), dtype=float)
    heights = support(rigid_body(trial.body).shape, turn, trial.surroundings.normal)
    return float(-heights.min())


def on_floor(state, trial):
    """An initial state (13,) put on the nominal floor; a ball whose spin nobody knows rolls."""
    shape = rigid_body(trial.body).shape
    state = contact_motion.seat(shape, state, trial.surroundings, trial.surroundings, 0.0)
    if trial.body.shape == "sphere" and "angular_velocity" not in trial.start and not np.isfinite(trial.orientation).any():
        state[10:13] = np.cross(trial.surroundings.floor_normal, state[3:6]) / shape.bounding_radius
    return state


def shifted(state, unknown, amount):
    """An initial state (13,) changed by an amount of one of its unknowns."""
    state = state.copy()
    slot, direction = unknown
    if slot == 2:
        state[6:10] = rotations.product(rotations.exponential(amount * direction), state[6:10])
    else:
        state[PLACES[slot]] += amount * direction
    return state


def stepped(state, unknown, move):
    """An initial state (13,) moved by amounts of its unknowns (unknowns,)."""
    for number, amount in zip(unknown, move, strict=True):
        state = shifted(state, number, amount)
    return state


def steady_turn(times, orientation):
    """Angular velocity (3,) and orientation (4,) at time 0 of a steady turn through orientations (n, 4) at times (n,).

    From the median turn between the first few neighbours on, over windows twice as long each, as long as what is left stays
    below a radian; samples far off the rest (a lost tracker) are left out, the first one included.
    """
    first = min(7, len(times))
    turns = rotations.logarithm(rotations.product(orientation[1:first], rotations.conjugate(orientation[: first - 1])))
    spin = np.median(turns / np.diff(times[:first])[:, None], axis=0)
    start, window = orientation[0], first
    while True:
        back = rotations.product(rotations.exponential(-spin * times[:window, None]), orientation[:window])
        left = rotations.logarithm(rotations.product(back, rotations.conjugate(start)))
        level = np.median(left, axis=0)
        far = np.linalg.norm(left - level, axis=1)
        near = far <= 5 * np.median(far) + 1e-9
        if window > first and np.max(far[near]) > 1.0:
            break
        line = np.column_stack([np.ones(near.sum()), times[:window][near]])
        (level, drift), *_ = np.linalg.lstsq(line, left[near], rcond=None) if near.sum() > 3 else (((level, 0 * level)),)
        start, spin = rotations.product(rotations.exponential(level), start), spin + drift
        if window == len(times):
            break
        window = min(2 * window, len(times))
    return spin, start
