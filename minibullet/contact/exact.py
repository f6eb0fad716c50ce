"""The exact one-step solver: impulses that satisfy Coulomb's law at every contact to a stated residual.

Given W (velocity per impulse), q (velocity without contact impulses) and the friction coefficients, find r with u = W r + q and

    r = P_K(r - u~),    u~ = u + mu |u_T| n,    K = {|r_T| <= mu r_N}              (De Saxce's form of Signorini + Coulomb)

Gauss-Seidel with exact local solves comes first and is enough for most steps; where it stalls Newton's method takes over
(`newton`). Both stop on the residual; a count of steps is only a cap, and the residual tells when it was reached.

Sources: V. Acary, M. Bremond, O. Huber, "On solving contact problems with Coulomb friction" (2018), for the comparison of methods
and the residual; M. Jean, CMAME 177 (1999), for the block Gauss-Seidel method.
"""

from numbers import Real
from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import norm

from minibullet.contact.block_rows import BlockProblem, block_problem, gauss_seidel, into_cone, natural_map_residual
from minibullet.contact.newton import solve_scaled
from minibullet.contact.problem import Iterate, apply_impulses
from minibullet.contact.residual import residual_of
from minibullet.errors import InputError

# most Newton steps and most entries of their factors, 20 million a second. Most problems take tens of steps, the hardest known
# one (a rock pile, mu = 1) 9000; a problem of 2000 contacts has a million entries in its factors.
EFFORT = (10_000, 800_000_000)
STEP_EFFORT = (1_000, 200_000_000)  # the same inside a simulation, which would rather report a residual than wait
# and where rounding hides the solution: between masses of 1 and 1e8 kg nothing got better after 60 steps, in 1000
VAIN_EFFORT = (100, 20_000_000)
MOST_CONTACTS = 2000  # of an island in a simulation: a larger one keeps what Gauss-Seidel found [-]

SYMMETRY = 0.1  # outside problems are unsymmetric by up to 0.25 %; ten per cent is another matrix


class ContactSolution(NamedTuple):
    """What the solver hands back."""

    impulse: np.ndarray  # (3m,) N s on the second body; order normal, tangent, tangent; inside the friction cone
    residual: float  # relative natural-map residual of all contacts together; solved means <= tolerance
    iterations: int  # Gauss-Seidel sweeps plus Newton steps, summed over the islands


def solve_blocks(problem, start, tolerance, reference_mass=1.0, effort=STEP_EFFORT, sweeps=200):
    """One island as a BlockProblem, unchecked, from a starting impulse: (impulse, residual, iterations, effort left).

    Where the effort (steps, entries) ends before a solution is found, the best impulse comes back with its true residual.
    """
    q, mu = problem.q, problem.friction
    impulse = into_cone(mu, start) if q.any() else np.zeros_like(q)
    residual = natural_map_residual(problem, impulse, reference_mass)
    used = 0
    while residual > tolerance and used < sweeps:
        gauss_seidel(problem, impulse, 10)
        used += 10
        residual = natural_map_residual(problem, impulse, reference_mass)
    if residual <= tolerance:
        return impulse, residual, used, effort

    # one factor per contact keeps the cones; afterwards the diagonal of W and the velocities are about 1 in any units
    row = np.repeat(np.arange(len(mu)), np.diff(problem.start))
    length = 1.0 / np.sqrt(np.trace(problem.block[row == problem.column], axis1=1, axis2=2) / 3.0)
    scaled_q = np.repeat(length, 3) * q
    speed = np.linalg.norm(scaled_q) / np.sqrt(len(q))
    unit = speed * np.repeat(length, 3)
    scaled = problem._replace(block=problem.block * (length[row] * length[problem.column])[:, None, None], q=scaled_q / speed)

    def true_residual(scaled_impulse):
        return natural_map_residual(problem, into_cone(mu, unit * scaled_impulse), reference_mass)

    progress = solve_scaled(scaled, impulse / unit, true_residual, tolerance, effort)
    left = effort[0] - progress.steps, effort[1] - progress.entries
    return into_cone(mu, unit * progress.impulse), progress.best, used + progress.steps, left


def solve_unconverged(problem, solution, tolerance):
    """Inside a step: solve the unconverged islands of a Solution, those of at most ``MOST_CONTACTS``, from where Gauss-Seidel
    ended."""
    impulse, outer = solution.impulse.copy(), 0
    for island in solution.unconverged:
        contacts = problem.order[problem.islands[island] : problem.islands[island + 1]]
        if problem.rolling[contacts].any() or len(contacts) > MOST_CONTACTS:
            continue  # rolling moments are solved by Gauss-Seidel alone
        # what a light body does is a small difference of impulses that heavy ones hand it: their rounding over its mass
        light = problem.factors.inverse_mass[np.unique(problem.factors.bodies[contacts]), 0, 0]
        light = light[light > 0.0]
        effort = VAIN_EFFORT if np.finfo(float).eps * light.max() > 0.5 * tolerance * light.min() else STEP_EFFORT
        blocks, start = block_problem(problem, contacts), impulse[contacts].reshape(-1)
        solved, _, used, _ = solve_blocks(blocks, start, 0.5 * tolerance, problem.reference_mass, effort, sweeps=0)
        impulse[contacts], outer = solved.reshape(-1, 3), outer + used
    iterate = Iterate(impulse, solution.moment, solution.twist.copy())
    apply_impulses(problem.factors, impulse - solution.impulse, iterate.twist)
    return solution._replace(**iterate._asdict(), residual=residual_of(problem, iterate), outer=outer)


