"""Inverse of mass and inertia of each body, in world axes, with the mass that effects add."""

import numpy as np

from minibullet.kernels import kernel


@kernel
def invert(matrices):
    """Replace symmetric positive definite matrices (n, 6, 6) by their inverses: Gauss-Jordan, which needs no pivots for these."""
    for matrix in matrices:
        for k in range(6):
            pivot = 1.0 / matrix[k, k]
            matrix[k, k] = 1.0
            for j in range(6):
                matrix[k, j] *= pivot
            for i in range(6):
                if i == k:
                    continue
                factor = matrix[i, k]
                matrix[i, k] = 0.0
                for j in range(6):
                    matrix[i, j] -= factor * matrix[k, j]


@kernel
def rigid_inverse_mass(mass, inertia, rotation):
    """Inverse mass and inertia of each body in world axes, (n, 6, 6) [1/kg, 1/(kg m2)]; zero if fixed."""
    result = np.zeros((len(mass), 6, 6))
    for n in range(len(mass)):
        if mass[n] == np.inf:
            continue
        for i in range(3):
            result[n, i, i] = 1.0 / mass[n]
            for j in range(3):
                value = 0.0
                for k in range(3):
                    value += rotation[n, i, k] * rotation[n, j, k] / inertia[n, k]
                result[n, 3 + i, 3 + j] = value
    return result


@kernel
def add_mass(inverse, added):
    """Bring inverse masses (n, 6, 6), in place, to those with the mass ``added`` (n, 6, 6); of fixed bodies they stay zero."""
    for n in range(len(inverse)):
        if inverse[n, 0, 0] > 0.0 and added[n].any():
            invert(inverse[n : n + 1])
            inverse[n] += added[n]
            invert(inverse[n : n + 1])


def inverse_mass(bodies, rotation, added):
    """Inverse of each body's mass and inertia, world axes, with the mass that effects add, (n, 6, 6); zero if fixed."""
    result = rigid_inverse_mass(bodies.mass, bodies.inertia, rotation)
    if added is not None:
        add_mass(result, added)
    return result
