"""Contacts of one face: between the same bodies, along the same normal. Four of them ask for more than three motions can give."""

import numpy as np

from minibullet.kernels import kernel, leaf

FLAT = 3e-6  # of the smaller body's radius, by which corners of a face may be moved, so that all of them touch [-]


@leaf
def same_face(c, d, factors):
    """Are two contacts between the same bodies, along the same normal?"""
    m, n = factors.jacobian[c, 0, 0], factors.jacobian[d, 0, 0]
    a, b = factors.bodies[c], factors.bodies[d]
    return a[0] == b[0] and a[1] == b[1] and m[0] == n[0] and m[1] == n[1] and m[2] == n[2]


@kernel
def off_plane(values, first, factors):
    """What values (n,) at the contacts of a face, from ``first`` on, leave of their plane of least squares (n,); nothing where
    the contacts stand on a line."""
    x, y = np.empty(len(values)), np.empty(len(values))
    for k in range(len(values)):  # coordinates in the face: arm x normal along the tangents
        row, axes = factors.jacobian[first + k, 0, 0], factors.jacobian[first, 0]
        x[k] = row[3] * axes[1, 0] + row[4] * axes[1, 1] + row[5] * axes[1, 2]
        y[k] = row[3] * axes[2, 0] + row[4] * axes[2, 1] + row[5] * axes[2, 2]
    x, y, t = x - np.mean(x), y - np.mean(y), values - np.mean(values)
    xx, xy, yy, xt, yt = np.sum(x * x), np.sum(x * y), np.sum(y * y), np.sum(x * t), np.sum(y * t)
    determinant = xx * yy - xy * xy
    if not determinant > 1e-9 * xx * yy:
        return 0.0 * t
    return t - ((yy * xt - xy * yt) * x + (xx * yt - xy * xt) * y) / determinant


@kernel
def attainable(target, factors, rolling, allowed):
    """Normal velocities, none above zero, that rigid bodies can have at all contacts of a face together, (m,) [m/s].

    Of four corners one is always too far or too near, by rounding. By Coulomb's law it would open and the others bear its load,
    and Gauss-Seidel takes thousands of sweeps to hand that over. Targets (m,), none above zero, are moved to a plane over the
    face, by ``allowed`` (m,) at most; where each contact resists ``rolling`` (m, 2), which holds two of them too, to one value.
    """
    result, first = target.copy(), 0
    while first < len(target):
        end = first + 1
        while end < len(target) and same_face(first, end, factors):
            end += 1
        face = target[first:end]
        for level in (True, False):
            if len(face) < (2 if level else 4) or level and not (rolling[first:end, 0] > 0.0).all():
                continue
            left = face if level else off_plane(face, first, factors)
            moved = np.max(left) - left
            moved -= max(0.0, np.max(face + moved))  # nothing is pushed apart
            if (np.abs(moved) <= allowed[first:end]).all():
                result[first:end] = np.minimum(face + moved, 0.0)
                break
        first = end
    return result
