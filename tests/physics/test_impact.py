"""Section 1.2: impact. Newton's law u_N+ = -e u_N- with Coulomb friction at the same moment.

rebounds        peak n is e^(2n) h, over after sqrt(2h/g) (1 + e)/(1 - e)
sphere, oblique sticks if mu (1 + e) v_n >= 2/7 v_t:  v_t' = 5/7 v_t;  else slides:  v_t' = v_t - mu (1 + e) v_n
two spheres     relative velocity -e, momentum kept
"""

import numpy as np
import pytest
import small_worlds as sw

import minibullet as mb
from minibullet import effects


def rebound_peaks(restitution, time_step, count):
    """Heights [m] of the first peaks of a sphere dropped with a gap of 1 m; from speed and height in flight, so not sampled."""
    world = sw.make(time_step=time_step, restitution=restitution)
    world.add_plane()
    ball = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 1.1))
    peaks, rising = [], False
    while len(peaks) < count and world.time < 6.0:
        world.step()
        up = ball.velocity[2] > 0
        if rising and not up:
            peaks.append(ball.position[2] - 0.1 + ball.velocity[2] ** 2 / (2 * sw.GRAVITY))
        rising = up
    return np.array(peaks)


@pytest.mark.parametrize(
    ("restitution", "count", "peer"), [(1.0, 5, "4 % and -15 %"), (0.8, 3, "4.7 % and 17 %"), (0.5, 2, "6.4 %")]
)
def test_case_12_every_rebound_reaches_e_squared_of_the_last(record_case, restitution, count, peer):
    """0.5 % per bounce at 1/240 s, and the error falls with the step (or is rounding, 1e-9, from the start)."""
    errors = []
    for time_step in (1 / 240, 1 / 480, 1 / 960):
        peaks = rebound_peaks(restitution, time_step, count)
        expected = restitution ** (2 * np.arange(1, count + 1))
        assert len(peaks) == count
        errors.append(np.max(np.abs((peaks / expected) ** (1 / np.arange(1, count + 1)) - 1)))
    record_case(12, f"rebound heights, e = {restitution:g}: worst relative error per bounce", errors[0], 5e-3, peer=peer)
    falls = max(errors) < 1e-9 or errors[2] < errors[1] < errors[0]
    record_case(12, f"rebound heights, e = {restitution:g}: the error falls with the step", falls, claim="falls", peer="grows")


def test_case_13_bouncing_ends_after_infinitely_many_impacts(record_case):
    """e = 0.5 from 1 m: 1.3546 s. From there on the ball lies still; 1 % is 3 steps."""
    world = sw.make(restitution=0.5)
    world.add_plane()
    ball = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 1.1))
    last_motion = 0.0
    while world.time < 2.0:
        world.step()
        if abs(ball.velocity[2]) > 1e-9:
            last_motion = world.time
    expected = 3 * np.sqrt(2 / sw.GRAVITY)
    record_case(13, "end of bouncing: relative error of the time", last_motion / expected - 1, 1e-2, peer="stops early")


def third_peak_in_drag(drop, per_metre, restitution, time_step):
    """Height [m] of the third peak of a sphere dropped in drag k v^2, k per metre; from speed and height in flight."""
    drag = mb.effects.QuadraticDrag(drag_per_metre=per_metre)
    world = sw.make(time_step=time_step, restitution=restitution, effects=(drag,))
    world.add_plane()
    ball = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 0.1 + drop))
    peaks, rising = [], False
    while len(peaks) < 3:
        world.step()
        up = ball.velocity[2] > 0
        if rising and not up:
            rise = np.log1p(per_metre * ball.velocity[2] ** 2 / sw.GRAVITY) / (2 * per_metre)
            peaks.append(ball.position[2] - 0.1 + rise)
        rising = up
    return peaks[-1]


