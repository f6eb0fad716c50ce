"""From one normal to a manifold: up to four contact points a pair of pieces, clipped from the faces that meet.

FCL gives one point a pair, and one point cannot hold a stack. The face whose normal is the contact normal clips the face of
the other piece that looks at it most squarely; every corner left within reach is a contact with its own gap. Points are
matched with those of the step before, so that impulses can start where they ended (warm start).
"""

from typing import NamedTuple

import numpy as np

from minibullet.collision.clipping import clip, drop_doubles, facing, support_edge, thin_out
from minibullet.collision.feature_cache import SAME_POINTS, largest_gap, margins, pair_at
from minibullet.collision.geometry import VERTICES, support, swapped
from minibullet.collision.round_bodies import round_points
from minibullet.collision.segments import midway
from minibullet.collision.separation import EDGE_EDGE, FACE_A, FACE_B, PLANE, ROUND, smaller_radius
from minibullet.collision.warm_start import carry, enter, warm_start
from minibullet.kernels import inlined, leaf
from minibullet.vectors import along, at, dot, minus, negative, plus, put, turn, turn_back

MOST = 9  # contact points of a pair of pieces: one of its own, and four over a face of either [-]
NEAR = 0.1  # a point is the same as last step's if it moved by less than this share of the piece: [-]


class ContactPoints(NamedTuple):
    """m contacts with which a step begins, in the order of the list of pairs."""

    bodies: np.ndarray  # body a and body b, (m, 2)
    arms: np.ndarray  # arm from a's centre to a's surface, from b's to b's, the normal from a to b; world axes [m, m, -], (m, 9)
    gap: np.ndarray  # distance of the surfaces along the normal, negative = overlap [m], (m,)
    impulse: np.ndarray  # last step's impulse on b, zero for a new contact, world axes [N s], (m, 3)
    on_a: np.ndarray  # the point on a's surface, body axes of a [m], (m, 3)
    on_b: np.ndarray  # the point on b's surface, body axes of b [m], (m, 3)


def build(pieces, cache, poses, scratch, last):
    """All contacts of the step, ContactPoints. ``last`` (WarmStart) is used up; ``cache.contacts`` and ``cache.since_points`` are
    brought up to date. ``scratch``: of ``clipping.polygons``."""
    most = MOST * count_near(pieces.bounding_radius, cache.pieces, cache.bodies, cache.gap, poses.motion_bound) + len(last.normal)
    points = ContactPoints(np.empty((most, 2), dtype=np.int64), np.empty((most, 9)), np.empty(most), *np.empty((3, most, 3)))
    total = fill(pieces, cache, poses, scratch, last, points)
    return ContactPoints(*[array[:total] for array in points])


@leaf
def count_near(bounding_radius, pieces, bodies, gap, motion_bound):
    """How many pairs may touch in this step. Single arrays, as whole records cost more to hand over than the work."""
    count = 0
    for k in range(len(gap)):
        size = min(bounding_radius[pieces[k, 0]], bounding_radius[pieces[k, 1]])
        count += not gap[k] > largest_gap(motion_bound, bodies[k, 0], bodies[k, 1], size)  # as in ``fill``, NaN counts
    return count


