"""One-step friction problems (W, q, mu) taken from settled scenes of the engine, and the ways in which they are made harder."""

import arch
import numpy as np
import scenes
import small_worlds as sw

import minibullet as mb
from minibullet.contact.block_rows import delassus


def settled(build, friction=0.5, seconds=2.0):
    """The contact problem of the last step of a scene that `build(world, generator)` fills."""
    world = sw.make(friction=friction, solver="gauss_seidel", tolerance=1e-6)
    world.add_plane()
    build(world, np.random.default_rng(3))
    world.run(seconds)
    return world.last_step.problem


def cubipod_heap(world, generator):
    """Twenty units of seven pieces dropped in two layers between four walls."""
    shape = mb.Compound(tuple(mb.ConvexPiece(points) for points in scenes.cubipod_pieces(1.0)))
    walls(world, 5.0)
    for k in range(20):
        place = (0.5 + 1.5 * (k % 3), 0.5 + 1.5 * (k // 3 % 3), 1.2 + 1.6 * (k // 9))
        world.add(shape, density=2300.0, position=place, orientation=random_turn(generator))


def rock_pile(world, generator):
    """Thirty rocks, hulls of fourteen points, masses from 1 to 10 000."""
    walls(world, 4.0)
    for k in range(30):
        points = generator.normal(size=(14, 3))
        points *= 0.5 / np.linalg.norm(points, axis=1)[:, None]
        place = (0.5 + 1.1 * (k % 3), 0.5 + 1.1 * (k // 3 % 3), 0.8 + 1.1 * (k // 9))
        mass = 10.0 ** generator.uniform(0, 4)
        world.add(mb.ConvexPiece(points), mass=mass, position=place, orientation=random_turn(generator))


def box_pile(world, generator):
    """Thirty boxes dropped at random orientations."""
    walls(world, 2.4)
    for k in range(30):
        place = (0.4 + 0.8 * (k % 3), 0.4 + 0.8 * (k // 3 % 3), 0.6 + 0.8 * (k // 9))
        world.add(mb.Box(0.4, 0.5, 0.6), density=1000.0, position=place, orientation=random_turn(generator))


def stack_of_50(world, generator):
    """Cubes, a little out of line."""
    for level in range(50):
        world.add(mb.Box(1, 1, 1), density=1000.0, position=(*generator.uniform(-0.01, 0.01, 2), level + 0.5))


def heavy_on_light(world, generator):
    """Eight cubes, the top one 10 000 times as heavy as the bottom one."""
    for level in range(8):
        world.add(mb.Box(1, 1, 1), mass=10.0 ** (4 * level / 7), position=(0, 0, level + 0.5))


def wall_of_100(world, generator):
    """Ten courses of ten bricks in running bond."""
    for course in range(10):
        for k in range(10):
            world.add(mb.Box(2, 1, 1), density=1000.0, position=(2.0 * k + (course % 2), 0, course + 0.5))


def standing_arch(world, generator):
    """Twenty blocks, 10 % thicker than they must be."""
    for corners in arch.blocks(20, 0.1181):
        shape = mb.ConvexPiece(np.array([(x, y, z) for x, z in corners for y in (-0.1, 0.1)]))
        world.add(shape, density=1000.0, position=shape.centre_of_mass)


def chain(world, generator):
    """Thirty balls, touching in a row, between two walls that do not give."""
    radius = 0.25
    for k in range(30):
        world.add(mb.Sphere(radius), density=1000.0, position=(radius * (2 * k + 1), 0, radius))
    walls(world, 60 * radius)


def walls(world, width):
    """Four smooth walls around 0..width."""
    for direction in np.eye(3)[:2]:
        world.add_plane(normal=direction, height=0.0)
        world.add_plane(normal=-direction, height=-width)


def random_turn(generator):
    """A quaternion drawn evenly."""
    turn = generator.normal(size=4)
    return turn / np.linalg.norm(turn)


SCENES = {
    "Cubipod heap": (cubipod_heap, 2.0),
    "rock pile, masses 1 to 1e4": (rock_pile, 2.0),
    "box pile": (box_pile, 2.0),
    "stack of 50": (stack_of_50, 0.1),
    "heavy on light, 1e4": (heavy_on_light, 0.1),
    "wall of 100": (wall_of_100, 0.1),
    "arch": (standing_arch, 0.1),
    "chain of 30": (chain, 0.1),
}


def variants(problem, generator):
    """(name, W, q, mu) of one scene: four coefficients, at rest and struck at random, and W unsymmetric by 0.25 %.

    Unsymmetric as turning bodies make it: x . W x, the energy of an impulse, is what it was, and so is the rank.
    """
    (W, q), struck = delassus(problem), blown(problem, generator)
    count = len(problem.target)
    for friction in (0.0, 0.3, 1.0, 1.5):
        mu = np.full(count, friction)
        yield f"mu {friction:g}", W, q, mu
        yield f"mu {friction:g}, struck", W, struck, mu
    skew = generator.normal(size=W.shape)
    turn = W @ (skew - skew.T) @ W
    yield "unsymmetric", W + 2.5e-3 * np.linalg.norm(W) / np.linalg.norm(turn) * turn, struck, np.full(count, 0.5)


def blown(problem, generator):
    """q (3m,) after every moving body was struck: random twists of 0.3 m/s and 0.3 rad/s on top."""
    moving = problem.factors.inverse_mass[:, 0, 0] > 0.0
    blow = 0.3 * generator.normal(size=problem.free_twist.shape) * moving[:, None]
    return delassus(problem._replace(free_twist=problem.free_twist + blow))[1]


def rounded(problem, generator):
    """(W, q, mu) with every entry of W off by up to 0.25 %: no operator of any bodies, and not positive if W was singular."""
    W, _ = delassus(problem)
    noisy = W * (1 + 2.5e-3 * generator.uniform(-1, 1, W.shape))
    return noisy, blown(problem, generator), np.full(len(problem.target), 0.5)


def random_problem(generator, contacts, freedoms, mu, spread=1.0):
    """W = G^T D G of a random matrix G (freedoms, 3 contacts) with inverse masses D over `spread`, q in the range of G^T.

    Rank-deficient where there are fewer freedoms than rows.
    """
    G = generator.normal(size=(freedoms, 3 * contacts))
    D = spread ** generator.uniform(-0.5, 0.5, freedoms)
    return (G.T * D) @ G / freedoms, G.T @ generator.normal(size=freedoms), np.full(contacts, mu)
