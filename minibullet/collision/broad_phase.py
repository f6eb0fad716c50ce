"""Which pieces may soon touch: a list that stays valid while bodies move less than its skin (Verlet list).

The skin is a layer around each body: pieces whose layers overlap are listed, although they may not touch in this step.
Bodies are swept along x by their bounding boxes, then pieces are compared by bounding spheres. The list is sorted by body and
piece indices, so its order depends on the scene alone.
"""

from typing import NamedTuple

import numpy as np

from minibullet.collision.geometry import FACES, HALF_SPACE, Pair, between_centres, vertices_of
from minibullet.kernels import inlined, kernel, leaf
from minibullet.vectors import at, dot, minus, turn


class Poses(NamedTuple):
    """Where n bodies are and how far they go, as collision sees it."""

    position: np.ndarray  # centre of mass, world frame [m], (n, 3)
    rotation: np.ndarray  # body axes to world axes, (n, 3, 3)
    margin: np.ndarray  # layer around the body that contacts keep open [m], (n,)
    past_motion: np.ndarray  # bound on the motion of any point of the body since the last look [m], (n,)
    motion_bound: np.ndarray  # bound on the motion of any point of the body in this step [m], (n,)


@kernel
def bounds(pieces, piece_ranges, poses, skin):
    """Axis-aligned box of each body, world frame, grown by its skin: lower (n, 3), upper (n, 3) [m]. That of a half-space has no
    bounds."""
    count = len(skin)
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for body in range(count):
        for piece in range(piece_ranges[body, 0], piece_ranges[body, 1]):
            if pieces.kind[piece] == HALF_SPACE:
                lower[body], upper[body] = -np.inf, np.inf
                continue
            grow = pieces.rounding[piece] + skin[body]
            for v in vertices_of(pieces, piece):
                for axis, value in enumerate(turn(poses.rotation[body], at(pieces.vertices, v))):
                    lower[body, axis] = min(lower[body, axis], value - grow + poses.position[body, axis])
                    upper[body, axis] = max(upper[body, axis], value + grow + poses.position[body, axis])
    return lower, upper


def overlapping(lower, upper, moving, group):
    """Index pairs (a < b) of bodies whose boxes overlap, at least one of them moving, groups compatible; sorted, (k, 2)."""
    order, found = np.argsort(lower[:, 0], kind="stable"), np.empty((8 * len(lower) + 64, 2), dtype=np.int64)
    count = sweep(lower, upper, moving, group, order, found)
    if count > len(found):
        found = np.empty((count, 2), dtype=np.int64)
        sweep(lower, upper, moving, group, order, found)
    found = found[:count]
    return found[np.lexsort((found[:, 1], found[:, 0]))]


@leaf
def sweep(lower, upper, moving, group, order, found):
    """How many pairs ``overlapping`` finds, sweeping along x through the bodies in ``order`` of their lower sides; as many of
    them as there is room for go into ``found``."""
    count = 0
    for place in range(len(order)):
        a = order[place]
        for after in range(place + 1, len(order)):
            b = order[after]
            if lower[b, 0] > upper[a, 0]:
                break
            if not (moving[a] or moving[b]) or (group[a] >= 0 and group[b] >= 0 and group[a] != group[b]):
                continue
            if lower[a, 1] > upper[b, 1] or lower[b, 1] > upper[a, 1] or lower[a, 2] > upper[b, 2] or lower[b, 2] > upper[a, 2]:
                continue
            if count < len(found):
                found[count, 0], found[count, 1] = min(a, b), max(a, b)
            count += 1
    return count


@inlined
def pair_of(poses, a, b, i, j):
    """Piece i of body a and piece j of body b, where they are."""
    return Pair(i, j, poses.rotation[a], poses.rotation[b], minus(at(poses.position, b), at(poses.position, a)))


@inlined
def may_touch(pieces, poses, a, b, i, j, skin):
    """Whether the bounding spheres of piece i of body a and piece j of body b are closer than ``skin`` [m]; a half-space is
    measured along its normal. Written with ``not``, so that a pair whose distance is not a number is looked at."""
    pair = pair_of(poses, a, b, i, j)
    apart, radius = between_centres(pieces, pair), pieces.bounding_radius[pair.b]
    if pieces.kind[pair.a] == HALF_SPACE:
        face = pieces.ranges[pair.a, FACES, 0]
        return not dot(turn(pair.rotation_a, at(pieces.normals, face)), apart) - pieces.offsets[face] > skin + radius
    distance = skin + pieces.bounding_radius[pair.a] + radius
    return not dot(apart, apart) > distance * distance


@kernel
def close_pieces(body_pairs, pieces, piece_ranges, poses, skin):
    """Pairs of pieces whose bounding spheres are closer than the skins: (body a, body b, piece a, piece b), (k, 4).

    A half-space always stands first in its pair.
    """
    found = np.empty((256, 4), dtype=np.int64)
    count = 0
    for k in range(len(body_pairs)):
        a, b = body_pairs[k]
        if pieces.kind[piece_ranges[b, 0]] == HALF_SPACE:
            a, b = b, a
        for i in range(piece_ranges[a, 0], piece_ranges[a, 1]):
            for j in range(piece_ranges[b, 0], piece_ranges[b, 1]):
                if may_touch(pieces, poses, a, b, i, j, skin[a] + skin[b]):
                    if count == len(found):
                        found = np.concatenate((found, np.empty_like(found)))
                    found[count, 0], found[count, 1], found[count, 2], found[count, 3] = a, b, i, j
                    count += 1
    return found[:count]
