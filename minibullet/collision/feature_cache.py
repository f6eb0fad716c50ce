"""The separating-feature cache: the feature that separates two pieces most, brought to today's poses, mended, and known to have
expired.

Two convex pieces are apart, touch or overlap by the largest separation over all directions: s(n) = min_b n.x - max_a n.x. The
cache names the feature that gives the direction - a face of either piece or a pair of edges -, so it turns with the bodies. It
has expired when the bodies have moved by more than half its lead over the second-best direction, because only then can
another direction have overtaken it: its neighbours are measured again, and after more motion, or where only corners are near,
FCL is asked again (``narrow_phase``).
"""

from typing import NamedTuple

import numpy as np

from minibullet.collision.broad_phase import pair_of
from minibullet.collision.geometry import DIRECTIONS, FACES, HALF_SPACE, between_centres, edges_of, faces_of, support, swapped
from minibullet.collision.round_bodies import is_closed, round_separation
from minibullet.collision.separation import PARALLEL, edge_normal, face_separation, separation
from minibullet.kernels import inlined, leaf
from minibullet.vectors import at, cross, divided, dot, length, minus, negative, plus, put, turn, turn_back

# kinds of feature: not known yet; the face of a half-space; a face of a, of b; an edge of each; a direction fixed in a's axes,
# which keeps corners apart; a closed form of ``round_bodies``
UNKNOWN, PLANE, FACE_A, FACE_B, EDGE_EDGE, DIRECTION, ROUND = range(7)

NOWHERE = 0.0, 0.0, 0.0  # in place of a direction

# cache tolerances: motions, lengths and depths in sizes of the smaller piece, cosines [-]
SAME_POINTS = 1e-5  # motion through which contacts stay the same points of their bodies
NO_QUERY = 1e-3  # motion below which a feature is never looked for again
FAR = 0.3  # motion after which FCL is asked: apart, separation has one maximum, and our search from the cached direction sees
#            all features within 45 degrees of it
FACING = 0.7  # cosine within which a normal looks the way of a known direction
SLAB = 0.3  # thickness of the side of a piece that looks along a direction
ANOTHER_WAY = 0.999  # cosine below which two directions are not the same
EDGE, CORNER = 1e-5, 2e-3  # by how much two edges or two corners must separate more than a face does
DEPTH = 1e-4  # overlap from which a feature is doubted after motion
EDGE_DEPTH = 1e-6  # the same for two edges: a face that looks almost their way may part the bodies better
DETECTION = 2e-3  # gap, beyond the motion bound, up to which a pair gets contacts


class FeatureCache(NamedTuple):
    """What is known of k pairs of pieces that may soon touch."""

    bodies: np.ndarray  # body a and body b, (k, 2)
    pieces: np.ndarray  # piece of a and piece of b, (k, 2)
    kind: np.ndarray  # kind of the separating feature, (k,)
    features: np.ndarray  # the feature: a face, or an edge direction of a and one of b, (k, 2)
    best_faces: np.ndarray  # the face of a and the face of b that separate most, -1 if there is none, (k, 2)
    gap: np.ndarray  # separation less the margins of both bodies; a lower bound where positive [m], (k,)
    lead: np.ndarray  # by how much the feature separates more than the runner-up [m], (k,)
    direction: np.ndarray  # the separating direction when it was found, body axes of a [-], (k, 3)
    normal: np.ndarray  # the separating direction now, a to b, world axes [-], (k, 3)
    since_search: np.ndarray  # bound on the relative motion since the feature was found [m], (k,)
    since_query: np.ndarray  # the same since FCL was asked [m], (k,)
    since_points: np.ndarray  # the same since contact points were made, infinite if there are none [m], (k,)
    contacts: np.ndarray  # first and end of the pair's contacts in the last step, (k, 2)


