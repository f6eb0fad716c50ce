"""The separation of two convex pieces, and the feature that gives it.

Two convex pieces are apart, touch or overlap by the largest separation over all directions: s(n) = min_b n.x - max_a n.x [m].
The direction of the largest is the normal of a face of either piece, the common normal of an edge of each, or, for pieces whose
corners are nearest, the line between the corners. ``search`` finds the best of these around a guess.
"""

from typing import NamedTuple

import numpy as np

from minibullet.collision.geometry import DIRECTIONS, between_centres, edges_of, faces_of, support, swapped
from minibullet.kernels import inlined, leaf
from minibullet.vectors import at, cross, divided, dot, length, minus, negative, plus, put, turn, turn_back

# kinds of feature: not known yet; the face of a half-space; a face of a, of b; an edge of each; a direction fixed in a's axes,
# which keeps corners apart; a closed form of ``round_bodies``
UNKNOWN, PLANE, FACE_A, FACE_B, EDGE_EDGE, DIRECTION, ROUND = range(7)

NOWHERE = 0.0, 0.0, 0.0  # in place of a direction
PARALLEL = 1e-4  # sine below which two edges span no direction that rounding leaves alone: faces decide there [-]

# limits of the search: lengths in sizes of the smaller piece, cosines [-]
FACING = 0.7  # cosine within which a normal looks the way of a known direction
SLAB = 0.3  # thickness of the side of a piece that looks along a direction
ANOTHER_WAY = 0.999  # cosine below which two directions are not the same
EDGE, CORNER = 1e-5, 2e-3  # by how much two edges or two corners must separate more than a face does


@inlined
def separation(pieces, pair, normal):
    """Separation of a pair along a world direction from a to b [m]."""
    far_a, far_b = turn_back(pair.rotation_a, normal), negative(turn_back(pair.rotation_b, normal))
    apart = dot(normal, pair.offset) - support(pieces, pair.a, far_a)[1] - support(pieces, pair.b, far_b)[1]
    return apart - pieces.rounding[pair.a] - pieces.rounding[pair.b]


@inlined
def face_separation(pieces, face, pair):
    """Separation of b from the plane of a face of a [m], and the face's normal, world axes."""
    normal = turn(pair.rotation_a, at(pieces.normals, face))
    nearest = support(pieces, pair.b, negative(turn_back(pair.rotation_b, normal)))[1]
    rounding = pieces.rounding[pair.a] + pieces.rounding[pair.b]
    return dot(normal, pair.offset) - pieces.offsets[face] - nearest - rounding, normal


@inlined
def edge_normal(pieces, first, second, pair):
    """Unit normal, from a to b, of an edge direction of a and one of b, world axes; zero where they are parallel."""
    normal = cross(turn(pair.rotation_a, at(pieces.directions, first)), turn(pair.rotation_b, at(pieces.directions, second)))
    size = length(normal)
    if size < PARALLEL:
        return 0.0, 0.0, 0.0
    return divided(normal, -size if dot(normal, between_centres(pieces, pair)) < 0.0 else size)


@inlined
def smaller_radius(pieces, i, j):
    """Bounding radius of the smaller of two pieces [m]."""
    return min(pieces.bounding_radius[i], pieces.bounding_radius[j])


class Workspace(NamedTuple):
    """Scratch of ``search``: the two best candidates, and lists as long as the longest list of edge directions of a piece."""

    value: np.ndarray  # separation of the best candidate and of its runner-up, preferences included [m], (2,)
    normal: np.ndarray  # their directions, a to b, world axes [-], (2, 3)
    feature: np.ndarray  # their kinds and features, (2, 3)
    lines: np.ndarray  # indices of the edge directions of a, of b that are tried (2, d)
    line: np.ndarray  # these directions, world axes [-], (2, d, 3)
    end: np.ndarray  # an end of an edge along each, world axes about the body's centre [m], (2, d, 3)


