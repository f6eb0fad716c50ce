"""Geometric measures of final poses, independent of either engine: NumPy only, no collision library.

Overlap of two convex polyhedra is found by the separating-axis theorem: over all face normals of both and all cross
products of their edges, the largest gap between the two shadows. Negative = depth of overlap [m]; positive = a lower
bound of the distance, exact when the nearest features are face-vertex or edge-edge.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, cKDTree


class Polyhedron(NamedTuple):
    """One convex piece in the axes of its body [m]."""

    vertices: np.ndarray  # (V, 3)
    normals: np.ndarray  # (F, 3) distinct face normals up to sign
    edges: np.ndarray  # (E, 3) distinct edge directions up to sign
    radius: float  # of the sphere about the centroid that holds it
    centre: np.ndarray  # (3,) centroid of the vertices


def distinct_directions(vectors):
    """Unit vectors (N, 3) without those parallel to an earlier one."""
    kept = []
    for vector in vectors / np.linalg.norm(vectors, axis=1, keepdims=True):
        if not any(abs(vector @ other) > 1 - 1e-9 for other in kept):
            kept.append(vector)
    return np.array(kept)


def polyhedron(points):
    """Convex hull of points (N, 3) as a Polyhedron."""
    points = np.asarray(points, float)
    hull = ConvexHull(points)
    vertices = points[hull.vertices]
    normals = hull.equations[:, :3]
    directions = []
    for i, triangle in enumerate(hull.simplices):
        for corner, j in enumerate(hull.neighbors[i]):
            if abs(normals[i] @ normals[j]) < 1 - 1e-9:  # a true edge, not a diagonal of a face
                a, b = np.delete(triangle, corner)
                directions.append(points[b] - points[a])
    centre = vertices.mean(axis=0)
    radius = np.linalg.norm(vertices - centre, axis=1).max()
    return Polyhedron(vertices, distinct_directions(normals), distinct_directions(np.array(directions)), radius, centre)


def rotation_matrix(quaternion):
    """Quaternions (..., 4) as (w, x, y, z) -> matrices (..., 3, 3)."""
    w, x, y, z = np.moveaxis(np.asarray(quaternion, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def separation(a, position_a, rotation_a, b, position_b, rotation_b):
    """Largest gap [m] between the shadows of two polyhedra; negative = they overlap by that depth."""
    offset = position_b - position_a  # about the first body's place: no digits lost far from the origin
    vertices_a = a.vertices @ rotation_a.T
    vertices_b = b.vertices @ rotation_b.T + offset
    edges_a, edges_b = a.edges @ rotation_a.T, b.edges @ rotation_b.T
    crossed = np.cross(edges_a[:, None], edges_b[None]).reshape(-1, 3)
    length = np.linalg.norm(crossed, axis=1)
    crossed = crossed[length > 1e-6] / length[length > 1e-6, None]
    axes = np.vstack([a.normals @ rotation_a.T, b.normals @ rotation_b.T, crossed])
    shadow_a, shadow_b = axes @ vertices_a.T, axes @ vertices_b.T
    gaps = np.maximum(shadow_b.min(axis=1) - shadow_a.max(axis=1), shadow_a.min(axis=1) - shadow_b.max(axis=1))
    return gaps.max()


def pair_separations(pieces, position, orientation, reach, moving=None):
    """Separations [m] below `reach` of all pieces of different bodies; all bodies have the same pieces.

    pieces: Polyhedra in body axes; position (n, 3); orientation (n, 4); moving (n,) bool leaves out pairs of fixed bodies.
    Returns an (N, 3) array: body a, body b, separation of the closest pieces of the two.
    """
    rotation = rotation_matrix(orientation)
    extent = max(np.linalg.norm(piece.vertices, axis=1).max() for piece in pieces)
    found = []
    for a, b in sorted(cKDTree(position).query_pairs(2 * extent + reach)):
        if moving is not None and not (moving[a] or moving[b]):
            continue
        nearest = np.inf
        for first in pieces:
            centre = position[a] + rotation[a] @ first.centre
            for second in pieces:
                if np.linalg.norm(position[b] + rotation[b] @ second.centre - centre) < first.radius + second.radius + reach:
                    nearest = min(nearest, separation(first, position[a], rotation[a], second, position[b], rotation[b]))
        if nearest < reach:
            found.append((a, b, nearest))
    return np.array(found).reshape(-1, 3)


def lowest(pieces, orientation):
    """Height [m] of the lowest vertex of each body over its centre (negative); orientation (n, 4)."""
    vertices = np.vstack([piece.vertices for piece in pieces])
    return (rotation_matrix(orientation) @ vertices.T)[:, 2].min(axis=1)


def highest(pieces, orientation):
    """Height [m] of the highest vertex of each body over its centre; orientation (n, 4)."""
    vertices = np.vstack([piece.vertices for piece in pieces])
    return (rotation_matrix(orientation) @ vertices.T)[:, 2].max(axis=1)


def deepest_overlap(form, planes, margin, position, orientation, fixed):
    """Deepest overlap [m] of the collision shapes (solid grown by `margin`), zero if nothing overlaps.

    form: scenes.Form; planes: (normal, height) pairs, which have no margin. Bodies with spheres use centre distances.
    """
    moving = ~np.asarray(fixed)
    if form.radius > 0:
        pairs = np.array(sorted(cKDTree(position).query_pairs(2.1 * form.radius)), dtype=int).reshape(-1, 2)
        distance = np.linalg.norm(position[pairs[:, 0]] - position[pairs[:, 1]], axis=1) - 2 * form.radius
        to_plane = [position @ np.asarray(normal) - height - form.radius for normal, height in planes]
        return max(0.0, *(-np.concatenate([distance, *to_plane])))
    pieces = [polyhedron(points) for points in form.pieces]
    depths = 2 * margin - pair_separations(pieces, position, orientation, 2 * margin, moving)[:, 2]
    deepest = [0.0, *depths]
    vertices = np.vstack(form.pieces)
    corners = rotation_matrix(orientation) @ vertices.T + position[:, :, None]
    for normal, height in planes:
        gap = np.einsum("i,nij->nj", np.asarray(normal, float), corners).min(axis=1) - height
        deepest += list(margin - gap[moving])
    return max(deepest)