def test_a_rebound_in_drag_is_braked_the_other_way_from_the_moment_of_the_impact():
    """Falling h in drag k v^2 and rebounding with e reaches ln(1 + e^2 (1 - exp(-2 k h)))/(2 k).

    The error of a step is of first order and smooth, so that two steps extrapolate to none (L. F. Richardson, 1911): 1e-4 of the
    height is the second order at 1/240 s. With drag at the speed before the impact it leaps by 7e-3 with the drop.
    """
    k, restitution = 0.2, 0.9
    for drop in np.linspace(0.70, 0.80, 6):
        expected = drop
        for _ in range(3):
            expected = np.log1p(restitution**2 * -np.expm1(-2 * k * expected)) / (2 * k)
        coarse, fine = (third_peak_in_drag(drop, k, restitution, dt) for dt in (1 / 240, 1 / 480))
        assert 2 * fine - coarse == pytest.approx(expected, rel=1e-4)


def head_on(mass, other_mass, speed, restitution):
    """Two spheres meet head-on without gravity -> their bodies afterwards."""
    world = sw.make(gravity=0, restitution=restitution)
    first = world.add(mb.Sphere(0.1), mass=mass, position=(-0.15, 0, 0), velocity=(speed, 0, 0))
    second = world.add(mb.Sphere(0.1), mass=other_mass, position=(0.15, 0, 0))
    world.run(0.3 / speed)
    return first, second


def test_case_14_unequal_spheres_meet_head_on(record_case):
    """m = 1 at 2 m/s against m = 3 at rest, e = 1: -1 and +1 m/s; energy and momentum are kept."""
    first, second = head_on(1.0, 3.0, 2.0, 1.0)
    record_case(
        14,
        "head-on, unequal: speeds",
        max(abs(first.velocity[0] + 1), abs(second.velocity[0] - 1)),
        1e-12,
        "m/s",
        peer="0.12 m/s",
    )
    energy = 0.5 * first.velocity @ first.velocity + 1.5 * second.velocity @ second.velocity
    record_case(14, "head-on, unequal: energy", energy / 2 - 1, 1e-12, peer="12 %")
    record_case(14, "head-on, unequal: momentum", first.velocity[0] + 3 * second.velocity[0] - 2, 1e-12, "kg m/s")


def oblique(radius, velocity, spin, friction, restitution):
    """Sphere thrown on a floor without gravity -> (v_x, v_z, spin about y) after the impact."""
    time_step = min(1 / 240, 0.2 * radius / abs(velocity[1]))  # a few steps of approach
    world = sw.make(gravity=0, friction=friction, restitution=restitution, time_step=time_step)
    world.add_plane()
    gap = 0.5 * radius
    ball = world.add(
        mb.Sphere(radius),
        mass=1.0,
        position=(0, 0, radius + gap),
        velocity=(velocity[0], 0, -velocity[1]),
        angular_velocity=(0, spin, 0),
    )
    world.run(2 * gap / velocity[1])
    return ball.velocity[0], ball.velocity[2], ball.angular_velocity[1]


def test_case_15_oblique_impact_that_sticks_keeps_five_sevenths(record_case):
    """v_t = 1, v_n = 3, mu = 0.3, e = 0.9: the contact comes to rest, 5/7 v_t."""
    along, up, _ = oblique(0.1, (1.0, 3.0), 0.0, 0.3, 0.9)
    record_case(15, "oblique impact, stick: tangential speed", along - 5 / 7, 1e-12, "m/s", peer="1e-16")
    record_case(15, "oblique impact, stick: rebound", up - 2.7, 1e-12, "m/s")


def test_case_16_oblique_impact_that_slides_loses_mu_times_the_normal_blow(record_case):
    """v_t = 10, v_n = 3, mu = 0.1, e = 0.5: 9.55 m/s and 11.25 rad/s."""
    along, _, spin = oblique(0.1, (10.0, 3.0), 0.0, 0.1, 0.5)
    record_case(16, "oblique impact, slide: tangential speed", along - 9.55, 1e-9, "m/s", peer="2.5e-5")
    record_case(16, "oblique impact, slide: spin", spin - 11.25, 1e-9, "rad/s")


