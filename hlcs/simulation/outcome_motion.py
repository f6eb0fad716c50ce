"""What the model says for one row of an outcome table: a fall, a throw, a rebound, a slide, a rest; many rows at once.

The forces and the laws of contact are those of the effects; the motion is that of one body without a turn, so that a row
costs no world: Runge-Kutta in flight, the law of restitution at the impact, Coulomb's law on the floor.
"""

from typing import NamedTuple

import numpy as np

from hlcs.data.quantities import OUTCOMES
from hlcs.data.rigid_body import rigid_body, support
from hlcs.simulation.free_flight import fly
from hlcs.simulation.track import Track
from minibullet.bodies import Bodies, ContactLaw, Contacts
from minibullet.effects import contact_law

STEPS = 160  # of a fall or a slide
UP, BACK = 1.3, 2.2  # times v / g within which a body that is thrown up is past its top, or back, in air: 1 and 2 in a vacuum
# factor on the time of a flight that was too short, and how often: after 1e9 times a free fall a body does not sink at all
LONGER, MOST_LONGER = 1.7, 40
LEAST_WAY = 1e-12  # a flight over no way at all is computed over this one, so that it has a duration [m]
ENDLESS = 1e-6  # deceleration below which a slide does not end: a slide of 1 m/s would take ten days [m/s2]
STEADY = 1e-10  # change of the speed over a step, relative, from which a body sinks on as it does
FURTHER = 100.0  # as many times as long, at most, where a body sinks so slowly at the end of a flight


def outcomes(model, setups, inputs, outcome):
    """Outcomes (d,) [s, m or m/s] of d distinct rows: setups of the rows, inputs name -> (d,); nan where one never comes."""
    answers, alike, unit = np.empty(len(setups)), {}, OUTCOMES[outcome]
    for row, setup in enumerate(setups):
        alike.setdefault(setup.surroundings, []).append(row)
    for surroundings, members in alike.items():
        effects, setup_changes, measurement_changes = model.changes(surroundings)
        actual = [setups[row] for row in members]
        for change in setup_changes:
            actual = [change.setup(setup) for setup in actual]
        true_inputs = {name: np.array(values[members], dtype=float) for name, values in inputs.items()}
        parts = in_each_session(measurement_changes, actual)
        for inside, changes in parts:
            own = {name: values[inside] for name, values in true_inputs.items()}
            for change in changes:
                own = change.inputs(own, unit)
            for name, values in own.items():
                true_inputs[name][inside] = values
        values = LAWS[outcome](actual, effects, true_inputs)
        for inside, changes in parts:
            for change in changes:
                values[inside] = change.outcome(values[inside], unit)
        answers[members] = values
    return answers


def in_each_session(changes, setups):
    """[(places of the rows of one session, the changes of the measurement as they are there)]."""
    sessions = np.array([setup.session for setup in setups])
    return [(np.flatnonzero(sessions == name), [change.in_session(name) for change in changes]) for name in np.unique(sessions)]


def state_of(setups, velocity, spin=0.0):
    """Bodies at the origin, upright, with the given velocities (d, 3) and angular velocities (d, 3) or 0."""
    bodies = [rigid_body(setup.body) for setup in setups]
    count = len(bodies)
    properties = [np.array([getattr(body, name) for body in bodies]) for name in ("mass", "inertia", "volume", "area", "radius")]
    orientation = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    return Bodies(np.zeros((count, 3)), orientation, np.concatenate([velocity, np.zeros((count, 3)) + spin], axis=1), *properties)


def crossing(track, passed, count=50, until=None, begin=0.0):
    """Times (B,) at which `passed(position (B, 3))` (positive before) first falls through zero, by bisection on a Track.

    begin, until: times between which it is [s] (B,), None = the end of the Track; beyond that motion goes straight on.
    """
    bodies, times = track.position.shape[1], track.times
    there = (np.array([passed(position) for position in track.position]) <= 0) & (times[:, None] > begin)
    first = np.where(there.any(axis=0), np.argmax(there, axis=0), len(times))  # a lift may take a body up once more
    last = np.full(bodies, times[-1]) if until is None else until
    low, high = np.maximum(times[first - 1], begin), np.where(there.any(axis=0), times[np.minimum(first, len(times) - 1)], last)
    for _ in range(count):
        middle = (low + high) / 2
        before = passed(track.position_at(middle[:, None])[:, 0]) > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return (low + high) / 2


