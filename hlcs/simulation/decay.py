"""What an exponential decay does over a step, exactly: the functions phi of exponential integrators."""

from typing import NamedTuple

import numpy as np

from minibullet.kernels import leaf

SERIES = 2.0  # |z| below which the functions of a decay are summed as series: their recursion loses digits there
TERMS = 26  # of these series: the last adds less than the last bit


@leaf
def functions_of_decay(z, left, found):
    """Fill in phi_1 to phi_4 (4, n) of z (n,): series near zero, else phi_(j+1) = (phi_j - 1/j!) / z from left = e^z (n,)."""
    for n in range(len(z)):
        known, product = left[n], 1.0
        for j in range(1, 5):
            before, product = product, product * j
            if abs(z[n]) < SERIES:
                known = 1.0
                for i in range(TERMS, 0, -1):
                    known = 1.0 + known * z[n] / (i + j)
                known /= product
            else:
                known = (known - 1.0 / before) / z[n]
            found[j - 1, n] = known


class Decay(NamedTuple):
    """What becomes of n velocities that decay at rates k over a step h: z = -k h, phi_j = sum of z^i / (i + j)!, as z each."""

    left: np.ndarray  # e^z, of a velocity
    one: np.ndarray  # phi_1
    two: np.ndarray  # phi_2
    three: np.ndarray  # phi_3
    four: np.ndarray  # phi_4

    @classmethod
    def over(cls, z):
        """The Decay for z, none of them positive."""
        left, found = np.exp(z), np.empty((4, *z.shape))
        functions_of_decay(z.ravel(), left.ravel(), found.reshape(4, -1))
        return cls(left, *found)
