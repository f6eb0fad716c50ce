"""Who touches whom: python-fcl decides for each pair of convex pieces, and its answer is kept while it holds.

Two convex pieces are apart, touch or overlap by the largest separation over all directions: s(n) = min_b n.x - max_a n.x. FCL
finds the direction for pieces that are apart (closest points of slightly inset hulls, so that touching pieces are still apart
for FCL); the direction is then made exact: the separation of the face and edge-edge normals around it is measured and the
largest taken. An answer names the feature, not the direction, so it turns with the bodies. It has expired when the bodies
have moved by more than half its lead over the second-best direction, because only then can another direction have overtaken
it: its neighbours are measured again, and after more motion, or where only corners are near, FCL is asked again. Overlap
cannot send FCL into its penetration algorithms, which are slow and sometimes wrong. Spheres, capsules and planes have closed
forms and never reach FCL.
"""

from math import sqrt

import fcl
import numpy as np

from minibullet import pairs as pairs_module
from minibullet.geometry import DIRECTIONS, EDGES, FACES, VERTICES, length, support, turn, turn_back
from minibullet.kernels import kernel, leaf
from minibullet.separation import (
    DIRECTION,
    EDGE_EDGE,
    FACE_A,
    FACE_B,
    PLANE,
    ROUND,
    UNKNOWN,
    capsule_direction,
    edge_normal,
    evaluate,
    face_separation,
    round_normal,
    separation,
)

INSET = 0.01  # share of its size by which a hull is shrunk before FCL sees it: [-]
PATIENCE = 1e-3  # motion, in piece sizes, below which an answer is never asked again [-]
FAR = 0.1  # motion, in piece sizes, after which an answer that has expired is FCL's to give again, not ours to mend [-]
FACING = 0.7  # cosine within which a normal looks the way of a known direction [-]
SLAB = 0.3  # thickness, in piece sizes, of the side of a piece that looks along a direction [-]
DEPTH = 1e-4  # overlap, in piece sizes, from which an answer that has moved is doubted [-]


@leaf
def near_directions(pieces, piece, x, y, z, chosen):
    """Edge directions of ``piece`` on its side that looks along (x, y, z), body axes: their indices into ``chosen``, in
    order; the count.

    An edge belongs when both of its ends lie within SLAB of the piece's size from the farthest vertex.
    """
    limit = support(pieces, piece, x, y, z) - SLAB * pieces.sizes[piece, 0]
    count = 0
    for edge in range(pieces.ranges[piece, EDGES], pieces.ranges[piece, EDGES + 1]):
        v, w, direction = pieces.edges[edge, 0], pieces.edges[edge, 1], pieces.edges[edge, 2]
        if (
            x * pieces.vertices[v, 0] + y * pieces.vertices[v, 1] + z * pieces.vertices[v, 2] < limit
            or x * pieces.vertices[w, 0] + y * pieces.vertices[w, 1] + z * pieces.vertices[w, 2] < limit
        ):
            continue
        known = False
        for k in range(count):
            known = known or chosen[k] == direction
        if not known:
            chosen[count] = direction
            count += 1
    return count


