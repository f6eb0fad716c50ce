"""The exact one-step solver: every class of problem to 1e-8, scaling, islands, warm start, refusals."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sparse
import small_scenes as scenes
from small_scenes import compress

import minibullet as mb
from minibullet.contact import gauss_seidel
from minibullet.contact.block_rows import BlockProblem
from minibullet.contact.coulomb import project_cone
from minibullet.contact.exact import solve_blocks, solve_contacts, solve_unconverged
from minibullet.errors import InputError

# the makers live beside this file, in a script that is run by its path
contact_problems = SimpleNamespace(**runpy.run_path(str(Path(__file__).with_name("contact_problems.py"))))

TOLERANCE = 1e-8  # what FCLIB prescribes

# minutes, or not solved in every draw; judged by the table that `python contact_problems.py` prints
HARD = {"stack, ratio 1e6, struck", "rubble, mu 1, unsymmetric", "rubble, ratio 1e4", "rubble, dense"}
STRUCK = {"tower of planks, struck", "wall of 95, struck", "arch of 60, struck", "ball pile, struck"}
LONG = STRUCK | {"ball pile", "ball pile, 1 mm"}


def residual(W, q, mu, r):
    """The relative natural-map residual, written a second time straight from its definition."""
    u, error = W @ r + q, 0.0
    for c in range(len(mu)):
        n = slice(3 * c, 3 * c + 3)
        y = r[n] - u[n] - (mu[c] * np.hypot(*u[n][1:]), 0.0, 0.0)
        error += np.sum((r[n] - project_cone(y, mu[c])) ** 2)
    return np.sqrt(error) / max(np.linalg.norm(q), np.linalg.norm(r), np.linalg.norm(u))


def assert_solved(W, q, mu, solution):
    """Residual as stated, to the tolerance, and every impulse inside its cone."""
    r = solution.impulse.reshape(-1, 3)
    assert np.all(r[:, 0] >= 0.0)
    assert np.all(np.hypot(r[:, 1], r[:, 2]) <= mu * r[:, 0] * (1.0 + 1e-9))
    assert solution.residual <= TOLERANCE
    assert residual(W, q, mu, solution.impulse) == pytest.approx(solution.residual, abs=1e-12)


@pytest.mark.parametrize("name", [name for name in contact_problems.CLASSES if name not in HARD | LONG])
def test_every_class_is_solved(name):
    """One draw of each class reaches 1e-8."""
    W, q, mu = contact_problems.CLASSES[name](np.random.default_rng((list(contact_problems.CLASSES).index(name), 0)))
    assert_solved(W, q, mu, solve_contacts(W, q, mu))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(LONG))
def test_large_struck_scenes_are_solved(name):
    """The same for 250 to 700 contacts with random velocities, seconds each."""
    W, q, mu = contact_problems.CLASSES[name](np.random.default_rng((list(contact_problems.CLASSES).index(name), 1)))
    assert_solved(W, q, mu, solve_contacts(W, q, mu))


def test_one_contact_is_exact():
    """One contact is one local solve: rounding level."""
    solution = solve_contacts(np.eye(3), [-1.0, 3.0, 4.0], 0.5)
    assert solution.impulse == pytest.approx([1.0, -0.3, -0.4], abs=1e-15)
    assert solution.residual < 1e-15


def test_stack_carries_its_weight():
    """A stack at rest: the net impulse of each level is the weight above it times dt (base 10 m g dt), to 1e-8 relative."""
    W, q, mu = contact_problems.stack(np.random.default_rng(1), levels=10)
    solution = solve_contacts(W, q, mu)
    per_level = solution.impulse.reshape(10, 4, 3)[:, :, 0].sum(axis=1)
    assert per_level == pytest.approx(np.arange(10, 0, -1) * 9.81 / 240.0, rel=1e-7)


def test_mass_ratio_of_ten_thousand():
    """Heavy on light: the light block at the bottom carries both weights."""
    W, q, mu = contact_problems.stack(np.random.default_rng(2), levels=2, ratio=1e4)
    solution = solve_contacts(W, q, mu, reference_mass=1e4)
    assert solution.residual <= TOLERANCE
    assert solution.impulse.reshape(2, 4, 3)[0, :, 0].sum() == pytest.approx(10001.0 * 9.81 / 240.0, rel=1e-7)


def test_units_do_not_matter():
    """Masses and speeds in other units (powers of two): the same bits when the reference mass is in those units too."""
    W, q, mu = contact_problems.two_cubes(np.random.default_rng(3))
    plain = solve_contacts(W, q, mu)
    mass, speed = 2.0**-20, 2.0**-7
    scaled = solve_contacts(W / mass, q * speed, mu, reference_mass=mass)
    assert np.array_equal(scaled.impulse, plain.impulse * mass * speed)
    assert scaled.residual == plain.residual


def test_islands_are_independent():
    """Two problems side by side, interleaved: both solved, as a sparse matrix too, with the same answer."""
    generator = np.random.default_rng(4)
    parts = [contact_problems.stack(generator, 5), contact_problems.two_cubes(generator)]
    W = sparse.block_diag([W for W, _, _ in parts]).toarray()
    q, mu = (np.concatenate([part[k] for part in parts]) for k in (1, 2))
    order = generator.permutation(len(mu))
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    W, q, mu = W[np.ix_(rows, rows)], q[rows], mu[order]
    dense, thin = solve_contacts(W, q, mu), solve_contacts(sparse.csr_array(W), q, mu)
    assert_solved(W, q, mu, dense)
    assert np.array_equal(dense.impulse, thin.impulse)


def test_unsymmetric_W_is_solved_as_given():
    """A disturbance of 1e-3 in W: the residual is that of the disturbed problem."""
    generator = np.random.default_rng(5)
    W, q, mu = contact_problems.curved_body(generator)
    W *= 1.0 + 1e-3 * generator.uniform(-1.0, 1.0, W.shape)
    assert_solved(W, q, mu, solve_contacts(W, q, mu))


def test_warm_start_at_the_solution_costs_nothing():
    """Started at its own answer the solver returns it to rounding (the cone again); the lean call agrees bit for bit."""
    W, q, mu = contact_problems.stack(np.random.default_rng(6), 8, speed=0.1)
    first = solve_contacts(W, q, mu)
    again = solve_contacts(W, q, mu, impulse=first.impulse)
    assert again.iterations == 0
    assert again.impulse == pytest.approx(first.impulse, rel=1e-14)
    lean = solve_blocks(BlockProblem(*compress(W), q, mu), np.zeros_like(q), TOLERANCE)
    assert np.array_equal(lean[0], first.impulse)


@pytest.mark.parametrize("kind", ["csr", "csc", "coo", "lil", "dok", "bsr"])
def test_every_sparse_format_is_read(kind):
    """The same problem in scipy's formats, as array and as matrix: the same bits."""
    W, q, mu = contact_problems.two_cubes(np.random.default_rng(9))
    thin, expected = sparse.coo_array(W), solve_contacts(W, q, mu).impulse
    assert np.array_equal(solve_contacts(thin.asformat(kind), q, mu).impulse, expected)
    assert np.array_equal(solve_contacts(sparse.coo_matrix(W).asformat(kind), q, mu).impulse, expected)


