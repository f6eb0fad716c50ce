"""W formed: block rows against the dense matrix, and the residual on them."""

import numpy as np
import pytest
import small_scenes as scenes
from hypothesis import given
from hypothesis import strategies as st
from small_scenes import compress

import minibullet as mb
from minibullet.contact.block_rows import BlockProblem, block_problem, delassus, into_cone, natural_map_residual, velocity


def test_coupled_blocks_are_the_delassus_operator_without_its_zeros(generator):
    """A heap of touching boxes, two of them fixed: block rows filled into a matrix give W to rounding, columns ascend."""
    world = mb.World()
    world.add_plane()
    for k in range(9):
        place = 0.95 * np.array([k % 3, k // 3, 0.0]) + (0, 0, 0.5 + 0.02 * k)
        world.add(mb.Box(1, 1, 1), **({"fixed": True} if k in (2, 7) else {"mass": 1.0 + k}), position=place)
    problem = scenes.problem(world)
    contacts = generator.permutation(len(problem.target))[:-3]
    start, column, block, free, _ = block_problem(problem, contacts)
    matrix, expected_free = delassus(problem, contacts)
    filled = np.zeros((len(contacts), 3, len(contacts), 3))
    filled[np.repeat(np.arange(len(contacts)), np.diff(start)), :, column] = block
    np.testing.assert_allclose(filled.reshape(matrix.shape), matrix, atol=1e-13 * np.abs(matrix).max())
    np.testing.assert_array_equal(free, expected_free)
    assert all(np.all(np.diff(column[a:b]) > 0) for a, b in zip(start, start[1:], strict=False))
    assert len(block) < 0.9 * len(contacts) ** 2


@given(st.integers(0, 10**6))
def test_block_rows_give_the_same_velocity(seed):
    """compress + velocity = W r + q for a W with empty blocks; tolerance: another order of summation."""
    generator = np.random.default_rng(seed)
    m = int(generator.integers(1, 8))
    W = generator.normal(size=(3 * m, 3 * m)) * np.kron(generator.random((m, m)) < 0.4, np.ones((3, 3)))
    r, q = generator.normal(size=(2, 3 * m))
    assert velocity(BlockProblem(*compress(W), q, np.zeros(m)), r) == pytest.approx(W @ r + q, abs=1e-12)


def test_residual_of_a_known_error():
    """A unit mass pressed down at 2 m/s without impulse: r = 0, u = q, so E = 2 and the relative residual 1."""
    problem = BlockProblem(*compress(np.eye(3)), np.array([-2.0, 0.0, 0.0]), np.array([0.5]))
    assert natural_map_residual(problem, np.zeros(3), 1.0) == 1.0
    assert natural_map_residual(problem, np.array([2.0, 0.0, 0.0]), 1.0) == 0.0
    assert natural_map_residual(problem._replace(q=np.zeros(3)), np.zeros(3), 1.0) == 0.0


def test_lifting_off_by_the_convex_relaxation_is_an_error():
    """A sliding body that rises at mu |u_T| solves the relaxed problem, not Coulomb's law: the residual must show it."""
    mu, rise = np.array([0.5]), 0.5 * 3.0
    q = np.array([rise - 1.0, 3.0 + 0.5, 0.0])
    problem = BlockProblem(*compress(np.eye(3)), q, mu)
    assert natural_map_residual(problem, np.array([1.0, -0.5, 0.0]), 1.0) > 0.1


def test_into_cone_leaves_the_inside_alone():
    """Points of the cone keep every bit; a pulling impulse becomes zero."""
    r = np.array([1.0, 0.2, -0.1, -1.0, 0.0, 0.0])
    assert into_cone(np.array([0.5, 0.5]), r).tolist() == [1.0, 0.2, -0.1, 0.0, 0.0, 0.0]
