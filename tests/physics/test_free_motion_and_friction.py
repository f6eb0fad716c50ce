"""Section 1.1: free motion and Coulomb friction, |r_T| <= mu r_N, opposite to slip.

free fall       z = g t^2/2                      slide          d = v^2/(2 mu g), straight on
incline         a = g (sin - mu cos), or rest    sphere         slips until v = R w, keeps angular momentum about the floor line
The engine moves with the mean of old and new velocity, so motion under constant forces is exact, not first order.
"""

import numpy as np
import pytest
import small_worlds as sw

import minibullet as mb


def test_case_1_free_fall_is_half_g_t_squared(record_case):
    """Midpoint positions make a parabola exact; 240 additions leave 1e-14 or so, the bound is 1e-12 relative."""
    world = sw.make()
    ball = world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 0))
    world.step(240)
    record_case(1, "free fall, 1 s, relative error of the drop", ball.position[2] / -4.905 - 1, 1e-12, peer="4.2e-3")


def test_case_2_projectile_keeps_its_parabola_and_its_spin(record_case):
    """Isotropic inertia: the spin is constant and the turn is |w| t; rounding only."""
    world = sw.make()
    start, spin = np.array([3.0, 0.5, 4.0]), np.array([1.0, -2.0, 3.0])
    ball = world.add(mb.Sphere(0.1), mass=2.0, position=(0, 0, 0), velocity=start, angular_velocity=spin)
    world.step(240)
    expected = start - (0, 0, 4.905)
    record_case(2, "projectile: place after 1 s", np.abs(ball.position - expected).max(), 1e-12, "m")
    record_case(2, "projectile: spin", np.abs(ball.angular_velocity - spin).max(), 1e-12, "rad/s")
    turn = sw.about(spin / np.linalg.norm(spin), np.linalg.norm(spin))
    record_case(2, "projectile: orientation", sw.turned(ball, turn), 1e-12, "rad")


def test_case_3_sliding_box_stops_after_v_squared_over_2_mu_g(record_case):
    """1.52905 m for 3 m/s and mu = 0.3, the same in every heading: the friction limit is a disc, not a square."""
    distances, target = [], 9.0 / (2 * 0.3 * sw.GRAVITY)
    for heading in np.radians([0.0, 22.5, 45.0]):
        world = sw.make(friction=0.3)
        world.add_plane()
        ahead, left = np.array([np.cos(heading), np.sin(heading), 0]), np.array([-np.sin(heading), np.cos(heading), 0])
        box = world.add(mb.Box(1, 1, 0.5), density=1000.0, position=(0, 0, 0.25), velocity=3 * ahead)
        world.run(1.5)
        distances.append(box.position @ ahead)
        name = f"slide to rest, heading {np.degrees(heading):g} deg"
        record_case(3, f"{name}: relative error", distances[-1] / target - 1, 5e-4, peer="4.0e-3")
        record_case(3, f"{name}: sideways", box.position @ left, 1e-6, "m", peer="1.9e-3 m")
    record_case(3, "slide to rest: spread over the headings", np.ptp(distances), 1e-6, "m", peer="2.9e-4 m")


def slide_down(degrees, friction, seconds):
    """Distance [m] a flat box slides down an incline from rest."""
    incline = sw.Incline(degrees)
    world = incline.world(friction=friction)
    start = 0.25 * incline.normal
    box = world.add(mb.Box(1, 1, 0.5), density=1000.0, position=start, orientation=incline.orientation)
    world.run(seconds)
    return (box.position - start) @ incline.down


LIMIT = np.degrees(np.arctan(0.6))


def test_case_4_box_just_below_the_angle_of_friction_stays(record_case):
    """0.1 degrees below atan(0.6), 4 s: friction holds, no creep; 1e-9 m is rounding over 960 steps with room."""
    record_case(4, "incline 0.1 deg below slip, 4 s", slide_down(LIMIT - 0.1, 0.6, 4.0), 1e-9, "m", peer="1.1e-4 m")


def test_case_5_box_just_above_the_angle_of_friction_slides(record_case):
    """0.1 degrees above: g (sin - mu cos) t^2/2 = 0.15974 m, a difference of nearly equal numbers."""
    angle = np.radians(LIMIT + 0.1)
    expected = 8 * sw.GRAVITY * (np.sin(angle) - 0.6 * np.cos(angle))
    error = slide_down(LIMIT + 0.1, 0.6, 4.0) / expected - 1
    record_case(5, "incline 0.1 deg above slip: relative error", error, 1e-3, peer="1.0e-2")