def unknown(close):
    """A cache for these close pieces (body a, body b, piece a, piece b), (k, 4), that knows nothing of them."""
    count = len(close)
    return FeatureCache(
        np.ascontiguousarray(close[:, :2]), np.ascontiguousarray(close[:, 2:]), np.zeros(count, dtype=np.int64),
        np.zeros((count, 2), dtype=np.int64), np.zeros((count, 2), dtype=np.int64), np.zeros(count), np.zeros(count),
        np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count), np.zeros(count), np.full(count, np.inf),
        np.zeros((count, 2), dtype=np.int64),
    )  # fmt: skip


def carried_over(cache, close):
    """A cache for these close pieces with all that ``cache`` knows of them."""
    new, before = unknown(close), np.hstack([cache.bodies, cache.pieces])
    if len(before) and len(close):
        most = np.maximum(before.max(axis=0), close.max(axis=0)) + 1
        old_key, key = (np.ravel_multi_index(tuple(pairs.T), most) for pairs in (before, close))
        order = np.argsort(old_key)
        match = order[np.minimum(np.searchsorted(old_key, key, sorter=order), len(order) - 1)]
        known = old_key[match] == key
        for array, old in zip(new, cache, strict=True):
            array[known] = old[match[known]]
    return new


class Workspace(NamedTuple):
    """Scratch of ``search``: the two best candidates, and lists as long as the longest list of edge directions of a piece."""

    value: np.ndarray  # separation of the best candidate and of its runner-up, preferences included [m], (2,)
    normal: np.ndarray  # their directions, a to b, world axes [-], (2, 3)
    feature: np.ndarray  # their kinds and features, (2, 3)
    lines: np.ndarray  # indices of the edge directions of a, of b that are tried (2, d)
    line: np.ndarray  # these directions, world axes [-], (2, d, 3)
    end: np.ndarray  # an end of an edge along each, world axes about the body's centre [m], (2, d, 3)


def workspace(pieces):
    """Scratch of ``search`` for these pieces."""
    most = int((pieces.ranges[:, DIRECTIONS, 1] - pieces.ranges[:, DIRECTIONS, 0]).max(initial=1))
    lines = np.empty((2, most), dtype=np.int64)
    return Workspace(
        np.empty(2), np.empty((2, 3)), np.empty((2, 3), np.int64), lines, np.empty((2, most, 3)), np.empty((2, most, 3))
    )


@inlined
def smaller_radius(pieces, i, j):
    """Bounding radius of the smaller of two pieces [m]."""
    return min(pieces.bounding_radius[i], pieces.bounding_radius[j])


@inlined
def enter(work, value, normal, kind, first, second):
    """Enter a candidate direction: ``work`` holds the one that separates most and the runner-up that looks another way."""
    if value > work.value[0]:
        if dot(at(work.normal, 0), normal) < ANOTHER_WAY:
            work.value[1] = work.value[0]
            put(work.normal, 1, at(work.normal, 0))
            put(work.feature, 1, at(work.feature, 0))
        rank = 0
    elif value > work.value[1] and dot(at(work.normal, 0), normal) < ANOTHER_WAY:
        rank = 1
    else:
        return
    work.value[rank] = value
    put(work.normal, rank, normal)
    put(work.feature, rank, (kind, first, second))


@leaf
def try_faces(pieces, pair, toward, everywhere, point, own, work):
    """Enter the faces of a that look ``toward`` b (body axes); the best of them, -1 if there is none.

    point: one of b's, world axes about a's centre: no face separates the bodies by more than it lies under this point. own:
    0 where a is body a of the pair, 1 where the pair is swapped.
    """
    best, most = -1, -np.inf
    rounding = pieces.rounding[pair.a] + pieces.rounding[pair.b]
    point = turn_back(pair.rotation_a, point)
    for face in faces_of(pieces, pair.a):
        normal = at(pieces.normals, face)
        if not everywhere and dot(normal, toward) < FACING:
            continue
        bound = dot(normal, point) - pieces.offsets[face] - rounding
        if bound <= most and bound <= work.value[1]:
            continue
        apart, normal = face_separation(pieces, face, pair)
        if apart > most:
            best, most = face, apart
        enter(work, apart, normal if own == 0 else negative(normal), FACE_A + own, face, 0)
    return best