def float_array(name, value):
    """An array of floats, or InputError."""
    try:
        return np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"contact problem: {name} is not made of numbers") from None


def checked(W, q, mu, impulse):
    """W in compressed sparse rows, q (3m,), mu (m,), impulse (3m,); InputError with one line where they cannot be used."""
    q, mu = float_array("q", q), float_array("mu", mu)
    if q.ndim != 1 or len(q) % 3:
        raise InputError(f"contact problem: q has shape {q.shape}; it needs three values per contact")
    m = len(q) // 3
    W = W if sparse.issparse(W) else float_array("W", W)
    if W.shape != (3 * m, 3 * m):
        raise InputError(f"contact problem: W has shape {W.shape}; q with {3 * m} values needs ({3 * m}, {3 * m})")
    if mu.ndim not in (0, 1) or mu.size not in (1, m):
        raise InputError(f"contact problem: mu has {mu.size} values for {m} contacts; give one value or one per contact")
    mu = np.broadcast_to(mu, (m,)).copy()
    impulse = np.zeros(3 * m) if impulse is None else float_array("impulse", impulse)
    if impulse.shape != (3 * m,):
        raise InputError(f"contact problem: impulse has shape {impulse.shape}; q with {3 * m} values needs ({3 * m},)")
    W = sparse.csr_array(W, dtype=float)
    for name, array in (("W", W.data), ("q", q), ("mu", mu), ("impulse", impulse)):
        if not np.all(np.isfinite(array)):
            raise InputError(f"contact problem: {name} has a value that is not finite")
    if np.any(mu < 0.0):
        raise InputError(f"contact problem: mu = {mu.min():g} at contact {mu.argmin()}; friction must be >= 0")
    W.sum_duplicates()
    W.eliminate_zeros()
    diagonal = W.diagonal().reshape(-1, 3)
    refused = np.flatnonzero((diagonal < (np.finfo(float).tiny, 0.0, 0.0)).ravel())
    if len(refused):
        i = refused[0]
        raise InputError(
            f"contact problem: W[{i}, {i}] = {diagonal.flat[i]:g} (contact {i // 3}); the diagonal must be > 0 for normals "
            "and >= 0 for tangents"
        )
    difference = norm(W - W.T)
    if difference > SYMMETRY * norm(W):
        raise InputError(
            f"contact problem: W is not symmetric, |W - W^T| = {difference / norm(W):.2g} |W|; W = H^T M^-1 H is, "
            f"up to errors that may reach {SYMMETRY:g} |W|"
        )
    return W, q, mu, impulse


def solve_contacts(W, q, mu, tolerance=1e-8, *, impulse=None, reference_mass=1.0):
    """Impulses of all contacts of one step, to a relative natural-map residual <= tolerance where that can be reached.

    W: (3m, 3m), dense or scipy.sparse [1/kg]; q: (3m,) [m/s]; mu: a number or (m,) [-]; tolerance: of the residual [-];
    impulse: (3m,), a warm start [N s]; reference_mass: the residual measures impulses in units of it times velocity, 1 gives
    the form that other codes publish [kg]. Order: normal, tangent, tangent. A singular or slightly unsymmetric W is used as
    given. Islands (sets of contacts that W does not couple) are solved one by one. Returns a ContactSolution; not converged is
    not an error: look at its residual. The work is bounded: whatever the problem, an answer comes back after about a minute.
    InputError: shapes that do not fit, values not finite, negative mu, W far from symmetric or with a diagonal entry that no
    contact has, a tolerance or reference mass that is no such number.
    """
    W, q, mu, impulse = checked(W, q, mu, impulse)
    for name, value, least in (("tolerance", tolerance, 0.0), ("reference_mass", reference_mass, np.finfo(float).tiny)):
        if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(value) or value < least:
            raise InputError(f"contact problem: {name} = {value!r}; it must be finite and {'> 0' if least else '>= 0'}")
    m = len(mu)
    if not m:
        return ContactSolution(np.zeros(0), 0.0, 0)
    blocks = sparse.bsr_array(W, blocksize=(3, 3))
    blocks.sort_indices()
    whole = BlockProblem(blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64), blocks.data, q, mu)
    pattern = sparse.csr_array((np.ones(len(whole.column)), whole.column, whole.start), shape=(m, m))
    count, island = connected_components(pattern, directed=False)
    total, iterations, effort = np.zeros(3 * m), 0, EFFORT
    # with several islands |q|, |r| and |u| may peak in different ones, which costs at most a factor of sqrt(3)
    goal = tolerance if count == 1 else 0.5 * tolerance
    for contacts in np.split(np.argsort(island, kind="stable"), np.cumsum(np.bincount(island))[:-1]):
        own = (3 * contacts[:, None] + np.arange(3)).ravel()
        part = part_of(whole, contacts, own)
        total[own], _, used, effort = solve_blocks(part, impulse[own], goal, reference_mass, effort)
        iterations += used
    residual = natural_map_residual(whole, total, reference_mass)
    return ContactSolution(total, float(residual), int(iterations))


def part_of(problem, contacts, own):
    """The BlockProblem of one island: its contacts (ascending), renumbered; own: their places in q."""
    length = np.diff(problem.start)[contacts]
    start = np.concatenate([[0], np.cumsum(length)])
    taken = np.arange(start[-1]) + np.repeat(problem.start[contacts] - start[:-1], length)
    column = np.searchsorted(contacts, problem.column[taken])
    return BlockProblem(start, column, problem.block[taken], problem.q[own], problem.friction[contacts])
