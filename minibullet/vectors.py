"""Vectors of three numbers as tuples, for kernels: (x, y, z).

The sums are taken in the order x, y, z, always, so that every result has the same bits on every machine. ``rotations`` has the
functions of arrays for everything that is no kernel.
"""

from math import sqrt

from minibullet.kernels import inlined


@inlined
def at(array, k):
    """Row k of an array (n, 3)."""
    return array[k, 0], array[k, 1], array[k, 2]


@inlined
def put(array, k, v):
    """Write v into row k of an array (n, 3)."""
    array[k, 0], array[k, 1], array[k, 2] = v


@inlined
def plus(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def negative(a):
    """-a."""
    return -a[0], -a[1], -a[2]


@inlined
def scaled(factor, a):
    """factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@inlined
def divided(a, divisor):
    """a / divisor."""
    return a[0] / divisor, a[1] / divisor, a[2] / divisor


@inlined
def along(start, share, direction):
    """start + share direction."""
    return start[0] + share * direction[0], start[1] + share * direction[1], start[2] + share * direction[2]


@inlined
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def length(a):
    """Euclidean length."""
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@inlined
def squared_distance(a, b):
    """Square of the distance of two points."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@inlined
def turn(rotation, v):
    """Body axes to world axes: R v, with R (3, 3)."""
    return (
        rotation[0, 0] * v[0] + rotation[0, 1] * v[1] + rotation[0, 2] * v[2],
        rotation[1, 0] * v[0] + rotation[1, 1] * v[1] + rotation[1, 2] * v[2],
        rotation[2, 0] * v[0] + rotation[2, 1] * v[1] + rotation[2, 2] * v[2],
    )


@inlined
def turn_back(rotation, v):
    """World axes to body axes: R^T v, with R (3, 3)."""
    return (
        rotation[0, 0] * v[0] + rotation[1, 0] * v[1] + rotation[2, 0] * v[2],
        rotation[0, 1] * v[0] + rotation[1, 1] * v[1] + rotation[2, 1] * v[2],
        rotation[0, 2] * v[0] + rotation[1, 2] * v[1] + rotation[2, 2] * v[2],
    )