@leaf
def near_lines(pieces, piece, rotation, toward, limit, lines, line, end):
    """Edge directions of ``piece`` both of whose ends go at least as far as ``limit`` along ``toward`` (body axes): indices,
    directions and one such end into ``lines``, ``line`` and ``end``; the count."""
    count = 0
    for edge in edges_of(pieces, piece):
        start = at(pieces.vertices, pieces.edges[edge, 0])
        if dot(toward, start) < limit or dot(toward, at(pieces.vertices, pieces.edges[edge, 1])) < limit:
            continue
        place = 0
        while place < count and lines[place] != pieces.edges[edge, 2]:
            place += 1
        if place == count:
            lines[count] = pieces.edges[edge, 2]
            put(line, count, turn(rotation, at(pieces.directions, lines[count])))
            put(end, count, turn(rotation, start))
            count += 1
    return count


@inlined
def farthest(points, count, direction):
    """How far the farthest of the first ``count`` points lies along the direction [m]."""
    most = -np.inf
    for k in range(count):
        most = max(most, dot(direction, at(points, k)))
    return most


@inlined
def try_edges(pieces, pair, guess, near, counts, preference, work):
    """Enter the pairs of the first edge directions of ``work`` (so many of a, of b) that look the way of ``guess``.

    near: from a point of a to one of b, which no direction parts by more than it parts the bodies.
    """
    centres, rounding = between_centres(pieces, pair), pieces.rounding[pair.a] + pieces.rounding[pair.b]
    everywhere = guess == NOWHERE
    for first in range(counts[0]):
        for second in range(counts[1]):
            normal = cross(at(work.line[0], first), at(work.line[1], second))
            if dot(normal, centres) < 0.0:
                normal = negative(normal)
            square, cosine = dot(normal, normal), dot(normal, guess)
            if square < PARALLEL * PARALLEL:
                continue
            if not everywhere and (cosine <= 0.0 or cosine * cosine < FACING * FACING * square):
                continue
            sine = np.sqrt(square)
            least = (work.value[1] + rounding + preference) * sine
            if dot(normal, near) <= least:
                continue
            most = dot(normal, pair.offset) - farthest(work.end[0], counts[0], normal)
            if most - farthest(work.end[1], counts[1], negative(normal)) <= least:
                continue
            normal = divided(normal, sine)
            apart = separation(pieces, pair, normal) - preference
            enter(work, apart, normal, EDGE_EDGE, work.lines[0, first], work.lines[1, second])


