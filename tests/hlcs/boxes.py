"""A box by its name and as a mesh file, and its throws."""

import numpy as np
import trimesh
from throws import correlated, csv

from minibullet import rotations

SIZE = (0.06, 0.1, 0.2)


COLUMNS = ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")


NAMED = f'shape = "box"\nsize = {list(SIZE)}\n'


MESH = 'shape = "mesh"\nmesh = "box.stl"\n'


def write_box(folder, at=(0.0, 0.0, 0.0), name="box.stl", turn=(1.0, 0.0, 0.0, 0.0)):
    """The box in a mesh file whose origin is not its centre, and whose axes may not be its own."""
    box = trimesh.creation.box(SIZE)
    box.vertices = rotations.rotate(np.array(turn), box.vertices) + at
    box.export(folder / name)
    return folder / name


def thrown(folder, body, drag=0.0, more=""):
    """Four spinning throws, recorded with noise; spin about a principal axis, so that it is steady. -> path of the experiment.

    Without drag the file states a vacuum; with it, it says nothing of a fluid."""
    generator, trials = np.random.default_rng(4), ""
    for k in range(4):
        times = np.arange(0, 0.8, 1 / 60)
        speed = np.array([1.5 * (k % 2), 1.0 + k, 3.0])
        decay = (1 - np.exp(-drag * times)) / drag if drag else times
        fall = -9.81 / drag * (times - decay) if drag else -9.81 * times**2 / 2
        place = np.outer(decay, speed) + np.outer(fall, [0, 0, 1]) + [0, 0, 1.5]
        turn = rotations.exponential(np.outer(times, [0, 0, 2.0 + k])) + correlated(generator, (len(times), 4), 0.005, 0.0)
        place = place + correlated(generator, (len(times), 3), 0.003, 0.0)
        seen = np.hstack([place, turn / np.linalg.norm(turn, axis=1)[:, None]])
        (folder / f"throw_{k}.csv").write_text(csv(times, seen, COLUMNS))
        trials += f'[[trial]]\nfile = "throw_{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "thrown.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\n'
        + body
        + more
        + ("" if drag else "[surroundings]\nfluid_density = 0.0\n")
        + "[measurement]\n"
        "noise = { position = 0.003, orientation = 0.01 }\n" + trials
    )
    return path
