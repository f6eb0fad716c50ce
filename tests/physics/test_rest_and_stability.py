"""Section 1.4, thresholds: friction and balance that hold on one side of a limit and fail on the other.

3 cylinders  mu = tan 15 deg         4 spheres  mu = tan(35.264 deg/2)     ladder  tan = (1 - mu^2)/(2 mu)
overhang     half the length         incline    tan = b/h                  arch    t/R = 0.107 (linear programming)
Each test looks at both sides of its limit.
"""

import arch
import numpy as np
import pytest
import small_worlds as sw

import minibullet as mb


def record_threshold(record_case, case, what, holds, fails, sides, peer="–"):
    """Both sides of a limit in one row each: `holds` and `fails` are the distances moved [m] or turned [rad]."""
    record_case(case, f"{what}: {sides[0]} stands", holds, 1e-3, peer=peer)
    record_case(case, f"{what}: {sides[1]} falls", fails > 0.05, claim="falls", peer=peer)


def cylinder_pyramid(friction):
    """Three cylinders R = 0.5 m side by side and on top, parallel to y -> how far the top one moves in 3 s [m]."""
    world = sw.make(friction=friction)
    world.add_plane()
    across = sw.about((0, 0, 1), np.pi / 2)
    inertia = (0.125, 0.5, 0.5)  # of 1 kg about the axis: m R^2/2
    for x, z in ((-0.5, 0.5), (0.5, 0.5), (0.0, 0.5 + np.sqrt(0.75))):
        top = world.add(mb.Capsule(0.5, 1.0), mass=1.0, inertia=inertia, position=(x, 0, z), orientation=across)
    start = top.position.copy()
    world.run(3.0)
    return np.linalg.norm(top.position - start)


def test_case_29_pyramid_of_three_cylinders_stands_on_friction_above_tan_15_degrees(record_case):
    """mu = 0.26795: each lower cylinder is held by two contacts whose forces must meet on its rim."""
    limit = np.tan(np.radians(15))
    record_threshold(
        record_case,
        29,
        "3 cylinders",
        cylinder_pyramid(1.01 * limit),
        cylinder_pyramid(0.99 * limit),
        ("mu + 1 %", "mu - 1 %"),
        "right at 0.28 and 0.255, sinks 1.6 mm",
    )


def sphere_pyramid(friction):
    """Three spheres R = 0.5 m in a triangle and one on top -> how far the top one moves in 3 s [m]."""
    world = sw.make(friction=friction)
    world.add_plane()
    angle = 2 * np.pi * np.arange(3) / 3
    for x, y in np.column_stack([np.cos(angle), np.sin(angle)]) / np.sqrt(3):
        world.add(mb.Sphere(0.5), mass=1.0, position=(x, y, 0.5))
    top = world.add(mb.Sphere(0.5), mass=1.0, position=(0, 0, 0.5 + np.sqrt(2 / 3)))
    start = top.position.copy()
    world.run(3.0)
    return np.linalg.norm(top.position - start)


def test_case_30_pyramid_of_four_spheres_stands_on_friction_above_0_318(record_case):
    """mu = tan(35.264 deg/2) = 0.31784."""
    limit = np.tan(np.arctan(1 / np.sqrt(2)) / 2)
    record_threshold(
        record_case, 30, "4 spheres", sphere_pyramid(1.01 * limit), sphere_pyramid(0.99 * limit), ("mu + 1 %", "mu - 1 %")
    )


def ladder(degrees, friction=0.4):
    """A 1 m ladder leans on the wall x = 0 at an angle from the floor -> how far its middle moves in 3 s [m]."""
    angle, thickness = np.radians(degrees), 0.002
    world = sw.make(friction=friction)
    world.add_plane()
    world.add_plane(normal=(1, 0, 0), height=0.0)
    middle = (0.5 * np.cos(angle) + 0.5 * thickness * np.sin(angle), 0, 0.5 * np.sin(angle) + 0.5 * thickness * np.cos(angle))
    rungs = world.add(mb.Box(1.0, 0.4, thickness), mass=1.0, position=middle, orientation=sw.about((0, 1, 0), angle))
    world.run(3.0)
    return np.linalg.norm(rungs.position - middle)


def test_case_31_ladder_slides_below_the_angle_of_its_friction(record_case):
    """Equal mu = 0.4 on floor and wall: tan = (1 - mu^2)/(2 mu), 46.397 degrees, to 0.2 degrees."""
    limit = np.degrees(np.arctan((1 - 0.16) / 0.8))
    record_threshold(
        record_case, 31, "ladder", ladder(limit + 0.2), ladder(limit - 0.2), ("+0.2 deg", "-0.2 deg"), "right at 1 deg"
    )


