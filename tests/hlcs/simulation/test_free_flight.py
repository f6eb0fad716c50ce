"""Free flight against closed forms."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.simulation.decay import Decay
from hlcs.simulation.free_flight import alike, fly, fly_each, some_of
from hlcs.simulation.model import Model
from minibullet.bodies import Bodies
from minibullet.effects import AddedMass, Effect, Gravity, LinearDrag, QuadraticDrag, SphereDrag

G = 9.81


@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0), (0.02, 0.0, 0.0), (1.0, 0.5, -1.0)])
@pytest.mark.parametrize("step", [1 / 15, 1.0])
@pytest.mark.parametrize(
    ("radius", "effect"),
    [
        (5e-4, QuadraticDrag(2.5, 1000.0)),  # k V = 600 1/s
        (1e-4, QuadraticDrag(50.0, 1255.0)),  # k V = 8,000 1/s: no such body, but a fit may ask for it
        (5e-4, SphereDrag(1e-3, 1000.0)),  # a bead in water
        (1e-3, SphereDrag(1e-5, 1000.0)),  # of a hundredth of its viscosity: Reynolds numbers of 40,000
    ],
)
def test_a_drag_that_answers_within_a_step_is_flown_in_few_steps(effect, radius, step, start):
    """A glass bead falls in a liquid for ten seconds, from rest or thrown, beside LSODA at 1e-10: to 0.02 mm, in 100 steps more
    than a stone takes."""
    one, volume = np.ones(1), 4 / 3 * np.pi * radius**3
    twist, upright = np.array([[*start, 0, 0, 0]]), np.array([[1.0, 0, 0, 0]])
    bodies = Bodies(
        np.zeros((1, 3)),
        upright,
        twist,
        2500 * volume * one,
        np.ones((1, 3)),
        volume * one,
        np.pi * radius**2 * one,
        radius * one,
    )

    def rate(_, state):
        moving = bodies._replace(twist=np.array([[*state[3:], 0, 0, 0]]))
        return *state[3:], *(effect.forces(moving, 0.0)[0, :3] / bodies.mass[0] - np.array([0, 0, G]))

    track = fly(bodies, (Gravity(G), effect), 10.0, step)
    exact = solve_ivp(rate, (0.0, track.times[-1]), (0.0, 0.0, 0.0, *start), "LSODA", track.times, rtol=1e-10, atol=1e-14).y
    assert np.abs(track.position[:, 0] - exact[:3].T).max() < 2e-5 and len(track.times) < 10 / step + 100


def test_a_bead_goes_with_the_stream_and_sinks_in_it():
    """In water that streams at 2 m/s sideways: v = (2, 0, -sqrt(g/k)) in the end."""
    around = Surroundings(fluid_density=1000.0)
    body = Body(shape="sphere", radius=5e-4, mass=2.6e-6)
    model = Model(fixed=({"name": "quadratic_drag", "drag_coefficient": 2.5}, {"name": "uniform_flow", "velocity_x": 2.0}))
    times = np.linspace(0.0, 5.0, 11)
    bead = Trial("bead.csv", "1", times, np.zeros((11, 3)), np.full((11, 4), np.nan), {}, body, around)
    position, _ = model.run(bead, np.array([0, 0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0]), times)
    per_metre = 2.5 * 1000 * np.pi * 5e-4**2 / (2 * 2.6e-6)
    np.testing.assert_allclose(np.diff(position, axis=0)[-1] / 0.5, (2.0, 0.0, -np.sqrt(G / per_metre)), atol=1e-6)


def test_a_drag_that_does_not_answer_within_a_step_shortens_none():
    """Balls thrown into water at up to 0.9 m/s, k = 10 1/m: h |da/dv| = 2 k v h is 0.6 at most, in every heading."""
    count, one = 400, np.ones(400)
    velocity = np.random.default_rng(1).standard_normal((count, 3))
    velocity *= (0.9 * np.linspace(0.0, 1.0, count) / np.linalg.norm(velocity, axis=1))[:, None]
    twist, upright = np.hstack([velocity, np.zeros((count, 3))]), np.tile([1.0, 0, 0, 0], (count, 1))
    area = np.pi * 0.01**2
    mass = 0.5 * 1000 * 0.45 * area / 10
    bodies = Bodies(np.zeros((count, 3)), upright, twist, mass * one, np.ones((count, 3)), one, area * one, 0.01 * one)
    track = fly(bodies, (Gravity(1.0), QuadraticDrag(0.45, 1000.0)), 1.2, 1 / 30)
    assert np.diff(track.times) == pytest.approx(1 / 30)


def test_a_drag_as_strong_as_an_impact_is_none():
    """A sheet thrown at 13 m/s, k = 1.7 1/m, is slowed by 290 m/s2: x = ln(1 + k v t)/k between the nodes as well as on them."""
    k, speed, one = 1.7, 13.0, np.ones(1)
    twist = np.array([[speed, 0.0, 0, 0, 0, 0]])
    bodies = Bodies(np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), twist, one, np.ones((1, 3)), one, one, one)
    times = np.linspace(0.0, 0.3, 301)[None]
    x = fly(bodies, (QuadraticDrag(2 * k, 1.0),), 0.3, 1 / 120).observe(times)[0][0, :, 0]
    assert np.abs(x - np.log1p(k * speed * times[0]) / k).max() < 2e-5  # a cubic over a step: h^4/384 of the fourth derivative


@pytest.mark.parametrize("rate", [0.0, 500.0])
def test_a_longer_flight_is_the_shorter_one_gone_on_with(rate):
    """To the last bit: where nodes followed the duration two predictions differed by more than their models."""
    one = np.ones(1)
    bodies = Bodies(
        np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.array([[2.0, 0, 1, 0, 0, 0]]), one, np.ones((1, 3)), one, one, one
    )
    *short, long = (fly(bodies, (Gravity(9.81), LinearDrag(rate)), duration, 1 / 30) for duration in (0.001, 0.91, 1.37))
    for track in short:
        for few, many in zip(track, long, strict=True):
            assert np.array_equal(few, many[: len(few)])


@pytest.mark.parametrize("rate", [0.1, 10.0, 1e3, 1e5])
def test_a_drag_in_proportion_to_speed_is_exact_however_stiff(rate):
    """v = g / k (1 - e^-kt) + v0 e^-kt and its integral, in steps of 1/30 s: at the nodes to the last digits."""
    start, one = np.array([2.0, 0.0, 1.0]), np.ones(1)
    twist, upright = np.array([[*start, 0, 0, 0]]), np.array([[1.0, 0, 0, 0]])
    bodies = Bodies(np.zeros((1, 3)), upright, twist, one, np.ones((1, 3)), one, one, one)
    track = fly(bodies, (Gravity(9.81), LinearDrag(rate)), 1.0, 1 / 30)
    fall, t = np.array([0.0, 0.0, -9.81 / rate]), track.times[:, None]
    left = -np.expm1(-rate * t) / rate
    np.testing.assert_allclose(track.velocity[:, 0], fall + (start - fall) * np.exp(-rate * t), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(track.position[:, 0], bodies.position[0] + fall * t + (start - fall) * left, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize(("radius", "eta"), [(3e-4, 1.0), (3e-4, 0.12), (2e-3, 0.12), (1e-2, 0.8)])
def test_a_sphere_sinks_by_its_drag_in_viscous_flow_however_stiff(radius, eta):
    """Steel thrown into oil at 2 m/s, beside LSODA at 1e-10. Reynolds numbers of 1 to 58 at first; rates of 4.6 to 6,400 /s."""
    oil, steel, start = 870.0, 7800.0, -2.0
    volume = 4 / 3 * np.pi * radius**3
    one = np.ones(1)
    bodies = Bodies(
        np.zeros((1, 3)),
        np.array([[1.0, 0, 0, 0]]),
        np.array([[0.0, 0.0, start, 0, 0, 0]]),
        steel * volume * one,
        np.ones((1, 3)),
        volume * one,
        np.pi * radius**2 * one,
        radius * one,
    )

    def rate(_, state):
        reynolds = max(2 * radius * oil * abs(state[1]) / eta, 1e-12)
        drag = 6 * np.pi * eta * radius * (1 + 0.15 * reynolds**0.687) * state[1]
        return state[1], -9.81 - drag / (steel * volume)

    track = fly(bodies, (Gravity(9.81), SphereDrag(eta, oil)), 0.5, 1 / 30)
    exact = solve_ivp(rate, (0.0, track.times[-1]), (0.0, start), "LSODA", track.times, rtol=1e-10, atol=1e-14).y
    np.testing.assert_allclose(track.position[:, 0, 2], exact[0], rtol=1e-3, atol=1e-4)  # a tenth of what a camera sees


def test_functions_of_a_decay_agree_with_their_series():
    """phi_j(z) = sum of z^i / (i + j)!, near zero and where the recursion takes over, and phi_1 = (e^z - 1) / z far away."""
    z = -np.array([[0.0], [1e-9], [0.1], [0.5], [1.99], [2.01], [5.0]])
    series = [sum(z**i / math.factorial(i + j) for i in range(60)) for j in range(5)]
    for found, expected in zip(Decay.over(z), series, strict=True):
        np.testing.assert_allclose(
            found, expected, rtol=1e-12
        )  # at z = -5 the terms of the series reach 26: it loses three digits
    assert Decay.over(np.array([[-1e5]])).one[0, 0] == pytest.approx(1e-5, rel=1e-12)


def test_bodies_under_other_effects_fly_beside_each_other_as_alone():
    """Gravity and the added mass of all, a drag of some, one of each form, a heavier plate: to rounding; equal effects as one."""
    rod = np.diag([4.0, 1.0, 1.0, 0.0, 0.0, 0.0]) * 0.002
    air, water = (Gravity(9.81), AddedMass(0.5, 1.2)), (Gravity(9.81), AddedMass(0.5, 1.2), LinearDrag(0.4))

    @dataclass(frozen=True)
    class Plate(Effect):
        def added_mass(self, bodies):
            return np.tile(rod, (len(bodies.mass), 1, 1))

    mixed = [air, water, (*air, QuadraticDrag(0.5, 1.2)), water, (*air, SphereDrag(1e-3, 1.2)), (Gravity(9.81), Plate())]
    count = len(mixed)
    one, twist = np.ones(count), np.tile([3.0, 1.0, 2.0, 4.0, -3.0, 2.0], (count, 1))
    inertia = np.tile([1e-6, 2e-6, 3e-6], (count, 1))
    bodies = Bodies(
        np.zeros((count, 3)), np.tile([1.0, 0, 0, 0], (count, 1)), twist, 0.003 * one, inertia, 4e-6 * one, 3e-4 * one, 0.01 * one
    )
    beside = fly_each(bodies, mixed, 0.7, 1 / 60)
    for place, effects in enumerate(mixed):
        alone = fly(some_of(bodies, [place]), effects, 0.7, 1 / 60)
        for mine, all_of_them in zip(alone[1:5], beside[1:5], strict=True):
            np.testing.assert_allclose(all_of_them[:, place], mine[:, 0], rtol=1e-12, atol=1e-12)
    ends = beside.position[-1]
    assert np.array_equal(ends[1], ends[3]) and len({tuple(end) for end in ends.round(4)}) == 5
    assert [rows for _, rows in alike(mixed)][0] == slice(0, 1) and alike([air] * 3) == [(air, slice(0, 3))]
