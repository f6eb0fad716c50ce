"""Section 1.6: balls on a pushed box, constructions that stand, a falling wave, the first layer of Cubipods, linear cost."""

import time
from dataclasses import dataclass

import numpy as np
import pytest
import scenes
import small_worlds as sw

import minibullet as mb


def test_incline_one_degree_below_slip_does_not_creep(record_case):
    """Soft contact creeps; hard contact must not. 4 s."""
    incline = sw.Incline(np.degrees(np.arctan(0.6)) - 1)
    world = incline.world(friction=0.6)
    start = 0.25 * incline.normal
    box = world.add(mb.Box(1, 1, 0.5), density=1000.0, position=start, orientation=incline.orientation)
    world.run(4.0)
    record_case(
        "creep",
        "incline 1 deg below slip, 4 s",
        (box.position - start) @ incline.down,
        1e-9,
        "m",
        peer="6.9e-5 m; MuJoCo 5.5e-3 m",
    )


@dataclass(frozen=True)
class Push(mb.Effect):
    """A constant force [N] along x on every body heavier than 5 kg."""

    force: float = 150.0

    def forces(self, bodies, time):
        wrench = np.zeros((len(bodies.mass), 6))
        wrench[np.isfinite(bodies.mass) & (bodies.mass > 5.0), 0] = self.force
        return wrench


def test_balls_roll_on_a_pushed_box(record_case):
    """a_box = (F - mu1 (M + n m) g)/(M + 2 n m/7) = 0.7385 m/s2, a_ball = 2/7 a_box; mean squared velocity error over 4 s.

    F = 150 N, mu1 = 0.4, M = 10 kg, n = 25, m = 1 kg, step 1e-3 s. Friction of balls on the box 0.8.
    """
    world = sw.make(effects=[Push()], time_step=1e-3)
    world.add_plane()
    box = world.add(mb.Box(20, 20, 1), mass=10.0, position=(0, 0, 0.5), friction=0.4)
    balls = [
        world.add(mb.Sphere(0.5), mass=1.0, friction=1.6, position=(2.0 * x, 2.0 * y, 1.5))
        for x in range(-2, 3)
        for y in range(-2, 3)
    ]
    acceleration = (150 - 0.4 * 35 * sw.GRAVITY) / (10 + 50 / 7)
    squares = []
    for _ in range(100):
        world.step(40)
        exact = acceleration * world.time
        squares.append(np.mean([(box.velocity[0] - exact) ** 2] + [(ball.velocity[0] - exact * 2 / 7) ** 2 for ball in balls]))
    record_case(
        "rolling",
        "25 balls roll on a pushed box: mean squared velocity error",
        np.mean(squares),
        5.7e-9,
        "m2/s2",
        peer="5.7e-9 (own), 1.1e-5 (transcribed); RaiSim 4.1e-7",
    )


def card_house(world):
    """Two storeys of leaning cards, 12 degrees from upright: three tents, two roofs."""
    lean, length, thickness = np.radians(12), 1.0, 0.02
    up = 0.5 * length * np.cos(lean) + 0.5 * thickness * np.sin(lean)
    half = 0.5 * length * np.sin(lean) + 0.5 * thickness * np.cos(lean)
    pitch, storey = 4 * half, 2 * up + thickness
    for level, middles in ((0, (-0.5, 0.5)), (1, (0.0,))):
        for middle in middles:
            for side in (-1, 1):
                place = (middle * pitch + side * half, 0, level * storey + up)
                turn = sw.about((0, 1, 0), -side * lean)
                world.add(mb.Box(thickness, 0.7, length), density=800.0, position=place, orientation=turn)
    world.add(mb.Box(1.4 * pitch, 0.7, thickness), density=800.0, position=(0, 0, 2 * up + 0.5 * thickness))


def circular_tower(world):
    """Ten rings of eight blocks, every other ring turned by half a block."""
    for ring in range(10):
        for k in range(8):
            angle = (k + 0.5 * (ring % 2)) * np.pi / 4
            world.add(
                mb.Box(0.3, 0.7, 0.25),
                density=800.0,
                orientation=sw.about((0, 0, 1), angle),
                position=(np.cos(angle), np.sin(angle), 0.125 + 0.25 * ring),
            )


