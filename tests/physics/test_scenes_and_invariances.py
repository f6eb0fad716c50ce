"""Section 1.5: whole scenes, and what must not change them: size, place, order, repetition.

Chaotic scenes are judged by residuals, energies and averages; invariances by bits.
"""

import os
import subprocess
import sys
from pathlib import Path

import invariant
import numpy as np
import pytest
import small_worlds as sw
from scipy.spatial import cKDTree

import minibullet as mb


def test_case_37_sliding_cube_does_not_lift(record_case):
    """0.1 m cube at 6 m/s, mu = 0.5: Coulomb's law has no dilation; the convex relaxation would lift it by mu |u_T| dt."""
    world = sw.make(friction=0.5)
    world.add_plane()
    cube = world.add(mb.Box(0.1, 0.1, 0.1), density=1000.0, position=(0, 0, 0.05), velocity=(6, 0, 0))
    lift = tilt = 0.0
    while world.time < 1.5:
        world.step()
        lift = max(lift, abs(cube.position[2] - 0.05))
        tilt = max(tilt, np.linalg.norm(sw.rotation(cube.orientation) - np.eye(3)))
    record_case(37, "sliding cube: lift", lift, 1e-9, "m", peer="0 (Genesis 0.318 m)")
    record_case(37, "sliding cube: |R - I|", tilt, 1e-9, peer="0.06")


@pytest.mark.slow
def test_case_38_pile_of_a_hundred_boxes_obeys_the_contact_law_at_every_step(record_case):
    """Residual <= 1e-8 in each of 480 steps; friction inside its cone; at the end the floor carries the weight."""
    generator = np.random.default_rng(38)
    world = sw.make(friction=0.5)
    world.add_plane()
    for layer in range(11):
        for x in range(3):
            for y in range(3):
                turn = generator.normal(size=4)
                place = 0.9 * np.array([x, y, layer + 1]) + generator.uniform(-0.05, 0.05, 3)
                world.add(mb.Box(0.4, 0.5, 0.6), density=1000.0, position=place, orientation=turn / np.linalg.norm(turn))
    world.add(mb.Box(0.4, 0.5, 0.6), density=1000.0, position=(0.9, 0.9, 12.0))
    residuals, cone = [], 0.0
    for _ in range(480):
        world.step()
        residuals.append(world.last_step.residual)
        cone = max(cone, world.last_step.components["cone"])
    solved = np.mean(np.array(residuals) <= 1e-8)
    record_case(38, f"100 boxes: worst residual of 480 steps ({solved:.1%} below 1e-8)", max(residuals), 1e-8)
    record_case(38, "100 boxes: impulse outside the cone", cone, 1e-9)
    world.run(6.0)
    weight = 100 * 120.0 * sw.GRAVITY
    record_case(
        38, "100 boxes: floor force at rest, relative error", sw.floor_force(world) / weight - 1, 1e-3, peer="still 0.06 m/s"
    )
    overlap = sw.overlap_of_boxes(world.bodies, np.array([0.4, 0.5, 0.6])) / 0.5
    record_case(38, "100 boxes: overlap / size", overlap, 5e-3, peer="5e-3")


def cube_of_spheres(spacing, **settings):
    """216 spheres R = 0.1 m in a loose cube above the floor, a little out of line."""
    generator = np.random.default_rng(666)
    world = sw.make(friction=0.0, **settings)
    world.add_plane()
    for cell in np.ndindex(6, 6, 6):
        place = spacing * np.array(cell) + (0, 0, 0.3) + generator.uniform(-0.004, 0.004, 3)
        world.add(mb.Sphere(0.1), mass=1.0, position=place)
    return world


def sum_of_squared_overlaps(position):
    """Over pairs and the floor [m2]; spheres R = 0.1 m."""
    pairs = np.array(sorted(cKDTree(position).query_pairs(0.2)), dtype=int).reshape(-1, 2)
    depth = 0.2 - np.linalg.norm(position[pairs[:, 0]] - position[pairs[:, 1]], axis=1)
    floor = np.maximum(0.1 - position[:, 2], 0.0)
    return (depth**2).sum() + (floor**2).sum()