@kernel
def search(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz):
    """Make the direction n for row k exact: of n and the normals of faces and edge pairs that look its way, keep the one that
    separates most.

    n is FCL's, or that of the answer kept so far, which the bodies' small motion can only have turned a little. Where there
    is none (zero), all faces and edge pairs are tried.
    """
    a, b, i, j = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
    dx, dy, dz = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
    rounding = pieces.sizes[i, 1] + pieces.sizes[j, 1]
    size = min(pieces.sizes[i, 0], pieces.sizes[j, 0])
    everywhere = nx == 0.0 and ny == 0.0 and nz == 0.0
    ax, ay, az = turn_back(rotation[a], nx, ny, nz)
    bx, by, bz = turn_back(rotation[b], -nx, -ny, -nz)
    faces_a, faces_b = (
        pieces.ranges[i, FACES + 1] - pieces.ranges[i, FACES],
        pieces.ranges[j, FACES + 1] - pieces.ranges[j, FACES],
    )
    lines_a = np.arange(pieces.ranges[i, DIRECTIONS], pieces.ranges[i, DIRECTIONS + 1])
    lines_b = np.arange(pieces.ranges[j, DIRECTIONS], pieces.ranges[j, DIRECTIONS + 1])
    if not everywhere:
        lines_a = lines_a[: near_directions(pieces, i, ax, ay, az, lines_a)]
        lines_b = lines_b[: near_directions(pieces, j, bx, by, bz, lines_b)]
    found = np.empty((faces_a + faces_b + len(lines_a) * len(lines_b) + 1, 7))
    count, face_of_a, face_of_b = 0, -1, -1
    best_a, best_b = -np.inf, -np.inf
    for face in range(pieces.ranges[i, FACES], pieces.ranges[i, FACES + 1]):
        if not everywhere and pieces.normals[face, 0] * ax + pieces.normals[face, 1] * ay + pieces.normals[face, 2] * az < FACING:
            continue
        apart, x, y, z = face_separation(pieces, face, j, rotation[a], rotation[b], dx, dy, dz, rounding)
        if apart > best_a:
            best_a, face_of_a = apart, face
        found[count] = (apart, x, y, z, float(FACE_A), float(face), 0.0)
        count += 1
    for face in range(pieces.ranges[j, FACES], pieces.ranges[j, FACES + 1]):
        if not everywhere and pieces.normals[face, 0] * bx + pieces.normals[face, 1] * by + pieces.normals[face, 2] * bz < FACING:
            continue
        apart, x, y, z = face_separation(pieces, face, i, rotation[b], rotation[a], -dx, -dy, -dz, rounding)
        if apart > best_b:
            best_b, face_of_b = apart, face
        found[count] = (apart, -x, -y, -z, float(FACE_B), float(face), 0.0)
        count += 1
    preference = 1e-5 * size  # an edge must beat the faces by this much: faces give full manifolds
    for first in lines_a:
        for second in lines_b:
            x, y, z = edge_normal(pieces, first, second, i, j, rotation[a], rotation[b], dx, dy, dz)
            if (x == 0.0 and y == 0.0 and z == 0.0) or (not everywhere and x * nx + y * ny + z * nz < FACING):
                continue
            apart = separation(pieces, i, j, rotation[a], rotation[b], dx, dy, dz, x, y, z)
            found[count] = (apart - preference, x, y, z, float(EDGE_EDGE), float(first), float(second))
            count += 1
    if not everywhere:
        apart = separation(pieces, i, j, rotation[a], rotation[b], dx, dy, dz, nx, ny, nz)
        found[count] = (apart - 2e-3 * size, nx, ny, nz, float(DIRECTION), 0.0, 0.0)  # only for corners that are clearly apart
        count += 1
    best = np.argmax(found[:count, 0])
    second_best = -np.inf
    for other in range(count):
        if found[other, 1] * found[best, 1] + found[other, 2] * found[best, 2] + found[other, 3] * found[best, 3] < 0.999:
            second_best = max(second_best, found[other, 0])
    answers[k, 0], answers[k, 1], answers[k, 2] = int(found[best, 4]), int(found[best, 5]), int(found[best, 6])
    answers[k, 3], answers[k, 4] = face_of_a, face_of_b
    x, y, z = found[best, 1], found[best, 2], found[best, 3]
    handicap = 0.0 if found[best, 4] < EDGE_EDGE else (preference if found[best, 4] == EDGE_EDGE else 2e-3 * size)
    numbers[k, 0] = found[best, 0] + handicap - margin[a] - margin[b]
    numbers[k, 1], numbers[k, 2] = 0.0, min(found[best, 0] - second_best, size)
    numbers[k, 3], numbers[k, 4], numbers[k, 5] = turn_back(rotation[a], x, y, z)
    numbers[k, 6], numbers[k, 7], numbers[k, 8], numbers[k, 10] = x, y, z, np.inf


@kernel
def adopt(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz):
    """The exact answer for row k near the direction n; an overlap found there is believed only after looking everywhere."""
    search(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz)
    size = min(pieces.sizes[rows[k, 2], 0], pieces.sizes[rows[k, 3], 0])
    if numbers[k, 0] < -DEPTH * size and (nx != 0.0 or ny != 0.0 or nz != 0.0):
        search(pieces, rows, answers, numbers, k, position, rotation, margin, 0.0, 0.0, 0.0)


