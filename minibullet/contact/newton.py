"""Newton's method for the one-step friction problem, for what Gauss-Seidel cannot finish.

Hyperstatic stacks, large mass ratios and redundant contacts make W singular and far from diagonal. Two globalisations of the same
Newton step share the work; each alone leaves problems unsolved that the other solves:

- `follow_path` rounds the kinks of the law by a smoothing that goes to zero, as in interior-point methods: few, sure steps;
- `proximal_loop` solves W + alpha I about the last iterate and lets alpha go to zero: slower, but works where no path exists.

All problems come scaled: the diagonal of W and the velocities are about 1.

Sources: M. Fukushima, Z.-Q. Luo, P. Tseng, SIAM J. Optim. 12 (2002), smoothing on second-order cones; R. T. Rockafellar, SIAM J.
Control Optim. 14 (1976), the proximal point algorithm; V. Acary, M. Bremond, O. Huber (2018), both ideas compared for friction;
P. Alart and A. Curnier, CMAME 92 (1991), for the law as equations.
"""

from math import sqrt

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from minibullet.contact.block_rows import gauss_seidel, into_cone, velocity
from minibullet.kernels import kernel


class Progress:
    """The best impulse so far by the true residual, and what was spent of the effort allowed.

    Effort is counted, not timed, so that every machine gives the same answer: Newton steps, and entries of their factors (about
    20 million a second).
    """

    def __init__(self, residual, impulse, tolerance, effort):
        self.residual, self.tolerance, self.effort, self.steps, self.entries = residual, tolerance, effort, 0, 0
        self.impulse, self.best = impulse, residual(impulse)

    def spend(self, entries):
        """Count a Newton step whose factors have so many entries."""
        self.steps += 1
        self.entries += entries

    def judge(self, impulse):
        """Residual of an impulse; kept if it is the best so far."""
        value = self.residual(impulse)
        if value < self.best:
            self.best, self.impulse = value, impulse
        return value

    @property
    def over(self):
        """Solved, or out of effort."""
        return self.best <= self.tolerance or self.exhausted

    @property
    def exhausted(self):
        """Out of steps or entries."""
        return self.steps >= self.effort[0] or self.entries >= self.effort[1]


@kernel
def law_equations(impulse, u, friction, rho, smoothing, F, A, B):
    """Coulomb's law as equations F(r, u) = 0 and their derivatives A = dF/dr, B = dF/du; returns |F|.

    With y = r - rho u: F_N = r_N - p, p = max(y_N, 0), and F_T = r_T - g y_T, g = R/max(R, |y_T|), R = mu p (Alart and Curnier).
    smoothing s > 0 rounds the kinks: max(y, 0) -> (y + sqrt(y^2 + 4 s^2))/2, so that r_N u_N rho = s^2 (the central path of an
    interior-point method), and likewise max(R, |y_T|) and |y_T| with s/10. F (3m,), A and B (m, 3, 3) are written.
    """
    A[:], B[:] = 0.0, 0.0
    for i in range(len(friction)):
        n, s = 3 * i, smoothing
        y_n, y_1, y_2 = impulse[n] - rho * u[n], impulse[n + 1] - rho * u[n + 1], impulse[n + 2] - rho * u[n + 2]
        root = sqrt(y_n * y_n + 4.0 * s * s)
        pressure = 0.5 * (y_n + root) if y_n > 0.0 else (2.0 * s * s / (root - y_n) if root > 0.0 else 0.0)
        rise = pressure / root if root > 0.0 else 0.0
        F[n], A[i, 0, 0], B[i, 0, 0] = impulse[n] - pressure, 1.0 - rise, rho * rise
        s *= 0.1
        limit = friction[i] * pressure
        length = sqrt(y_1 * y_1 + y_2 * y_2 + s * s)
        root = sqrt((limit - length) ** 2 + 4.0 * s * s)
        larger = 0.5 * (limit + length + root)
        if larger <= 0.0 or limit <= 0.0:
            F[n + 1], F[n + 2], A[i, 1, 1], A[i, 2, 2] = impulse[n + 1], impulse[n + 2], 1.0, 1.0
            continue
        share = 0.5 * (1.0 + (limit - length) / root) if root > 0.0 else 1.0
        scale = limit / larger
        by_pressure = (1.0 - scale * share) / larger * friction[i] * rise
        by_length = -scale / larger * (1.0 - share) / length if length > 0.0 else 0.0
        F[n + 1], F[n + 2] = impulse[n + 1] - scale * y_1, impulse[n + 2] - scale * y_2
        g_11, g_22, g_12 = scale + by_length * y_1 * y_1, scale + by_length * y_2 * y_2, by_length * y_1 * y_2
        A[i, 1, 0], A[i, 1, 1], A[i, 1, 2] = -by_pressure * y_1, 1.0 - g_11, -g_12
        A[i, 2, 0], A[i, 2, 1], A[i, 2, 2] = -by_pressure * y_2, -g_12, 1.0 - g_22
        B[i, 1, 0], B[i, 1, 1], B[i, 1, 2] = rho * by_pressure * y_1, rho * g_11, rho * g_12
        B[i, 2, 0], B[i, 2, 1], B[i, 2, 2] = rho * by_pressure * y_2, rho * g_12, rho * g_22
    return sqrt((F * F).sum())