def test_case_6_box_slides_down_a_steep_incline(record_case):
    """40 degrees, mu = 0.6, 4 s: 14.3745 m."""
    angle = np.radians(40)
    expected = 8 * sw.GRAVITY * (np.sin(angle) - 0.6 * np.cos(angle))
    record_case(6, "steep incline: relative error", slide_down(40, 0.6, 4.0) / expected - 1, 5e-4, peer="1.3e-3")


def thrown_sphere(speed, spin):
    """World and sphere R = 0.5 m on a floor of friction 0.2; spin about y."""
    world = sw.make(friction=0.2)
    world.add_plane()
    ball = world.add(mb.Sphere(0.5), mass=1.0, position=(0, 0, 0.5), velocity=(speed, 0, 0), angular_velocity=(0, spin, 0))
    return world, ball


def test_case_7_thrown_sphere_ends_rolling_with_five_sevenths_of_its_speed(record_case):
    """v = 5/7 v0 from t = 2 v0/(7 mu g) on: angular momentum about the floor line is kept, whatever the friction does."""
    world, ball = thrown_sphere(5.0, 0.0)
    rolling_since = None
    while world.time < 1.5:
        world.step()
        if rolling_since is None and abs(ball.velocity[0] - 0.5 * ball.angular_velocity[1]) < 1e-9:
            rolling_since = world.time
    record_case(7, "slip to roll: relative error of the final speed", ball.velocity[0] / (25 / 7) - 1, 1e-12, peer="6e-15")
    steps = (rolling_since - 10 / (7 * 0.2 * sw.GRAVITY)) * 240
    record_case(7, "slip to roll: moment, in steps from 0.72812 s", steps, 1.0, "steps", peer="0.25 steps")


def test_case_8_backspin_brings_the_sphere_back(record_case):
    """5/7 v0 + 2/7 R w0 = -1.428571 m/s."""
    world, ball = thrown_sphere(2.0, -20.0)
    world.run(2.0)
    record_case(8, "backspin: relative error of the final speed", ball.velocity[0] / (10 / 7 - 20 / 7) - 1, 1e-12, peer="6e-15")


def roll_down(shape, inertia, degrees, friction, radius=0.5, orientation=(1, 0, 0, 0)):
    """Speed [m/s] along the incline and spin [rad/s] after 3 s from rest."""
    incline = sw.Incline(degrees)
    world = incline.world(friction=friction)
    body = world.add(shape, mass=1.0, inertia=inertia, position=radius * incline.normal, orientation=orientation)
    world.run(3.0)
    return body.velocity @ incline.down, body.angular_velocity[1]


def test_case_9_sphere_rolls_down_with_five_sevenths(record_case):
    """a = 5/7 g sin on 20 degrees."""
    speed, _ = roll_down(mb.Sphere(0.5), None, 20, 0.6)
    expected = 15 / 7 * sw.GRAVITY * np.sin(np.radians(20))
    record_case(9, "sphere rolls down: relative error", speed / expected - 1, 1e-12, peer="6e-15")


def test_case_10_sphere_slips_down_where_tan_exceeds_three_and_a_half_mu(record_case):
    """a = g (sin - mu cos), spin 5 mu g cos/(2R) on 45 degrees with mu = 0.2."""
    speed, spin = roll_down(mb.Sphere(0.5), None, 45, 0.2)
    record_case(10, "sphere slips down: speed", speed / (3 * sw.GRAVITY * 0.8 * np.sqrt(0.5)) - 1, 1e-12, peer="9e-15")
    record_case(10, "sphere slips down: spin", spin / (3 * sw.GRAVITY * np.sqrt(0.5)) - 1, 1e-12, peer="9e-15")


@pytest.mark.parametrize(("name", "inertia", "share"), [("cylinder", 0.125, 2 / 3), ("hoop", 0.25, 1 / 2)])
def test_case_11_cylinder_and_hoop_roll_down(record_case, name, inertia, share):
    """a = g sin/(1 + I/(m R^2)). A capsule of radius 0.5 m across the slope touches along a line; its inertia is given."""
    across = sw.about((0, 0, 1), np.pi / 2)
    speed, _ = roll_down(mb.Capsule(0.5, 1.0), (inertia, 0.25, 0.25), 20, 0.6, orientation=across)
    record_case(11, f"{name} rolls down: relative error", speed / (share * 3 * sw.GRAVITY * np.sin(np.radians(20))) - 1, 1e-10)
