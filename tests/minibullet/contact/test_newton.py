"""Coulomb's law as equations: their derivatives, and their zeros."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from minibullet.contact.coulomb import solve_coulomb
from minibullet.contact.newton import law_equations

frictions = st.one_of(st.just(0.0), st.floats(1e-3, 3.0))


@given(st.integers(0, 10**6), frictions, st.sampled_from([0.0, 1e-3, 1.0]))
def test_derivatives_of_the_law(seed, mu, smoothing):
    """A and B against central differences; tolerance 1e-6: steps of 1e-6 on values of order 1, away from kinks almost surely."""
    generator = np.random.default_rng(seed)
    r, u, d, e = generator.normal(size=(4, 3))
    friction, rho, h = np.array([mu]), 3.0, 1e-6 * max(smoothing, 0.1)
    F, A, B = np.empty(3), np.empty((1, 3, 3)), np.empty((1, 3, 3))
    plus, minus = np.empty(3), np.empty(3)
    law_equations(r + h * d, u + h * e, friction, rho, smoothing, plus, A, B)
    before = (A.copy(), B.copy())
    law_equations(r - h * d, u - h * e, friction, rho, smoothing, minus, A, B)
    if smoothing < 0.1 and max(abs(A - before[0]).max(), abs(B - before[1]).max()) > 1e-4:
        return  # a kink lies between the two points
    law_equations(r, u, friction, rho, smoothing, F, A, B)
    assert (plus - minus) / (2.0 * h) == pytest.approx(A[0] @ d + B[0] @ e, abs=2e-5)


def test_solutions_are_the_zeros_of_the_equations():
    """law_equations vanish exactly where the natural map does: stick, slide and take-off of a unit mass."""
    F, A, B = np.empty(3), np.empty((1, 3, 3)), np.empty((1, 3, 3))
    for b in ([-1.0, 0.3, -0.2], [-1.0, 3.0, 4.0], [0.2, 1.0, 0.0]):
        r = np.array(solve_coulomb(np.eye(3), tuple(b), 0.5))
        assert law_equations(r, r + b, np.array([0.5]), 7.0, 0.0, F, A, B) <= 1e-14