def velocity_at(track, times):
    """Velocities (B, 3) at times (B,), by a central difference well inside a step."""
    h = 1e-4 * track.times[-1] / STEPS
    ahead, behind = track.position_at((times + h)[:, None])[:, 0], track.position_at((times - h)[:, None])[:, 0]
    return (ahead - behind) / (2 * h)


class Descent(NamedTuple):
    """Bodies on their way down, further than they have to go."""

    track: Track
    until: np.ndarray  # time by which each has gone its way [s] (d,); nan where one floats

    def time_at(self, depth):
        """Times at which the bodies pass a depth below their start [m], (d,) -> (d,)."""
        times = crossing(self.track, lambda position: depth + position[:, 2], until=np.nan_to_num(self.until))
        return np.where(np.isfinite(self.until), times, np.nan)


def descent(setups, effects, depth, velocity, spin=0.0):
    """The Descent of bodies to `depth` (d,) below their start [m], thrown with velocities (d, 3) [m/s] and angular velocities
    (d, 3) [rad/s] or 0."""
    gravity, rise = setups[0].surroundings.gravity, np.max(velocity[:, 2], initial=0.0)
    state = state_of(setups, velocity, spin)
    longest = 1.5 * (2 * rise / gravity + np.sqrt(2 * np.nanmax(np.append(depth, LEAST_WAY)) / gravity))
    for _ in range(MOST_LONGER):
        track = fly(state, effects, longest, longest / STEPS)
        passed = (depth + track.position[1:, :, 2] <= 0).any(axis=0)
        left, pace = depth + track.position[-1, :, 2], -track.velocity[-1, :, 2]
        later = np.where(passed, 0.0, left / np.where(pace > 0, pace, np.nan))  # where it goes on as it does at the end
        change = track.velocity[-1] - track.velocity[-2]
        steady = np.abs(change).max(axis=1) < STEADY * np.abs(pace)
        floats = ~passed & (pace <= 0) & (change[:, 2] >= 0)  # one that rises more and more slowly may still come down
        if np.all(passed | steady) or floats.any():
            break
        longest *= np.clip(1.05 * (1 + np.max(np.nan_to_num(later)) / longest), LONGER, FURTHER)
    return Descent(track, np.where(passed | steady, longest + 1.01 * later, np.nan))


def fallen(setups, effects, height):
    """(time [s], velocity (d, 3)) of bodies that have fallen by `height` (d,) [m] from rest; nan where one floats."""
    way = descent(setups, effects, height, np.zeros((len(setups), 3)))
    times = way.time_at(height)
    return times, velocity_at(way.track, times)


def load_on(setups, state, normal):
    """Force with which bodies press on a floor with unit normal (d, 3), under their weight (d,) [N]."""
    return state.mass * setups[0].surroundings.gravity * normal[:, 2]


def law_at(setups, effects, state, velocity, normal):
    """ContactLaw of bodies moving with `velocity` (d, 3) on a floor with unit normal (d, 3), under their weight."""
    count = len(setups)
    surroundings = setups[0].surroundings
    both = Bodies(
        *(
            np.concatenate([np.asarray(field), np.full((1, *np.shape(field)[1:]), np.inf if name == "mass" else 0.0)])
            for name, field in zip(Bodies._fields, state, strict=True)
        )
    )
    load = load_on(setups, state, normal)
    contacts = Contacts(np.full(count, count), np.arange(count), np.zeros((count, 3)), normal, np.zeros(count), velocity, load)
    law = ContactLaw(np.full(count, surroundings.friction), np.full(count, surroundings.restitution), *np.zeros((3, count)))
    return contact_law(effects, contacts, both, law)


def rebound(setups, effects, hit):
    """Speeds with which bodies leave a level floor that they strike with velocities `hit` (d, 3), (d,) [m/s]."""
    up = np.tile([0.0, 0.0, 1.0], (len(setups), 1))
    return -hit[:, 2] * law_at(setups, effects, state_of(setups, hit), hit, up).restitution


