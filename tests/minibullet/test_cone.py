"""The friction cone: projection and the exact solve of one contact, against their definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_scenes import compress

from minibullet.contact.coulomb import (
    into_cone,
    law_equations,
    natural_map_error,
    natural_map_residual,
    project_cone,
    solve_block,
    velocity,
)

# products of numbers below 1e-100 lose their digits or vanish: no tolerance relative to the size could hold there
numbers = st.floats(-1e3, 1e3, allow_nan=False).map(lambda value: value if abs(value) > 1e-100 else 0.0)
frictions = st.one_of(st.just(0.0), st.floats(1e-3, 3.0))


@given(numbers, numbers, numbers, frictions)
def test_projection_splits_into_cone_and_polar_cone(y_n, y_1, y_2, mu):
    """Moreau: y = p + d with p in K, -d in K*, p . d = 0; tolerance: rounding of numbers up to 1e3."""
    p = np.array(project_cone(y_n, y_1, y_2, mu))
    d = np.array([y_n, y_1, y_2]) - p
    size = max(np.linalg.norm([y_n, y_1, y_2]), 1e-300)
    assert np.hypot(p[1], p[2]) <= mu * p[0] + 1e-14 * size
    assert mu * np.hypot(d[1], d[2]) <= -d[0] + 1e-13 * size
    assert abs(p @ d) <= 1e-13 * size**2


def block(seed, condition):
    """A positive definite 3x3 block with eigenvalues 1..condition and a random velocity."""
    generator = np.random.default_rng(seed)
    Q, _ = np.linalg.qr(generator.normal(size=(3, 3)))
    return Q @ np.diag(condition ** generator.uniform(0.0, 1.0, 3)) @ Q.T, generator.normal(size=3)


@given(st.integers(0, 10**6), frictions, st.sampled_from([1.0, 10.0, 1e3]))
def test_local_solve_satisfies_coulombs_law(seed, mu, condition):
    """r = P_K(r - u~) to rounding, for every state; the impulse lies inside the cone exactly as published.

    Strongly coupled blocks with large friction may have no solution with contact (Painleve); those still must stay in the cone.
    """
    W, b = block(seed, condition)
    r = np.array(solve_block(*W.ravel(), *b, mu))
    assert r[0] >= 0.0 and np.hypot(r[1], r[2]) <= mu * r[0] * (1.0 + 1e-14)
    coupling = mu * np.hypot(W[0, 1], W[0, 2]) / W[0, 0]
    if coupling < 0.9:
        u = W @ r + b
        rho = 1.0 / W.trace()
        error = np.sqrt(natural_map_error(*r, *u, mu, rho))
        assert error <= 1e-10 * max(np.linalg.norm(r), rho * np.linalg.norm(b))


def test_local_solve_take_off_stick_slide():
    """One unit mass at its centre (W = I): the three states have closed answers."""
    unit = np.eye(3).ravel()
    assert solve_block(*unit, 0.1, 3.0, 0.0, 0.5) == (0.0, 0.0, 0.0)
    assert solve_block(*unit, -1.0, 0.3, -0.2, 0.5) == (1.0, -0.3, 0.2)
    assert solve_block(*unit, -1.0, 3.0, 4.0, 0.5) == pytest.approx((1.0, -0.3, -0.4), abs=1e-15)


def test_local_solve_is_isotropic():
    """Friction opposes slip in every direction: turning the tangents turns the answer, to rounding."""
    for heading in np.linspace(0.0, 6.0, 13):
        c, s = np.cos(heading), np.sin(heading)
        r = solve_block(*np.eye(3).ravel(), -1.0, 2.0 * c, 2.0 * s, 0.3)
        assert r == pytest.approx((1.0, -0.3 * c, -0.3 * s), abs=1e-15)


@given(st.integers(0, 10**6))
def test_block_rows_give_the_same_velocity(seed):
    """compress + velocity = W r + q for a W with empty blocks; tolerance: another order of summation."""
    generator = np.random.default_rng(seed)
    m = int(generator.integers(1, 8))
    W = generator.normal(size=(3 * m, 3 * m)) * np.kron(generator.random((m, m)) < 0.4, np.ones((3, 3)))
    r, q = generator.normal(size=(2, 3 * m))
    assert velocity(*compress(W), q, r) == pytest.approx(W @ r + q, abs=1e-12)


def test_residual_of_a_known_error():
    """A unit mass pressed down at 2 m/s without impulse: r = 0, u = q, so E = 2 and the relative residual 1."""
    rows = compress(np.eye(3))
    q, mu = np.array([-2.0, 0.0, 0.0]), np.array([0.5])
    assert natural_map_residual(*rows, q, mu, np.zeros(3), 1.0) == 1.0
    assert natural_map_residual(*rows, q, mu, np.array([2.0, 0.0, 0.0]), 1.0) == 0.0
    assert natural_map_residual(*rows, np.zeros(3), mu, np.zeros(3), 1.0) == 0.0


def test_lifting_off_by_the_convex_relaxation_is_an_error():
    """A sliding body that rises at mu |u_T| solves the relaxed problem, not Coulomb's law: the residual must show it."""
    mu, rise = np.array([0.5]), 0.5 * 3.0
    q = np.array([rise - 1.0, 3.0 + 0.5, 0.0])
    assert natural_map_residual(*compress(np.eye(3)), q, mu, np.array([1.0, -0.5, 0.0]), 1.0) > 0.1


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
        r = np.array(solve_block(*np.eye(3).ravel(), *b, 0.5))
        assert law_equations(r, r + b, np.array([0.5]), 7.0, 0.0, F, A, B) <= 1e-14


def test_into_cone_leaves_the_inside_alone():
    """Points of the cone keep every bit; a pulling impulse becomes zero."""
    r = np.array([1.0, 0.2, -0.1, -1.0, 0.0, 0.0])
    assert into_cone(np.array([0.5, 0.5]), r).tolist() == [1.0, 0.2, -0.1, 0.0, 0.0, 0.0]
