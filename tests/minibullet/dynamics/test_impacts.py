"""Impacts with restitution at their own moment: the moment, the rebound, and what is left to the resting contacts."""

import numpy as np
import pytest

import minibullet as mb
from minibullet.dynamics import impacts


@pytest.mark.parametrize(
    ("gap", "rate", "pull", "expected"),
    [
        (1.0, -2.0, 0.0, 0.5),  # straight on
        (1.0, 0.0, -2.0, 1.0),  # dropped: t = sqrt(2 gap/g)
        (1.0, 1.0, -4.0, 1.0),  # thrown up first: 1 + t - 2 t^2 = 0
        (1.0, 1.0, 0.0, np.inf),  # parting
        (1.0, -1.0, 2.0, np.inf),  # turns back before it arrives
        (0.0, -1.0, 0.0, 0.0),  # touching and closing
        (0.0, 1.0, -4.0, np.inf),  # touching and parting: that it comes back belongs to the next step
        (1.0, -0.1, 0.0, np.inf),  # not within this step
    ],
)
def test_first_touch_is_the_root_of_the_parabola(gap, rate, pull, expected):
    """gap + rate t + pull t^2/2 = 0 by hand, within [0, 2]."""
    assert impacts.first_touch(gap, rate, pull, 0.0, 2.0) == pytest.approx(expected, rel=1e-14)


def drop(restitution, time_step, duration, height=1.0):
    world = mb.World([mb.Gravity(10.0)], mb.Settings(time_step=time_step, restitution=restitution, friction=0.0))
    world.add_plane()
    ball = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 0.1 + height))
    world.run(duration)
    return ball


@pytest.mark.parametrize("time_step", [1 / 60, 1 / 240, 1 / 1000])
def test_a_bounce_in_the_middle_of_a_step_is_exact(time_step):
    """Drop from 1 m with e = 0.8 for 0.6 s: touch at sqrt(0.2) s at sqrt(20) m/s, then a parabola from 0.8 of that. The parabola
    of a step is solved exactly, so any step gives it to rounding."""
    touch, speed = np.sqrt(0.2), 0.8 * np.sqrt(20.0)
    after = time_step * round(0.6 / time_step) - touch
    ball = drop(0.8, time_step, 0.6)
    assert ball.position[2] - 0.1 == pytest.approx(speed * after - 5.0 * after**2, abs=1e-10)
    assert ball.velocity[2] == pytest.approx(speed - 10.0 * after, abs=1e-10)


@pytest.mark.parametrize("late", [1e-4, 0.002, 0.004, 0.006])
def test_a_ball_that_strikes_right_after_a_step_is_not_caught_by_its_end(late):
    """Let fall so that it touches 80 + late steps later, at v = g t; a step ends v late dt above the floor, less than the
    g dt^2/2 = v dt / 160 by which the last velocity of that step would overshoot. It then flies a parabola from 0.8 v. All of it
    is exact, so rounding alone is left."""
    touch = (80 + late) / 240
    speed, after = 10.0 * touch, 120 / 240 - touch
    ball = drop(0.8, 1 / 240, 120 / 240, height=5.0 * touch**2)
    assert ball.position[2] - 0.1 == pytest.approx(0.8 * speed * after - 5.0 * after**2, abs=1e-10)
    assert ball.velocity[2] == pytest.approx(0.8 * speed - 10.0 * after, abs=1e-10)


def test_full_restitution_keeps_the_energy_through_many_bounces():
    """Ten seconds of e = 1: m g h + T is 10 J to 1e-9, whatever part of the step the impacts fall on."""
    ball = drop(1.0, 1 / 240, 10.0)
    assert 10.0 * (ball.position[2] - 0.1) + 0.5 * ball.velocity[2] ** 2 == pytest.approx(10.0, rel=1e-9)


def test_bounces_end_and_the_ball_then_rests():
    """e = 0.5: after the sum of the geometric series (1.34 s) the ball lies still on the floor, at its radius to 1e-9."""
    ball = drop(0.5, 1 / 240, 2.0)
    assert ball.position[2] == pytest.approx(0.1, abs=1e-9) and np.abs(ball.velocity).max() < 1e-9


def test_what_one_body_leaves_to_rest_stays_so_when_another_is_struck_elsewhere():
    """e v = 0.03 m/s is less than g dt, which ends such a rebound within the step, and more than the half of it that ends one
    begun 0.9 dt later, when a body far away strikes: the same digits with it and without."""
    slow = []
    for company in (False, True):
        world = mb.World([mb.Gravity(9.81)], mb.Settings(time_step=1 / 240, restitution=0.5))
        world.add_plane()
        box = world.add(mb.Box(0.2, 0.2, 0.2), mass=1.0, position=(0, 0, 0.1), velocity=(0.1, 0, -0.06))
        if company:
            world.add(mb.Sphere(0.1), mass=1.0, position=(5, 0, 0.1 + 0.9 * 3.0 / 240), velocity=(0, 0, -3.0))
        world.step()
        slow.append(np.concatenate([box.position, box.velocity]))
    assert slow[0][5] == pytest.approx(0.0, abs=1e-9)  # it rests
    np.testing.assert_array_equal(*slow)


def test_one_blow_a_step_is_booked_as_an_impulse():
    """The contact table shows the blow: force times step is m (1 + e) v, and the ledger has no defect beyond rounding."""
    world = mb.World(settings=mb.Settings(restitution=0.5))
    world.add_plane()
    world.add(mb.Sphere(0.1), mass=2.0, position=(0, 0, 0.105), velocity=(0, 0, -2.0))
    world.step()
    assert world.contacts.to_dataframe().normal_force[0] / 240 == pytest.approx(2.0 * 1.5 * 2.0, rel=1e-12)
    work = world.last_step.work
    assert work["contact_normal"] == pytest.approx(0.5 * 2.0 * (1.0 - 4.0), rel=1e-12) and abs(work["defect"]) < 1e-12


def test_what_a_heap_does_it_does_beside_other_bodies_too():
    """A dozen cubes that overlap where they are put strike each other until the impacts of a step are used up. What is left to
    the resting contacts then is a matter of the heap alone, not of forty cubes that fall far away: the same to rounding."""

    def velocities(far):
        generator = np.random.default_rng(7)
        world = mb.World([mb.Gravity()], mb.Settings(restitution=0.3, solver="gauss_seidel", iterations=1000))
        world.add_plane()
        places = [0.11 * np.array([k // 2 % 2, k % 2, 0]) + [0, 0, 0.1 + 0.12 * (k // 4)] for k in range(12)]
        places += [np.array([3.0 + k, 0, 0.2]) for k in range(far)]
        cubes = []
        for k, place in enumerate(places):
            shift = [*0.01 * generator.normal(size=2), 0] if k < 12 else [0, 0, 0]
            turn = mb.rotations.random(generator, 1)[0]
            cubes.append(world.add(mb.Box(0.1, 0.1, 0.1), density=2300.0, position=place + shift, orientation=turn))
        world.step(40)
        return np.array([[*cube.velocity, *cube.angular_velocity] for cube in cubes[:12]])

    np.testing.assert_allclose(velocities(40), velocities(0), atol=1e-9)
