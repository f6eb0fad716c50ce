"""What a force that nobody knows would do to the recordings: their paths, and the response of the observations to any force.

A force per mass a(t) added to a flight moves the body by the double integral of a, less what the initial state takes up. The
white observations, initial states projected out, are therefore linear in a: residual = response a + white noise of variance 1.
The response is kept in its singular vectors, so that the rows of a recording are as many as the motions that a force can cause.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import integrate, interpolate, optimize

from hlcs.data.rigid_body import rigid_body
from hlcs.estimation.least_squares import basis, least_squares, project_out
from hlcs.estimation.whitening import Whitening, colour, whiten
from minibullet import rotations

NODES = 160  # moments of a recording between which a force is a straight line: ten a period at 16 periods a recording
SMALLEST = 1e-3  # singular values kept, relative to the largest: falling as 1/j^2, those of the first thirty half waves
LONG = 12  # samples of a stretch between impacts: double the numbers of its start
FORCE_ABOVE_NOISE = 3.0  # standard deviations by which the rows of an octave stand above noise where they show a force


@dataclass(frozen=True)
class Part:
    """A stretch of a recording without contact: all of it, or what lies between two impacts; its white observations (n,)."""

    group: str  # what is held out together
    begins: float  # when its initial state stands, since the start of the recording [s]
    times: np.ndarray  # of the samples, since the start of the recording (s,) [s]
    position: np.ndarray  # of the model (s, 3) [m]
    orientation: np.ndarray  # (s, 4)
    seen: np.ndarray  # when it was observed, since the start of the recording (n,) [s]
    channel: np.ndarray  # 0-2 position, 3-5 rotation (n,)
    whitening: Whitening
    white: np.ndarray  # residuals, the initial state projected out (n,)
    states: np.ndarray  # changes per unit of each unknown of the initial state (n, unknowns)
    unknown: tuple  # (slot, direction (3,)) each
    nuisance: np.ndarray  # columns of the numbers that the model has already, the initial state projected out (n, p)


@dataclass(frozen=True)
class Flight:
    """A stretch of a recording: where the body was at some moments, and what a force at these does to the observations."""

    part: Part
    times: np.ndarray  # since the start of the recording (g,) [s]
    position: np.ndarray  # (g, 3) [m]
    velocity: np.ndarray  # (g, 3) [m/s]
    spin: np.ndarray  # angular velocity, world frame (g, 3) [rad/s]
    residual: np.ndarray  # white (r,)
    response: np.ndarray  # white change of the observations per unit of force per mass at each moment (r, g, 3)
    nuisance: np.ndarray  # white columns of the numbers that the model has already (r, p)
    rows: np.ndarray  # what each row is made of: orthonormal combinations of the white observations (n, r)
    strength: np.ndarray  # singular values of the response, of the rows (r,)


def double_integral(times, nodes):
    """Displacement at the times (n,) per unit of an acceleration at each node (g,), straight lines between: (n, g)."""
    step = nodes[1] - nodes[0]
    cubes = np.maximum(times[:, None] - nodes, 0.0) ** 3 / (6 * step)  # of the ramps that hat functions are made of
    response = -2 * cubes
    response[:, 1:] += cubes[:, :-1]
    response[:, :-1] += cubes[:, 1:]
    response[:, 0] = times**2 / 2 - cubes[:, 0] + cubes[:, 1]
    return response


def flights_of(problem, fit):
    """The Flight of every stretch without contact around a fit, moved by the force that the residuals themselves show."""
    touching = [problem.contact and trial.surroundings.floor_height is not None for trial in problem.trials]
    parts = [(between_impacts if touches else whole)(problem, fit.linearization, k) for k, touches in enumerate(touching)]
    found = [_flight(part) for of_one in parts for part in of_one]
    found = [flight for flight in found if len(flight.strength)]  # orientations alone, or too few positions, show no force
    variance = force_variance(found) if found else 0.0
    return [_corrected(flight, variance) for flight in found]


def whole(problem, linear, k):
    """All of a recording that touches nothing, [Part]."""
    trial, recording, start = problem.trials[k], problem.recordings[k], problem.simulator.start_time[k]
    white, nuisance = (part[k] for part in linear.projected)
    path, seen = linear.trajectories[k][:2], recording.times - start
    states = linear.state_columns[k], recording.unknown
    return [
        Part(trial.group, 0.0, trial.times - start, *path, seen, recording.channel, recording.whitening, white, *states, nuisance)
    ]


def between_impacts(problem, linear, k):
    """The stretches of a recording, each LONG samples at least, in which neither body nor model is near the floor, [Part].

    Each has an initial state of its own: its place and velocity along the axes that are measured.
    """
    trial, recording, start = problem.trials[k], problem.recordings[k], problem.simulator.start_time[k]
    surroundings, (position, orientation, _) = trial.surroundings, linear.trajectories[k]
    reach = rigid_body(trial.body).shape.bounding_radius + problem.noise.reaches(surroundings.normal)  # noise hides no contact
    free = np.ones(len(position), bool)
    for path in (trial.position, position):
        level = surroundings.above_floor(path)
        step = np.abs(np.diff(level, prepend=level[:1], append=level[-1:]))  # an impact may lie between two samples
        free &= level - np.maximum(step[1:], step[:-1]) > reach
    edges = np.flatnonzero(np.diff(np.concatenate([[0], free, [0]])))
    found = []
    for first, last in edges.reshape(-1, 2):
        inside = (recording.sample >= first) & (recording.sample < last) & (recording.channel < 3)
        if last - first < LONG or not inside.any():
            continue
        channel, seen = recording.channel[inside], recording.times[inside] - start
        whitening, begins = problem.noise.whitening(channel, recording.times[inside]), trial.times[first] - start
        unknown = tuple((slot, np.eye(3)[axis]) for slot in (0, 1) for axis in np.unique(channel))
        states = np.column_stack([direction[channel] * (seen - begins) ** slot for slot, direction in unknown])
        states = whiten(whitening, states)
        raw = np.column_stack([linear.raw[k], colour(recording.whitening, linear.parameter_columns[k])])[inside]
        white = project_out(basis(states), whiten(whitening, raw))
        path = trial.times[first:last] - start, position[first:last], orientation[first:last]
        found.append(Part(trial.group, begins, *path, seen, channel, whitening, white[:, 0], states, unknown, white[:, 1:]))
    return found


def _by_axis(channel, moved, force):
    """Rows `moved` (n, g) of the three axes applied to a force (g, 3), each observation that of its channel: (n,)."""
    return sum(np.where(channel == axis, moved @ force[:, axis], 0.0) for axis in range(3))


def _flight(part):
    nodes = np.linspace(part.begins, part.times[-1], min(2 * len(part.times), NODES))
    curve = interpolate.CubicSpline(part.times, part.position)
    turn = rotations.logarithm(rotations.product(part.orientation[1:], rotations.conjugate(part.orientation[:-1])))
    turn /= np.diff(part.times)[:, None]
    spin = np.column_stack([np.interp(nodes, (part.times[1:] + part.times[:-1]) / 2, axis) for axis in turn.T])
    moved = double_integral(part.seen - part.begins, nodes - part.begins)
    response = np.stack([np.where(part.channel[:, None] == axis, moved, 0.0) for axis in range(3)], axis=2)
    response = project_out(basis(part.states), whiten(part.whitening, response.reshape(len(moved), -1)))
    squares, modes = np.linalg.eigh(response.T @ response)
    keep = squares > SMALLEST**2 * squares[-1]
    strength, modes = np.sqrt(squares[keep]), modes[:, keep]
    rows = response @ modes / strength  # orthonormal: white noise stays white
    reduced = (modes * strength).T.reshape(-1, len(nodes), 3)
    path = nodes, curve(nodes), curve(nodes, 1), spin
    return Flight(part, *path, rows.T @ part.white, reduced, rows.T @ part.nuisance, rows, strength)


def force_variance(flights):
    """Variance of a force per mass without memory that makes the residuals most likely [(m/s2)^2]; 0 where there is none."""
    squares = np.concatenate([flight.residual**2 for flight in flights])
    gains = np.concatenate([flight.strength**2 for flight in flights])

    def cost(logarithm):
        variance = 1 + gains * np.exp(logarithm)
        return float(np.sum(squares / variance + np.log(variance)))

    largest = np.log(gains.max())
    best = optimize.minimize_scalar(cost, bounds=(-largest - 10, -largest + 25), method="bounded").x
    return float(np.exp(best)) if cost(best) < squares.sum() else 0.0


def rows_with_force(flights):
    """The rows of all flights, one after the other, of those octaves of strength in which they stand above noise: boolean.

    Singular values fall with the frequency of the motion, so an octave of them is a band of frequencies.
    """
    strength = np.concatenate([flight.strength for flight in flights])
    octave = np.floor(np.log2(strength.max() / strength)).astype(int)
    count = np.bincount(octave)
    excess = np.bincount(octave, np.concatenate([flight.residual**2 for flight in flights])) - count
    return (excess > FORCE_ABOVE_NOISE * np.sqrt(2 * count))[octave]


def _corrected(flight, variance):
    """The flight moved by what the likeliest force does to it, its start included."""
    part, since = flight.part, flight.times - flight.part.begins
    force = np.einsum("rga,r->ga", flight.response, variance / (1 + variance * flight.strength**2) * flight.residual)
    seen = whiten(part.whitening, _by_axis(part.channel, double_integral(part.seen - part.begins, since), force))
    moves = least_squares(part.states, part.white - seen).estimate if part.unknown else ()
    position, velocity = double_integral(since, since) @ force, integrate.cumulative_trapezoid(force, since, axis=0, initial=0.0)
    for (slot, direction), move in zip(part.unknown, moves, strict=True):
        if slot < 2:
            position = position + np.multiply.outer(since**slot, move * direction)
            velocity = velocity + slot * move * direction
    return replace(flight, position=flight.position + position, velocity=flight.velocity + velocity)
