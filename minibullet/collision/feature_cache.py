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
from minibullet.collision.geometry import FACES, HALF_SPACE, between_centres, swapped
from minibullet.collision.round_bodies import is_closed, round_separation
from minibullet.collision.separation import (
    DIRECTION,
    EDGE_EDGE,
    FACE_A,
    FACE_B,
    NOWHERE,
    PLANE,
    ROUND,
    UNKNOWN,
    edge_normal,
    face_separation,
    search,
    separation,
    smaller_radius,
)
from minibullet.kernels import inlined, leaf
from minibullet.vectors import at, divided, length, negative, put, turn, turn_back

# cache tolerances: motions, lengths and depths in sizes of the smaller piece [-]
SAME_POINTS = 1e-5  # motion through which contacts stay the same points of their bodies
NO_QUERY = 1e-3  # motion below which a feature is never looked for again
FAR = 0.3  # motion after which FCL is asked: apart, separation has one maximum, and our search from the cached direction sees
#            all features within 45 degrees of it
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
        # the pair of bodies and the pair of pieces as one sortable number: a product of all four might not fit an integer
        old_key, key = (a * most[1] + b + 1j * (i * most[3] + j) for a, b, i, j in (before.T, close.T))
        order = np.argsort(old_key)
        match = order[np.minimum(np.searchsorted(old_key, key, sorter=order), len(order) - 1)]
        known = old_key[match] == key
        for array, old in zip(new, cache, strict=True):
            array[known] = old[match[known]]
    return new


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
