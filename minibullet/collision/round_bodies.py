"""Spheres and capsules: a pair with one of them has a closed form and needs neither FCL nor the feature cache.

A sphere is a point and a capsule a segment, its core, thickened by a radius.
"""

import numpy as np

from minibullet.collision.geometry import CAPSULE, POLYTOPE, SPHERE, VERTICES, faces_of, side, swapped
from minibullet.collision.segments import midway, segment_closest
from minibullet.collision.separation import PARALLEL
from minibullet.kernels import inlined, leaf
from minibullet.vectors import (
    along,
    at,
    cross,
    divided,
    dot,
    length,
    minus,
    negative,
    plus,
    put,
    squared_distance,
    turn,
    turn_back,
)

UP = (0.0, 0.0, 1.0)


@inlined
def is_closed(pieces, pair):
    """Whether the pair has a closed form: a sphere with anything but a half-space, or two capsules."""
    return pieces.kind[pair.a] == SPHERE or pieces.kind[pair.b] == SPHERE or both_round(pieces, pair)


@inlined
def both_round(pieces, pair):
    """Whether both pieces are spheres or capsules."""
    return pieces.kind[pair.a] <= CAPSULE and pieces.kind[pair.b] <= CAPSULE


@inlined
def core(pieces, piece, rotation):
    """The core of a sphere (length zero) or capsule: start and vector, world axes about the centre of mass."""
    start = turn(rotation, at(pieces.vertices, pieces.ranges[piece, VERTICES, 0]))
    return start, minus(turn(rotation, at(pieces.vertices, pieces.ranges[piece, VERTICES, 1] - 1)), start)


@leaf
def closest_on_piece(pieces, piece, point):
    """Point of a polytope nearest to ``point``, both in its body axes; the point itself where it lies inside."""
    best, nearest, inside = np.inf, point, True
    for face in faces_of(pieces, piece):
        normal = at(pieces.normals, face)
        height = dot(normal, point) - pieces.offsets[face]
        if height <= 0.0:
            continue
        inside, within, foot = False, True, along(point, -height, normal)
        for k in range(pieces.loop_ranges[face, 0], pieces.loop_ranges[face, 1]):
            corner, edge = side(pieces, face, k)
            beyond = minus(foot, corner)
            if dot(cross(edge, normal), beyond) > 0.0:
                within = False
                on_edge = along(corner, min(max(dot(edge, beyond) / dot(edge, edge), 0.0), 1.0), edge)
                if squared_distance(point, on_edge) < best:
                    best, nearest = squared_distance(point, on_edge), on_edge
        if within and height * height < best:
            best, nearest = height * height, foot
    return point if inside else nearest


@inlined
def shallowest_face(pieces, piece, point):
    """The face that a point inside a polytope is nearest to, both in its body axes: the point's height over the face, at most
    0 [m], and the face's outward normal."""
    best, most = -1, -np.inf
    for face in faces_of(pieces, piece):
        height = dot(at(pieces.normals, face), point) - pieces.offsets[face]
        if height > most:
            best, most = face, height
    return min(most, 0.0), at(pieces.normals, best)


@inlined
def normal_of_cores(u, v):
    """The direction in which two cores (vectors u and v) that cross part soonest: their common normal, any normal of the one
    that has a length, or up where neither has one."""
    normal, length_u, length_v = cross(u, v), length(u), length(v)
    if length(normal) > PARALLEL * length_u * length_v:
        return divided(normal, length(normal))
    longer, size = (v, length_v) if length_v > length_u else (u, length_u)
    if size == 0.0:
        return UP
    x, y, z = longer
    if abs(z) < 0.7 * size:  # across it, as far up as can be
        normal = (-z * x, -z * y, size * size - z * z)
    else:
        normal = (size * size - x * x, -x * y, -x * z)
    return divided(normal, length(normal))


@leaf
def round_separation(pieces, pair):
    """Separation [m] and normal, a to b, world axes, of a pair with a closed form."""
    rounding = pieces.rounding[pair.a] + pieces.rounding[pair.b]
    p, u = core(pieces, pair.a, pair.rotation_a)
    q, v = core(pieces, pair.b, pair.rotation_b)
    if both_round(pieces, pair):
        s, t = segment_closest(p, u, plus(q, pair.offset), v)
        apart = along(minus(along(plus(q, pair.offset), t, v), p), -s, u)
        if apart == (0.0, 0.0, 0.0):
            return -rounding, normal_of_cores(u, v)
    else:
        sphere_is_a = pieces.kind[pair.a] == SPHERE
        polytope, rotation = (pair.b, pair.rotation_b) if sphere_is_a else (pair.a, pair.rotation_a)
        centre = turn_back(rotation, minus(p, pair.offset) if sphere_is_a else plus(q, pair.offset))
        nearest = closest_on_piece(pieces, polytope, centre)
        if nearest == centre:
            height, normal = shallowest_face(pieces, polytope, centre)
            normal = turn(rotation, normal)
            return height - rounding, negative(normal) if sphere_is_a else normal
        nearest = turn(rotation, nearest)
        apart = minus(plus(nearest, pair.offset), p) if sphere_is_a else minus(plus(q, pair.offset), nearest)
    distance = length(apart)
    return distance - rounding, divided(apart, distance)


@leaf
def capsule_direction(pieces, pair):
    """Direction a to b, world axes, between a capsule's core and a polytope, by ternary search for the nearest point of the
    core; zero if inside."""
    capsule_is_a = pieces.kind[pair.b] == POLYTOPE
    if capsule_is_a:
        pair = swapped(pair)
    start, vector = core(pieces, pair.b, pair.rotation_b)
    start, vector = turn_back(pair.rotation_a, plus(start, pair.offset)), turn_back(pair.rotation_a, vector)
    low, high = 0.0, 1.0
    for _ in range(60):
        s, t = low + (high - low) / 3.0, high - (high - low) / 3.0
        one, other = along(start, s, vector), along(start, t, vector)
        apart_one = length(minus(one, closest_on_piece(pieces, pair.a, one)))
        if apart_one < length(minus(other, closest_on_piece(pieces, pair.a, other))):
            high = t
        else:
            low = s
    point = along(start, low, vector)
    apart = minus(point, closest_on_piece(pieces, pair.a, point))
    size = length(apart)
    if size == 0.0:
        return 0.0, 0.0, 0.0
    direction = turn(pair.rotation_a, divided(apart, size))
    return negative(direction) if capsule_is_a else direction


@inlined
def round_points(pieces, pair, normal, points):
    """Contact points of a pair with a closed form, world axes about a, into ``points``: the count.

    Two parallel capsules touch along a line: both of its ends are given.
    """
    p, u = core(pieces, pair.a, pair.rotation_a)
    q, v = core(pieces, pair.b, pair.rotation_b)
    if not both_round(pieces, pair):
        if pieces.kind[pair.a] == SPHERE:
            put(points, 0, along(p, pieces.rounding[pair.a], normal))
        else:
            put(points, 0, along(plus(q, pair.offset), -pieces.rounding[pair.b], normal))
        return 1
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    if not (uu > 0.0 and vv > 0.0 and uu * vv - uv * uv < 1e-8 * uu * vv):
        put(points, 0, midway(pieces, pair, p, u, q, v, normal))
        return 1
    for k, end in enumerate((q, plus(q, v))):
        share = min(max(dot(u, minus(plus(end, pair.offset), p)) / uu, 0.0), 1.0)
        put(points, k, along(along(p, share, u), pieces.rounding[pair.a], normal))
    return 2
