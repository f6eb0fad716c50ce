"""Kept answers: the feature that separates two pieces most, brought to today's poses, mended, and known to have expired.

Two convex pieces are apart, touch or overlap by the largest separation over all directions: s(n) = min_b n.x - max_a n.x. An
answer names the feature that gives the direction - a face of either piece or a pair of edges -, so it turns with the bodies. It
has expired when the bodies have moved by more than half its lead over the second-best direction, because only then can
another direction have overtaken it: its neighbours are measured again, and after more motion, or where only corners are near,
FCL is asked again (``collision``).
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from minibullet.collision.geometry import DIRECTIONS, EDGES, FACES, VERTICES, length, turn, turn_back
from minibullet.collision.separation import (
    DIRECTION,
    EDGE_EDGE,
    FACE_A,
    FACE_B,
    PARALLEL,
    PLANE,
    ROUND,
    UNKNOWN,
    evaluate,
    face_separation,
    separation,
)
from minibullet.kernels import leaf

STILL = 1e-5  # motion, in piece sizes, through which contacts stay the same points of their bodies: [-]
PATIENCE = 1e-3  # motion, in piece sizes, below which an answer is never asked again [-]
FAR = 0.3  # motion, in piece sizes, after which an answer is FCL's to give again: apart, separation has one maximum, and our
#            search from the kept direction sees all features within 45 degrees of it [-]
FACING = 0.7  # cosine within which a normal looks the way of a known direction [-]
SLAB = 0.3  # thickness, in piece sizes, of the side of a piece that looks along a direction [-]
ANOTHER_WAY = 0.999  # cosine below which two directions are not the same answer [-]
EDGE, CORNER = 1e-5, 2e-3  # by how much, in piece sizes, two edges or two corners must separate more than a face does [-]
DEPTH = 1e-4  # overlap, in piece sizes, from which an answer that has moved is doubted [-]
EDGE_DEPTH = 1e-6  # the same for two edges: a face that looks almost their way may part the bodies better [-]


class Workspace(NamedTuple):
    """Scratch of ``search``, as long as the longest lists of edge directions and of vertices of a piece."""

    best: np.ndarray  # the best answer and its runner-up: separation, direction, kind, features (2, 7)
    lines: np.ndarray  # indices of the edge directions of a, of b that are tried (2, d)
    turned: np.ndarray  # these directions, then the end nearest to the other piece of an edge along each, world axes (2, d, 6)
    reach: np.ndarray  # how far the vertices of a, of b go towards the other along the given direction (2, v)


def workspace(pieces):
    """Scratch of ``search`` for these pieces."""
    most = int((pieces.ranges[:, DIRECTIONS + 1] - pieces.ranges[:, DIRECTIONS]).max(initial=1))
    corners = int((pieces.ranges[:, VERTICES + 1] - pieces.ranges[:, VERTICES]).max(initial=1))
    return Workspace(np.empty((2, 7)), np.empty((2, most), dtype=np.int64), np.empty((2, most, 6)), np.empty((2, corners)))


@leaf
def farthest_vertex(pieces, piece, x, y, z, reach):
    """Vertex of ``piece`` farthest along (x, y, z), body axes; how far every vertex goes into ``reach``."""
    first = pieces.ranges[piece, VERTICES]
    best = 0
    for k in range(pieces.ranges[piece, VERTICES + 1] - first):
        v = first + k
        reach[k] = x * pieces.vertices[v, 0] + y * pieces.vertices[v, 1] + z * pieces.vertices[v, 2]
        if reach[k] > reach[best]:
            best = k
    return first + best


@leaf
def near_directions(pieces, piece, rotation, limit, reach, chosen, turned):
    """Edge directions of ``piece`` both of whose ends go at least as far as ``limit``: their indices into ``chosen``, in order,
    and themselves and one such end in world axes into ``turned``; the count."""
    count, first = 0, pieces.ranges[piece, VERTICES]
    for edge in range(pieces.ranges[piece, EDGES], pieces.ranges[piece, EDGES + 1]):
        v, w = pieces.edges[edge, 0], pieces.edges[edge, 1]
        if reach[v - first] < limit or reach[w - first] < limit:
            continue
        d, place = pieces.edges[edge, 2], 0
        while place < count and chosen[place] != d:
            place += 1
        if place < count:
            continue
        chosen[count] = d
        turned[count, 0], turned[count, 1], turned[count, 2] = turn(
            rotation, pieces.directions[d, 0], pieces.directions[d, 1], pieces.directions[d, 2]
        )
        turned[count, 3], turned[count, 4], turned[count, 5] = turn(
            rotation, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2]
        )
        count += 1
    return count


@leaf
def farthest_end(turned, count, x, y, z):
    """How far the farthest of the ends that ``near_directions`` kept lies along (x, y, z), world axes [m]."""
    most = -np.inf
    for k in range(count):
        value = x * turned[k, 3] + y * turned[k, 4] + z * turned[k, 5]
        if value > most:
            most = value
    return most


@leaf
def height(pieces, face, rotation, x, y, z):
    """Height over a face of the point (x, y, z), world axes about the centre of the face's body [m]."""
    x, y, z = turn_back(rotation, x, y, z)
    return pieces.normals[face, 0] * x + pieces.normals[face, 1] * y + pieces.normals[face, 2] * z - pieces.offsets[face]


