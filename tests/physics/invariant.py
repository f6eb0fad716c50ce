"""One heap of twelve bodies for the tests of invariance: boxes, spheres and compounds fall on a floor and on each other."""

import hashlib
import sys
from pathlib import Path

import numpy as np
import small_worlds as sw

import minibullet as mb

sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmarks"))
import scenes

COUNT, STEPS = 12, 240


def shapes(size):
    """Three solids of about `size` [m]: a box, a sphere, and an L of two boxes."""
    corners = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 0.5) for z in (0.0, 0.5)]) * size
    upper = corners * (0.5, 1, 1) + np.array([0, 0, 0.5]) * size
    angle = mb.Compound((mb.ConvexPiece(corners), mb.ConvexPiece(upper)))
    return mb.Box(size, 0.75 * size, 0.5 * size), mb.Sphere(0.375 * size), angle


def add_bodies(world, size, speed, order, cubipods=False, heading=0.0, shift=(0.0, 0.0, 0.0)):
    """Twelve bodies from a fixed seed, added in the order of another seed (None = as drawn), turned by `heading` [rad]."""
    generator = np.random.default_rng(44)
    forms = (cubipod(0.6 * size),) * 3 if cubipods else shapes(size)
    spin = sw.about((0, 0, 1), heading)
    axes = sw.rotation(spin) if heading else np.eye(3)
    drawn = []
    for i in range(COUNT):
        turn = generator.normal(size=4)
        place = np.array([0.5 * (i % 2), 0.4 * (i // 2 % 2), 1.25 * (i // 2) + 1.0]) + generator.integers(0, 64, 3) / 512
        turn = mb.rotations.product(spin, turn) if heading else turn
        drawn.append(
            {
                "shape": forms[i % 3],
                "density": 2048.0,
                "position": axes @ (place * size) + shift,
                "name": f"body{i:02d}",
                "orientation": turn / np.linalg.norm(turn),
                "velocity": axes @ (generator.integers(-64, 64, 3) / 64 * speed),
            }
        )
    indices = np.arange(COUNT) if order is None else np.random.default_rng(order).permutation(COUNT)
    for i in indices:
        body = dict(drawn[i])
        world.add(body.pop("shape"), **body)


def cubipod(side):
    """The unit as seven convex pieces."""
    return mb.Compound(tuple(mb.ConvexPiece(points) for points in scenes.cubipod_pieces(side)))


def state(world, size, speed):
    """(12, 13) positions, orientations, velocities, spins in units of the scene, bodies by name."""
    bodies = sorted(world.bodies, key=lambda body: body.name)
    rate = speed / size
    return np.array(
        [np.concatenate([b.position / size, b.orientation, b.velocity / speed, b.angular_velocity / rate]) for b in bodies]
    )


def run(
    power=0, order=None, save=None, save_every=None, steps=STEPS, cubipods=False, heading=0.0, shift=(0.0, 0.0, 0.0), **settings
):
    """The scene after `steps` steps. power k: lengths x 2^-2k, times x 2^-k; save, save_every: (step, path) of checkpoints.

    With `cubipods` twelve of them, 0.6 of the size (1.62135 m: 0.9728 m, and 3.8 mm at power 4) on a side.
    """
    size, tempo = 2.0 ** (-2 * power) * (1.62135 if cubipods else 1.0), 2.0**-power
    world = sw.make(time_step=tempo / 256, **{"friction": 0.5, **settings})
    world.add_plane()
    add_bodies(world, size, size / tempo, order, cubipods, heading, np.asarray(shift))
    for step in range(steps):
        if save and step == save[0]:
            world.save(save[1])
        if save_every and step and step % save_every[0] == 0:
            world.save(save_every[1])
        world.step()
    return state(world, size, size / tempo)


def resume(path):
    """The checkpointed scene run on to its end."""
    world = mb.World.load(path)
    world.step(STEPS - round(world.time * 256))
    return state(world, 1.0, 1.0)


def digest(numbers):
    """Hash of the bits."""
    return hashlib.sha256(np.ascontiguousarray(numbers).tobytes()).hexdigest()