def workspace(pieces):
    """Scratch of ``search`` for these pieces."""
    most = int((pieces.ranges[:, DIRECTIONS, 1] - pieces.ranges[:, DIRECTIONS, 0]).max(initial=1))
    lines = np.empty((2, most), dtype=np.int64)
    return Workspace(
        np.empty(2), np.empty((2, 3)), np.empty((2, 3), np.int64), lines, np.empty((2, most, 3)), np.empty((2, most, 3))
    )


@inlined
def enter(work, value, normal, kind, first, second):
    """Enter a candidate direction: ``work`` holds the one that separates most and the runner-up that looks another way."""
    if value > work.value[0]:
        if dot(at(work.normal, 0), normal) < ANOTHER_WAY:
            work.value[1] = work.value[0]
            put(work.normal, 1, at(work.normal, 0))
            put(work.feature, 1, at(work.feature, 0))
        rank = 0
    elif value > work.value[1] and dot(at(work.normal, 0), normal) < ANOTHER_WAY:
        rank = 1
    else:
        return
    work.value[rank] = value
    put(work.normal, rank, normal)
    put(work.feature, rank, (kind, first, second))


@leaf
def try_faces(pieces, pair, toward, everywhere, point, own, work):
    """Enter the faces of a that look ``toward`` b (body axes); the best of them, -1 if there is none.

    point: one of b's, world axes about a's centre: no face separates the bodies by more than it lies under this point. own:
    0 where a is body a of the pair, 1 where the pair is swapped.
    """
    best, most = -1, -np.inf
    rounding = pieces.rounding[pair.a] + pieces.rounding[pair.b]
    point = turn_back(pair.rotation_a, point)
    for face in faces_of(pieces, pair.a):
        normal = at(pieces.normals, face)
        if not everywhere and dot(normal, toward) < FACING:
            continue
        bound = dot(normal, point) - pieces.offsets[face] - rounding
        if bound <= most and bound <= work.value[1]:
            continue
        apart, normal = face_separation(pieces, face, pair)
        if apart > most:
            best, most = face, apart
        enter(work, apart, normal if own == 0 else negative(normal), FACE_A + own, face, 0)
    return best


@leaf
def near_lines(pieces, piece, rotation, toward, limit, lines, line, end):
    """Edge directions of ``piece`` both of whose ends go at least as far as ``limit`` along ``toward`` (body axes): indices,
    directions and one such end into ``lines``, ``line`` and ``end``; the count."""
    count = 0
    for edge in edges_of(pieces, piece):
        start = at(pieces.vertices, pieces.edges[edge, 0])
        if dot(toward, start) < limit or dot(toward, at(pieces.vertices, pieces.edges[edge, 1])) < limit:
            continue
        place = 0
        while place < count and lines[place] != pieces.edges[edge, 2]:
            place += 1
        if place == count:
            lines[count] = pieces.edges[edge, 2]
            put(line, count, turn(rotation, at(pieces.directions, lines[count])))
            put(end, count, turn(rotation, start))
            count += 1
    return count


@inlined
def farthest(points, count, direction):
    """How far the farthest of the first ``count`` points lies along the direction [m]."""
    most = -np.inf
    for k in range(count):
        most = max(most, dot(direction, at(points, k)))
    return most


@inlined
def try_edges(pieces, pair, guess, near, counts, preference, work):
    """Enter the pairs of the first edge directions of ``work`` (so many of a, of b) that look the way of ``guess``.

    near: from a point of a to one of b, which no direction parts by more than it parts the bodies.
    """
    centres, rounding = between_centres(pieces, pair), pieces.rounding[pair.a] + pieces.rounding[pair.b]
    everywhere = guess == NOWHERE
    for first in range(counts[0]):
        for second in range(counts[1]):
            normal = cross(at(work.line[0], first), at(work.line[1], second))
            if dot(normal, centres) < 0.0:
                normal = negative(normal)
            square, cosine = dot(normal, normal), dot(normal, guess)
            if square < PARALLEL * PARALLEL:
                continue
            if not everywhere and (cosine <= 0.0 or cosine * cosine < FACING * FACING * square):
                continue
            sine = np.sqrt(square)
            least = (work.value[1] + rounding + preference) * sine
            if dot(normal, near) <= least:
                continue
            most = dot(normal, pair.offset) - farthest(work.end[0], counts[0], normal)
            if most - farthest(work.end[1], counts[1], negative(normal)) <= least:
                continue
            normal = divided(normal, sine)
            apart = separation(pieces, pair, normal) - preference
            enter(work, apart, normal, EDGE_EDGE, work.lines[0, first], work.lines[1, second])