def overhang(share):
    """A 1 m block with `share` of its length over the edge of a fixed block -> angle [rad] it turns in 4 s."""
    world = sw.make(friction=0.6)
    world.add(mb.Box(2, 1, 0.5), mass=1.0, position=(-1.0, 0, -0.25), fixed=True)
    block = world.add(mb.Box(1.0, 0.5, 0.2), density=1000.0, position=(share - 0.5, 0, 0.1))
    world.run(4.0)
    return sw.turned(block, (1, 0, 0, 0))


def test_case_32_block_topples_when_half_of_it_hangs_over(record_case):
    """0.4999 stays, 0.5001 falls: one part in ten thousand of the length."""
    record_threshold(
        record_case, 32, "overhang", overhang(0.4999), overhang(0.5001), ("0.4999", "0.5001"), "right at 0.499, 0.501"
    )


def tipping(degrees):
    """A block with base 0.5 and height 1 on an incline, friction 0.9 -> angle [rad] it turns in 4 s."""
    incline = sw.Incline(degrees)
    world = incline.world(friction=0.9)
    block = world.add(mb.Box(0.5, 0.5, 1.0), density=1000.0, position=0.5 * incline.normal, orientation=incline.orientation)
    world.run(4.0)
    return sw.turned(block, incline.orientation)


def test_case_33_block_tips_where_its_weight_leaves_the_base(record_case):
    """atan(b/h) = 26.565 degrees, to 0.05 degrees."""
    limit = np.degrees(np.arctan(0.5))
    record_threshold(
        record_case,
        33,
        "tip on an incline",
        tipping(limit - 0.05),
        tipping(limit + 0.05),
        ("-0.05 deg", "+0.05 deg"),
        "tips at 26.3 deg",
    )


@pytest.mark.slow
@pytest.mark.parametrize("count", [7, 20])
def test_case_34_arch_stands_when_thick_enough_for_a_line_of_thrust(record_case, count):
    """Semicircular arch of equal blocks, mu = 0.9; the least thickness from linear programming over the joints."""
    limit = arch.least_thickness(count, 0.9)
    record_case(34, f"arch of {count}: least t/R by linear programming", limit / {7: 0.0957, 20: 0.10735}[count] - 1, 2e-3)
    stands, falls = (arch.sag(count, share * limit, 0.9, seconds=5.0) for share in (1.02, 0.98))
    record_threshold(record_case, 34, f"arch of {count}", stands, falls, ("t + 2 %", "t - 2 %"), "right at 0.125 and 0.12")


def test_case_35_sphere_in_a_groove_presses_on_its_walls(record_case):
    """Smooth walls at beta: N = W/(2 cos beta) each."""
    for degrees in (30, 45, 60):
        beta = np.radians(degrees)
        world = sw.make(friction=0.0)
        for side in (-1, 1):
            world.add_plane(normal=(side * np.sin(beta), 0, np.cos(beta)), height=0.0)
        world.add(mb.Sphere(0.5), mass=2.0, position=(0, 0, 0.5 / np.cos(beta)))
        world.step(60)
        force = world.contacts.to_dataframe()["normal_force"].to_numpy()
        error = np.abs(force / (sw.GRAVITY / np.cos(beta)) - 1).max()
        assert len(force) == 2
        record_case(35, f"sphere in a V-groove, {degrees} deg", error, 1e-9)


@pytest.mark.parametrize("direction", [1, -1])
def test_case_36_painleve_rod_gains_no_energy(record_case, direction):
    """Rod of 1 m at 60 degrees slides at 3 m/s with mu = 2, where rigid statics has no solution: an impact without collision."""
    angle, radius = np.radians(60), 0.005
    world = sw.make(friction=2.0, time_step=1e-3)
    world.add_plane()
    inertia = (1e-4, 1 / 12, 1 / 12)
    rod = world.add(
        mb.Capsule(radius, 1.0),
        mass=1.0,
        inertia=inertia,
        position=(0, 0, radius + 0.5 * np.sin(angle)),
        orientation=sw.about((0, 1, 0), -angle),
        velocity=(3.0 * direction, 0, 0),
    )

    def energy():
        return sw.kinetic_energy([rod], [1.0], [inertia]) + sw.GRAVITY * rod.position[2]

    start, highest, residual = energy(), 0.0, 0.0
    for _ in range(1000):
        world.step()
        highest = max(highest, energy())
        residual = max(residual, world.last_step.residual)
    towards = "leaning back" if direction > 0 else "leaning forward"
    record_case(36, f"Painlevé rod, {towards}: energy gained, relative", max(highest / start - 1, 0.0), 1e-12, peer="0 (dt 1e-3)")
    record_case(36, f"Painlevé rod, {towards}: residual", residual, 1e-8)
