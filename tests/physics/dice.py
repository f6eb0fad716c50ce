"""Cubes poured into a box, and which share of the space they fill.

python tests/physics/dice.py --pours 6 --friction 0.4 --sweeps 100    says it of every pour, and the mean with its interval
"""

import argparse
import time

import numpy as np
from scipy import stats
from scipy.spatial import cKDTree

import minibullet as mb

LANE = 1.8  # between cubes that fall side by side: more than the diagonal of their cross-section, sqrt(3) = 1.73 edges
COUNT, WIDTH = 600, 10.0  # cubes of a pour, edges: about 11 edges high, so a quarter of the box is far from every wall
FRICTION = 0.4  # plastic on plastic, handbooks; written down before the first pour
SWEEPS = 100  # of the solver, a step at most
WALL = 2.0  # edges from walls, floor and surface within which dice order themselves: left out of the measurement


def pour(count, width, seed, friction=FRICTION, sweeps=SWEEPS, time_step=1 / 120):
    """A World with so many cubes of edge 1 m, poured layer by layer at random into a box of this width [m]; the dice.

    The solver is that of a placement test, with so many sweeps a step. The exact one took 65,000 sparse factorizations for the
    first 400 steps of a pour.
    """
    solver = {"solver": "gauss_seidel", "iterations": sweeps, "tolerance": 1e-4}
    world = mb.World(mb.Gravity(9.81), mb.Settings(friction=friction, time_step=time_step, **solver))
    world.add_plane()
    for wall in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)):
        world.add_plane(wall, -0.5 * width)
    generator, die, dice = np.random.default_rng(seed), mb.Box(1.0, 1.0, 1.0), []
    lanes = (np.arange(int((width - 1.8) / LANE) + 1) - 0.5 * int((width - 1.8) / LANE)) * LANE
    places = np.array([(x, y) for x in lanes for y in lanes])
    while len(dice) < count:
        above = 2.5 + max((body.position[2] for body in dice), default=0.0)
        for x, y in generator.permutation(places)[: count - len(dice)]:
            turn = mb.rotations.random(generator, 1)[0]
            dice.append(world.add(die, density=1000.0, position=(x, y, above), orientation=turn))
        world.run(0.8)  # the time to fall 3 m: the next ones fall on these at rest, or nearly so
    world.settle(10.0)
    return world, dice


def surface(dice, width):
    """Lowest of the highest centres over squares of 2 x 2 edges [m]: below it, the box is full."""
    places = np.array([body.position for body in dice])
    cell = ((places[:, :2] + 0.5 * width) // 2.0).clip(0, width // 2.0 - 1) @ (1000, 1)
    return min(places[cell == each, 2].max() for each in np.unique(cell))


def solid_fraction(dice, width, points=100_000):
    """Share of the interior, WALL from walls, floor and surface, that lies inside cubes, from so many random points."""
    inner, top = 0.5 * width - WALL, surface(dice, width) - WALL
    if inner <= 0.0 or top <= WALL:
        raise ValueError(f"{len(dice)} cubes in a box of {width:g} edges leave no interior; pour more, or into a wider box")
    spots = np.random.default_rng(0).uniform((-inner, -inner, WALL), (inner, inner, top), (points, 3))
    tree, filled = cKDTree(spots), np.zeros(points, dtype=bool)
    for body in dice:
        near = tree.query_ball_point(body.position, 0.5 * 3**0.5)
        away = mb.rotations.rotate(mb.rotations.conjugate(body.orientation), spots[near] - body.position)
        filled[near] |= np.abs(away).max(axis=1) < 0.5
    return filled.mean()


def poured(seeds, count=COUNT, width=WIDTH, friction=FRICTION, sweeps=SWEEPS, told=None):
    """Solid fraction of a pour of each seed, (n,) [-], and the deepest penetration at the end of any [m]; told(seed, fraction,
    penetration, seconds) is called after each."""
    found, deepest = [], 0.0
    for seed in seeds:
        started = time.process_time()
        world, dice = pour(count, width, seed, friction, sweeps)
        found.append(solid_fraction(dice, width))
        deepest = max(deepest, world.last_step.penetration)
        if told:
            told(seed, found[-1], world.last_step.penetration, time.process_time() - started)
    return np.array(found), deepest


def half_interval(fractions):
    """Half the 95 % interval of their mean (Student) [-]."""
    return stats.t.ppf(0.975, len(fractions) - 1) * np.std(fractions, ddof=1) / np.sqrt(len(fractions))


def _told(seed, fraction, penetration, seconds):
    print(f"seed {seed}: solid fraction {fraction:.4f}, penetration {penetration:.1e} edges, {seconds:.0f} s", flush=True)


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--pours", type=int, default=6)
    asked.add_argument("--count", type=int, default=COUNT)
    asked.add_argument("--width", type=float, default=WIDTH)
    asked.add_argument("--friction", type=float, default=FRICTION)
    asked.add_argument("--sweeps", type=int, default=SWEEPS)
    options = asked.parse_args()
    settings = options.count, options.width, options.friction, options.sweeps
    fractions, _ = poured(range(1, options.pours + 1), *settings, _told)
    print(f"solid fraction of {options.pours} pours: {fractions.mean():.3f} +- {half_interval(fractions):.3f} (95 %, Student)")