@pytest.mark.slow
def test_case_39_dropped_cube_of_spheres_does_not_overlap(record_case):
    """Frictionless, e = 0: the mean over 2 s of the sum of squared overlaps."""
    world = cube_of_spheres(0.21)
    sums = []
    for _ in range(96):
        world.step(5)
        sums.append(sum_of_squared_overlaps(np.array([body.position for body in world.bodies])))
    record_case(39, "666: mean sum of squared overlaps", np.mean(sums), 1e-10, "m2", peer="4.4e-5 m2 (dt 4e-3)")


@pytest.mark.slow
@pytest.mark.parametrize("gravity", [0.0, sw.GRAVITY])
def test_case_40_elastic_spheres_keep_their_energy(record_case, gravity):
    """e = 1 and no friction: a gas in a box without gravity, and the dropped cube of spheres with it; rms over 2 s."""
    world = cube_of_spheres(0.25, restitution=1.0, time_step=1e-3)
    if gravity == 0.0:
        generator = np.random.default_rng(40)
        gas = sw.make(gravity=0.0, friction=0.0, restitution=1.0, time_step=1e-3)
        for axis in np.eye(3):
            gas.add_plane(normal=axis, height=0.0)
            gas.add_plane(normal=-axis, height=-1.6)
        for cell in np.ndindex(4, 4, 4):
            gas.add(mb.Sphere(0.1), mass=1.0, position=0.2 + 0.4 * np.array(cell), velocity=generator.normal(size=3))
        world = gas

    def energy():
        return sum(0.5 * body.velocity @ body.velocity + gravity * body.position[2] for body in world.bodies)

    start, errors = energy(), []
    for _ in range(100):
        world.step(20)
        errors.append(energy() / start - 1)
    name = "elastic 666" if gravity else "elastic gas"
    record_case(40, f"{name}: energy, relative rms", np.sqrt(np.mean(np.square(errors))), 1e-3, peer="up to 66 %")


POURED = "poured under gravity between flat walls, not compressed evenly in a periodic cell as in the reference"


def poured(friction, seed, width=1.6, radius=0.1, count=600):
    """A world of `count` spheres come to rest in a square well, friction between spheres and on the floor only."""
    generator = np.random.default_rng(seed)
    world = sw.make(friction=friction, solver="gauss_seidel", tolerance=1e-6)  # averages do not need 1e-8
    world.add_plane()
    for direction in ((1.0, 0, 0), (0, 1.0, 0)):
        for sign, height in ((1.0, 0.0), (-1.0, -width)):
            world.add_plane(normal=sign * np.array(direction), height=height, friction=0.0)
    for cell in np.ndindex(13, 7, 7):
        if len(world.bodies) < count:
            place = (np.array(cell[::-1]) + 0.5) * width / 7 + generator.uniform(-0.013, 0.013, 3)
            world.add(mb.Sphere(radius), density=2300.0, position=place)
    world.settle(max_time=8.0)
    return world


