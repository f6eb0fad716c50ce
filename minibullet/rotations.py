"""Unit quaternions (w, x, y, z): how bodies are turned.

A quaternion q = (cos(a/2), n sin(a/2)) turns vectors by the angle a about the unit axis n; it takes body axes to
world axes. All functions work on arrays of shape (..., 4) or (..., 3) and broadcast; angles are in radians.
Formulas: J. Diebel, Representing attitude (2006); M. D. Shuster, A survey of attitude representations (1993).
"""

from math import atan2, cos, sin

import numpy as np

from minibullet.kernels import kernel, leaf
from minibullet.vectors import at, length, put, scaled

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
IDENTITY.setflags(write=False)


def product(a, b):
    """Hamilton product a b: turn by b first, then by a. (..., 4), (..., 4) -> (..., 4)."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    if a.shape != b.shape:
        a, b = map(np.array, np.broadcast_arrays(a, b))
    return _products(np.ascontiguousarray(a).reshape(-1, 4), np.ascontiguousarray(b).reshape(-1, 4)).reshape(a.shape)


@kernel
def _products(a, b):
    result = np.empty_like(a)
    for n in range(len(a)):
        result[n, 0], result[n, 1], result[n, 2], result[n, 3] = one_product(quaternion(a, n), quaternion(b, n))
    return result


@leaf
def one_product(a, b):
    """The same of two quaternions, tuples."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(q):
    """The opposite turn of a unit quaternion: (w, -x, -y, -z)."""
    return np.asarray(q, dtype=float) * np.array([1.0, -1.0, -1.0, -1.0])


def normalised(q):
    """q divided by its length; a zero or non-finite quaternion gives NaN, which callers refuse by name."""
    q = np.asarray(q, dtype=float)
    # Dividing by a power of two first keeps the squares from over- or underflowing and rounds nothing.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        q = np.ldexp(q, -np.frexp(np.max(np.abs(q), axis=-1, keepdims=True))[1])
        return q / np.sqrt(np.sum(q * q, axis=-1, keepdims=True))


def matrix(q):
    """Rotation matrix R with R v = rotate(q, v); columns are the body axes in the world. (..., 4) -> (..., 3, 3)."""
    q = np.array(q, dtype=float)
    return rotation_matrices(q.reshape(-1, 4)).reshape(*q.shape[:-1], 3, 3)


@leaf
def quaternion(orientation, n):
    """Row n of an array of quaternions (n, 4), as a tuple."""
    return orientation[n, 0], orientation[n, 1], orientation[n, 2], orientation[n, 3]


@kernel
def rotation_matrices(orientation):
    """The same of an array of quaternions (n, 4): (n, 3, 3)."""
    result = np.empty((len(orientation), 3, 3))
    for n in range(len(orientation)):
        w, x, y, z = quaternion(orientation, n)
        R = result[n]
        R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return result


def from_matrix(rotation):
    """The unit quaternion, w >= 0, of a rotation matrix: (..., 3, 3) -> (..., 4).

    Shepperd's method: of the four equivalent formulas take the one that divides by the largest component.
    S. W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978) 223-224.
    """
    r = np.asarray(rotation, dtype=float)
    xx, yy, zz = r[..., 0, 0], r[..., 1, 1], r[..., 2, 2]
    wx, wy, wz = r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]
    xy, xz, yz = r[..., 0, 1] + r[..., 1, 0], r[..., 0, 2] + r[..., 2, 0], r[..., 1, 2] + r[..., 2, 1]
    # Row k of this symmetric matrix is 4 q_k q.
    outer = np.stack(
        [
            np.stack(row, axis=-1)
            for row in (
                (1 + xx + yy + zz, wx, wy, wz),
                (wx, 1 + xx - yy - zz, xy, xz),
                (wy, xy, 1 - xx + yy - zz, yz),
                (wz, xz, yz, 1 - xx - yy + zz),
            )
        ],
        axis=-2,
    )
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(outer, largest[..., None, None], axis=-2)[..., 0, :]
    return normalised(np.where(row[..., :1] < 0, -row, row))


def rotate(q, v):
    """Turn vectors: body components to world components. (..., 4), (..., 3) -> (..., 3)."""
    q, v = np.asarray(q, dtype=float), np.asarray(v, dtype=float)
    axis = q[..., 1:]
    twice = 2.0 * cross(axis, v)
    return v + q[..., :1] * twice + cross(axis, twice)


