"""Polygons cut by the outline of a face, and the few corners of them that are worth keeping."""

import numpy as np

from minibullet.collision.geometry import EDGES, FACES, VERTICES, edge_vector
from minibullet.kernels import leaf


def polygons(pieces):
    """Scratch for the polygons of a contact: points, their gaps and normals, and what ``clip`` needs.

    A polygon clipped by another has at most as many corners as both; the points of both sides of a pair come together.
    """
    corners = max(16, int((pieces.ranges[:, VERTICES + 1] - pieces.ranges[:, VERTICES]).max(initial=0)))
    return np.empty((4 * corners, 3)), np.empty(4 * corners), np.empty((4 * corners, 3)), np.empty((4 * corners, 4))


@leaf
def facing(pieces, piece, x, y, z):
    """Face of ``piece`` whose normal is most opposite to (x, y, z), body axes."""
    best, least = -1, np.inf
    for face in range(pieces.ranges[piece, FACES], pieces.ranges[piece, FACES + 1]):
        value = pieces.normals[face, 0] * x + pieces.normals[face, 1] * y + pieces.normals[face, 2] * z
        if value < least:
            best, least = face, value
    return best


@leaf
def clip(pieces, face, polygon, count, work):
    """Clip ``polygon`` (count points in the axes of the face's body) by the side planes of ``face``; returns the number left,
    in place.

    Sutherland and Hodgman's algorithm (Commun. ACM 17, 1974). work (at least as long, 4): the points' heights over the plane
    in column 3.
    """
    first, end = pieces.face_ranges[face, 0], pieces.face_ranges[face, 1]
    nx, ny, nz = pieces.normals[face, 0], pieces.normals[face, 1], pieces.normals[face, 2]
    for k in range(first, end):
        v, w = pieces.loops[k], pieces.loops[k + 1 if k + 1 < end else first]
        ux, uy, uz = edge_vector(pieces, v, w)
        ox, oy, oz = uy * nz - uz * ny, uz * nx - ux * nz, ux * ny - uy * nx
        limit = ox * pieces.vertices[v, 0] + oy * pieces.vertices[v, 1] + oz * pieces.vertices[v, 2]
        outside = False
        for p in range(count):
            x, y, z = polygon[p, 0], polygon[p, 1], polygon[p, 2]
            work[p, 0], work[p, 1], work[p, 2], work[p, 3] = x, y, z, ox * x + oy * y + oz * z - limit
            outside = outside or work[p, 3] > 0.0
        if not outside:
            continue
        left = 0
        for p in range(count):
            q = p + 1 if p + 1 < count else 0
            here, there = work[p, 3], work[q, 3]
            if here <= 0.0:
                polygon[left, 0], polygon[left, 1], polygon[left, 2] = work[p, 0], work[p, 1], work[p, 2]
                left += 1
            if (here < 0.0 < there or there < 0.0 < here) and not (count == 2 and p == 1):
                share = here / (here - there)
                polygon[left, 0] = work[p, 0] + share * (work[q, 0] - work[p, 0])
                polygon[left, 1] = work[p, 1] + share * (work[q, 1] - work[p, 1])
                polygon[left, 2] = work[p, 2] + share * (work[q, 2] - work[p, 2])
                left += 1
        count = left
    return count


@leaf
def thin_out(points, gaps, count):
    """Keep four of the points: the deepest, the farthest from it, and the two that span most area on either side; in place."""
    if count <= 4:
        return count
    deepest, farthest, left, right = 0, 0, -1, -1
    for p in range(count):
        if gaps[p] < gaps[deepest]:
            deepest = p
    ox, oy, oz = points[deepest, 0], points[deepest, 1], points[deepest, 2]
    best = -1.0
    for p in range(count):
        distance = (points[p, 0] - ox) ** 2 + (points[p, 1] - oy) ** 2 + (points[p, 2] - oz) ** 2
        if distance > best:
            best, farthest = distance, p
    lx, ly, lz = points[farthest, 0] - ox, points[farthest, 1] - oy, points[farthest, 2] - oz
    rx = ry = rz = high = low = 0.0
    for p in range(count):
        x, y, z = points[p, 0] - ox, points[p, 1] - oy, points[p, 2] - oz
        x, y, z = ly * z - lz * y, lz * x - lx * z, lx * y - ly * x
        if rx == 0.0 and ry == 0.0 and rz == 0.0:
            rx, ry, rz = x, y, z
        value = x * rx + y * ry + z * rz
        if value > high:
            high, left = value, p
        if value < low:
            low, right = value, p
    kept = 0
    for p in range(count):  # in the polygon's order, so that the result does not depend on the order of choice
        if p == deepest or p == farthest or p == left or p == right:
            points[kept, 0], points[kept, 1], points[kept, 2], gaps[kept] = points[p, 0], points[p, 1], points[p, 2], gaps[p]
            kept += 1
    return kept


@leaf
def support_edge(pieces, piece, direction, x, y, z):
    """Edge of ``piece`` with the given direction index that lies farthest along (x, y, z), body axes."""
    best, most = -1, -np.inf
    for edge in range(pieces.ranges[piece, EDGES], pieces.ranges[piece, EDGES + 1]):
        if pieces.edges[edge, 2] == direction:
            v, w = pieces.edges[edge, 0], pieces.edges[edge, 1]
            value = (
                x * (pieces.vertices[v, 0] + pieces.vertices[w, 0])
                + y * (pieces.vertices[v, 1] + pieces.vertices[w, 1])
                + z * (pieces.vertices[v, 2] + pieces.vertices[w, 2])
            )
            if value > most:
                best, most = edge, value
    return best


@leaf
def drop_doubles(points, gaps, normals, count, nearness):
    """Drop points closer (squared) to an earlier one than ``nearness``, in place: twice the same support only slows the
    solver."""
    kept = 0
    for p in range(count):
        double = False
        for q in range(kept):
            if (
                (points[p, 0] - points[q, 0]) ** 2 + (points[p, 1] - points[q, 1]) ** 2 + (points[p, 2] - points[q, 2]) ** 2
            ) < nearness:
                double = True
                break
        if not double:
            for axis in range(3):
                points[kept, axis], normals[kept, axis] = points[p, axis], normals[p, axis]
            gaps[kept] = gaps[p]
            kept += 1
    return kept