def fraction_and_coordination(world, generator, width=1.6, radius=0.1):
    """Solid fraction, and bearing contacts of a sphere that bears, two diameters from walls, floor and top."""
    position = np.array([body.position for body in world.bodies])
    margin = 4 * radius
    low, high = np.full(3, margin), np.array([width - margin, width - margin, np.quantile(position[:, 2], 0.99) - margin])
    fraction = np.mean(cKDTree(position).query(generator.uniform(low, high, (300_000, 3)))[0] < radius)
    table, number = world.contacts.to_dataframe(), {body.name: k for k, body in enumerate(world.bodies)}
    table = table[table.normal_force > 1e-3 * table.normal_force.median()]
    ends = [number[name] for column in (table.body_a, table.body_b) for name in column if name in number]
    bearing = np.bincount(ends, minlength=len(position))
    inside = np.all((position > low) & (position < high), axis=1) & (bearing > 1)
    return fraction, bearing[inside].mean()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "fraction", "coordination", "peer"),
    [(0.0, 0.639, 6.0, ("0.633", "5.96")), (0.3, 0.593, 4.5, ("0.590 (mu 0.5)", "5.3 (mu 0.5)"))],
)
def test_case_41_packing_of_spheres(record_case, friction, fraction, coordination, peer):
    """600 spheres poured into a square well, mean of three pours: one pour scatters by 0.01 in the fraction."""
    generator = np.random.default_rng(41)
    means = np.mean([fraction_and_coordination(poured(friction, seed), generator) for seed in (1, 2, 3)], axis=0)
    record_case(
        41, f"packing, mu = {friction:g}: solid fraction less {fraction}", means[0] - fraction, 0.01, peer=peer[0], reason=POURED
    )
    record_case(
        41,
        f"packing, mu = {friction:g}: coordination less {coordination}",
        means[1] - coordination,
        0.2,
        peer=peer[1],
        reason=POURED,
    )


@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_case_42_scaled_scene_is_bit_identical(record_case, power):
    """Lengths x 2^-2k, times x 2^-k, masses x 2^-6k, g kept: Froude scaling by powers of two changes no bit of the motion."""
    large, small = invariant.run(), invariant.run(power=power)
    differing = int((large.view(np.uint64) != small.view(np.uint64)).sum())
    record_case(42, f"Froude scaling, 2^-{2 * power}: numbers that differ", differing, 0, peer="1 to 2.6 widths")


@pytest.mark.parametrize("solver", ["exact", "gauss_seidel", "sequential_impulse"])
def test_case_42_cubipods_that_bounce_scale_bit_for_bit_down_to_3_8_mm(record_case, solver):
    """Twelve Cubipods of 0.973 m and of 3.8 mm (2^-8) with restitution 0.3 fall on each other: the same bits in every solver.

    And nothing depends on the order in which they were added.
    """
    settings = {"solver": solver, "restitution": 0.3}
    large = invariant.run(cubipods=True, **settings)
    for name, other in (
        ("3.8 mm", invariant.run(power=4, cubipods=True, **settings)),
        ("added in another order", invariant.run(order=1, cubipods=True, **settings)),
    ):
        differing = int((large.view(np.uint64) != other.view(np.uint64)).sum())
        record_case(42, f"bouncing Cubipods, {solver}, {name}: numbers that differ", differing, 0, peer="none passes")


@pytest.mark.slow
@pytest.mark.parametrize("size", [1.07, 0.038, 0.0038])
def test_case_42_stack_stands_at_every_size(record_case, size):
    """Five cubes of that size as hulls, 4 s: the top centre at 4.5 sizes."""
    world = sw.make(friction=0.6)
    world.add_plane()
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    cubes = [world.add(mb.ConvexPiece(corners), density=2300.0, position=(0, 0, (0.5 + i) * size)) for i in range(5)]
    world.run(4.0)
    peer = {1.07: "4.508", 0.038: "4.735", 0.0038: "collapses"}[size]
    error = cubes[4].position[2] / size - 4.5
    record_case(42, f"stack of 5 cubes of {size} m: top centre / size less 4.5", error, 1e-6, peer=peer)


def test_case_43_turned_and_shifted_scene_moves_alike(record_case):
    """A tumbling cube lands and slides for 0.5 s, turned by 37 degrees and shifted by 1e4 m, where doubles are 2e-12 m apart."""
    heading = sw.about((0, 0, 1), np.radians(37))
    shift = np.array([1e4, -1e4, 0])

    def fly(turn, origin):
        world = sw.make(friction=0.4)
        world.add_plane()
        axes = sw.rotation(turn)
        cube = world.add(
            mb.Box(0.5, 0.5, 0.5),
            density=1000.0,
            position=origin + (0, 0, 0.6),
            orientation=turn,
            velocity=axes @ (2.0, 0.5, 0.0),
            angular_velocity=axes @ (0.3, 0.2, 0.1),
        )
        world.run(0.5)
        return axes.T @ (cube.position - origin), axes.T @ sw.rotation(cube.orientation), axes.T @ cube.velocity

    plain, moved = fly(np.array([1.0, 0, 0, 0]), np.zeros(3)), fly(heading, shift)
    difference = max(np.abs(a - b).max() for a, b in zip(plain, moved, strict=True))
    record_case(43, "turned by 37 deg, shifted by 1e4 m", difference, 1e-9, "m", peer="1.0 width after 100 m")