@leaf
def search(pieces, cache, k, pair, margin, guess, work):
    """Make the direction ``guess`` for pair k exact: of it and the normals of faces and edge pairs that look its way, keep the
    one that separates most.

    The guess is FCL's, or the direction cached so far, which the bodies' small motion can only have turned a little. Where
    there is none (zero), all faces and edge pairs are tried. No direction separates the bodies by more than it separates two
    of their points: the two points that lie nearest along the guess spare most candidates the search for their own.
    """
    size = smaller_radius(pieces, pair.a, pair.b)
    everywhere = guess == NOWHERE
    start = guess
    if everywhere:  # any direction will do to find two points that lie near
        centres = between_centres(pieces, pair)
        start = divided(centres, length(centres)) if length(centres) > 0.0 else (0.0, 0.0, 1.0)
    work.value[:], work.normal[:, :], work.feature[:, :] = -np.inf, 0.0, 0
    toward_b, toward_a = turn_back(pair.rotation_a, start), turn_back(pair.rotation_b, negative(start))
    vertex_a, reach_a = support(pieces, pair.a, toward_b)
    vertex_b, reach_b = support(pieces, pair.b, toward_a)
    point_a = turn(pair.rotation_a, at(pieces.vertices, vertex_a))
    near = minus(plus(pair.offset, turn(pair.rotation_b, at(pieces.vertices, vertex_b))), point_a)
    if not everywhere:  # the guess itself serves only corners that are clearly apart
        apart = dot(start, near) - (pieces.rounding[pair.a] + pieces.rounding[pair.b])
        enter(work, apart - CORNER * size, start, DIRECTION, 0, 0)
    cache.best_faces[k, 0] = try_faces(pieces, pair, toward_b, everywhere, plus(point_a, near), 0, work)
    cache.best_faces[k, 1] = try_faces(pieces, swapped(pair), toward_a, everywhere, minus(point_a, pair.offset), 1, work)
    # on the sides that look at each other, or everywhere, all edges; they must beat the faces, which give full manifolds
    slab_a, slab_b = SLAB * pieces.bounding_radius[pair.a], SLAB * pieces.bounding_radius[pair.b]
    limit_a, limit_b = (-np.inf, -np.inf) if everywhere else (reach_a - slab_a, reach_b - slab_b)
    count_a = near_lines(pieces, pair.a, pair.rotation_a, toward_b, limit_a, work.lines[0], work.line[0], work.end[0])
    count_b = near_lines(pieces, pair.b, pair.rotation_b, toward_a, limit_b, work.lines[1], work.line[1], work.end[1])
    try_edges(pieces, pair, guess, near, (count_a, count_b), EDGE * size, work)
    kind, best = work.feature[0, 0], work.value[0]
    preference = 0.0 if kind < EDGE_EDGE else (EDGE * size if kind == EDGE_EDGE else CORNER * size)
    cache.kind[k], cache.features[k, 0], cache.features[k, 1] = at(work.feature, 0)
    cache.gap[k], cache.lead[k] = best + preference - margin[0] - margin[1], min(best - work.value[1], size)
    cache.since_search[k], cache.since_points[k] = 0.0, np.inf
    put(cache.direction, k, turn_back(pair.rotation_a, at(work.normal, 0)))
    put(cache.normal, k, at(work.normal, 0))


@leaf
def revalidate(pieces, cache, k, pair, margin, guess, work):
    """The exact feature for pair k near the direction ``guess``; an overlap found there is believed only after looking
    everywhere."""
    search(pieces, cache, k, pair, margin, guess, work)
    if not cache.gap[k] >= -DEPTH * smaller_radius(pieces, pair.a, pair.b) and guess != NOWHERE:
        search(pieces, cache, k, pair, margin, NOWHERE, work)


@inlined
def pair_at(cache, k, poses):
    """Pair k, where its bodies are."""
    return pair_of(poses, cache.bodies[k, 0], cache.bodies[k, 1], cache.pieces[k, 0], cache.pieces[k, 1])


@inlined
def margins(cache, k, poses):
    """Margins of both bodies of pair k [m]."""
    return poses.margin[cache.bodies[k, 0]], poses.margin[cache.bodies[k, 1]]


@inlined
def largest_gap(motion_bound, a, b, size):
    """Gap beyond which pieces of bodies a and b, the smaller of them of this size, get no contacts in this step [m]."""
    return motion_bound[a] + motion_bound[b] + DETECTION * size


@inlined
def evaluate(pieces, kind, first, second, direction, pair):
    """Separation of a pair along its cached feature at today's poses [m], -inf where the feature has no normal, and the normal, a
    to b, world axes."""
    if kind == FACE_A or kind == PLANE:
        return face_separation(pieces, first, pair)
    if kind == FACE_B:
        apart, normal = face_separation(pieces, first, swapped(pair))
        return apart, negative(normal)
    if kind == ROUND:
        return round_separation(pieces, pair)
    if kind == EDGE_EDGE:
        normal = edge_normal(pieces, first, second, pair)
    else:
        normal = turn(pair.rotation_a, direction)
    return (-np.inf if normal == NOWHERE else separation(pieces, pair, normal)), normal


@inlined
def begin(pieces, cache, k, pair):
    """The first feature of pair k: half-spaces and round bodies have closed forms; for polytopes the line of centres may do."""
    if pieces.kind[pair.a] == HALF_SPACE:
        cache.kind[k], cache.features[k, 0] = PLANE, pieces.ranges[pair.a, FACES, 0]
    elif is_closed(pieces, pair):
        cache.kind[k] = ROUND
    else:
        centres = between_centres(pieces, pair)
        cache.kind[k], cache.since_search[k], cache.since_query[k] = DIRECTION, np.inf, np.inf
        if length(centres) > 0.0:
            put(cache.direction, k, turn_back(pair.rotation_a, divided(centres, length(centres))))


