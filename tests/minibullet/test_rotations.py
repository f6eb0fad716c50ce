"""Quaternions obey the algebra of rotations, to rounding, at every angle and every size."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from minibullet import rotations

# A product of rotations is a few dozen roundings of numbers below 2.
ROUNDING = 4e-15


@pytest.fixture
def turns(generator):
    """Two arrays of 500 random orientations."""
    return rotations.random(generator, 500), rotations.random(generator, 500)


def same_turn(a, b):
    """q and -q are the same turn."""
    return np.minimum(np.abs(a - b).max(axis=-1), np.abs(a + b).max(axis=-1)).max()


def test_product_of_quaternions_is_product_of_matrices(turns):
    a, b = turns
    difference = rotations.matrix(rotations.product(a, b)) - rotations.matrix(a) @ rotations.matrix(b)
    assert np.abs(difference).max() < ROUNDING


def test_rotate_is_multiplication_by_the_matrix(turns, generator):
    q, v = turns[0], generator.normal(size=(500, 3))
    np.testing.assert_allclose(rotations.rotate(q, v), np.einsum("nij,nj->ni", rotations.matrix(q), v), atol=4 * ROUNDING)


def test_conjugate_turns_back(turns, generator):
    q, v = turns[0], generator.normal(size=(500, 3))
    np.testing.assert_allclose(rotations.rotate(rotations.conjugate(q), rotations.rotate(q, v)), v, atol=4 * ROUNDING)


def test_matrix_is_orthogonal_and_right_handed(turns):
    r = rotations.matrix(turns[0])
    assert np.abs(np.swapaxes(r, -1, -2) @ r - np.eye(3)).max() < ROUNDING
    assert np.abs(np.linalg.det(r) - 1).max() < ROUNDING


def test_from_matrix_undoes_matrix(turns):
    q = np.concatenate([turns[0], [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0.6, 0.8, 0]]])
    back = rotations.from_matrix(rotations.matrix(q))
    assert same_turn(back, q) < ROUNDING
    assert np.all(back[:, 0] >= 0)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-3, 1.0, 3.1])
def test_logarithm_undoes_exponential_at_every_angle(size, generator):
    """Relative accuracy: a slow rotation is not lost in the rounding of 1."""
    axis = generator.normal(size=(200, 3))
    vector = size * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    # Near pi the angle comes from a sine of 0.02 whose rounding it magnifies.
    np.testing.assert_allclose(rotations.logarithm(rotations.exponential(vector)), vector, rtol=1e-13)


def test_exponential_of_one_axis_adds_angles():
    a, b = np.array([0.0, 0.0, 0.3]), np.array([0.0, 0.0, 0.9])
    together = rotations.product(rotations.exponential(a), rotations.exponential(b))
    np.testing.assert_allclose(together, rotations.exponential(a + b), atol=ROUNDING)


def test_logarithm_takes_the_shorter_way_round():
    three_quarters = rotations.exponential([0, 0, 1.5 * np.pi])
    np.testing.assert_allclose(rotations.logarithm(three_quarters), [0, 0, -0.5 * np.pi], atol=ROUNDING)


@pytest.mark.parametrize("away", [0.0, 1e-300, 1e-17, 1e-16, 1e-12, 1e-8, 1e-3, 1.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_between_turns_u_onto_v_even_when_nearly_opposite(away, sign, generator):
    u, noise = generator.normal(size=(2, 300, 3))
    v = sign * u + away * noise
    q = rotations.between(u, v)
    turned = rotations.rotate(q, u / np.linalg.norm(u, axis=1, keepdims=True))
    np.testing.assert_allclose(turned, v / np.linalg.norm(v, axis=1, keepdims=True), atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=ROUNDING)


def test_between_is_the_shortest_turn(generator):
    u, v = generator.normal(size=(2, 300, 3))
    cosine = np.sum(u * v, axis=1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
    angle = np.linalg.norm(rotations.logarithm(rotations.between(u, v)), axis=1)
    np.testing.assert_allclose(angle, np.arccos(cosine), atol=1e-12)  # arccos loses digits near 0 and pi


def test_random_orientations_are_uniform(generator):
    """Each matrix entry of uniform turns has mean 0 and variance 1/3; 4.5 standard errors of 20 000 draws."""
    entries = rotations.matrix(rotations.random(generator, 20_000)).reshape(-1, 9)
    assert np.abs(entries.mean(axis=0)).max() < 4.5 * np.sqrt(1 / 3 / 20_000)
    # Var(entry^2) = E z^4 - 1/9 = 1/5 - 1/9 for z uniform in [-1, 1].
    assert np.abs(np.square(entries).mean(axis=0) - 1 / 3).max() < 4.5 * np.sqrt((1 / 5 - 1 / 9) / 20_000)


@given(st.integers(-900, 900), st.lists(st.floats(-1, 1).filter(lambda x: abs(x) > 1e-3), min_size=4, max_size=4))
def test_normalising_ignores_powers_of_two_bit_for_bit(exponent, q):
    q = np.array(q)
    np.testing.assert_array_equal(rotations.normalised(np.ldexp(q, exponent)), rotations.normalised(q))


@pytest.mark.parametrize("bad", [[0, 0, 0, 0], [np.nan, 0, 0, 1], [np.inf, 0, 0, 0]])
def test_what_is_no_direction_becomes_nan_without_a_warning(bad):
    assert not np.isfinite(rotations.normalised(np.array(bad, dtype=float))).all()


def test_scalar_products_cosines_and_sines_are_those_of_the_libraries(generator):
    """`dot` and `cosine_and_sine` stand in for library functions whose last bit depends on the processor: equal to rounding."""
    a, b = generator.normal(size=(2, 200, 3))
    size = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    assert (np.abs(rotations.dot(a, b) - np.einsum("ni,ni->n", a, b)) < ROUNDING * size).all()
    angles = generator.uniform(-10.0, 10.0, (4, 50))
    cosine, sine = rotations.cosine_and_sine(angles)
    np.testing.assert_allclose(cosine, np.cos(angles), rtol=0.0, atol=ROUNDING)
    np.testing.assert_allclose(sine, np.sin(angles), rtol=0.0, atol=ROUNDING)