def jenga_tower(world):
    """Twelve layers of three planks, crosswise."""
    for layer in range(12):
        turn = sw.about((0, 0, 1), 0.5 * np.pi * (layer % 2))
        for k in (-1, 0, 1):
            place = sw.rotation(turn) @ (0, 0.26 * k, 0.075 + 0.15 * layer)
            world.add(mb.Box(0.75, 0.25, 0.15), density=600.0, position=place, orientation=turn)


def standing_arch(world):
    """Semicircle of 20 blocks, 10 % thicker than it must be."""
    import arch

    for corners in arch.blocks(20, 0.1181):
        shape = mb.ConvexPiece(np.array([(x, y, z) for x, z in corners for y in (-0.1, 0.1)]))
        world.add(shape, density=1000.0, position=shape.centre_of_mass)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("build", "friction"), [(card_house, 0.6), (circular_tower, 0.6), (jenga_tower, 0.6), (standing_arch, 0.9)]
)
def test_construction_stands_for_a_minute(record_case, build, friction):
    """60 s; no piece moves more than a hundredth of its length."""
    world = sw.make(friction=friction)
    world.add_plane()
    build(world)
    start = np.array([body.position for body in world.bodies])
    world.run(60.0)
    moved = np.linalg.norm(np.array([body.position for body in world.bodies]) - start, axis=1).max()
    record_case("standing", f"{build.__name__.replace('_', ' ')} after 60 s: largest motion", moved, 1e-2, "m")


@pytest.mark.slow
def test_wave_of_dominoes_passes_every_piece(record_case):
    """Twenty dominoes half a height apart; the first is pushed."""
    world = sw.make(friction=0.6)
    world.add_plane()
    pieces = [world.add(mb.Box(0.15, 0.5, 1.0), density=800.0, position=(0.5 * i, 0, 0.5)) for i in range(20)]
    pieces[0].angular_velocity = (0, 2.0, 0)
    pieces[0].velocity = (1.0, 0, 0)
    world.run(8.0)
    fallen = sum(sw.rotation(piece.orientation)[2, 2] < 0.9 for piece in pieces)
    record_case("dominoes", "wave passes every one of 20 dominoes", fallen == 20, claim="20 of 20")


@pytest.mark.parametrize("nominal_diameter", [1.07, 0.038])
def test_first_layer_of_cubipods_is_1_298_thick(record_case, nominal_diameter):
    """A unit let go 0.01 Dn above its low pose comes to rest 1.29826 Dn thick, whatever its size: no margin."""
    side = nominal_diameter / scenes.NOMINAL_DIAMETER
    shape = mb.Compound(tuple(mb.ConvexPiece(points) for points in scenes.cubipod_pieces(side)))
    world = sw.make(friction=0.6)
    world.add_plane()
    unit = world.add(
        shape,
        density=2300.0,
        orientation=scenes.low_pose(0.7),
        position=(0, 0, side * scenes.LOW_POSE_HEIGHT + 0.01 * nominal_diameter),
    )
    world.settle(max_time=5.0)
    corners = np.vstack(scenes.cubipod_pieces(side)) @ sw.rotation(unit.orientation).T
    thickness = (unit.position[2] + corners[:, 2].max()) / nominal_diameter
    record_case(
        "first layer",
        f"Cubipod at rest, Dn = {nominal_diameter} m: thickness / Dn less 1.298",
        thickness - 1.298,
        1e-3,
        peer="published Bullet model 1.317 to 1.319",
    )


@pytest.mark.slow
def test_cost_grows_in_proportion_to_the_number_of_units(record_case):
    """CPU time of 60 steps of a falling and landing layer of hulls, 100 to 3 000 units: slope of the logarithms."""
    numbers, seconds = [], []
    for count in (100, 300, 1000, 3000):
        scene = scenes.scaling(count)
        world = sw.make(friction=scene.friction)
        world.add_plane()
        shape = mb.ConvexPiece(scene.form.pieces[0])
        for position, orientation, fixed in zip(scene.position, scene.orientation, scene.fixed, strict=True):
            given = {"fixed": True} if fixed else {"mass": scene.form.mass, "inertia": scene.form.inertia}
            world.add(shape, position=position, orientation=orientation, **given)
        world.step(60)  # until the units touch
        start = time.process_time()
        world.step(60)
        numbers.append((~scene.fixed).sum())
        seconds.append(time.process_time() - start)
    slope = np.polyfit(np.log(numbers), np.log(seconds), 1)[0]
    record_case("cost", "slope of log time to log number of units, 100 to 3 000", slope, 1.1)