def test_a_contact_that_cannot_move_along_a_tangent():
    """A plane problem with empty rows for its third axis, a singular tangential block, and a thrust along the immovable axis."""
    W = np.diag([1.0, 1.0, 0.0])
    assert solve_contacts(W, [-1.0, 0.1, 0.0], 0.5).impulse == pytest.approx([1.0, -0.1, 0.0], abs=1e-8)
    assert solve_contacts(W, [-1.0, 3.0, 0.0], 0.5).impulse == pytest.approx([1.0, -0.5, 0.0], abs=1e-8)
    assert solve_contacts(np.diag([1.0, 0.0, 0.0]), [-1.0, 0.3, 0.4], 0.5).impulse == pytest.approx([1.0, -0.3, -0.4], abs=1e-8)
    singular = np.eye(3)
    singular[1:, 1:] = 1.0
    assert_solved(singular, np.array([-1.0, 0.2, 0.2]), np.array([0.5]), solve_contacts(singular, [-1.0, 0.2, 0.2], 0.5))


def test_a_problem_without_solution_ends_with_its_residual():
    """Two walls close on a body of no play and nothing may give: no impulse helps, the answer says so and comes back."""
    H = np.zeros((6, 1))
    H[0], H[3] = 1.0, -1.0  # two normals that pull the body in opposite directions
    W = H @ H.T + 1e-3 * np.diag([0.0, 1, 1, 0, 1, 1])
    solution = solve_contacts(W, np.array([-1.0, 0.3, 0.0, -1.0, 0.0, 0.2]), 0.5)
    assert np.all(np.isfinite(solution.impulse)) and np.isfinite(solution.residual)
    r = solution.impulse
    assert residual(W, np.array([-1.0, 0.3, 0.0, -1.0, 0.0, 0.2]), [0.5, 0.5], r) == pytest.approx(solution.residual, rel=1e-6)


