"""What a force that nobody knows would do to the recordings: their paths, and the response of the observations to any force.

A force per mass a(t) added to a flight moves the body by the double integral of a, less what the initial state takes up. The
white observations, initial states projected out, are therefore linear in a: residual = response a + white noise of variance 1.
The response is kept in its singular vectors, so that the rows of a recording are as many as the motions that a force can cause.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from hlcs.estimation.least_squares import least_squares, project_out
from hlcs.estimation.whitening import whiten
from minibullet import rotations

NODES = 160  # moments of a recording between which a force is a straight line: ten a period at 16 periods a recording
SMALLEST = 1e-3  # singular values kept, relative to the largest: falling as 1/j^2, those of the first thirty half waves
CLEAR = 3.0  # standard deviations by which the rows of an octave stand above noise where they show a force


@dataclass(frozen=True)
class Flight:
    """One recording: where the body was at some moments, and what a force at these moments does to the observations."""

    group: str  # what is held out together
    times: np.ndarray  # since the start (g,) [s]
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
    """The Flight of every recording around a fit, corrected by the force that the residuals themselves show."""
    found = [_flight(problem, fit, k) for k in range(len(problem.trials))]
    variance = force_variance(found)
    return [_corrected(problem, fit, k, flight, variance) for k, flight in enumerate(found)]


def _clock(problem, k):
    """Times of the observations of a recording since its start (n,) [s]."""
    return problem.recordings[k].times - problem.simulator.start_time[k]


def _by_axis(channel, moved, force):
    """Rows `moved` (n, g) of the three axes applied to a force (g, 3), each observation that of its channel: (n,)."""
    return sum(np.where(channel == axis, moved @ force[:, axis], 0.0) for axis in range(3))


def _flight(problem, fit, k):
    trial, recording, linear = problem.trials[k], problem.recordings[k], fit.linearization
    clock = trial.times - problem.simulator.start_time[k]
    nodes = np.linspace(0.0, clock[-1], min(2 * len(clock), NODES))
    position, orientation = linear.trajectories[k]
    curve = CubicSpline(clock, position)
    turn = rotations.logarithm(rotations.product(orientation[1:], rotations.conjugate(orientation[:-1])))
    turn /= np.diff(clock)[:, None]
    spin = np.column_stack([np.interp(nodes, (clock[1:] + clock[:-1]) / 2, axis) for axis in turn.T])
    moved = double_integral(_clock(problem, k), nodes)
    response = np.stack([np.where(recording.channel[:, None] == axis, moved, 0.0) for axis in range(3)], axis=2)
    response = project_out(linear.state_bases[k], whiten(recording.whitening, response.reshape(len(moved), -1)))
    squares, modes = np.linalg.eigh(response.T @ response)
    keep = squares > SMALLEST**2 * squares[-1]
    strength, modes = np.sqrt(squares[keep]), modes[:, keep]
    rows = response @ modes / strength  # orthonormal: white noise stays white
    residual, nuisance = (rows.T @ part[k] for part in linear.projected)
    reduced = (modes * strength).T.reshape(-1, len(nodes), 3)
    return Flight(trial.group, nodes, curve(nodes), curve(nodes, 1), spin, residual, reduced, nuisance, rows, strength)


def force_variance(flights):
    """Variance of a force per mass without memory that makes the residuals most likely [(m/s2)^2]; 0 where there is none."""
    squares = np.concatenate([flight.residual**2 for flight in flights])
    gains = np.concatenate([flight.strength**2 for flight in flights])

    def cost(logarithm):
        variance = 1 + gains * np.exp(logarithm)
        return float(np.sum(squares / variance + np.log(variance)))

    largest = np.log(gains.max())
    best = minimize_scalar(cost, bounds=(-largest - 10, -largest + 25), method="bounded").x
    return float(np.exp(best)) if cost(best) < squares.sum() else 0.0


def rows_with_force(flights):
    """The rows of all flights, one after the other, of those octaves of strength in which they stand above noise: boolean.

    Singular values fall with the frequency of the motion, so an octave of them is a band of frequencies.
    """
    strength = np.concatenate([flight.strength for flight in flights])
    octave = np.floor(np.log2(strength.max() / strength)).astype(int)
    count = np.bincount(octave)
    excess = np.bincount(octave, np.concatenate([flight.residual**2 for flight in flights])) - count
    return (excess > CLEAR * np.sqrt(2 * count))[octave]


def _corrected(problem, fit, k, flight, variance):
    """The path moved by what the likeliest force does to it, its start included."""
    recording, linear, nodes = problem.recordings[k], fit.linearization, flight.times
    force = np.einsum("rga,r->ga", flight.response, variance / (1 + variance * flight.strength**2) * flight.residual)
    seen = whiten(recording.whitening, _by_axis(recording.channel, double_integral(_clock(problem, k), nodes), force))
    moves = least_squares(linear.state_columns[k], linear.white[k] - seen).estimate if recording.unknown else ()
    position, velocity = double_integral(nodes, nodes) @ force, cumulative_trapezoid(force, nodes, axis=0, initial=0.0)
    for (slot, direction), move in zip(recording.unknown, moves, strict=True):
        if slot < 2:
            position = position + np.multiply.outer(nodes**slot, move * direction)
            velocity = velocity + slot * move * direction
    return replace(flight, position=flight.position + position, velocity=flight.velocity + velocity)
