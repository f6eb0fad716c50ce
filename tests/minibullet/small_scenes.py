"""Small scenes and brute force for the tests of the engine's rooms; nothing here leans on the code it judges."""

from types import SimpleNamespace

import numpy as np
from scipy.optimize import nnls

import minibullet as mb
from minibullet.bodies import ContactLaw
from minibullet.collision import manifolds
from minibullet.collision.warm_start import NO_CONTACTS
from minibullet.contact.islands import find_islands
from minibullet.dynamics import constraints
from minibullet.dynamics.impacts import ImpactContacts
from minibullet.dynamics.inverse_mass import inverse_mass


def polytope(generator, count=12, size=0.5):
    """Hull of random points on a sphere of radius ``size`` [m], of a random flatness."""
    points = generator.normal(size=(count, 3))
    points *= size / np.sqrt((points**2).sum(axis=1))[:, None]
    return mb.ConvexPiece(points * generator.uniform(0.4, 1.0, 3))


def corners(body):
    """World coordinates (v, 3) of the corners of a body of one piece."""
    return body.position + body.shape.pieces[0].vertices @ mb.rotations.matrix(body.orientation).T


def normals(body):
    """World face normals (f, 3) of a body of one piece."""
    return body.shape.pieces[0].normals @ mb.rotations.matrix(body.orientation).T


def distance(one, two, weight=1e3):
    """Distance of two hulls of points (v, 3), 0 where they overlap: least |x - y| over convex weights, by SciPy's nnls."""
    matrix = np.zeros((5, len(one) + len(two)))
    matrix[:3, : len(one)], matrix[:3, len(one) :] = one.T, -two.T
    matrix[3, : len(one)], matrix[4, len(one) :] = weight, weight
    weights, _ = nnls(matrix, np.array([0.0, 0.0, 0.0, weight, weight]))
    first, second = weights[: len(one)], weights[len(one) :]
    return np.linalg.norm(one.T @ first / first.sum() - two.T @ second / second.sum())


def axis_separation(a, b):
    """Largest separation over all face normals and all cross products
    of edges (the separating-axis theorem); exact where negative."""
    one, two = corners(a), corners(b)
    lines = [[points[w] - points[v] for v, w in body.shape.pieces[0].edges] for body, points in ((a, one), (b, two))]
    crossed = np.cross(np.array(lines[0])[:, None], np.array(lines[1])[None]).reshape(-1, 3)
    length = np.sqrt((crossed**2).sum(axis=1))
    crossed = crossed[length > 1e-8] / length[length > 1e-8, None]
    axes = np.concatenate([normals(a), -normals(b), crossed, -crossed])
    return ((axes @ two.T).min(axis=1) - (axes @ one.T).max(axis=1)).max()


def poses(scene, reach):
    """Where the bodies of a scene are; each may move by ``reach`` [m]."""
    return scene.poses(mb.rotations.matrix(scene.bodies.orientation), np.full(len(scene.names), reach))


def look(world, reach=1.0):
    """The feature cache of all pairs within ``reach`` [m], looked at afresh where bodies moved."""
    scene = world.registry.commit()
    cache = scene.update_pairs(poses(scene, reach))
    scene.past_motion = np.zeros(len(scene.names))
    cache.since_points[:] = np.inf  # no contact points are kept from look to look
    return cache


def random_pair(generator, low, high):
    """Two random polytopes at a random distance of centres, and their world."""
    world = mb.World()
    direction = generator.normal(size=3)
    direction *= generator.uniform(low, high) / np.linalg.norm(direction)
    turns = mb.rotations.random(generator, 2)
    one = world.add(polytope(generator), density=1.0, orientation=turns[0])
    two = world.add(polytope(generator), density=1.0, position=direction, orientation=turns[1])
    return world, one, two


def separation(world, one, reach=1.0):
    """The one pair's separation and normal from ``one`` to the other body."""
    cache = look(world, reach)
    assert len(cache.gap) == 1
    return cache.gap[0], cache.normal[0] if cache.bodies[0, 0] == one._row else -cache.normal[0]


def touch(world, reach=0.01):
    """Contacts of a world where it stands: a record of pair, arm_a, arm_b, normal, gap, point (midway, world)."""
    cache, scene = look(world, reach), world.registry.scene
    fresh, collision = cache._replace(contacts=cache.contacts.copy()), scene.collision
    points = manifolds.build(collision.pieces, fresh, poses(scene, reach), collision.polygons, NO_CONTACTS)
    pair, arms, gap = points.bodies, points.arms, points.gap
    on_a = scene.bodies.position[pair[:, 0]] + arms[:, :3]
    on_b = scene.bodies.position[pair[:, 1]] + arms[:, 3:6]
    return SimpleNamespace(pair=pair, arms=arms, normal=arms[:, 6:], gap=gap, on_a=on_a, on_b=on_b, deepest=cache.gap)


def step_contacts(scene, factors, gap, law):
    """The contacts of a step as `constraints.assemble` takes them."""
    linked = find_islands(factors.bodies, scene.moving)
    return ImpactContacts(factors, gap, scene.contact_size(factors.bodies), law.restitution, law.friction, *linked)


def problem(world, friction=0.5, twist=None, reach=0.01):
    """The contact problem of a world where it stands, free twist and friction as given."""
    found = touch(world, reach)
    scene = world.registry.scene
    inverse = inverse_mass(scene.bodies, mb.rotations.rotation_matrices(scene.bodies.orientation), None)
    factors, none = constraints.contact_factors(found.pair, found.arms, inverse), np.zeros(len(found.gap))
    law = ContactLaw(np.full(len(none), friction), none, none, none, none)
    contacts = step_contacts(scene, factors, found.gap, law)
    twist = scene.bodies.twist if twist is None else twist
    return constraints.assemble(contacts, law, twist, found.gap, 0.0, scene.reference_mass, 1 / 240)


def block_on_floor(velocity=(0.0, 0.0, 0.0), size=(1.0, 1.0, 1.0), **settings):
    """A world without gravity with a block at rest on the floor: (world, block)."""
    world = mb.World(settings=mb.Settings(**settings))
    world.add_plane()
    return world, world.add(mb.Box(*size), mass=2.0, position=(0, 0, size[2] / 2), velocity=velocity)


def compress(W):
    """Start, column, block of a dense W (3m, 3m) as block rows; diagonal blocks are always kept."""
    m = len(W) // 3
    blocks = W.reshape(m, 3, m, 3).swapaxes(1, 2)
    filled = (blocks != 0.0).any(axis=(2, 3)) | np.eye(m, dtype=bool)
    row, column = (np.ascontiguousarray(index) for index in np.nonzero(filled))  # compiled for contiguous arrays
    return np.concatenate([[0], np.cumsum(np.bincount(row, minlength=m))]), column, np.ascontiguousarray(blocks[row, column])