def fall_time(setups, effects, inputs):
    """Time of a fall from rest through height_m."""
    return fallen(setups, effects, inputs["height_m"])[0]


def rebound_height(setups, effects, inputs):
    """Height regained after impact number `bounce`, the first where none is given, of a fall through height_m; 0 after the
    body has come to lie."""
    numbers = inputs.get("bounce", np.ones(len(setups)))
    speed = rebound(setups, effects, fallen(setups, effects, inputs["height_m"])[1])
    left = speed
    for number in range(2, int(numbers.max()) + 1):
        left = np.where(left > 0, rebound(setups, effects, thrown_up(setups, effects, left)[1]), left)
        speed = np.where(numbers >= number, left, speed)
    track = risen(setups, effects, speed, lambda track: track.velocity[-1, :, 2] < 0)
    return np.where(np.isfinite(speed), apex(track), np.nan)


def apex(track):
    """Greatest height of each body on a Track, from a parabola through the highest node with its velocity (B,)."""
    top = np.clip(np.argmax(track.position[:, :, 2], axis=0), 0, len(track.times) - 1)
    who = np.arange(track.position.shape[1])
    other = np.where((track.velocity[top, who, 2] > 0) & (top + 1 < len(track.times)), top + 1, np.maximum(top - 1, 0))
    v, w = track.velocity[top, who, 2], track.velocity[other, who, 2]
    h = track.times[other] - track.times[top]
    slope = np.where(h != 0, (w - v) / np.where(h != 0, h, 1.0), -1.0)
    return track.position[top, who, 2] + np.where(slope < 0, v**2 / (-2 * np.minimum(slope, -1e-12)), 0.0)


def passage_time(setups, effects, inputs):
    """Time from mark_1_m, or the release, to mark_2_m, depths below the release at start_speed_m_s, or at rest."""
    none = np.zeros(len(setups))
    down = np.array([0.0, 0.0, -1.0])
    way = descent(setups, effects, inputs["mark_2_m"], inputs.get("start_speed_m_s", none)[:, None] * down)
    return way.time_at(inputs["mark_2_m"]) - way.time_at(inputs.get("mark_1_m", none))


def throw_range(setups, effects, inputs):
    """Horizontal distance from the launch at speed_m_s, angle_deg above the horizontal, with a backspin spin_rad_s, to where the
    body is height_m below it; the last three are 0 where they are not given."""
    none = np.zeros(len(setups))
    angle, depth = np.deg2rad(inputs.get("angle_deg", none)), inputs.get("height_m", none)
    velocity = inputs["speed_m_s"][:, None] * np.stack([np.cos(angle), none, np.sin(angle)], axis=1)
    backspin = inputs.get("spin_rad_s", none)[:, None] * np.array([0.0, -1.0, 0.0])  # its upper side turns towards the launch
    way = descent(setups, effects, depth, velocity, backspin)
    times = way.time_at(depth)
    return np.where(np.isfinite(times), way.track.position_at(np.nan_to_num(times)[:, None])[:, 0, 0], np.nan)


def bounce_time(setups, effects, inputs):
    """Time from the release at rest, height_m above where it strikes, to impact number `bounce`, when it is heard.

    nan where there is no such impact: the body floats, or it stays down after one before.
    """
    number = inputs["bounce"].astype(int)
    return impact_times(setups, effects, inputs["height_m"], number.max())[number - 1, np.arange(len(setups))]


def bounce_interval(setups, effects, inputs):
    """Time from impact number `bounce` to the next one, of a fall as in `bounce_time`."""
    number, rows = inputs["bounce"].astype(int), np.arange(len(setups))
    times = impact_times(setups, effects, inputs["height_m"], number.max() + 1)
    return times[number, rows] - times[number - 1, rows]


def impact_times(setups, effects, heights, most):
    """Times from the release at rest to impacts 1 to `most` (most, d); nan where there is no such impact."""
    time, hit = fallen(setups, effects, heights)
    found = [time]
    for _ in range(1, most):
        aloft, hit = thrown_up(setups, effects, rebound(setups, effects, hit))
        found.append(found[-1] + aloft)
    return np.array(found)