@kernel
def refresh(pieces, rows, answers, numbers, position, rotation, moved, stride, margin):
    """Bring the kept answers to today's poses and return the rows that FCL must be asked about, in order.

    answers (k, 5): kind, first, second feature, best face of a, best face of b. numbers (k, 11): gap (a lower bound where
    positive), motion since the answer was made exact, lead, direction in a's axes (3), normal (3), motion since FCL was
    asked, motion since the contact points were made. A pair whose lower bound minus the motion stays beyond the reach of this
    step costs nothing.
    """
    ask = np.empty(len(rows), dtype=np.int64)
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
        if numbers[k, 0] > reach or (motion == 0.0 and answers[k, 0] != UNKNOWN):
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
        if (
            kind == DIRECTION
        ):  # it only has to keep corners apart; it may stay while the bodies are farther apart than they have moved
            if numbers[k, 1] > 0.5 * max(gap, 0.0):
                ask[count] = k
                count += 1
        elif (
            jumped
            or numbers[k, 1] > max(0.5 * numbers[k, 2], PATIENCE * size)
            or (gap < -DEPTH * size and numbers[k, 1] > 0.1 * PATIENCE * size)
        ):
            if numbers[k, 9] > FAR * size or jumped:
                ask[count] = k
                count += 1
            else:
                adopt(pieces, rows, answers, numbers, k, position, rotation, margin, nx, ny, nz)
    return ask[:count]


@leaf
def first_look(pieces, rows, answers, numbers, k, rotation, dx, dy, dz):
    """The first answer about row k: planes and round bodies have closed forms; for polytopes the line of centres may do."""
    a, b, i, j = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
    if pieces.ranges[i, VERTICES] == pieces.ranges[i, VERTICES + 1]:
        answers[k, 0], answers[k, 1] = PLANE, pieces.ranges[i, FACES]
        return
    if round_normal(pieces, i, j, rotation[a], rotation[b], dx, dy, dz)[0] < np.inf:
        answers[k, 0] = ROUND
        return
    ax, ay, az = turn(rotation[a], pieces.centres[i, 0], pieces.centres[i, 1], pieces.centres[i, 2])
    bx, by, bz = turn(rotation[b], pieces.centres[j, 0], pieces.centres[j, 1], pieces.centres[j, 2])
    cx, cy, cz = dx + bx - ax, dy + by - ay, dz + bz - az
    distance = length(cx, cy, cz)
    answers[k, 0], numbers[k, 1], numbers[k, 9] = DIRECTION, np.inf, np.inf
    if distance > 0.0:
        numbers[k, 3], numbers[k, 4], numbers[k, 5] = turn_back(rotation[a], cx / distance, cy / distance, cz / distance)


@kernel
def adopt_all(pieces, rows, answers, numbers, ask, position, rotation, margin, directions):
    """``adopt`` FCL's directions (q, 3) for the rows ``ask`` (q,)."""
    for place in range(len(ask)):
        adopt(
            pieces,
            rows,
            answers,
            numbers,
            ask[place],
            position,
            rotation,
            margin,
            directions[place, 0],
            directions[place, 1],
            directions[place, 2],
        )
        numbers[ask[place], 9] = 0.0