@leaf
def fill(pieces, cache, poses, scratch, last, points):
    """The work of ``build``, into arrays that are long enough; returns the number of contacts."""
    total = 0
    for k in range(len(cache.gap)):
        first, end = cache.contacts[k, 0], cache.contacts[k, 1]
        cache.contacts[k, 0] = total
        size = smaller_radius(pieces, cache.pieces[k, 0], cache.pieces[k, 1])
        most = largest_gap(poses.motion_bound, cache.bodies[k, 0], cache.bodies[k, 1], size)
        if cache.gap[k] > most or at(cache.normal, k) == (0.0, 0.0, 0.0):
            cache.since_points[k] = np.inf
        elif cache.since_points[k] <= SAME_POINTS * size:
            # nothing moved far enough to change who touches where: the same points, carried along with their bodies
            total = carry(pair_at(cache, k, poses), cache.bodies[k], last, first, end, points, total)
        else:
            pair, margin = pair_at(cache, k, poses), margins(cache, k, poses)
            count = pair_points(pieces, cache, k, pair, most, margin[0] + margin[1], scratch)
            cache.since_points[k] = 0.0 if count else np.inf
            for p in range(count):
                normal, gap = at(scratch.normals, p), scratch.gaps[p] - margin[0] - margin[1]
                # from the midpoint to either surface: they meet when the gap has closed
                on_a = along(at(scratch.points, p), -(0.5 * gap), normal)
                on_b = along(minus(at(scratch.points, p), pair.offset), 0.5 * gap, normal)
                enter(points, total, cache.bodies[k], on_a, on_b, normal, gap)
                put(points.on_a, total, turn_back(pair.rotation_a, on_a))
                put(points.on_b, total, turn_back(pair.rotation_b, on_b))
                # the same point of the same body: of a, but of b where a is a plane, over which the points of b slide
                warm_start(points, total, last, first, end, cache.kind[k] == PLANE, (NEAR * size) ** 2)
                total += 1
        cache.contacts[k, 1] = total
    return total


@inlined
def pair_points(pieces, cache, k, pair, most, margin, scratch):
    """Contact points of pair k with gaps up to ``most``, midway between the surfaces, world axes about a, with their gaps
    (margins not taken off) and normals into ``scratch``; the count."""
    kind, size = cache.kind[k], smaller_radius(pieces, pair.a, pair.b)
    if kind == FACE_A or kind == FACE_B or kind == PLANE:
        count = side_points(pieces, cache.features[k, 0], pair, kind == FACE_B, -np.inf, most + margin, scratch, 0)
        # a face that no corner lies over, or only a high one, still has its lowest corner beside the outline
        if kind != PLANE and lowest(scratch.gaps, count) > cache.gap[k] + 1e-3 * size:
            count = single_point(pieces, cache, k, pair, margin, scratch, count)
        return count
    # a feature that is no face gives one point; what else may touch lies over the face of a and that of b that separate most
    count = single_point(pieces, cache, k, pair, margin, scratch, 0)
    for side in range(2):
        face = cache.best_faces[k, side]
        if face < 0 or kind == ROUND:
            continue
        if kind == EDGE_EDGE and rise(pieces, face, pair, side == 1, cache.features[k, 1 - side]) * NEAR * size > most + margin:
            continue  # the other's edge rises out of reach within the distance at which points count as one
        count = side_points(pieces, face, pair, side == 1, 0.0, most + margin, scratch, count)
    return drop_doubles(scratch.points, scratch.gaps, scratch.normals, count, (NEAR * size) ** 2)


@inlined
def rise(pieces, face, pair, of_b, line):
    """Slope, against a face of a (or of b), of the edge direction ``line`` of the other body [-]."""
    own, other = (pair.rotation_b, pair.rotation_a) if of_b else (pair.rotation_a, pair.rotation_b)
    return abs(dot(turn(own, at(pieces.normals, face)), turn(other, at(pieces.directions, line))))


@inlined
def lowest(gaps, count):
    """The smallest of the first ``count`` gaps; infinite if there is none."""
    least = np.inf
    for p in range(count):
        least = min(least, gaps[p])
    return least


@leaf
def side_points(pieces, face, pair, of_b, least, most, scratch, first):
    """``face_points`` of a face of a (or of b) from place ``first`` on, in world axes about a, with normals from a to b; the new
    count."""
    seen = swapped(pair) if of_b else pair
    end = face_points(pieces, face, seen, least, most, scratch, first)
    normal, shift = turn(seen.rotation_a, at(pieces.normals, face)), 1.0 if of_b else 0.0
    for p in range(first, end):
        put(scratch.points, p, along(turn(seen.rotation_a, at(scratch.points, p)), shift, pair.offset))
        put(scratch.normals, p, negative(normal) if of_b else normal)
    return end


