"""The friction cone: projection and the exact solve of one contact, against their definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from minibullet.contact.coulomb import project_cone, solve_coulomb
from minibullet.contact.residual import natural_map_error

# products of numbers below 1e-100 lose their digits or vanish: no tolerance relative to the size could hold there
numbers = st.floats(-1e3, 1e3, allow_nan=False).map(lambda value: value if abs(value) > 1e-100 else 0.0)
frictions = st.one_of(st.just(0.0), st.floats(1e-3, 3.0))


@given(numbers, numbers, numbers, frictions)
def test_projection_splits_into_cone_and_polar_cone(y_n, y_1, y_2, mu):
    """Moreau: y = p + d with p in K, -d in K*, p . d = 0; tolerance: rounding of numbers up to 1e3."""
    p = np.array(project_cone((y_n, y_1, y_2), mu))
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
    r = np.array(solve_coulomb(W, tuple(b), mu))
    assert r[0] >= 0.0 and np.hypot(r[1], r[2]) <= mu * r[0] * (1.0 + 1e-14)
    coupling = mu * np.hypot(W[0, 1], W[0, 2]) / W[0, 0]
    if coupling < 0.9:
        u = W @ r + b
        rho = 1.0 / W.trace()
        error = np.sqrt(natural_map_error(r, rho * u, mu))
        assert error <= 1e-10 * max(np.linalg.norm(r), rho * np.linalg.norm(b))


def test_local_solve_take_off_stick_slide():
    """One unit mass at its centre (W = I): the three states have closed answers."""
    unit = np.eye(3)
    assert solve_coulomb(unit, (0.1, 3.0, 0.0), 0.5) == (0.0, 0.0, 0.0)
    assert solve_coulomb(unit, (-1.0, 0.3, -0.2), 0.5) == (1.0, -0.3, 0.2)
    assert solve_coulomb(unit, (-1.0, 3.0, 4.0), 0.5) == pytest.approx((1.0, -0.3, -0.4), abs=1e-15)


@pytest.mark.parametrize("approach", [5e-324, 1e-310, 1e-200, 1e-101, 1e-99])
def test_a_load_that_dies_away_stays_a_number(approach):
    """Sweeps halve a load until it underflows. Sliding at 3 m/s it is resisted by half of it at most, and by a number."""
    for guess in (-1.0, 1e90):
        r = np.array(solve_coulomb(np.eye(3), (-approach, 3.0, 0.0), 0.5, guess))
        assert r[0] == pytest.approx(approach, rel=1e-14, abs=0.0) and -0.5 * r[0] <= r[1] <= 0.0 and r[2] == 0.0


def test_local_solve_is_isotropic():
    """Friction opposes slip in every direction: turning the tangents turns the answer, to rounding."""
    for heading in np.linspace(0.0, 6.0, 13):
        c, s = np.cos(heading), np.sin(heading)
        r = solve_coulomb(np.eye(3), (-1.0, 2.0 * c, 2.0 * s), 0.3)
        assert r == pytest.approx((1.0, -0.3 * c, -0.3 * s), abs=1e-15)