@leaf
def rank(best, value, x, y, z, kind, first, second):
    """Enter a candidate direction into ``best`` (2, 7), the direction that separates most and the runner-up that looks another
    way: separation, direction, kind, features."""
    if value > best[0, 0]:
        if best[0, 1] * x + best[0, 2] * y + best[0, 3] * z < ANOTHER_WAY:
            for column in range(7):
                best[1, column] = best[0, column]
        row = 0
    elif value > best[1, 0] and best[0, 1] * x + best[0, 2] * y + best[0, 3] * z < ANOTHER_WAY:
        row = 1
    else:
        return
    best[row, 0], best[row, 1], best[row, 2], best[row, 3] = value, x, y, z
    best[row, 4], best[row, 5], best[row, 6] = kind, first, second


@leaf
def search(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz, work):
    """Make the direction n for row k exact: of n and the normals of faces and edge pairs that look its way, keep the one that
    separates most.

    n is FCL's, or that of the answer kept so far, which the bodies' small motion can only have turned a little. Where there
    is none (zero), all faces and edge pairs are tried. No direction separates the bodies by more than it separates two of
    their points: the two points that lie nearest along n spare most candidates the search for their own. ``work``: scratch
    of ``workspace``.
    """
    a, b, i, j = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
    dx, dy, dz = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
    rounding = pieces.sizes[i, 1] + pieces.sizes[j, 1]
    size = min(pieces.sizes[i, 0], pieces.sizes[j, 0])
    everywhere = nx == 0.0 and ny == 0.0 and nz == 0.0
    ax, ay, az = turn(rotation[a], pieces.centres[i, 0], pieces.centres[i, 1], pieces.centres[i, 2])
    bx, by, bz = turn(rotation[b], pieces.centres[j, 0], pieces.centres[j, 1], pieces.centres[j, 2])
    cx, cy, cz = dx + bx - ax, dy + by - ay, dz + bz - az  # from centre to centre
    if everywhere:  # any direction will do to find two points that lie near
        distance = length(cx, cy, cz)
        sx, sy, sz = (cx / distance, cy / distance, cz / distance) if distance > 0.0 else (0.0, 0.0, 1.0)
    else:
        sx, sy, sz = nx, ny, nz
    best = work.best
    best[:, :] = 0.0
    best[0, 0] = best[1, 0] = -np.inf
    ax, ay, az = turn_back(rotation[a], sx, sy, sz)
    bx, by, bz = turn_back(rotation[b], -sx, -sy, -sz)
    v = farthest_vertex(pieces, i, ax, ay, az, work.reach[0])
    w = farthest_vertex(pieces, j, bx, by, bz, work.reach[1])
    px, py, pz = turn(rotation[a], pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
    qx, qy, qz = turn(rotation[b], pieces.vertices[w, 0], pieces.vertices[w, 1], pieces.vertices[w, 2])
    qx, qy, qz = dx + qx - px, dy + qy - py, dz + qz - pz  # from one of the two near points to the other
    if not everywhere:  # n itself serves only corners that are clearly apart
        apart = sx * qx + sy * qy + sz * qz - rounding
        rank(best, apart - CORNER * size, sx, sy, sz, float(DIRECTION), 0.0, 0.0)
    best_a, best_b, face_of_a, face_of_b = -np.inf, -np.inf, -1, -1
    for face in range(pieces.ranges[i, FACES], pieces.ranges[i, FACES + 1]):
        if not everywhere and pieces.normals[face, 0] * ax + pieces.normals[face, 1] * ay + pieces.normals[face, 2] * az < FACING:
            continue
        most = height(pieces, face, rotation[a], px + qx, py + qy, pz + qz) - rounding
        if most <= best_a and most <= best[1, 0]:
            continue
        apart, x, y, z = face_separation(pieces, face, j, rotation[a], rotation[b], dx, dy, dz, rounding)
        if apart > best_a:
            best_a, face_of_a = apart, face
        rank(best, apart, x, y, z, float(FACE_A), float(face), 0.0)
    for face in range(pieces.ranges[j, FACES], pieces.ranges[j, FACES + 1]):
        if not everywhere and pieces.normals[face, 0] * bx + pieces.normals[face, 1] * by + pieces.normals[face, 2] * bz < FACING:
            continue
        most = height(pieces, face, rotation[b], px - dx, py - dy, pz - dz) - rounding
        if most <= best_b and most <= best[1, 0]:
            continue
        apart, x, y, z = face_separation(pieces, face, i, rotation[b], rotation[a], -dx, -dy, -dz, rounding)
        if apart > best_b:
            best_b, face_of_b = apart, face
        rank(best, apart, -x, -y, -z, float(FACE_B), float(face), 0.0)
    preference = EDGE * size  # an edge must beat the faces by this much: faces give full manifolds
    # on the sides that look at each other, or everywhere, all edges
    slab_a, slab_b = (np.inf, np.inf) if everywhere else (SLAB * pieces.sizes[i, 0], SLAB * pieces.sizes[j, 0])
    limit = work.reach[0, v - pieces.ranges[i, VERTICES]] - slab_a
    count_a = near_directions(pieces, i, rotation[a], limit, work.reach[0], work.lines[0], work.turned[0])
    limit = work.reach[1, w - pieces.ranges[j, VERTICES]] - slab_b
    count_b = near_directions(pieces, j, rotation[b], limit, work.reach[1], work.lines[1], work.turned[1])
    for first in range(count_a):
        ux, uy, uz = work.turned[0, first, 0], work.turned[0, first, 1], work.turned[0, first, 2]
        for second in range(count_b):
            vx, vy, vz = work.turned[1, second, 0], work.turned[1, second, 1], work.turned[1, second, 2]
            x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            if x * cx + y * cy + z * cz < 0.0:
                x, y, z = -x, -y, -z
            square, along = x * x + y * y + z * z, x * nx + y * ny + z * nz
            if square < PARALLEL * PARALLEL or (not everywhere and (along <= 0.0 or along * along < FACING * FACING * square)):
                continue
            sine = sqrt(square)
            least = (best[1, 0] + rounding + preference) * sine
            if x * qx + y * qy + z * qz <= least:
                continue
            most = x * dx + y * dy + z * dz - farthest_end(work.turned[0], count_a, x, y, z)
            if most - farthest_end(work.turned[1], count_b, -x, -y, -z) <= least:
                continue
            x, y, z = x / sine, y / sine, z / sine
            apart = separation(pieces, i, j, rotation[a], rotation[b], dx, dy, dz, x, y, z)
            rank(best, apart - preference, x, y, z, float(EDGE_EDGE), float(work.lines[0, first]), float(work.lines[1, second]))
    kind = int(best[0, 4])
    answers[k, 0], answers[k, 1], answers[k, 2] = kind, int(best[0, 5]), int(best[0, 6])
    answers[k, 3], answers[k, 4] = face_of_a, face_of_b
    handicap = 0.0 if kind < EDGE_EDGE else (preference if kind == EDGE_EDGE else CORNER * size)
    numbers[k, 0] = best[0, 0] + handicap - margin[a] - margin[b]
    numbers[k, 1], numbers[k, 2] = 0.0, min(best[0, 0] - best[1, 0], size)
    numbers[k, 3], numbers[k, 4], numbers[k, 5] = turn_back(rotation[a], best[0, 1], best[0, 2], best[0, 3])
    numbers[k, 6], numbers[k, 7], numbers[k, 8], numbers[k, 10] = best[0, 1], best[0, 2], best[0, 3], np.inf


@leaf
def adopt(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz, work):
    """The exact answer for row k near the direction n; an overlap found there is believed only after looking everywhere."""
    size = min(pieces.sizes[rows[k, 2], 0], pieces.sizes[rows[k, 3], 0])
    for _ in range(2):
        search(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz, work)
        if numbers[k, 0] >= -DEPTH * size or (nx == 0.0 and ny == 0.0 and nz == 0.0):
            return
        nx = ny = nz = 0.0


@leaf
def refresh(pieces, rows, answers, numbers, position, rotation, moved, stride, margin, work, ask):
    """Bring the kept answers to today's poses; the rows that FCL must be asked about, in order, into ``ask`` (k,); their count.

    answers (k, 5): kind, first, second feature, best face of a, best face of b. numbers (k, 11): gap (a lower bound where
    positive), motion since the answer was made exact, lead, direction in a's axes (3), normal (3), motion since FCL was
    asked, motion since the contact points were made. A pair whose lower bound minus the motion stays beyond the reach of this
    step costs nothing, nor does one whose contact points stay as they are.
    """
    count = 0
    for k in range(len(rows)):
        a, b, i, j = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
        motion = moved[a] + moved[b]
        size = min(pieces.sizes[i, 0], pieces.sizes[j, 0])
        reach = stride[a] + stride[b] + 2e-3 * size
        numbers[k, 0] -= motion
        numbers[k, 1] += motion
        numbers[k, 9] += motion
        numbers[k, 10] += motion
        if numbers[k, 0] > reach or numbers[k, 10] <= STILL * size or (motion == 0.0 and answers[k, 0] != UNKNOWN):
            continue
        dx, dy, dz = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
        if answers[k, 0] == UNKNOWN:
            first_look(pieces, rows, answers, numbers, k, rotation, dx, dy, dz)
        gap, nx, ny, nz = evaluate(
            pieces, answers[k, 0], answers[k, 1], answers[k, 2], numbers[k, 3:6], i, j, rotation[a], rotation[b], dx, dy, dz
        )
        gap -= margin[a] + margin[b]
        # no separation falls faster than the bodies move: an answer that does has lost its features
        jumped = gap < numbers[k, 0] - 3.0 * motion - 1e-5 * size
        numbers[k, 0], numbers[k, 6], numbers[k, 7], numbers[k, 8] = gap, nx, ny, nz
        kind = answers[k, 0]
        if gap > reach or kind == PLANE or kind == ROUND:
            continue
        if kind == DIRECTION:
            # it only has to keep corners apart; it may stay while the bodies are farther apart than they have moved
            expired = numbers[k, 1] > 0.5 * max(gap, 0.0)
        else:
            expired = (
                jumped
                or numbers[k, 1] > max(0.5 * numbers[k, 2], PATIENCE * size)
                or (gap < -(EDGE_DEPTH if kind == EDGE_EDGE else DEPTH) * size and numbers[k, 1] > 0.1 * PATIENCE * size)
            )
        if not expired:
            continue
        if numbers[k, 9] <= FAR * size and not jumped:
            adopt(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz, work)
            if answers[k, 0] != DIRECTION or numbers[k, 0] > 0.0:
                continue
        ask[count] = k
        count += 1
    return count


@leaf
def first_look(pieces, rows, answers, numbers, k, rotation, dx, dy, dz):
    """The first answer about row k: planes and round bodies have closed forms; for polytopes the line of centres may do."""
    a, b, i, j = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
    if pieces.ranges[i, VERTICES] == pieces.ranges[i, VERTICES + 1]:
        answers[k, 0], answers[k, 1] = PLANE, pieces.ranges[i, FACES]
        return
    corners_a = pieces.ranges[i, VERTICES + 1] - pieces.ranges[i, VERTICES]
    corners_b = pieces.ranges[j, VERTICES + 1] - pieces.ranges[j, VERTICES]
    if min(corners_a, corners_b) == 1 or max(corners_a, corners_b) <= 2:  # a sphere with anything, two capsules
        answers[k, 0] = ROUND
        return
    ax, ay, az = turn(rotation[a], pieces.centres[i, 0], pieces.centres[i, 1], pieces.centres[i, 2])
    bx, by, bz = turn(rotation[b], pieces.centres[j, 0], pieces.centres[j, 1], pieces.centres[j, 2])
    cx, cy, cz = dx + bx - ax, dy + by - ay, dz + bz - az
    distance = length(cx, cy, cz)
    answers[k, 0], numbers[k, 1], numbers[k, 9] = DIRECTION, np.inf, np.inf
    if distance > 0.0:
        numbers[k, 3], numbers[k, 4], numbers[k, 5] = turn_back(rotation[a], cx / distance, cy / distance, cz / distance)


@leaf
def adopt_all(pieces, rows, answers, numbers, ask, position, rotation, margin, directions, work):
    """``adopt`` the directions (q, 3), axes of a, for the rows ``ask`` (q,)."""
    for place in range(len(ask)):
        k = ask[place]
        x, y, z = turn(rotation[rows[k, 0]], directions[place, 0], directions[place, 1], directions[place, 2])
        adopt(pieces, rows, answers, numbers, k, position, rotation, margin, x, y, z, work)
        numbers[k, 9] = 0.0


@leaf
def relative_poses(rows, ask, position, rotation, poses):
    """Orientation (3x3) and place (3) of b in the axes of a for the rows ``ask`` (q,), into ``poses`` (q, 12)."""
    for place in range(len(ask)):
        a, b = rows[ask[place], 0], rows[ask[place], 1]
        for i in range(3):
            for j in range(3):
                poses[place, 3 * i + j] = (
                    rotation[a, 0, i] * rotation[b, 0, j]
                    + rotation[a, 1, i] * rotation[b, 1, j]
                    + rotation[a, 2, i] * rotation[b, 2, j]
                )
        poses[place, 9], poses[place, 10], poses[place, 11] = turn_back(
            rotation[a], position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
        )
