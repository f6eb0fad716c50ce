"""Cubes poured into a box, and which share of the space they fill."""

import numpy as np
from scipy.spatial import cKDTree

import minibullet as mb

LANE = 1.8  # between cubes that fall side by side: more than the diagonal of their cross-section, sqrt(3) = 1.73 edges
WALL = 2.0  # edges from walls, floor and surface within which dice order themselves: left out of the measurement


def pour(count, width, seed, friction=0.4, time_step=1 / 120):
    """A World with so many cubes of edge 1 m, poured layer by layer at random into a box of this width [m]; the dice."""
    world = mb.World(mb.Gravity(9.81), mb.Settings(friction=friction, time_step=time_step))
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
    inner = 0.5 * width - WALL
    spots = np.random.default_rng(0).uniform((-inner, -inner, WALL), (inner, inner, surface(dice, width) - WALL), (points, 3))
    tree, filled = cKDTree(spots), np.zeros(points, dtype=bool)
    for body in dice:
        near = tree.query_ball_point(body.position, 0.5 * 3**0.5)
        away = mb.rotations.rotate(mb.rotations.conjugate(body.orientation), spots[near] - body.position)
        filled[near] |= np.abs(away).max(axis=1) < 0.5
    return filled.mean()