def thrown_up(setups, effects, speed):
    """(time [s], velocity (d, 3)) with which bodies thrown up at a speed (d,) [m/s] are back at their height.

    nan where one has no speed, so that it is never up, or does not come down.
    """
    track = risen(setups, effects, speed, lambda track: track.position[-1, :, 2] < 0, BACK)
    top = track.times[np.argmax(track.position[:, :, 2], axis=0)]
    times = crossing(track, lambda position: position[:, 2], begin=top)
    back = (speed > 0) & (track.position[-1, :, 2] < 0)
    return np.where(back, times, np.nan), np.where(back[:, None], velocity_at(track, times), np.nan)


def risen(setups, effects, speed, done, long=UP):
    """The Track of bodies thrown up at a speed (d,) [m/s] until `done` (Track -> booleans (d,)) holds for all; long: how long it
    is tried first.

    A body whose speed is nan never came to be thrown: it goes with the others at no speed.
    """
    speed = np.nan_to_num(speed)
    state = state_of(setups, speed[:, None] * np.array([0.0, 0.0, 1.0]))
    duration = max(long * speed.max() / setups[0].surroundings.gravity, 1e-3)
    for _ in range(6):
        track = fly(state, effects, duration, duration / STEPS)
        if np.all(done(track) | (speed == 0)):
            break
        duration *= 1.7
    return track


def rebound_speed(setups, effects, inputs):
    """Speed after an impact straight down at impact_speed_m_s."""
    return rebound(setups, effects, inputs["impact_speed_m_s"][:, None] * np.array([0.0, 0.0, -1.0]))


def slope_angle(inputs, count):
    """Angle of the slope of each row, (count,) [rad]."""
    angle = np.deg2rad(inputs["angle_deg"]) if "angle_deg" in inputs else np.arctan(inputs.get("slope", np.zeros(count)))
    return np.broadcast_to(angle, (count,))


def rolling(setups, inputs, friction):
    """Which bodies are spheres, let go at rest, that a friction (d,) makes roll without slipping down their slope, boolean (d,).

    A ball rolls where mu >= k/(1 + k) tan(angle), k = I/(m r^2): 2/7 of the slope where it is solid. With less it slips as it
    turns, and goes as what slides.
    """
    ball, at_rest = np.array([setup.body.shape == "sphere" for setup in setups]), inputs.get("speed_m_s", 0.0) == 0
    turn = turns(setups)
    return ball & at_rest & (friction >= turn / (1 + turn) * np.tan(slope_angle(inputs, len(setups))))


def turns(setups):
    """I/(m r^2) of the spheres among bodies as they roll along x, 0 of what does not roll here (d,)."""
    return np.array([turning(setup.body) if setup.body.shape == "sphere" else 0.0 for setup in setups])


def turning(body, axis=1):
    """I/(m r^2) of a round Body that turns about one of its axes as it rolls: as if its mass were larger by that part [-]."""
    rigid = rigid_body(body)
    return rigid.inertia[axis] / (rigid.mass * body.radius**2)


