"""One heap of twelve bodies for the tests of invariance: boxes, spheres and compounds fall on a floor and on each other."""

import hashlib

import numpy as np
import small_worlds as sw

import minibullet as mb

COUNT, STEPS = 12, 240


def shapes(size):
    """Three solids of about `size` [m]: a box, a sphere, and an L of two boxes."""
    corners = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 0.5) for z in (0.0, 0.5)]) * size
    upper = corners * (0.5, 1, 1) + np.array([0, 0, 0.5]) * size
    angle = mb.Compound((mb.ConvexPiece(corners), mb.ConvexPiece(upper)))
    return mb.Box(size, 0.75 * size, 0.5 * size), mb.Sphere(0.375 * size), angle


def add_bodies(world, size, speed, order):
    """Twelve bodies from a fixed seed, added in the order of another seed (None = as drawn)."""
    generator = np.random.default_rng(44)
    forms = shapes(size)
    drawn = []
    for i in range(COUNT):
        turn = generator.normal(size=4)
        place = np.array([0.5 * (i % 2), 0.4 * (i // 2 % 2), 1.25 * (i // 2) + 1.0]) + generator.integers(0, 64, 3) / 512
        drawn.append({"shape": forms[i % 3], "density": 2048.0, "position": place * size, "name": f"body{i:02d}",
                      "orientation": turn / np.linalg.norm(turn), "velocity": generator.integers(-64, 64, 3) / 64 * speed})
    indices = np.arange(COUNT) if order is None else np.random.default_rng(order).permutation(COUNT)
    for i in indices:
        body = dict(drawn[i])
        world.add(body.pop("shape"), **body)


def state(world, size, speed):
    """(12, 13) positions, orientations, velocities, spins in units of the scene, bodies by name."""
    bodies = sorted(world.bodies, key=lambda body: body.name)
    rate = speed / size
    return np.array([np.concatenate([b.position / size, b.orientation, b.velocity / speed, b.angular_velocity / rate])
                     for b in bodies])


def run(power=0, order=None, save=None):
    """The scene after 240 steps. power k: lengths x 2^-2k, times x 2^-k; save: (step, path) to write a checkpoint."""
    size, tempo = 2.0 ** (-2 * power), 2.0**-power
    world = sw.make(friction=0.5, time_step=tempo / 256)
    world.add_plane()
    add_bodies(world, size, size / tempo, order)
    for step in range(STEPS):
        if save and step == save[0]:
            world.save(save[1])
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