def cross(a, b):
    """Vector product. (..., 3), (..., 3) -> (..., 3). The bits of numpy's own, which takes twice the time on a few vectors."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def cosine_and_sine(angle):
    """Cosine and sine of an array of angles [rad], in its shape; the C library's, as in the kernels: NumPy's own functions of
    arrays depend on the processor and on the version in the last bit."""
    angle = np.asarray(angle, dtype=float)
    cosine, sine = _cosines_and_sines(np.ravel(angle))
    return cosine.reshape(angle.shape), sine.reshape(angle.shape)


@kernel
def _cosines_and_sines(angle):
    cosine, sine = np.empty_like(angle), np.empty_like(angle)
    for k in range(len(angle)):
        cosine[k], sine[k] = cos(angle[k]), sin(angle[k])
    return cosine, sine


def dot(a, b):
    """Scalar product over the last axis, (..., n), (..., n) -> (...), by sums in a fixed order.

    What the linear algebra library gives in its place (`@`) depends on the processor in the last bit; a heap magnifies that.
    """
    return (a * b).sum(axis=-1)


def exponential(rotation_vector):
    """The turn by |r| about r, exact to rounding down to zero angle. (..., 3) [rad] -> (..., 4)."""
    vectors = np.ascontiguousarray(rotation_vector, dtype=float)
    return _exponentials(vectors.reshape(-1, 3)).reshape(*vectors.shape[:-1], 4)


@kernel
def _exponentials(vectors):
    result = np.empty((len(vectors), 4))
    for n in range(len(vectors)):
        result[n, 0], result[n, 1], result[n, 2], result[n, 3] = one_exponential(at(vectors, n))
    return result


@leaf
def one_exponential(vector):
    """The same of one rotation vector, a tuple."""
    x, y, z = scaled(0.5, vector)
    half = length((x, y, z))
    ratio = sin(half) / half if half > 0.0 else 1.0
    return cos(half), ratio * x, ratio * y, ratio * z


def logarithm(q):
    """The rotation vector of the shorter way round, |r| <= pi, exact to rounding down to zero angle. (..., 4) -> (..., 3)."""
    q = np.ascontiguousarray(q, dtype=float)
    return _logarithms(q.reshape(-1, 4)).reshape(*q.shape[:-1], 3)


@kernel
def _logarithms(orientation):
    result = np.empty((len(orientation), 3))
    for n in range(len(orientation)):
        put(result, n, one_logarithm(quaternion(orientation, n)))
    return result


@leaf
def one_logarithm(q):
    """The same of one quaternion, a tuple."""
    w, x, y, z = q
    sine = length((x, y, z))
    shorter = -1.0 if w < 0.0 else 1.0
    ratio = 2.0 * atan2(sine, shorter * w) / sine if sine > 0.0 else 2.0  # the limit for a vanishing angle
    return scaled(ratio * shorter, (x, y, z))


def random(generator, n):
    """n turns, uniform over all orientations: four normal numbers, normalised. -> (n, 4)."""
    return normalised(generator.standard_normal((n, 4)))


def between(u, v):
    """The shortest turn of direction u onto direction v (lengths do not matter). (..., 3), (..., 3) -> (..., 4).

    For opposite directions the axis is arbitrary; the one nearest a coordinate axis is taken.
    """
    u, v = np.broadcast_arrays(normalised(u), normalised(v))
    normal = cross(u, v)
    sine = np.sqrt(np.sum(normal * normal, axis=-1, keepdims=True))
    cosine = np.sum(u * v, axis=-1, keepdims=True)
    helper = np.eye(3)[np.argmin(np.abs(u), axis=-1)]
    axis = normalised(np.where(sine > 0, normal, cross(u, helper)))
    # Nearly opposite directions leave a rounded cross product; only its part square to u turns u in the right plane.
    axis = normalised(axis - np.sum(axis * u, axis=-1, keepdims=True) * u)
    # half of the angle, from whichever of its sine and cosine loses no digits
    larger = np.sqrt(0.5 * (1.0 + np.abs(cosine)))
    smaller = 0.5 * sine / larger
    return normalised(
        np.where(
            cosine >= 0.0, np.concatenate([larger, smaller * axis], axis=-1), np.concatenate([smaller, larger * axis], axis=-1)
        )
    )
