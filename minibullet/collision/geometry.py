"""The convex pieces of a scene, packed into arrays that kernels read.

A body is a range of pieces; bodies of equal shape share them. All coordinates are body axes about the centre of mass. A piece
is the convex hull of its vertices, thickened by its rounding radius (a sphere is one vertex, a capsule two). A half-space is a
piece without vertices and with one face.
"""

from typing import NamedTuple

import numpy as np

from minibullet.kernels import inlined
from minibullet.vectors import at, dot, minus, negative, plus, turn

HALF_SPACE, SPHERE, CAPSULE, POLYTOPE = range(4)  # kinds of piece
VERTICES, FACES, DIRECTIONS, EDGES = range(4)  # rows of Pieces.ranges


class Pieces(NamedTuple):
    """Packed geometry of p convex pieces."""

    kind: np.ndarray  # HALF_SPACE, SPHERE, CAPSULE or POLYTOPE, (p,)
    vertices: np.ndarray  # all vertices, body axes [m], (v, 3)
    normals: np.ndarray  # outward face normals, body axes [-], (f, 3)
    offsets: np.ndarray  # face planes: normal . x = offset [m], (f,)
    loops: np.ndarray  # vertex indices of the faces, counter-clockwise from outside, (l,)
    loop_ranges: np.ndarray  # first and end of each face in loops, (f, 2)
    directions: np.ndarray  # distinct edge directions, unit, body axes [-], (d, 3)
    edges: np.ndarray  # first vertex, second vertex, direction of each edge, (e, 3)
    ranges: np.ndarray  # first and end of each piece's vertices, faces, directions, edges, (p, 4, 2)
    centres: np.ndarray  # centre of each piece's bounding sphere, body axes [m], (p, 3)
    bounding_radius: np.ndarray  # about the centre, rounding included; infinite for a half-space [m], (p,)
    rounding: np.ndarray  # radius by which the hull of the vertices is thickened [m], (p,)


class Pair(NamedTuple):
    """A piece of body a, a piece of body b, and how they stand to each other."""

    a: int  # piece of a
    b: int  # piece of b
    rotation_a: np.ndarray  # body axes of a to world axes, (3, 3)
    rotation_b: np.ndarray  # body axes of b to world axes, (3, 3)
    offset: tuple  # from a's centre of mass to b's, world axes [m], (3,)


@inlined
def vertices_of(pieces, piece):
    """Indices of the vertices of a piece."""
    return range(pieces.ranges[piece, VERTICES, 0], pieces.ranges[piece, VERTICES, 1])


@inlined
def faces_of(pieces, piece):
    """Indices of the faces of a piece."""
    return range(pieces.ranges[piece, FACES, 0], pieces.ranges[piece, FACES, 1])


@inlined
def edges_of(pieces, piece):
    """Indices of the edges of a piece."""
    return range(pieces.ranges[piece, EDGES, 0], pieces.ranges[piece, EDGES, 1])


@inlined
def support(pieces, piece, direction):
    """The vertex of ``piece`` farthest along the direction (body axes), and how far that is, rounding not included [m]."""
    best, most = -1, -np.inf
    for v in vertices_of(pieces, piece):
        value = dot(direction, at(pieces.vertices, v))
        if value > most:
            best, most = v, value
    return best, most


@inlined
def side(pieces, face, k):
    """Side k of a face, from the vertex at place k of ``loops`` to the next one: start and vector, body axes [m]."""
    first, end = pieces.loop_ranges[face, 0], pieces.loop_ranges[face, 1]
    start = at(pieces.vertices, pieces.loops[k])
    return start, minus(at(pieces.vertices, pieces.loops[k + 1 if k + 1 < end else first]), start)


@inlined
def swapped(pair):
    """The same pair as b sees it."""
    return Pair(pair.b, pair.a, pair.rotation_b, pair.rotation_a, negative(pair.offset))


@inlined
def between_centres(pieces, pair):
    """From the centre of a's piece to the centre of b's, world axes [m]."""
    to_b = turn(pair.rotation_b, at(pieces.centres, pair.b))
    return minus(plus(pair.offset, to_b), turn(pair.rotation_a, at(pieces.centres, pair.a)))