@inlined
def expired(cache, k, size, jumped):
    """Whether another direction may separate pair k more than its cached feature does."""
    kind, moved = cache.kind[k], cache.since_search[k]
    if kind == PLANE or kind == ROUND:
        return False
    if kind == DIRECTION:
        # it only has to keep corners apart; it may stay while the bodies are farther apart than they have moved
        return moved > 0.5 * max(cache.gap[k], 0.0)
    deep = cache.gap[k] < -(EDGE_DEPTH if kind == EDGE_EDGE else DEPTH) * size and moved > 0.1 * NO_QUERY * size
    return jumped or moved > max(0.5 * cache.lead[k], NO_QUERY * size) or deep


@leaf
def update(pieces, cache, poses, work, queries):
    """Bring the cache to today's poses; the pairs that FCL must be asked about, in order, into ``queries`` (k,); their count.

    A pair whose lower bound minus the motion stays beyond the largest gap of this step costs nothing, nor does one whose
    contact points stay as they are.
    """
    count = 0
    for k in range(len(cache.kind)):
        a, b, size = cache.bodies[k, 0], cache.bodies[k, 1], smaller_radius(pieces, cache.pieces[k, 0], cache.pieces[k, 1])
        motion, most = poses.past_motion[a] + poses.past_motion[b], largest_gap(poses.motion_bound, a, b, size)
        cache.gap[k] -= motion
        cache.since_search[k] += motion
        cache.since_query[k] += motion
        cache.since_points[k] += motion
        unmoved = motion == 0.0 and cache.kind[k] != UNKNOWN
        if cache.gap[k] > most or cache.since_points[k] <= SAME_POINTS * size or unmoved:
            continue
        pair = pair_at(cache, k, poses)
        if cache.kind[k] == UNKNOWN:
            begin(pieces, cache, k, pair)
        margin = margins(cache, k, poses)
        first, second = cache.features[k, 0], cache.features[k, 1]
        apart, normal = evaluate(pieces, cache.kind[k], first, second, at(cache.direction, k), pair)
        gap = apart - (margin[0] + margin[1])
        # no separation falls faster than the bodies move: one that does has lost its features
        jumped = gap < cache.gap[k] - 3.0 * motion - 1e-5 * size
        cache.gap[k] = gap
        put(cache.normal, k, normal)
        if gap > most or not expired(cache, k, size, jumped):
            continue
        if cache.since_query[k] <= FAR * size and not jumped:
            revalidate(pieces, cache, k, pair, margin, normal, work)
            if cache.kind[k] != DIRECTION or cache.gap[k] > 0.0:
                continue
        queries[count] = k
        count += 1
    return count


@leaf
def revalidate_all(pieces, cache, poses, queries, directions, work):
    """``revalidate`` the directions (q, 3), body axes of a, that FCL gave for the pairs ``queries`` (q,)."""
    for place in range(len(queries)):
        k = queries[place]
        pair = pair_at(cache, k, poses)
        revalidate(pieces, cache, k, pair, margins(cache, k, poses), turn(pair.rotation_a, at(directions, place)), work)
        cache.since_query[k] = 0.0


@leaf
def relative_poses(cache, poses, queries, orientation, place):
    """Orientation (q, 3, 3) and place (q, 3) of b in the body axes of a for the pairs ``queries`` (q,)."""
    for q in range(len(queries)):
        pair = pair_at(cache, queries[q], poses)
        a, b = pair.rotation_a, pair.rotation_b
        for i in range(3):
            for j in range(3):
                orientation[q, i, j] = a[0, i] * b[0, j] + a[1, i] * b[1, j] + a[2, i] * b[2, j]
        put(place, q, turn_back(a, pair.offset))
