"""Bodies that overlap where they stand: listed, and pushed apart without giving them velocity."""

import numpy as np

from minibullet import rotations
from minibullet.collision import manifolds
from minibullet.collision.warm_start import NO_CONTACTS
from minibullet.dynamics import constraints, depenetration

TOUCH = 1e-9  # depth, in radii of the smaller body, below which bodies touch and do not overlap [-]
PLAY = 0.02  # gap, in radii of each body, up to which a pair is watched while bodies are pushed apart [-]


def list_overlaps(scene, tolerance=TOUCH):
    """Rows (index a, index b, depth [m]), deepest first; see ``World.overlaps``."""
    depth, cache = {}, scene.update_pairs(_poses(scene, 0.0))
    scene.past_motion = np.zeros(len(scene.past_motion))
    deep = np.flatnonzero(cache.gap < 0.0)
    pairs, gaps = cache.bodies[deep], cache.gap[deep]
    for (a, b), gap, size in zip(pairs.tolist(), gaps.tolist(), scene.contact_size(pairs), strict=True):
        if gap < -tolerance * size:
            depth[a, b] = max(depth.get((a, b), 0.0), -gap)
    return sorted(((*pair, d) for pair, d in depth.items()), key=lambda row: -row[2])


def separate(scene, rows, most):
    """Push overlapping bodies apart, none but the moving ones among these rows, in so many rounds at most; the largest distance
    that any was moved [m]."""
    movable = np.zeros(len(scene.names))
    movable[rows] = 1.0
    movable[~scene.moving] = 0.0
    inverse = np.zeros((len(movable), 6, 6))
    inverse[:, :3, :3] = movable[:, None, None] * np.eye(3)
    start, collision = scene.bodies.position, scene.collision
    for _ in range(most):
        if not list_overlaps(scene):
            break
        cache = collision.cache._replace(contacts=np.zeros_like(collision.cache.contacts))
        points = manifolds.build(collision.pieces, cache, _poses(scene, PLAY), collision.polygons, NO_CONTACTS)
        factors = constraints.contact_factors(points.bodies, points.arms, inverse)
        shift = depenetration.separation_displacement(factors, points.gap, np.zeros(len(points.gap)), share=1.0, sweeps=50)
        scene.bodies = scene.bodies._replace(position=scene.bodies.position + shift[:, :3])
        scene.past_motion = np.sqrt((shift[:, :3] ** 2).sum(axis=1))
        collision.cache.since_points[:] = np.inf  # last step's contact points have been left behind
    return float(np.sqrt(((scene.bodies.position - start) ** 2).sum(axis=1)).max())


def _poses(scene, play):
    """Where the bodies are; all may move by ``play`` radii."""
    return scene.poses(rotations.matrix(scene.bodies.orientation), play * scene.bounding_radius)