@kernel
def newton_system(problem, impulse, F, A, B):
    """(A + B W) d = -F without the contacts that take off (B = 0, where d = -r).

    Returns number (m,), the place of each contact in the system or -1, the matrix as compressed rows (pointer, index, value), and
    the right side.
    """
    start, column, block = problem.start, problem.column, problem.block
    m = len(start) - 1
    number = np.full(m, -1)
    held = filled = 0
    for i in range(m):
        if B[i, 0, 0] != 0.0:
            number[i] = held
            held += 1
    for i in range(m):
        for k in range(start[i], start[i + 1]):
            filled += 9 * (number[i] >= 0 and number[column[k]] >= 0)
    pointer, index, value = np.zeros(3 * held + 1, np.int32), np.empty(filled, np.int32), np.empty(filled)
    right, at = np.empty(3 * held), 0
    for i in range(m):
        if number[i] < 0:
            continue
        for a in range(3):
            right[3 * number[i] + a] = -F[3 * i + a]
            for k in range(start[i], start[i + 1]):
                j = column[k]
                for b in range(3):
                    entry = B[i, a, 0] * block[k, 0, b] + B[i, a, 1] * block[k, 1, b] + B[i, a, 2] * block[k, 2, b]
                    if number[j] < 0:
                        right[3 * number[i] + a] += entry * impulse[3 * j + b]
                        continue
                    index[at], value[at] = 3 * number[j] + b, entry + (A[i, a, b] if j == i else 0.0)
                    at += 1
            pointer[3 * number[i] + a + 1] = at
    return number, pointer, index, value, right


def regularised(problem, alpha, centre):
    """The problem with the velocity W r + q + alpha (r - centre)."""
    block = problem.block.copy()
    block[problem.column == np.repeat(np.arange(len(problem.friction)), np.diff(problem.start))] += alpha * np.eye(3)
    return problem._replace(block=block, q=problem.q - alpha * centre)


def newton_direction(problem, impulse, F, A, B):
    """The Newton step (3m,), or None where the matrix is singular; and how many entries its factors have."""
    number, pointer, index, value, right = newton_system(problem, impulse, F, A, B)
    step, entries = -impulse, 0
    if len(right):
        try:
            # compressed rows read as columns are the transpose; the pattern is symmetric, so a symmetric ordering fills least
            transpose = csc_array((value, index, pointer), shape=(len(right), len(right)))
            factors = splu(transpose, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True})
        except RuntimeError:
            return None, len(value)
        entries = factors.nnz
        step.reshape(-1, 3)[number >= 0] = factors.solve(right, "T").reshape(-1, 3)
    return (step if np.all(np.isfinite(step)) else None), entries