@pytest.mark.slow
def test_case_43_turned_heap_settles_alike_on_average(record_case):
    """Twelve bodies for 4 s, where chaos has set in: heights of the centres of the plain and of the turned and shifted heap.

    Two heaps from other seeds differ in mean height by 10 %; the same law in other axes should not differ by more.
    """
    plain = invariant.run(steps=1024)[:, 2]
    moved = invariant.run(steps=1024, heading=np.radians(37), shift=(1e4, -1e4, 0.0))[:, 2]
    record_case(43, "heap turned and shifted, after the chaos: mean height, relative", moved.mean() / plain.mean() - 1, 0.15)


def test_case_44_killed_run_resumes_from_its_checkpoint_bit_identically(record_case, tmp_path):
    """A process that saves every 20 steps is killed with SIGKILL while it runs; what lies on disk is a whole checkpoint, the
    resumed run ends on the same bits, and no partial file counts."""
    folder, path = Path(__file__).resolve().parent, tmp_path / "state"
    script = (
        f"import sys; sys.path.insert(0, {str(folder)!r}); import invariant; print('go', flush=True); "
        f"invariant.run(save_every=(20, {str(path)!r}))"
    )
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, cwd=folder.parents[1])
    process.stdout.readline()
    while not path.exists():
        assert process.poll() is None
    process.kill()
    assert process.wait() == -9
    at = round(mb.World.load(path).time * 256)
    assert at % 20 == 0 and at < invariant.STEPS
    resumed = invariant.digest(invariant.resume(path))
    record_case(44, "determinism: kill -9 and resume", resumed == invariant.digest(invariant.run()), claim="equal bits")


def elsewhere(**environment):
    """Digest of the scene computed by a fresh process."""
    folder = Path(__file__).resolve().parent
    script = f"import sys; sys.path.insert(0, {str(folder)!r}); import invariant; print(invariant.digest(invariant.run()))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, env={**os.environ, **environment}, cwd=folder.parents[1]
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_case_44_same_bits_on_repeat_in_another_process_and_with_other_threads(record_case):
    """Hash of all poses and velocities of a heap after 240 steps."""
    here = invariant.digest(invariant.run())
    record_case(44, "determinism: repeat", invariant.digest(invariant.run()) == here, claim="equal bits", peer="equal")
    record_case(44, "determinism: another process", elsewhere() == here, claim="equal bits", peer="equal")
    threads = {elsewhere(NUMBA_NUM_THREADS=str(n), OMP_NUM_THREADS=str(n)) for n in (1, 2)}
    record_case(44, "determinism: 1 and 2 threads", threads == {here}, claim="equal bits")


def test_case_44_order_of_insertion_changes_no_bit(record_case):
    """Bodies are added in three other orders and read back by name."""
    here = invariant.digest(invariant.run())
    orders = [invariant.digest(invariant.run(order=seed)) for seed in (1, 2, 3)]
    record_case(44, "determinism: order of insertion", set(orders) == {here}, claim="equal bits", peer="1.0 width apart")


def test_case_44_saved_and_loaded_run_goes_on_bit_identically(record_case, tmp_path):
    """Saved after 100 steps, loaded in the same and in another process, run on to 240."""
    here = invariant.digest(invariant.run())
    invariant.run(save=(100, tmp_path / "state"))
    resumed = invariant.digest(invariant.resume(tmp_path / "state"))
    record_case(44, "determinism: resume", resumed == here, claim="equal bits", peer="1.4 m apart in memory")
