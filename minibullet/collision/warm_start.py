"""Contacts handed on from step to step: the same points carried along, or the impulse given to the point that is nearest."""

from typing import NamedTuple

import numpy as np

from minibullet.kernels import inlined
from minibullet.vectors import at, dot, minus, plus, put, squared_distance, turn


class WarmStart(NamedTuple):
    """What a step hands on to the next: its m contacts, and where their impulses ended."""

    on_a: np.ndarray  # the point on a's surface, body axes of a [m], (m, 3)
    on_b: np.ndarray  # the point on b's surface, body axes of b [m], (m, 3)
    normal: np.ndarray  # from a to b, world axes [-], (m, 3)
    impulse: np.ndarray  # on b, world axes [N s], (m, 3)


NO_CONTACTS = WarmStart(*np.empty((4, 0, 3)))


@inlined
def enter(points, c, bodies, on_a, on_b, normal, gap):
    """Write contact c: its bodies, the points on both surfaces about their bodies' centres, the normal (world axes), the gap."""
    points.bodies[c, 0], points.bodies[c, 1], points.gap[c] = bodies[0], bodies[1], gap
    for axis in range(3):
        points.arms[c, axis], points.arms[c, 3 + axis], points.arms[c, 6 + axis] = on_a[axis], on_b[axis], normal[axis]


@inlined
def carry(pair, bodies, last, first, end, points, total):
    """Last step's contacts from ``first`` to ``end``, carried along with their bodies, as contacts from ``total`` on; the new
    total."""
    for old in range(first, end):
        on_a, on_b = turn(pair.rotation_a, at(last.on_a, old)), turn(pair.rotation_b, at(last.on_b, old))
        normal = at(last.normal, old)
        enter(points, total, bodies, on_a, on_b, normal, dot(normal, minus(plus(on_b, pair.offset), on_a)))
        put(points.impulse, total, at(last.impulse, old))
        put(points.on_a, total, at(last.on_a, old))
        put(points.on_b, total, at(last.on_b, old))
        total += 1
    return total


@inlined
def warm_start(points, c, last, first, end, of_b, nearness):
    """Give contact c the impulse of last step's contact, of those from ``first`` to ``end``, that is nearest on the surface of
    one body and nearer (squared) than ``nearness``; no other contact may start from it."""
    mine, others = (points.on_b, last.on_b) if of_b else (points.on_a, last.on_a)
    nearest, match = nearness, -1
    for old in range(first, end):
        distance = squared_distance(at(others, old), at(mine, c))
        if distance < nearest:
            nearest, match = distance, old
    put(points.impulse, c, (0.0, 0.0, 0.0))
    if match >= 0:
        put(points.impulse, c, at(last.impulse, match))
        others[match, 0] = np.inf
