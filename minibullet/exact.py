"""The exact one-step solver: impulses that satisfy Coulomb's law at every contact to a stated residual.

Given W (velocity per impulse), q (velocity without contact impulses) and the friction coefficients, find r with u = W r + q and

    r = P_K(r - u~),    u~ = u + mu |u_T| n,    K = {|r_T| <= mu r_N}              (De Saxce's form of Signorini + Coulomb)

Gauss-Seidel with exact local solves comes first and is enough for most steps; where it stalls Newton's method takes over
(`newton`). Both stop on the residual; a count of steps is only a cap, and the residual tells when it was reached.

Sources: V. Acary, M. Bremond, O. Huber, "On solving contact problems with Coulomb friction" (2018), for the comparison of methods
and the residual; M. Jean, CMAME 177 (1999), for the block Gauss-Seidel method.
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.csgraph import connected_components

from .cone import compress, gauss_seidel, into_cone, natural_map_residual
from .errors import InputError
from .newton import solve_scaled

NEWTON_STEPS = 10000  # cap per island; most problems take tens, the hardest known one (a rock pile, mu = 1) 9000
STEP_LIMIT = 1000  # the same inside a simulation, which would rather report a residual than wait


class ContactSolution(NamedTuple):
    """What the solver hands back."""

    impulse: np.ndarray  # (3m,) N s on the second body; order normal, tangent, tangent; inside the friction cone
    residual: float  # relative natural-map residual of all contacts together; solved means <= tolerance
    iterations: int  # Gauss-Seidel sweeps plus Newton steps, summed over the islands


def solve_dense(W, q, mu, r0, tolerance, reference_mass=1.0, newton_steps=STEP_LIMIT):
    """One island, dense float64 W (3m, 3m), unchecked: returns (impulse, residual, iterations). r0 (3m,) is the warm start.

    newton_steps caps the work where no solution is found; the best impulse found is returned with its true residual.
    """
    return solve_rows(compress(W), q, mu, r0, tolerance, reference_mass, newton_steps)


def solve_rows(rows, q, mu, r0, tolerance, reference_mass=1.0, newton_steps=STEP_LIMIT, sweeps=200):
    """One island as block rows (start, column, block), unchecked: returns (impulse, residual, iterations)."""
    impulse = into_cone(mu, r0) if q.any() else np.zeros_like(q)
    residual = natural_map_residual(*rows, q, mu, impulse, reference_mass)
    used = 0
    while residual > tolerance and used < sweeps:
        gauss_seidel(*rows, q, mu, impulse, 10)
        used += 10
        residual = natural_map_residual(*rows, q, mu, impulse, reference_mass)
    if residual <= tolerance:
        return impulse, residual, used

    # one factor per contact keeps the cones; afterwards the diagonal of W and the velocities are about 1 in any units
    start, column, block = rows
    row = np.repeat(np.arange(len(mu)), np.diff(start))
    length = 1.0 / np.sqrt(np.trace(block[row == column], axis1=1, axis2=2) / 3.0)
    scaled_rows = (start, column, block * (length[row] * length[column])[:, None, None])
    scaled_q = np.repeat(length, 3) * q
    speed = np.linalg.norm(scaled_q) / np.sqrt(len(q))
    unit = speed * np.repeat(length, 3)

    def true_residual(scaled):
        return natural_map_residual(*rows, q, mu, into_cone(mu, unit * scaled), reference_mass)

    scaled, residual, steps = solve_scaled(
        scaled_rows, scaled_q / speed, mu, impulse / unit, true_residual, tolerance, newton_steps
    )
    return into_cone(mu, unit * scaled), residual, used + steps


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
        small = m <= 300  # slicing a dense matrix is quicker than slicing a sparse one, while it fits
        whole = W.toarray() if small or count == 1 else None
        for number in range(count):
            contacts = np.flatnonzero(island == number)
            rows = (3 * contacts[:, None] + np.arange(3)).ravel()
            part = whole if count == 1 else whole[np.ix_(rows, rows)] if small else W[rows][:, rows].toarray()
            # with several islands |q|, |r| and |u| may peak in different ones, which costs at most a factor of sqrt(3)
            goal = tolerance if count == 1 else 0.5 * tolerance
            total[rows], _, used = solve_dense(part, q[rows], mu[contacts], impulse[rows], goal, reference_mass, NEWTON_STEPS)
            iterations += used
        blocks.sort_indices()
        start, column = blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64)
        residual = natural_map_residual(start, column, blocks.data, q, mu, total, reference_mass)
    else:
        residual = 0.0
    return ContactSolution(total, float(residual), int(iterations))
