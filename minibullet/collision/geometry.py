"""The convex pieces of a scene, packed into arrays that kernels read.

A body is a range of pieces; bodies of equal shape share them. All coordinates are body axes about the centre of mass. A piece
is the convex hull of its vertices, thickened by its rounding radius (a sphere is one vertex, a capsule two). A plane is a
piece without vertices and with one face.
"""

from itertools import product
from math import sqrt
from typing import NamedTuple

import numpy as np

from minibullet.kernels import leaf
from minibullet.rotations import dot


class Pieces(NamedTuple):
    """Packed geometry of p convex pieces."""

    vertices: np.ndarray  # all vertices, body axes [m], (v, 3)
    normals: np.ndarray  # outward face normals, body axes [-], (f, 3)
    offsets: np.ndarray  # face planes: normal . x = offset [m], (f,)
    loops: np.ndarray  # vertex indices of the faces, counter-clockwise from outside, (l,)
    directions: np.ndarray  # distinct edge directions, unit, body axes [-], (d, 3)
    edges: np.ndarray  # first vertex, second vertex, direction of each edge, (e, 3)
    ranges: np.ndarray  # per piece: first and end of vertices, faces, directions, edges, (p, 8)
    face_ranges: np.ndarray  # first and end of each face in loops, (f, 2)
    centres: np.ndarray  # centre of each piece's bounding sphere, body axes [m], (p, 3)
    sizes: np.ndarray  # bounding radius, rounding radius, inner radius of each piece [m], (p, 3)


PARALLEL = 1e-12  # 1 - |cos| below which two edges have one direction: rounding alone, an angle of 1.4e-6
CELL = 4e-6  # more than twice the distance of the ends of two such unit vectors: what equals a line is within half a cell
VERTICES, FACES, DIRECTIONS, EDGES = 0, 2, 4, 6  # columns of Pieces.ranges


def edge_directions(vertices, edges):
    """Distinct directions of a polytope's edges (first, second vertex): unit vectors (d, 3) and the index of each edge's (e,)."""
    directions, index = [], []
    lines = np.array([vertices[second] - vertices[first] for first, second in edges]).reshape(-1, 3)
    lines = lines / np.sqrt(dot(lines, lines))[:, None]
    ends = np.stack([lines, lines, -lines, -lines], axis=1) / CELL + np.array([[-0.5], [0.5], [-0.5], [0.5]])
    own, reach = (list(map(tuple, np.floor(part).tolist())) for part in (lines / CELL, ends.reshape(-1, 3)))
    known = {}  # cell of the space of unit vectors -> indices, increasing, of the directions that a line in it may equal
    for k, line in enumerate(lines):
        match = next((d for d in known.get(own[k], ()) if 1.0 - abs(dot(directions[d], line)) < PARALLEL), None)
        if match is None:
            match = len(directions)
            directions.append(line)
            for low, high in (reach[4 * k : 4 * k + 2], reach[4 * k + 2 : 4 * k + 4]):
                for cell in {low} if low == high else set(product(*zip(low, high, strict=True))):
                    known.setdefault(cell, []).append(match)
        index.append(match)
    return np.array(directions).reshape(-1, 3), np.array(index, dtype=np.int64)


def pack(pieces):
    """Pack ConvexPiece and Plane objects, in order, into one Pieces record."""
    vertices, normals, offsets, loops, directions, edges = [], [], [], [], [], []
    ranges, face_ranges, centres, sizes = [], [], [], []
    counts = np.zeros(5, dtype=np.int64)  # vertices, faces, directions, edges, loop entries
    for piece in pieces:
        own_vertices = np.asarray(piece.vertices, dtype=float).reshape(-1, 3)
        own_edges = np.asarray(piece.edges, dtype=np.int64).reshape(-1, 2)
        own_normals = np.asarray(piece.normals, dtype=float).reshape(-1, 3)
        own_offsets = np.asarray(piece.offsets, dtype=float).reshape(-1)
        own_directions, index = edge_directions(own_vertices, own_edges)
        first = counts.copy()
        for face in piece.faces:
            face_ranges.append((counts[4], counts[4] + len(face)))
            loops.extend(int(v) + first[0] for v in face)
            counts[4] += len(face)
        for _ in range(len(own_normals) - len(piece.faces)):  # a plane: a face without a loop
            face_ranges.append((counts[4], counts[4]))
        edges.extend((a + first[0], b + first[0], d + first[2]) for (a, b), d in zip(own_edges, index, strict=True))
        vertices.append(own_vertices)
        normals.append(own_normals)
        offsets.append(own_offsets)
        directions.append(own_directions)
        counts[:4] += (len(own_vertices), len(own_normals), len(own_directions), len(own_edges))
        ranges.append([x for pair in zip(first[:4], counts[:4], strict=True) for x in pair])
        if len(own_vertices):
            centre = 0.5 * (own_vertices.min(axis=0) + own_vertices.max(axis=0))
            bound = np.sqrt(((own_vertices - centre) ** 2).sum(axis=1).max()) + piece.radius
            inner = (own_offsets - dot(own_normals, centre)).min() if len(own_offsets) else piece.radius
        else:
            centre, bound, inner = np.zeros(3), np.inf, np.inf
        centres.append(centre)
        sizes.append((bound, piece.radius, inner))
    stack = lambda rows, width, kind=float: np.ascontiguousarray(np.array(rows, dtype=kind).reshape(-1, width))  # noqa: E731
    return Pieces(
        np.concatenate(vertices),
        np.concatenate(normals),
        np.concatenate(offsets),
        np.array(loops, dtype=np.int64),
        np.concatenate(directions),
        stack(edges, 3, np.int64),
        stack(ranges, 8, np.int64),
        stack(face_ranges, 2, np.int64),
        stack(centres, 3),
        stack(sizes, 3),
    )


@leaf
def support(pieces, piece, x, y, z):
    """Largest value over the vertices of ``piece`` of (x, y, z) . vertex, direction in body axes, rounding not included [m]."""
    best = -np.inf
    for v in range(pieces.ranges[piece, VERTICES], pieces.ranges[piece, VERTICES + 1]):
        value = x * pieces.vertices[v, 0] + y * pieces.vertices[v, 1] + z * pieces.vertices[v, 2]
        if value > best:
            best = value
    return best


@leaf
def support_vertex(pieces, piece, x, y, z):
    """Vertex of ``piece`` farthest along (x, y, z), body axes."""
    best, most = -1, -np.inf
    for v in range(pieces.ranges[piece, VERTICES], pieces.ranges[piece, VERTICES + 1]):
        value = x * pieces.vertices[v, 0] + y * pieces.vertices[v, 1] + z * pieces.vertices[v, 2]
        if value > most:
            best, most = v, value
    return best


@leaf
def edge_vector(pieces, v, w):
    """From vertex v to vertex w, body axes [m]."""
    return (
        pieces.vertices[w, 0] - pieces.vertices[v, 0],
        pieces.vertices[w, 1] - pieces.vertices[v, 1],
        pieces.vertices[w, 2] - pieces.vertices[v, 2],
    )


@leaf
def turn(rotation, x, y, z):
    """Body axes to world axes: R (x, y, z)."""
    return (
        rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2] * z,
        rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2] * z,
        rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2] * z,
    )


@leaf
def turn_back(rotation, x, y, z):
    """World axes to body axes: R^T (x, y, z)."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
        rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z,
    )


@leaf
def length(x, y, z):
    """Euclidean length of a vector."""
    return sqrt(x * x + y * y + z * z)