@pytest.mark.parametrize("degrees", [10, 20, 30, 35, 40, 50, 60, 70])
def test_case_17_oblique_impact_by_angle_follows_sticking_or_sliding(record_case, degrees):
    """R = 2.5 mm, 3.9 m/s, mu = 0.092, e = 0.98: v_t'/v_t = max(1 - mu (1 + e)/tan, 5/7). Elastic micro-slip is out of reach."""
    angle = np.radians(degrees)
    along, _, _ = oblique(0.0025, (3.9 * np.sin(angle), 3.9 * np.cos(angle)), 0.0, 0.092, 0.98)
    expected = max(1 - 0.092 * 1.98 / np.tan(angle), 5 / 7)
    record_case(17, f"oblique impact at {degrees} deg from the normal", along / (3.9 * np.sin(angle)) - expected, 1e-9)


def test_case_18_spin_becomes_speed_on_impact(record_case):
    """v_n = 0.2, mu = 0.4, e = 0.5, w = 22.86: v_t' = mu (1 + e) v_n = 0.12 m/s and 19.86 rad/s."""
    along, _, spin = oblique(0.1, (0.0, 0.2), 22.86, 0.4, 0.5)
    record_case(18, "spin impact: tangential speed", along - 0.12, 1e-9, "m/s")
    record_case(18, "spin impact: spin", spin - 19.86, 1e-9, "rad/s")


def test_case_19_counter_spinning_spheres_keep_their_spin(record_case):
    """Their surfaces move alike where they meet: nothing slips, so friction does nothing."""
    world = sw.make(gravity=0, friction=0.4, restitution=0.5)
    balls = [
        world.add(
            mb.Sphere(0.1),
            mass=1.0,
            position=(0.11 * side, 0, 0),
            velocity=(-0.1 * side, 0, 0),
            angular_velocity=(0, 0, -22.86 * side),
        )
        for side in (-1, 1)
    ]
    world.run(0.3)
    assert balls[0].velocity[0] < 0 < balls[1].velocity[0]
    error = max(abs(balls[0].angular_velocity[2] - 22.86), abs(balls[1].angular_velocity[2] + 22.86))
    record_case(19, "counter-spinning spheres: spin", error, 1e-12, "rad/s", peer="LAMMPS asks 1e-8")


@pytest.mark.parametrize("restitution", [0.2, 0.8, 1.0])
def test_case_20_two_spheres_part_with_e_times_the_speed(record_case, restitution):
    """Relative velocity after = e times before."""
    first, second = head_on(1.0, 1.0, 1.0, restitution)
    record_case(20, f"two spheres, e = {restitution:g}", second.velocity[0] - first.velocity[0] - restitution, 1e-12, "m/s")


def test_case_21_cradle_passes_the_speed_on_to_the_last_ball(record_case):
    """Five balls 1 mm apart, e = 1: one impact after another, so (0, 0, 0, 0, 1) is Newton's law ball by ball."""
    world = sw.make(gravity=0, restitution=1.0, time_step=1e-3)
    balls = [world.add(mb.Sphere(0.1), mass=1.0, position=(0.201 * i, 0, 0), velocity=(float(i == 0), 0, 0)) for i in range(5)]
    world.run(0.2)
    speeds = np.array([ball.velocity[0] for ball in balls])
    record_case(21, "Newton's cradle: energy", speeds @ speeds - 1, 1e-9, peer="7.5 % (dt 1e-3)")
    record_case(21, "Newton's cradle: speeds", np.abs(speeds - (0, 0, 0, 0, 1)).max(), 1e-9, "m/s", peer="0.04 (dt 1e-3)")


@pytest.mark.parametrize("height", [0.02, 0.2, 1.0])
def test_a_restitution_that_depends_on_speed_is_that_of_the_moment_of_impact(height):
    """v' = e_1 v^(1 - k), wherever in the step of 1/240 s the ball strikes; to the rounding of some hundred steps."""
    for share in np.linspace(0.0, 1.0, 7):
        gap = height * (1 + 0.1 * share)
        world = sw.make(restitution=0.75, effects=[effects.VelocityDependentRestitution(exponent=0.5)])
        world.add_plane()
        ball = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, gap + 0.1))
        while ball.velocity[2] <= 0:
            world.step()
        speed = np.sqrt(2 * sw.GRAVITY * gap)
        found = np.sqrt(ball.velocity[2] ** 2 + 2 * sw.GRAVITY * (ball.position[2] - 0.1))
        assert found == pytest.approx(min(0.75 * speed**-0.5, 1.0) * speed, rel=1e-9)