@inlined
def face_points(pieces, face, pair, least, most, scratch, first):
    """Contacts of b's piece on a face of a's with gaps from ``least`` to ``most``, from place ``first`` of ``scratch`` on: points
    midway between the surfaces, body axes of a; returns the new count.

    The face of b that looks at it most squarely (the incident face) is clipped by the outline of the face of a.
    """
    normal, points = at(pieces.normals, face), scratch.points[first:]
    offset = turn_back(pair.rotation_a, pair.offset)
    is_plane = pieces.loop_ranges[face, 0] == pieces.loop_ranges[face, 1]
    incident = -1 if is_plane else facing(pieces, pair.b, turn_back(pair.rotation_b, turn(pair.rotation_a, normal)))
    start, end = pieces.ranges[pair.b, VERTICES]  # a plane takes every vertex, a capsule offers its two ends
    if incident >= 0:
        start, end = pieces.loop_ranges[incident]
    count = 0
    for k in range(start, end):
        vertex = turn(pair.rotation_b, at(pieces.vertices, pieces.loops[k] if incident >= 0 else k))
        put(points, count, plus(turn_back(pair.rotation_a, vertex), offset))
        count += 1
    if not is_plane:
        count = clip(pieces, face, points, count, scratch)
    kept, gaps = 0, scratch.gaps[first:]
    for p in range(count):
        point = at(points, p)
        height = dot(normal, point) - pieces.offsets[face]
        gap = height - (pieces.rounding[pair.a] + pieces.rounding[pair.b])
        if least <= gap <= most:
            # midway between the two surfaces
            put(points, kept, along(point, pieces.rounding[pair.a] + 0.5 * gap - height, normal))
            gaps[kept] = gap
            kept += 1
    return first + thin_out(points, gaps, normal, kept)


@leaf
def single_point(pieces, cache, k, pair, margin, scratch, first):
    """The point midway between two edges, two round bodies or two corners, from place ``first`` of ``scratch`` on; the new
    count."""
    kind, normal, points = cache.kind[k], at(cache.normal, k), scratch.points[first:]
    count = 1
    if kind == ROUND:
        count = round_points(pieces, pair, normal, points)
    else:
        toward_b, toward_a = turn_back(pair.rotation_a, normal), turn_back(pair.rotation_b, negative(normal))
        if kind == EDGE_EDGE:
            p, u = edge_segment(pieces, support_edge(pieces, pair.a, cache.features[k, 0], toward_b), pair.rotation_a)
            q, v = edge_segment(pieces, support_edge(pieces, pair.b, cache.features[k, 1], toward_a), pair.rotation_b)
        else:
            u = v = (0.0, 0.0, 0.0)
            p = turn(pair.rotation_a, at(pieces.vertices, support(pieces, pair.a, toward_b)[0]))
            q = turn(pair.rotation_b, at(pieces.vertices, support(pieces, pair.b, toward_a)[0]))
            # at a face, the corner of the other piece says where; any corner of the face only says how high
            height = dot(normal, minus(plus(q, pair.offset), p))
            if kind == FACE_A:
                p = along(plus(q, pair.offset), -height, normal)
            elif kind == FACE_B:
                q = minus(along(p, height, normal), pair.offset)
        put(points, 0, midway(pieces, pair, p, u, q, v, normal))
    for p in range(first, first + count):
        put(scratch.normals, p, normal)
        scratch.gaps[p] = cache.gap[k] + margin
    return first + count


@inlined
def edge_segment(pieces, edge, rotation):
    """Start and vector of an edge, world axes about the body's centre [m]."""
    start = turn(rotation, at(pieces.vertices, pieces.edges[edge, 0]))
    return start, minus(turn(rotation, at(pieces.vertices, pieces.edges[edge, 1])), start)
