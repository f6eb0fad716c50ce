"""Polygons cut by the outline of a face, and the few corners of them that are worth keeping."""

from typing import NamedTuple

import numpy as np

from minibullet.collision.geometry import VERTICES, edges_of, faces_of, side
from minibullet.kernels import inlined
from minibullet.vectors import along, at, cross, dot, minus, plus, put, squared_distance


class Polygons(NamedTuple):
    """Scratch for the contacts of one pair of pieces: k points, and what ``clip`` needs.

    A polygon clipped by another has at most as many corners as both; the points of both sides of a pair come together.
    """

    points: np.ndarray  # (k, 3) [m]
    gaps: np.ndarray  # distance of the surfaces at each point [m], (k,)
    normals: np.ndarray  # unit normal at each point, from a to b, world axes [-], (k, 3)
    corners: np.ndarray  # the points before they are clipped by a side, (k, 3) [m]
    heights: np.ndarray  # of these points over the plane of that side [m2: not divided by its length], (k,)


def polygons(pieces):
    """Scratch that is long enough for these pieces."""
    most = 4 * max(16, int((pieces.ranges[:, VERTICES, 1] - pieces.ranges[:, VERTICES, 0]).max(initial=0)))
    return Polygons(np.empty((most, 3)), np.empty(most), np.empty((most, 3)), np.empty((most, 3)), np.empty(most))


@inlined
def facing(pieces, piece, direction):
    """Face of ``piece`` whose normal is most opposite to the direction, body axes; -1 where it has no faces."""
    best, least = -1, np.inf
    for face in faces_of(pieces, piece):
        value = dot(at(pieces.normals, face), direction)
        if value < least:
            best, least = face, value
    return best


@inlined
def clip(pieces, face, polygon, count, work):
    """Clip ``polygon`` (count points in the axes of the face's body) by the side planes of ``face``; returns the number left,
    in place.

    Sutherland and Hodgman's algorithm (Commun. ACM 17, 1974). ``work``: Polygons, for its corners and heights.
    """
    corners, heights = work.corners, work.heights
    for k in range(pieces.loop_ranges[face, 0], pieces.loop_ranges[face, 1]):
        start, edge = side(pieces, face, k)
        outward = cross(edge, at(pieces.normals, face))
        limit, outside = dot(outward, start), False
        for p in range(count):
            corner = at(polygon, p)
            put(corners, p, corner)
            heights[p] = dot(outward, corner) - limit
            outside = outside or heights[p] > 0.0
        if not outside:
            continue
        left = 0
        for p in range(count):
            q = p + 1 if p + 1 < count else 0
            here, there = heights[p], heights[q]
            if here <= 0.0:
                put(polygon, left, at(corners, p))
                left += 1
            if (here < 0.0 < there or there < 0.0 < here) and not (count == 2 and p == 1):
                put(polygon, left, along(at(corners, p), here / (here - there), minus(at(corners, q), at(corners, p))))
                left += 1
        count = left
    return count


@inlined
def thin_out(points, gaps, normal, count):
    """Keep four of the points: the deepest, the farthest from it, and the two that span most area on either side; in place. What
    lies higher than the deepest counts as so much nearer: of two corners one above the other the lower one is kept."""
    if count <= 4:
        return count
    deepest, farthest, left, right = 0, 0, -1, -1
    for p in range(count):
        if gaps[p] < gaps[deepest]:
            deepest = p
    origin, best = at(points, deepest), -1.0
    for p in range(count):
        distance = squared_distance(at(points, p), origin) - (gaps[p] - gaps[deepest]) ** 2
        if distance > best:
            best, farthest = distance, p
    diagonal, high, low = minus(at(points, farthest), origin), 0.0, 0.0
    length = np.sqrt(dot(diagonal, diagonal))
    for p in range(count):
        value = dot(normal, cross(diagonal, minus(at(points, p), origin)))
        higher = 0.5 * (gaps[p] - gaps[deepest]) * length
        if value - higher > high:
            high, left = value - higher, p
        if value + higher < low:
            low, right = value + higher, p
    kept = 0
    for p in range(count):  # in the polygon's order, so that the result does not depend on the order of choice
        if p == deepest or p == farthest or p == left or p == right:
            put(points, kept, at(points, p))
            gaps[kept] = gaps[p]
            kept += 1
    return kept


@inlined
def support_edge(pieces, piece, line, direction):
    """Edge of ``piece`` along ``line`` (an index of ``directions``) that lies farthest along the direction, body axes."""
    best, most = -1, -np.inf
    for edge in edges_of(pieces, piece):
        if pieces.edges[edge, 2] == line:
            value = dot(direction, plus(at(pieces.vertices, pieces.edges[edge, 0]), at(pieces.vertices, pieces.edges[edge, 1])))
            if value > most:
                best, most = edge, value
    return best


@inlined
def drop_doubles(points, gaps, normals, count, nearness):
    """Drop points closer (squared) to an earlier one than ``nearness``, in place: twice the same support only slows the
    solver."""
    kept = 0
    for p in range(count):
        double = False
        for q in range(kept):
            double = double or squared_distance(at(points, p), at(points, q)) < nearness
        if not double:
            put(points, kept, at(points, p))
            put(normals, kept, at(normals, p))
            gaps[kept] = gaps[p]
            kept += 1
    return kept