@leaf
def search(pieces, cache, k, pair, margin, guess, work):
    """Make the direction ``guess`` for pair k exact: of it and the normals of faces and edge pairs that look its way, keep the
    one that separates most.

    The guess is FCL's, or the direction cached so far, which the bodies' small motion can only have turned a little. Where
    there is none (zero), all faces and edge pairs are tried. No direction separates the bodies by more than it separates two
    of their points: the two points that lie nearest along the guess spare most candidates the search for their own.

    Row k of ``cache`` (``feature_cache.FeatureCache``) takes the result: kind and indices of the feature, its direction, the
    gap, and its lead over the second-best direction, which says how far the bodies may move before another can be better.
    """
    size = smaller_radius(pieces, pair.a, pair.b)
    everywhere = guess == NOWHERE
    start = guess
    if everywhere:  # any direction will do to find two points that lie near
        centres = between_centres(pieces, pair)
        start = divided(centres, length(centres)) if length(centres) > 0.0 else (0.0, 0.0, 1.0)
    work.value[:], work.normal[:, :], work.feature[:, :] = -np.inf, 0.0, 0
    toward_b, toward_a = turn_back(pair.rotation_a, start), turn_back(pair.rotation_b, negative(start))
    vertex_a, reach_a = support(pieces, pair.a, toward_b)
    vertex_b, reach_b = support(pieces, pair.b, toward_a)
    point_a = turn(pair.rotation_a, at(pieces.vertices, vertex_a))
    near = minus(plus(pair.offset, turn(pair.rotation_b, at(pieces.vertices, vertex_b))), point_a)
    if not everywhere:  # the guess itself serves only corners that are clearly apart
        apart = dot(start, near) - (pieces.rounding[pair.a] + pieces.rounding[pair.b])
        enter(work, apart - CORNER * size, start, DIRECTION, 0, 0)
    cache.best_faces[k, 0] = try_faces(pieces, pair, toward_b, everywhere, plus(point_a, near), 0, work)
    cache.best_faces[k, 1] = try_faces(pieces, swapped(pair), toward_a, everywhere, minus(point_a, pair.offset), 1, work)
    # on the sides that look at each other, or everywhere, all edges; they must beat the faces, which give full manifolds
    slab_a, slab_b = SLAB * pieces.bounding_radius[pair.a], SLAB * pieces.bounding_radius[pair.b]
    limit_a, limit_b = (-np.inf, -np.inf) if everywhere else (reach_a - slab_a, reach_b - slab_b)
    count_a = near_lines(pieces, pair.a, pair.rotation_a, toward_b, limit_a, work.lines[0], work.line[0], work.end[0])
    count_b = near_lines(pieces, pair.b, pair.rotation_b, toward_a, limit_b, work.lines[1], work.line[1], work.end[1])
    try_edges(pieces, pair, guess, near, (count_a, count_b), EDGE * size, work)
    kind, best = work.feature[0, 0], work.value[0]
    preference = 0.0 if kind < EDGE_EDGE else (EDGE * size if kind == EDGE_EDGE else CORNER * size)
    cache.kind[k], cache.features[k, 0], cache.features[k, 1] = at(work.feature, 0)
    cache.gap[k], cache.lead[k] = best + preference - margin[0] - margin[1], min(best - work.value[1], size)
    cache.since_search[k], cache.since_points[k] = 0.0, np.inf
    put(cache.direction, k, turn_back(pair.rotation_a, at(work.normal, 0)))
    put(cache.normal, k, at(work.normal, 0))