def slide(setups, effects, inputs, way=None):
    """(time [s], distance [m]) until a body stops, or until it has gone `way` (d,) [m], along x down a slope.

    It slides. A sphere let go at rest that grips its slope rolls (`rolling`): its inertia counts 1 + I/(m r^2) times, and its
    load acts on the arm of rolling friction alone. nan where a body does not stop, or stops before it has gone that way.
    """
    count = len(setups)
    angle = slope_angle(inputs, count)
    down = np.stack([np.cos(angle), np.zeros(count), -np.sin(angle)], axis=1)
    normal = np.stack([np.sin(angle), np.zeros(count), np.cos(angle)], axis=1)
    speed = inputs.get("speed_m_s", np.zeros(count)).astype(float)
    state = state_of(setups, speed[:, None] * down)

    def moving_at(v):
        velocity = np.maximum(v, 1e-9)[:, None] * down
        moving = state._replace(twist=np.concatenate([velocity, np.zeros((count, 3))], axis=1))
        return moving, law_at(setups, effects, moving, velocity, normal)

    rolls = rolling(setups, inputs, moving_at(speed)[1].friction) & (way is not None)
    inertia = state.mass * (1 + np.where(rolls, turns(setups), 0.0))

    def slowing(v):
        moving, law = moving_at(v)
        pull = sum(effect.forces(moving, 0.0)[:, :3] for effect in effects)
        load = np.maximum(-np.sum(pull * normal, axis=1), 0.0)
        resistance = np.where(rolls, law.rolling_arm / state.radius, law.friction)
        return (np.sum(pull * down, axis=1) - resistance * load) / inertia

    if way is None:  # the speed is the independent variable: distance = int v dv / -a, time = int dv / -a
        nodes, weights = np.polynomial.legendre.leggauss(48)
        times, distances = np.zeros(count), np.zeros(count)  # the sums keep the nan of a block that does not stop
        for node, weight in zip(0.5 * (nodes + 1), 0.5 * weights, strict=True):
            v = speed * node**2  # dense where the block is slow and friction may vary
            brake = -slowing(v)
            brake = np.where(brake > ENDLESS, brake, np.where(speed > 0, np.nan, 1.0))
            times += weight * 2 * node * speed / brake
            distances += weight * 2 * node * speed * v / brake
        return times, distances
    times, gone, v = np.zeros(count), np.zeros(count), speed.copy()
    pace = np.maximum(np.abs(slowing(v)), 1e-3)
    h = (np.sqrt(speed**2 + 2 * pace * way) - speed) / pace / STEPS
    running, there = np.ones(count, bool), way <= 0
    for _ in range(20 * STEPS):
        a = slowing(v)
        b = slowing(v + h * a / 2)
        step = (v + h * b / 2) * h
        last = running & (gone + step >= way)
        times += np.where(running, np.where(last, h * (way - gone) / np.where(step > 0, step, 1.0), h), 0.0)
        gone, v = np.where(running, gone + step, gone), np.where(running, v + h * b, v)
        there |= last
        running &= ~last & (v > 0)
        if not running.any():
            break
    times += np.where(running, (way - gone) / np.where(running, v, 1.0), 0.0)  # it goes on as it does at the end
    return np.where(there | running, times, np.nan), gone


def stop_distance(setups, effects, inputs):
    """Distance from the launch at speed_m_s to the stop."""
    return slide(setups, effects, inputs)[1]


def slide_time(setups, effects, inputs):
    """Time to slide, or to roll, through distance_m from rest or speed_m_s, or, where no distance is given, to stop."""
    return slide(setups, effects, inputs, inputs.get("distance_m"))[0]


def rest_height(setups, effects, inputs):
    """Height of the centre of a body at rest on its floor."""
    return np.array(
        [
            (setup.surroundings.floor_height or 0.0)
            + setup.margin
            - support(rigid_body(setup.body).shape, np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])).min()
            for setup in setups
        ]
    )


LAWS = {
    "fall_time_s": fall_time,
    "rebound_height_m": rebound_height,
    "stop_distance_m": stop_distance,
    "slide_time_s": slide_time,
    "rest_height_m": rest_height,
    "passage_time_s": passage_time,
    "bounce_time_s": bounce_time,
    "bounce_interval_s": bounce_interval,
    "rebound_speed_m_s": rebound_speed,
    "range_m": throw_range,
}
USES = {  # inputs that an outcome depends on, beside those of ROW_KEYS
    "fall_time_s": ("height_m",),
    "rebound_height_m": ("height_m", "bounce"),
    "stop_distance_m": ("speed_m_s", "slope", "angle_deg"),
    "slide_time_s": ("distance_m", "speed_m_s", "slope", "angle_deg"),
    "rest_height_m": (),
    "passage_time_s": ("start_speed_m_s", "mark_1_m", "mark_2_m"),
    "bounce_time_s": ("height_m", "bounce"),
    "bounce_interval_s": ("height_m", "bounce"),
    "rebound_speed_m_s": ("impact_speed_m_s",),
    "range_m": ("speed_m_s", "angle_deg", "height_m", "spin_rad_s"),
}
