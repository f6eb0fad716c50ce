"""The inverse of mass matrices."""

import numpy as np

from minibullet.dynamics.inverse_mass import invert


def test_the_inverse_mass_is_that_of_the_library(generator):
    """Gauss-Jordan against NumPy on 100 masses with added mass and coupling, moments apart by up to 1e6: to rounding times the
    condition number."""
    root = generator.normal(size=(100, 6, 6)) * 10.0 ** generator.uniform(-1.5, 1.5, (100, 6, 1))
    matrices = root @ root.swapaxes(1, 2)
    found = matrices.copy()
    invert(found)
    error = np.linalg.norm(found @ matrices - np.eye(6), axis=(1, 2))
    assert (error < 1e-14 * np.linalg.cond(matrices)).all()
