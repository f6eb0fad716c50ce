"""How far apart two convex pieces are along a direction.

Two convex pieces are apart, touch or overlap by the largest separation over all directions: s(n) = min_b n.x - max_a n.x [m].
"""

from minibullet.collision.geometry import between_centres, support
from minibullet.kernels import inlined
from minibullet.vectors import along, at, cross, divided, dot, length, minus, negative, plus, scaled, turn, turn_back

PARALLEL = 1e-4  # sine below which two edges span no direction that rounding leaves alone: faces decide there [-]


@inlined
def separation(pieces, pair, normal):
    """Separation of a pair along a world direction from a to b [m]."""
    far_a, far_b = turn_back(pair.rotation_a, normal), negative(turn_back(pair.rotation_b, normal))
    apart = dot(normal, pair.offset) - support(pieces, pair.a, far_a)[1] - support(pieces, pair.b, far_b)[1]
    return apart - pieces.rounding[pair.a] - pieces.rounding[pair.b]


@inlined
def face_separation(pieces, face, pair):
    """Separation of b from the plane of a face of a [m], and the face's normal, world axes."""
    normal = turn(pair.rotation_a, at(pieces.normals, face))
    nearest = support(pieces, pair.b, negative(turn_back(pair.rotation_b, normal)))[1]
    rounding = pieces.rounding[pair.a] + pieces.rounding[pair.b]
    return dot(normal, pair.offset) - pieces.offsets[face] - nearest - rounding, normal


@inlined
def edge_normal(pieces, first, second, pair):
    """Unit normal, from a to b, of an edge direction of a and one of b, world axes; zero where they are parallel."""
    normal = cross(turn(pair.rotation_a, at(pieces.directions, first)), turn(pair.rotation_b, at(pieces.directions, second)))
    size = length(normal)
    if size < PARALLEL:
        return 0.0, 0.0, 0.0
    return divided(normal, -size if dot(normal, between_centres(pieces, pair)) < 0.0 else size)


@inlined
def segment_closest(p, u, q, v):
    """Closest points of the segments p + s u and q + t v, 0 <= s, t <= 1: (s, t). Ericson, Real-Time Collision Detection,
    5.1.9."""
    w = minus(p, q)
    a, e, b, c, f = dot(u, u), dot(v, v), dot(u, v), dot(u, w), dot(v, w)
    determinant = a * e - b * b
    s = min(max((b * f - c * e) / determinant, 0.0), 1.0) if determinant > 1e-12 * a * e and determinant > 0.0 else 0.0
    t = (b * s + f) / e if e > 0.0 else 0.0
    if t < 0.0 or t > 1.0 or e == 0.0:
        t = min(max(t, 0.0), 1.0)
        s = min(max((b * t - c) / a, 0.0), 1.0) if a > 0.0 else 0.0
    return s, t


@inlined
def midway(pieces, pair, p, u, q, v, normal):
    """The point midway between the surfaces of two segments, p + s u of a and q + t v of b, where they are closest; world axes
    about a, but q about b."""
    s, t = segment_closest(p, u, plus(q, pair.offset), v)
    on_a = along(along(p, s, u), pieces.rounding[pair.a], normal)
    both = along(along(plus(plus(on_a, q), pair.offset), t, v), -pieces.rounding[pair.b], normal)
    return scaled(0.5, both)