def test_effort_is_bounded_and_what_was_reached_is_told():
    """A jammed heap with three Newton steps allowed: an impulse inside its cones comes back with its true residual."""
    W, q, mu = contact_problems.rubble(np.random.default_rng(10), 30, mu=1.0)
    impulse, reached, used, _ = solve_blocks(BlockProblem(*compress(W), q, mu), np.zeros_like(q), TOLERANCE, effort=(3, 10**9))
    assert reached > TOLERANCE and used <= 200 + 6
    assert residual(W, q, mu, impulse) == pytest.approx(reached, rel=1e-6)
    few = solve_blocks(BlockProblem(*compress(W), q, mu), np.zeros_like(q), TOLERANCE, effort=(10_000, 10**5))
    assert few[2] < 240


def test_repeats_are_bit_identical():
    """No clock and no chance in the solver."""
    W, q, mu = contact_problems.wall(np.random.default_rng(7), 4, 4, speed=0.3)
    assert np.array_equal(solve_contacts(W, q, mu).impulse, solve_contacts(W, q, mu).impulse)


def test_no_contacts_and_nothing_to_do():
    """No contacts: an empty answer. q = 0 or separating: no impulse, even from a warm start."""
    assert solve_contacts(np.zeros((0, 0)), [], 0.5).impulse.shape == (0,)
    assert not solve_contacts(np.eye(3), np.zeros(3), 0.5, impulse=[1.0, 0.0, 0.0]).impulse.any()
    assert not solve_contacts(np.eye(3), [1.0, 2.0, 0.0], 0.5).impulse.any()


def test_not_converged_is_told_not_raised():
    """An unreachable tolerance returns the best point with its residual."""
    W, q, mu = contact_problems.one_body(np.random.default_rng(8), count=2)
    solution = solve_contacts(W, q, mu, tolerance=0.0)
    assert solution.residual <= 1e-12 and np.all(np.isfinite(solution.impulse))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"q": np.zeros(4)}, "q has shape"),
        ({"W": np.eye(6)}, "W has shape"),
        ({"mu": [0.1, 0.2]}, "mu has 2 values"),
        ({"mu": -0.1}, "friction must be >= 0"),
        ({"mu": np.nan}, "mu has a value that is not finite"),
        ({"q": [np.inf, 0.0, 0.0]}, "q has a value that is not finite"),
        ({"W": np.diag([1.0, np.nan, 1.0])}, "W has a value that is not finite"),
        ({"W": np.diag([0.0, 1.0, 1.0])}, "diagonal must be > 0"),
        ({"W": np.diag([1.0, 1.0, -1.0])}, r"W\[2, 2\] = -1 \(contact 0\); the diagonal must be > 0"),
        ({"W": np.eye(3) + np.diag([0.5, 0.0], 1)}, "W is not symmetric"),
        ({"W": [["a"] * 3] * 3}, "W is not made of numbers"),
        ({"q": ["x"] * 3}, "q is not made of numbers"),
        ({"mu": "much"}, "mu is not made of numbers"),
        ({"tolerance": np.nan}, "tolerance = nan; it must be finite"),
        ({"reference_mass": 0.0}, "reference_mass = 0.0; it must be finite and > 0"),
        ({"impulse": np.zeros(6)}, "impulse has shape"),
    ],
)
def test_bad_input_is_refused_in_one_line(change, words):
    """Each refusal names the argument and the rule."""
    with pytest.raises(InputError, match=words) as refusal:
        solve_contacts(**{"W": np.eye(3), "q": [-1.0, 0.0, 0.0], "mu": 0.5, **change})
    assert "\n" not in str(refusal.value)


def test_unconverged_islands_are_handed_to_newton():
    """Ten thousand kilograms on one kilogram: Gauss-Seidel stalls after 20 sweeps, Newton's method meets the tolerance."""
    world = mb.World()
    world.add_plane()
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5))
    world.add(mb.Box(1, 1, 1), mass=1e4, position=(0, 0, 1.5))
    still = np.zeros((3, 6))
    still[1:, 2] = -9.81 / 240
    problem = scenes.problem(world, 0.5, still)
    none = np.zeros((len(problem.target), 3))
    first = gauss_seidel.solve(problem, none, none, iterations=20, tolerance=1e-8)
    assert first.residual > 1e-8 and len(first.unconverged) == 1
    assert solve_unconverged(problem, first, 1e-8).residual <= 1e-8
