"""Shapes packed into the arrays of ``geometry.Pieces``, once, when bodies are added."""

from itertools import product

import numpy as np

from minibullet import rotations
from minibullet.collision.geometry import DIRECTIONS, FACES, POLYTOPE, VERTICES, Pieces

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