def newton(problem, impulse, rho, smoothing, goal, iterations, progress):
    """Solve law_equations = 0 from `impulse` until |F| <= goal; returns (impulse, reached, iterations).

    The line search halves the step until |F| falls below the largest of the last three values; kinks would trap a
    monotone search.
    """
    friction, m = problem.friction, len(problem.friction)
    F, A, B = np.empty(3 * m), np.empty((m, 3, 3)), np.empty((m, 3, 3))
    error = law_equations(impulse, velocity(problem, impulse), friction, rho, smoothing, F, A, B)
    recent = [error]
    for iteration in range(iterations):
        if error <= goal:
            return impulse, True, iteration
        if progress.exhausted:
            return impulse, False, iteration
        step, entries = newton_direction(problem, impulse, F, A, B)
        progress.spend(entries)
        if step is None:
            return impulse, False, iteration
        fraction = 1.0
        while fraction > 1e-3:
            following = impulse + fraction * step
            error = law_equations(following, velocity(problem, following), friction, rho, smoothing, F, A, B)
            if error <= (1.0 - 1e-4 * fraction) * max(recent):
                break
            fraction *= 0.5
        else:
            return impulse, False, iteration
        impulse = following
        recent = [*recent[-2:], error]
    return impulse, error <= goal, iterations


def follow_path(problem, impulse, progress, rho=10.0, alpha=1e-7, smoothing=1.0, attempt=60):
    """Follow the central path of the smoothed law to smoothing 0, stepping back where Newton's method fails."""
    last = progress.steps + attempt
    while progress.steps < last and not progress.over:
        shifted = regularised(problem, alpha, impulse)
        goal = 0.1 * smoothing * np.sqrt(len(problem.friction))
        impulse, reached, used = newton(shifted, impulse, rho, smoothing, goal, 8, progress)
        progress.judge(impulse)
        progress.steps += used == 0  # a path that needs no steps ends all the same
        smoothing = max(smoothing * (0.2 if used < 4 else 0.5), 1e-13) if reached else 2.0 * smoothing


def proximal_loop(problem, impulse, progress, rho=30.0, alpha=1e-2, outer=100):
    """Proximal point algorithm: alpha falls while Newton's method reaches its goal and grows where it does not.

    `fall`, the factor of the next decrease of alpha, grows after hard solves: otherwise alpha would bounce on its floor.
    """
    centre, here, size, fall = impulse, progress.judge(impulse), np.linalg.norm(problem.q), 0.2
    for _ in range(outer):
        shifted = regularised(problem, alpha, centre)
        goal = size * max(1e-14, 1e-2 * min(progress.best, 1e-2))
        following, reached, used = newton(shifted, centre, rho, 0.0, goal, 30, progress)
        easy = reached and used <= 8
        for other_rho in (0.3 * rho, 3.0 * rho):
            if reached:
                break
            # a few sweeps move the iterate off the kink that stopped the line search; another rho has its kinks elsewhere
            following = into_cone(problem.friction, following)
            gauss_seidel(shifted, following, 50)
            following, reached, _ = newton(shifted, following, other_rho, 0.0, goal, 30, progress)
        there = progress.judge(following)
        if progress.over:
            break
        if reached or there < here:
            centre, here = following, there
        if reached:
            alpha = max(fall * alpha, 1e-9)
            fall = max(0.7 * fall, 0.1) if easy else min(1.3 * fall, 0.7)
        else:
            alpha = min(5.0 * alpha, 1e2)
            fall = min(2.0 * fall, 0.7)


def solve_scaled(problem, impulse, residual, tolerance, effort):
    """The path first, then the proximal loop with one scale rho of the equations after another, until solved or out of ``effort``
    (steps, entries). Returns the Progress."""
    progress = Progress(residual, impulse, tolerance, effort)
    follow_path(problem, impulse, progress)
    if not progress.over:
        proximal_loop(problem, impulse, progress)
    if not progress.over:
        follow_path(problem, progress.impulse, progress, rho=1.0, attempt=150)
    for rho in (100.0, 10.0):
        if not progress.over:
            proximal_loop(problem, progress.impulse, progress, rho)
    return progress
