"""What could be measured next: the experiments that a kind of measurement can make of those it has."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from hlcs.data.bodies import impossible_density
from hlcs.data.rigid_body import known_body, rigid_body
from hlcs.simulation import contact_motion
from minibullet import rotations

AT_REST = 0.3  # speed below which a body is dropped rather than thrown [m/s]
TURNING = 1.0  # rate of turning from which a spin can be reversed [rad/s]
BY_HAND = 20.0  # speed that an arm gives a body [m/s]
HIGH = 10.0  # of a stairwell, the highest that most laboratories have; as long is a hall [m]
DEEP = 2.0  # the deepest tank that most laboratories have [m]
FURTHER = 4.0  # times as far as anything has gone that was recorded: one camera with the same noise sees no more
STANDING_GAP = 0.05  # gap below which a body stands on its floor rather than above it, in bounding radii
SLOPING = np.radians(0.5)  # slope from which a floor is a board that was tilted on purpose
STEEPEST = np.radians(45.0)  # of a board
SPEEDS = ((0.25, "a quarter as fast"), (0.5, "half as fast"), (2.0, "twice as fast"), (4.0, "four times as fast"))


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
    """[(Design, start (13,), Trial)]: a recording made again with one thing changed, each a thing that its scene allows.

    trial: the recording; start: its initial state; contact: does the body touch anything; seated: does it lie on its floor at the
    start; other_bodies: would another body tell?
    """
    name = trial.whole
    found = [(Design(f"repeat {name} as it was", {"repeat": name}), start, trial)]
    found += [*_speeds(trial, start, seated), *_headings(trial, start, seated)]
    found += _boards(trial, start) if seated else _heights(trial, start) if contact else _longer(trial, start)
    if np.linalg.norm(start[10:13]) > TURNING and not seated:  # a body that rolls cannot turn the other way
        found.append((Design("with the spin reversed", {"spin": "reversed"}), _with(start, spin=-1.0), trial))
    found += _bodies(trial, start) if other_bodies else []
    lead = f"make {name} again, "
    return [(design if "repeat" in design.what else design._replace(lead=lead), *rest) for design, *rest in found]


def _speeds(trial, start, seated):
    """Other speeds at the start: a throw is thrown faster, a fall is seen from where it is faster, a liquid sets its own."""
    speed = float(np.linalg.norm(start[3:6]))
    falling = not seated and start[5] < 0 and np.hypot(*start[3:5]) < AT_REST
    if speed <= AT_REST or (falling and trial.surroundings.in_liquid):
        return
    for factor, word in SPEEDS:
        text = f"started {word} ({factor * speed:.2g} m/s)"
        if falling:
            text = f"seen from where it falls {word} ({factor * speed:.2g} m/s)"
        rolls = seated and trial.body.shape == "sphere"
        state = _with(start, velocity=factor, spin=factor if rolls else 1.0)
        if factor * speed <= max(BY_HAND, speed):
            yield Design(text, {"speed_m_s": factor * speed}, octaves(factor)), state, trial


def _headings(trial, start, seated):
    """Other headings: of what moves sideways, where that is seen."""
    normal = trial.surroundings.normal if seated else np.array([0.0, 0.0, 1.0])
    aside = float(np.linalg.norm(start[3:6] - (start[3:6] @ normal) * normal))
    seen, turned = {"x", "y"} & set(trial.columns), start
    for degrees in (90, 180) if seen and aside > AT_REST else ():
        turned = _turned(turned, rotations.exponential(normal * np.pi / 2))
        if degrees == 180 or len(seen) == 2:  # a camera that sees one way sideways sees a quarter of a turn as none
            yield Design(f"in a heading turned by {degrees} degrees", {"heading_deg": degrees}), turned, trial


def _heights(trial, start):
    """Other heights of a drop onto a floor: of a body let go clear of it."""
    shape = rigid_body(trial.body).shape
    gap = contact_motion.gap(shape, start[:3], start[6:10], trial.surroundings) / trial.surroundings.floor_normal[2]
    if np.linalg.norm(start[3:6]) > AT_REST or not STANDING_GAP * shape.bounding_radius < gap < np.inf:
        return
    for factor, word in ((0.5, "half"), (2.0, "twice")):
        raised = (factor - 1) * gap
        text = f"dropped from {word} as high ({factor * gap:.2g} m between body and floor)"
        if factor * gap <= max(HIGH, gap):
            state = np.concatenate([start[:2], [start[2] + raised], start[3:]])
            yield Design(text, {"raise_m": raised}, octaves(factor)), state, trial


def _boards(trial, start):
    """Other slopes of a floor that slopes: such a floor is a board."""
    normal = trial.surroundings.normal
    angle = float(np.arccos(np.clip(normal[2], -1.0, 1.0)))
    for factor, word in ((0.5, "half"), (2.0, "twice")) if angle > SLOPING else ():
        if factor * angle > STEEPEST:
            continue
        axis = np.cross([0.0, 0.0, 1.0], normal) / np.sin(angle)
        turn = rotations.exponential((factor - 1) * angle * axis)
        surroundings = replace(trial.surroundings, floor_normal=tuple(float(x) for x in rotations.rotate(turn, normal)))
        state = _turned(start, turn)
        state[:3], state[6:10] = rotations.rotate(turn, start[:3]), rotations.product(turn, start[6:10])
        tilted = replace(trial, surroundings=surroundings, orientation=rotations.product(turn, trial.orientation))
        degrees = float(np.degrees(factor * angle))
        text = f"on a board {word} as steep ({degrees:.2g} degrees)"
        yield Design(text, {"angle_deg": degrees}, octaves(factor)), state, tilted


def _longer(trial, start):
    """Twice the time in flight."""
    longer = with_samples(trial, 2 * len(trial.times))
    yield Design(f"for twice as long ({np.ptp(longer.times):.2g} s)", {"duration": "twice"}, 1.0), start, longer


def _bodies(trial, start):
    """Other bodies of the same size; in a liquid one that goes the same way, up or down."""
    for factor, word in ((1 / 3, "a third of"), (3.0, "three times")) if trial.body.mass is not None else ():
        body = replace(trial.body, mass=factor * trial.body.mass, inertia=None)
        if not impossible_density(body) and goes_the_same_way(body, trial.body, trial.surroundings):
            text = f"with a body of the same size and {word} the mass ({body.mass:.2g} kg)"
            yield Design(text, {"mass_kg": body.mass}, octaves(factor)), start, replace(trial, body=body)


def goes_the_same_way(body, other, surroundings):
    """Do both bodies sink, or both rise, in a liquid? In a gas all fall."""
    if not surroundings.in_liquid or not known_body(body):
        return True
    weights = [each.mass - surroundings.fluid_density * rigid_body(each).volume for each in (body, other)]
    return weights[0] * weights[1] > 0


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
