"""Cubes tossed on a floor, recorded by the model itself in finer steps."""

from types import SimpleNamespace

import numpy as np
from throws import csv

from hlcs.data.experiment_file import read_experiment_file
from hlcs.simulation.model import Model
from hlcs.simulation.simulator import Simulator
from minibullet import rotations

CUBE = (
    'kind = "trajectory"\n[body]\nshape = "box"\nsize = [0.1, 0.1, 0.1]\nmass = 0.37\n[surroundings]\ngravity = 9.81\n'
    "friction = 0.2\nfloor = { height = 0.0 }\n[measurement]\nnoise = { position = 0.001, orientation = 0.01 }\n"
)


def write_tosses(folder, speeds, seconds=0.9, seed=4):
    """Cubes tossed on a floor, through the model itself at a fifth of its step: only how they are cut is tested with them."""
    generator, text = np.random.default_rng(seed), CUBE
    for k in range(len(speeds)):
        (folder / f"t{k}.csv").touch()
        text += f'[[trial]]\nfile = "t{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "tosses.toml"
    path.write_text(text)
    trial = SimpleNamespace(**{name: getattr(read_experiment_file(path).trials[0], name) for name in ("body", "surroundings")})
    times = np.arange(0, seconds, 1 / 120)
    for k, speed in enumerate(speeds):
        turn = generator.standard_normal(4)
        spin = 3 * speed * generator.standard_normal(3)
        start = np.concatenate([[0, 0, 0.15], [speed, 0, 0], turn / np.linalg.norm(turn), spin])
        whole = SimpleNamespace(
            times=times, position=np.zeros((len(times), 3)), recording="", start={}, accelerations=None, **vars(trial)
        )
        ((position, turns, _),) = Simulator(Model(), (whole,), [0.0], True, 1 / 1200).simulate(
            Model(), start[None], np.zeros(1, int)
        )
        seen = position + 0.001 * generator.standard_normal(position.shape)
        turns = rotations.product(rotations.exponential(0.01 * generator.standard_normal((len(times), 3))), turns)
        (folder / f"t{k}.csv").write_text(csv(times, np.hstack([seen, turns]), ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")))
    return path
