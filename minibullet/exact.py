"""The exact one-step solver: impulses that satisfy Coulomb's law at every contact to a stated residual.

Given W (velocity per impulse), q (velocity without contact impulses) and the friction coefficients, find r with u = W r + q and

    r = P_K(r - u~),    u~ = u + mu |u_T| n,    K = {|r_T| <= mu r_N}              (De Saxce's form of Signorini + Coulomb)

Gauss-Seidel with exact local solves comes first and is enough for most steps; where it stalls a proximal loop with a semismooth
Newton solve takes over (`newton`). Both stop on the residual, never on an iteration count alone.

Sources: V. Acary, M. Bremond, O. Huber, "On solving contact problems with Coulomb friction" (2018), for the comparison of methods
and the residual; M. Jean, CMAME 177 (1999), for the block Gauss-Seidel method.
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from numba import njit
from scipy.sparse.csgraph import connected_components

from .cone import natural_map_error, project_cone, solve_block
from .errors import InputError
from .newton import proximal_newton

MACHINE_EPSILON = 2.220446049250313e-16


class ContactSolution(NamedTuple):
    """What the solver hands back."""

    impulse: np.ndarray  # (3m,) N s on the second body; order normal, tangent, tangent; inside the friction cone
    residual: float  # relative natural-map residual of all contacts together; solved means <= tolerance
    iterations: int  # Gauss-Seidel sweeps plus Newton steps, summed over the islands


@njit(cache=True)
def compress(W):
    """Dense W (3m, 3m) as block rows: start (m+1,), column (b,), block (b, 3, 3); diagonal blocks are always kept."""
    m = W.shape[0] // 3
    filled = np.zeros((m, m), np.bool_)
    for i in range(m):
        for a in range(3):
            for j in range(m):
                if W[3 * i + a, 3 * j] != 0.0 or W[3 * i + a, 3 * j + 1] != 0.0 or W[3 * i + a, 3 * j + 2] != 0.0:
                    filled[i, j] = True
        filled[i, i] = True
    start = np.zeros(m + 1, np.int64)
    for i in range(m):
        start[i + 1] = start[i] + filled[i].sum()
    column = np.empty(start[m], np.int64)
    block = np.empty((start[m], 3, 3))
    k = 0
    for i in range(m):
        for j in range(m):
            if filled[i, j]:
                column[k] = j
                block[k] = W[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
                k += 1
    return start, column, block


@njit(cache=True)
def natural_map_residual(start, column, block, q, friction, impulse, reference_mass):
    """E / max(|q|, |r|, |u|) with E = |r - P_K(r - u~)| and r in units of the reference mass; E itself if all of them vanish."""
    error = q_2 = r_2 = u_2 = 0.0
    for i in range(len(friction)):
        u_n, u_1, u_2nd = q[3 * i], q[3 * i + 1], q[3 * i + 2]
        q_2 += u_n * u_n + u_1 * u_1 + u_2nd * u_2nd
        for k in range(start[i], start[i + 1]):
            j, w = 3 * column[k], block[k]
            u_n += w[0, 0] * impulse[j] + w[0, 1] * impulse[j + 1] + w[0, 2] * impulse[j + 2]
            u_1 += w[1, 0] * impulse[j] + w[1, 1] * impulse[j + 1] + w[1, 2] * impulse[j + 2]
            u_2nd += w[2, 0] * impulse[j] + w[2, 1] * impulse[j + 1] + w[2, 2] * impulse[j + 2]
        r_n = impulse[3 * i] / reference_mass
        r_1 = impulse[3 * i + 1] / reference_mass
        r_2nd = impulse[3 * i + 2] / reference_mass
        r_2 += r_n * r_n + r_1 * r_1 + r_2nd * r_2nd
        u_2 += u_n * u_n + u_1 * u_1 + u_2nd * u_2nd
        error += natural_map_error(r_n, r_1, r_2nd, u_n, u_1, u_2nd, friction[i], 1.0)
    size = np.sqrt(max(q_2, r_2, u_2))
    return np.sqrt(error) / size if size > MACHINE_EPSILON else np.sqrt(error)


@njit(cache=True)
def gauss_seidel(start, column, block, q, friction, impulse, sweeps):
    """Solve every contact exactly with the others held, in order, `sweeps` times; changes impulse in place."""
    for _ in range(sweeps):
        for i in range(len(friction)):
            b_n, b_1, b_2 = q[3 * i], q[3 * i + 1], q[3 * i + 2]
            own = start[i]
            for k in range(start[i], start[i + 1]):
                if column[k] == i:
                    own = k
                    continue
                j, w = 3 * column[k], block[k]
                b_n += w[0, 0] * impulse[j] + w[0, 1] * impulse[j + 1] + w[0, 2] * impulse[j + 2]
                b_1 += w[1, 0] * impulse[j] + w[1, 1] * impulse[j + 1] + w[1, 2] * impulse[j + 2]
                b_2 += w[2, 0] * impulse[j] + w[2, 1] * impulse[j + 1] + w[2, 2] * impulse[j + 2]
            w = block[own]
            impulse[3 * i], impulse[3 * i + 1], impulse[3 * i + 2] = solve_block(
                w[0, 0], w[0, 1], w[0, 2], w[1, 0], w[1, 1], w[1, 2], w[2, 0], w[2, 1], w[2, 2], b_n, b_1, b_2, friction[i]
            )


@njit(cache=True)
def into_cone(friction, impulse):
    """A copy of impulse (3m,) with every contact projected on its friction cone."""
    inside = np.empty_like(impulse)
    for i in range(len(friction)):
        inside[3 * i], inside[3 * i + 1], inside[3 * i + 2] = project_cone(
            impulse[3 * i], impulse[3 * i + 1], impulse[3 * i + 2], friction[i]
        )
    return inside


def solve_dense(W, q, mu, r0, tolerance, reference_mass=1.0, sweeps=200):
    """One island, dense float64 W (3m, 3m), unchecked: returns (impulse, residual, iterations). r0 (3m,) is the warm start."""
    start, column, block = compress(W)
    impulse = into_cone(mu, r0)
    if not q.any():
        impulse[:] = 0.0
    residual = natural_map_residual(start, column, block, q, mu, impulse, reference_mass)
    used = 0
    while residual > tolerance and used < sweeps:
        gauss_seidel(start, column, block, q, mu, impulse, 10)
        used += 10
        residual = natural_map_residual(start, column, block, q, mu, impulse, reference_mass)
    if residual <= tolerance:
        return impulse, residual, used

    # one factor per contact keeps the cones; afterwards the diagonal of W and the velocities are about 1 in any units
    length = np.repeat(1.0 / np.sqrt(np.diag(W).reshape(-1, 3).mean(axis=1)), 3)
    speed = np.linalg.norm(length * q) / np.sqrt(len(q))

    def true_residual(scaled):
        inside = into_cone(mu, length * speed * scaled)
        return natural_map_residual(start, column, block, q, mu, inside, reference_mass)

    scaled, residual, steps = proximal_newton(
        length[:, None] * W * length, length * q / speed, mu, impulse / (length * speed), true_residual, tolerance
    )
    return into_cone(mu, length * speed * scaled), residual, used + steps


def checked(W, q, mu, impulse):
    """The problem as sparse block rows, q (3m,), mu (m,), impulse (3m,); InputError with one line where it cannot be used."""
    q = np.asarray(q, dtype=float)
    if q.ndim != 1 or len(q) % 3:
        raise InputError(f"contact problem: q has shape {q.shape}; it needs three values per contact")
    m = len(q) // 3
    if np.shape(W) != (3 * m, 3 * m):
        raise InputError(f"contact problem: W has shape {np.shape(W)}; q with {3 * m} values needs ({3 * m}, {3 * m})")
    if np.ndim(mu) not in (0, 1) or np.size(mu) not in (1, m):
        raise InputError(f"contact problem: mu has {np.size(mu)} values for {m} contacts; give one value or one per contact")
    mu = np.broadcast_to(np.asarray(mu, dtype=float), (m,)).copy()
    impulse = np.zeros(3 * m) if impulse is None else np.asarray(impulse, dtype=float)
    if impulse.shape != (3 * m,):
        raise InputError(f"contact problem: impulse has shape {impulse.shape}; q with {3 * m} values needs ({3 * m},)")
    values = W.data if sparse.issparse(W) else np.asarray(W)
    for name, array in (("W", values), ("q", q), ("mu", mu), ("impulse", impulse)):
        if not np.all(np.isfinite(array)):
            raise InputError(f"contact problem: {name} has a value that is not finite")
    if np.any(mu < 0.0):
        raise InputError(f"contact problem: mu = {mu.min():g} at contact {mu.argmin()}; friction must be >= 0")
    W = sparse.csr_array(W, dtype=float)
    diagonal = W.diagonal()
    if np.any(diagonal <= 0.0):
        c = np.argmax(diagonal <= 0.0)
        raise InputError(f"contact problem: W[{c}, {c}] = {diagonal[c]:g} (contact {c // 3}); the diagonal must be > 0")
    return W, q, mu, impulse


def solve_contacts(W, q, mu, tolerance=1e-8, *, impulse=None, reference_mass=1.0):
    """Impulses of all contacts of one step, to a relative natural-map residual <= tolerance where that can be reached.

    W (3m, 3m) dense or scipy.sparse [1/kg], q (3m,) [m/s], mu scalar or (m,); order normal, tangent, tangent. W may be singular
    and slightly unsymmetric; it is used as given. impulse (3m,) [N s] is a warm start. The residual measures impulses in units of
    reference_mass [kg] times velocity; 1 gives the form that other codes publish. Islands (sets of contacts that W does not
    couple) are solved one by one. Returns a ContactSolution; not converged is not an error: look at its residual.
    InputError: shapes that do not fit, values not finite, negative mu, a diagonal entry of W that is not positive.
    """
    W, q, mu, impulse = checked(W, q, mu, impulse)
    m = len(mu)
    blocks = sparse.bsr_array(W, blocksize=(3, 3)) if m else W
    total, iterations = np.zeros(3 * m), 0
    if m:
        pattern = sparse.csr_array((np.ones(len(blocks.indices)), blocks.indices, blocks.indptr), shape=(m, m))
        count, island = connected_components(pattern, directed=False)
        for number in range(count):
            contacts = np.flatnonzero(island == number)
            rows = (3 * contacts[:, None] + np.arange(3)).ravel()
            part = (W if count == 1 else W[rows][:, rows]).toarray()
            # with several islands |q|, |r| and |u| may peak in different ones, which costs at most a factor of sqrt(3)
            goal = tolerance if count == 1 else 0.5 * tolerance
            total[rows], _, used = solve_dense(part, q[rows], mu[contacts], impulse[rows], goal, reference_mass)
            iterations += used
        blocks.sort_indices()
        start, column = blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64)
        residual = natural_map_residual(start, column, blocks.data, q, mu, total, reference_mass)
    else:
        residual = 0.0
    return ContactSolution(total, float(residual), int(iterations))
