"""The convex pieces of a scene, packed into arrays that kernels read.

A body is a range of pieces; bodies of equal shape share them. All coordinates are body axes about the centre of mass. A piece
is the convex hull of its vertices, thickened by its rounding radius (a sphere is one vertex, a capsule two). A half-space is a
piece without vertices and with one face.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from minibullet import rotations
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


PARALLEL = 1e-12  # 1 - |cos| below which two edges have one direction: rounding alone, an angle of 1.4e-6
CELL = 4e-6  # more than twice the distance of the ends of two such unit vectors: what equals a line is within half a cell


def edge_directions(vertices, edges):
    """Distinct directions of a polytope's edges (first, second vertex): unit vectors (d, 3) and the index of each edge's (e,)."""
    directions, index = [], []
    lines = np.array([vertices[second] - vertices[first] for first, second in edges]).reshape(-1, 3)
    lines = lines / np.sqrt(rotations.dot(lines, lines))[:, None]
    ends = np.stack([lines, lines, -lines, -lines], axis=1) / CELL + np.array([[-0.5], [0.5], [-0.5], [0.5]])
    own, touched = (list(map(tuple, np.floor(part).tolist())) for part in (lines / CELL, ends.reshape(-1, 3)))
    known = {}  # cell of the space of unit vectors -> indices, increasing, of the directions that a line in it may equal
    for k, line in enumerate(lines):
        match = next((d for d in known.get(own[k], ()) if 1.0 - abs(rotations.dot(directions[d], line)) < PARALLEL), None)
        if match is None:
            match = len(directions)
            directions.append(line)
            for low, high in (touched[4 * k : 4 * k + 2], touched[4 * k + 2 : 4 * k + 4]):
                for cell in {low} if low == high else set(product(*zip(low, high, strict=True))):
                    known.setdefault(cell, []).append(match)
        index.append(match)
    return np.array(directions).reshape(-1, 3), np.array(index, dtype=np.int64)


def pack(shapes):
    """Pack ConvexPiece and PlaneShape objects, in order, into one Pieces record."""
    vertices, normals = ([np.reshape(getattr(s, key), (-1, 3)).astype(float) for s in shapes] for key in ("vertices", "normals"))
    offsets = [np.reshape(shape.offsets, -1).astype(float) for shape in shapes]
    edges = [np.reshape(shape.edges, (-1, 2)).astype(np.int64) for shape in shapes]
    directions, index = zip(*map(edge_directions, vertices, edges), strict=True)
    counts = np.array([list(map(len, lists)) for lists in zip(vertices, normals, directions, edges, strict=True)])
    first = counts.cumsum(axis=0) - counts
    # a half-space has a face without a loop
    loops = [
        np.array(loop, dtype=np.int64) + start
        for shape, start, faces in zip(shapes, first[:, VERTICES], counts[:, FACES], strict=True)
        for loop in (shape.faces or [()] * faces)
    ]
    loop_ends = np.cumsum([0, *map(len, loops)])
    radius = np.array([float(shape.radius) for shape in shapes])
    centres, bound = np.zeros((len(shapes), 3)), np.full(len(shapes), np.inf)
    for k, own in enumerate(vertices):
        if len(own):
            centres[k] = 0.5 * (own.min(axis=0) + own.max(axis=0))
            bound[k] = np.sqrt(((own - centres[k]) ** 2).sum(axis=1).max()) + radius[k]
    return Pieces(
        np.minimum(counts[:, VERTICES], POLYTOPE),
        np.concatenate(vertices),
        np.concatenate(normals),
        np.concatenate(offsets),
        np.concatenate(loops),
        np.stack([loop_ends[:-1], loop_ends[1:]], axis=1),
        np.concatenate(directions),
        np.concatenate(
            [np.column_stack([e + f[VERTICES], i + f[DIRECTIONS]]) for e, i, f in zip(edges, index, first, strict=True)]
        ),
        np.stack([first, first + counts], axis=2),
        centres,
        bound,
        radius,
    )


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
