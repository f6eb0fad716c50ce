"""Throws of a ball on which a force acts that no library knows, by fourth-order Runge-Kutta in steps of 2 ms."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.fitting import fit_at
from hlcs.estimation.noise_model import Noise
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.simulation.model import Model
from hlcs.simulation.simulator import Simulator

SIGMA, STEP = 0.002, 0.02
TIMES = STEP * np.arange(46)
COUNT = 6


def thrown(force, sigma=SIGMA, seed=1):
    """(problem, fit of gravity alone) of six throws in unlike headings; force: (x, v, t) -> per mass (n, 3)."""
    heading = np.arange(COUNT) + 0.3
    speed = np.array([2.0, 5.0, 3.0, 4.0, 2.5, 4.5])
    v = np.column_stack([speed * np.cos(heading), speed * np.sin(heading), [3.0, 1.0, 4.0, 2.0, 3.5, 0.5]])
    x = np.column_stack([-0.4 * v[:, :2] + [[0.5, 0.2]], [1.5, 4.0, 1.0, 3.0, 2.0, 4.5]])
    generator, h = np.random.default_rng(seed), STEP / 10
    track = [x]

    def slope(x, v, t):
        return force(x, v, t) - np.array([0.0, 0.0, 9.81])

    for k in range(10 * (len(TIMES) - 1)):
        t = k * h
        a = slope(x, v, t)
        b = slope(x + h / 2 * v, v + h / 2 * a, t + h / 2)
        c = slope(x + h / 2 * v + h * h / 4 * a, v + h / 2 * b, t + h / 2)
        d = slope(x + h * v + h * h / 2 * b, v + h * c, t + h)
        x, v = x + h * v + h * h / 6 * (a + b + c), v + h / 6 * (a + 2 * b + 2 * c + d)
        if (k + 1) % 10 == 0:
            track.append(x)
    seen = np.array(track) + sigma * generator.standard_normal((len(TIMES), COUNT, 3))
    body, around, unseen = Body(radius=0.03, mass=0.05), Surroundings(), np.full((len(TIMES), 4), np.nan)
    trials = tuple(Trial(f"throw {k}", f"throw {k}", TIMES, seen[:, k], unseen, {}, body, around) for k in range(COUNT))
    noise = Noise(CorrelatedNoise(SIGMA, 0.0, 0.0, np.zeros((3, 3))), None, STEP, "stated")
    problem = TrajectoryProblem(trials, noise, Simulator(Model(), trials, np.zeros(COUNT)))
    return problem, problem.fit(Model())


@pytest.fixture(scope="session")
def throw():
    return thrown


@pytest.fixture(scope="session")
def magnet():
    """A pull of 0.4 m3/s2 over the square of the distance to (0.5, 0.2, 1.0)."""

    def pull(x, v, t):
        gap = np.array([0.5, 0.2, 1.0]) - x
        return 0.4 * gap / np.linalg.norm(gap, axis=1, keepdims=True) ** 3

    return thrown(pull)


def bounced(force, sigma=SIGMA, seed=1):
    """(problem, gravity and the floor at the true starts) of two balls with sideways speed that bounce with e = 0.8, no friction.

    The moment of an impact is found within a step of 0.1 ms by a straight line: 1e-7 m.
    """
    body, around = Body(radius=0.03, mass=0.05), Surroundings(floor_height=0.0, friction=0.0, restitution=0.8)
    x, v = np.array([[0.0, 0.0, 1.0], [0.5, 0.2, 1.6]]), np.array([[1.0, 0.5, 0.0], [-2.0, 1.0, 1.0]])
    starts = np.hstack([x, v, np.tile([1.0, 0, 0, 0, 0, 0, 0], (2, 1))])
    generator, h, track, times = np.random.default_rng(seed), 1e-4, [x.copy()], 0.01 * np.arange(100)

    def slope(x, v):
        return force(x, v, 0.0) - np.array([0.0, 0.0, 9.81])

    for k in range(100 * (len(times) - 1)):
        middle = v + h / 2 * slope(x, v)
        new = x + h * middle, v + h * slope(x + h / 2 * v, middle)
        hit = (new[0][:, 2] < body.radius) & (new[1][:, 2] < 0)
        new[1][hit, 2] *= -0.8
        new[0][hit, 2] = body.radius + 0.8 * (body.radius - new[0][hit, 2])
        x, v = new
        if (k + 1) % 100 == 0:
            track.append(x.copy())
    seen = np.array(track) + sigma * generator.standard_normal((len(times), 2, 3))
    trials = tuple(
        Trial(f"drop {k}", f"drop {k}", times, seen[:, k], np.full((len(times), 4), np.nan), {}, body, around) for k in range(2)
    )
    noise = Noise(CorrelatedNoise(SIGMA, 0.0, 0.0, np.zeros((3, 3))), None, 0.01, "stated")
    problem = TrajectoryProblem(trials, noise, Simulator(Model(), trials, np.zeros(2), contact=True))
    return problem, fit_at(Model(), starts, problem.linearise(Model(), starts))


@pytest.fixture(scope="session")
def bounce():
    return bounced
