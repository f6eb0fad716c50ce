"""Closest points of two segments: edges of polytopes, cores of capsules."""

from minibullet.kernels import inlined
from minibullet.vectors import along, dot, minus, plus, scaled


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