class Collision:
    """The list of close pieces with FCL's kept answers. One object belongs to one World; ``calls`` counts the calls of FCL."""

    def __init__(self, pieces):
        self.pieces = pieces
        self.rows = np.empty((0, 4), dtype=np.int64)  # body a, body b, piece a, piece b
        self.answers = np.empty((0, 5), dtype=np.int64)
        self.numbers = np.empty((0, 11))
        self.contact_range = np.empty((0, 2), dtype=np.int64)  # this pair's contacts of the previous step
        self.travel, self.allowance = np.empty(0), np.empty(0)  # motion since the list was made, and its limit [m], (n,)
        self.calls = 0
        self._hulls = {}  # (piece, exponent of scale, role) -> fcl object; keeps FCL's geometry alive
        self._request, self._result = fcl.DistanceRequest(enable_nearest_points=True), None

    def find(self, bodies, rotation, piece_ranges, group, margin, moved, stride):
        """Refresh the list and the answers; per body: margin [m], motion in the last step and bound on it in this one [m]."""
        self._update_list(bodies, rotation, piece_ranges, group, margin, moved, stride)
        ask = refresh(self.pieces, self.rows, self.answers, self.numbers, bodies.position, rotation, moved, stride, margin)
        if len(ask):
            directions = np.array([self._ask(k, bodies.position, rotation) for k in ask])
            adopt_all(self.pieces, self.rows, self.answers, self.numbers, ask, bodies.position, rotation, margin, directions)
        return self.rows

    def _update_list(self, bodies, rotation, piece_ranges, group, margin, moved, stride):
        """Make the list anew when some body's motion since, and the reach of this step, have used up its allowance."""
        if len(self.travel) == len(moved):
            self.travel += moved
            if not (self.travel + 1.01 * stride > self.allowance).any():
                return
        moving = np.isfinite(bodies.mass)
        size = np.array([self._body_size(first, end) for first, end in piece_ranges])
        self.travel = np.zeros(len(moved))
        # a fast body gets a thicker skin: about eight steps of its motion, or its list would be made anew at every step
        self.allowance = np.where(moving, 0.05 * size + np.minimum(8.0 * stride, 0.3 * size) + 1.5 * stride, stride)
        grown = self.allowance + 0.005 * size + margin
        lower, upper = pairs_module.bounds(self.pieces, piece_ranges, bodies.position, rotation, grown)
        body_pairs = pairs_module.overlapping(lower, upper, moving, group)
        rows = pairs_module.close_pieces(body_pairs, self.pieces, piece_ranges, bodies.position, rotation, grown)
        match = pairs_module.carry_over(self.rows, rows)
        kept = match >= 0
        answers, numbers = np.zeros((len(rows), 5), dtype=np.int64), np.zeros((len(rows), 11))
        contact_range = np.zeros((len(rows), 2), dtype=np.int64)
        answers[kept], numbers[kept], contact_range[kept] = (
            self.answers[match[kept]],
            self.numbers[match[kept]],
            self.contact_range[match[kept]],
        )
        self.rows, self.answers, self.numbers, self.contact_range = rows, answers, numbers, contact_range

    def _body_size(self, first, end):
        sizes = self.pieces.sizes[first:end, 0]
        return sizes.max() if np.isfinite(sizes).all() else 0.0

    def _hull(self, piece, exponent, role):
        key = (piece, exponent, role)
        if key not in self._hulls:
            pieces = self.pieces
            first, end = pieces.ranges[piece, VERTICES], pieces.ranges[piece, VERTICES + 1]
            points = np.ldexp(
                pieces.centres[piece] + (1.0 - INSET) * (pieces.vertices[first:end] - pieces.centres[piece]), -exponent
            )
            faces = []
            for loop_first, loop_end in pieces.face_ranges[pieces.ranges[piece, FACES] : pieces.ranges[piece, FACES + 1]]:
                loop = pieces.loops[loop_first:loop_end] - first
                faces.extend((len(loop), *loop))
            self._hulls[key] = fcl.CollisionObject(
                fcl.Convex(
                    points,
                    len(pieces.face_ranges[pieces.ranges[piece, FACES] : pieces.ranges[piece, FACES + 1]]),
                    np.array(faces, dtype=np.int64),
                ),
                fcl.Transform(),
            )
        return self._hulls[key]

    def _ask(self, k, position, rotation):
        """FCL's direction a to b for row k, world; zero where the inset hulls overlap or one is not a polytope.

        FCL's tolerances are absolute lengths, so it sees everything relative to a and scaled by a power of two to about unit
        size.
        """
        a, b, i, j = self.rows[k]
        if (
            self.pieces.ranges[i, FACES] == self.pieces.ranges[i, FACES + 1]
            or self.pieces.ranges[j, FACES] == self.pieces.ranges[j, FACES + 1]
        ):
            return self._ask_capsule(k, position, rotation)
        exponent = int(np.frexp(max(self.pieces.sizes[i, 0], self.pieces.sizes[j, 0]))[1])
        one, two = self._hull(i, exponent, "a"), self._hull(j, exponent, "b")
        back = rotation[a].T
        two.setTransform(fcl.Transform(back @ rotation[b], np.ldexp(back @ (position[b] - position[a]), -exponent)))
        result = fcl.DistanceResult()
        distance = fcl.distance(one, two, self._request, result)
        self.calls += 1
        if not distance > 0.0:
            return 0.0, 0.0, 0.0
        line = np.asarray(result.nearest_points[1]) - np.asarray(result.nearest_points[0])
        size = sqrt(line @ line)
        if not size > 0.0:
            return 0.0, 0.0, 0.0
        # FCL answers in the frame of its world, here the frame of a
        return tuple(rotation[a] @ (line / size))

    def _ask_capsule(self, k, position, rotation):
        """Direction between a capsule and a polytope: from the segment's point that lies nearest (FCL is not needed for a
        segment)."""
        a, b, i, j = self.rows[k]
        return capsule_direction(self.pieces, i, j, rotation[a], rotation[b], *(position[b] - position[a]))
