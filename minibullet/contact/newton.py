"""Newton's method for the one-step friction problem, for what Gauss-Seidel cannot finish.

Hyperstatic stacks, large mass ratios and redundant contacts make W singular and far from diagonal. Two globalisations of the same
Newton step share the work; each alone leaves problems unsolved that the other solves:

- `follow_path` rounds the kinks of the law by a smoothing that goes to zero, as in interior-point methods: few, sure steps;
- `proximal_loop` solves W + alpha I about the last iterate and lets alpha go to zero: slower, but works where no path exists.

All problems come scaled: the diagonal of W and the velocities are about 1. `rows` is (start, column, block), see `cone`.

Sources: M. Fukushima, Z.-Q. Luo, P. Tseng, SIAM J. Optim. 12 (2002), smoothing on second-order cones; R. T. Rockafellar, SIAM J.
Control Optim. 14 (1976), the proximal point algorithm; V. Acary, M. Bremond, O. Huber (2018), both ideas compared for friction.
"""

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from minibullet.contact.coulomb import gauss_seidel, into_cone, law_equations, newton_system, velocity


class Progress:
    """The best impulse so far by the true residual, and what was spent of the effort allowed.

    Effort is counted, not timed, so that every machine gives the same answer: Newton steps, and numbers in their factors (about
    20 million a second).
    """

    def __init__(self, residual, impulse, tolerance, steps, numbers):
        self.residual, self.tolerance, self.steps, self.numbers, self.spent, self.used = residual, tolerance, steps, numbers, 0, 0
        self.impulse, self.best = impulse, residual(impulse)

    def spend(self, numbers):
        """Book a Newton step whose factors have so many numbers."""
        self.spent += 1
        self.used += numbers

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
        """Out of steps or numbers."""
        return self.spent >= self.steps or self.used >= self.numbers


def regularised(rows, q, alpha, centre):
    """Block rows and q of the velocity W r + q + alpha (r - centre)."""
    start, column, block = rows
    block = block.copy()
    block[column == np.repeat(np.arange(len(start) - 1), np.diff(start))] += alpha * np.eye(3)
    return (start, column, block), q - alpha * centre


def newton_direction(rows, impulse, F, A, B):
    """The Newton step (3m,), or None where the matrix is singular; and how many numbers its factors have."""
    number, pointer, index, value, right = newton_system(*rows, impulse, F, A, B)
    step, numbers = -impulse, 0
    if len(right):
        try:
            # compressed rows read as columns are the transpose; the pattern is symmetric, so a symmetric ordering fills least
            transpose = csc_array((value, index, pointer), shape=(len(right), len(right)))
            factors = splu(transpose, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True})
        except RuntimeError:
            return None, len(value)
        numbers = factors.nnz
        step.reshape(-1, 3)[number >= 0] = factors.solve(right, "T").reshape(-1, 3)
    return (step if np.all(np.isfinite(step)) else None), numbers


def newton(rows, q, friction, impulse, rho, smoothing, goal, iterations, progress):
    """Solve law_equations = 0 from `impulse` until |F| <= goal; returns (impulse, reached, iterations).

    The line search halves the step until |F| falls below the largest of the last three values; kinks would trap a
    monotone search.
    """
    m = len(friction)
    F, A, B = np.empty(3 * m), np.empty((m, 3, 3)), np.empty((m, 3, 3))
    error = law_equations(impulse, velocity(*rows, q, impulse), friction, rho, smoothing, F, A, B)
    recent = [error]
    for iteration in range(iterations):
        if error <= goal:
            return impulse, True, iteration
        if progress.exhausted:
            return impulse, False, iteration
        step, numbers = newton_direction(rows, impulse, F, A, B)
        progress.spend(numbers)
        if step is None:
            return impulse, False, iteration
        fraction = 1.0
        while fraction > 1e-3:
            following = impulse + fraction * step
            error = law_equations(following, velocity(*rows, q, following), friction, rho, smoothing, F, A, B)
            if error <= (1.0 - 1e-4 * fraction) * max(recent):
                break
            fraction *= 0.5
        else:
            return impulse, False, iteration
        impulse = following
        recent = [*recent[-2:], error]
    return impulse, error <= goal, iterations


def follow_path(rows, q, friction, impulse, progress, rho=10.0, alpha=1e-7, smoothing=1.0, attempt=60):
    """Follow the central path of the smoothed law to smoothing 0, stepping back where Newton's method fails."""
    last = progress.spent + attempt
    while progress.spent < last and not progress.over:
        shifted_rows, shifted_q = regularised(rows, q, alpha, impulse)
        goal = 0.1 * smoothing * np.sqrt(len(friction))
        impulse, reached, used = newton(shifted_rows, shifted_q, friction, impulse, rho, smoothing, goal, 8, progress)
        progress.judge(impulse)
        progress.spent += used == 0  # a path that needs no steps ends all the same
        smoothing = max(smoothing * (0.2 if used < 4 else 0.5), 1e-13) if reached else 2.0 * smoothing


def proximal_loop(rows, q, friction, impulse, progress, rho=30.0, alpha=1e-2, outer=100):
    """Proximal point algorithm: alpha falls while Newton's method reaches its goal and grows where it does not.

    `fall`, the factor of the next decrease of alpha, grows after hard solves: otherwise alpha would bounce on its floor.
    """
    centre, here, size, fall = impulse, progress.judge(impulse), np.linalg.norm(q), 0.2
    for _ in range(outer):
        shifted_rows, shifted_q = regularised(rows, q, alpha, centre)
        goal = size * max(1e-14, 1e-2 * min(progress.best, 1e-2))
        following, reached, used = newton(shifted_rows, shifted_q, friction, centre, rho, 0.0, goal, 30, progress)
        easy = reached and used <= 8
        for other_rho in (0.3 * rho, 3.0 * rho):
            if reached:
                break
            # a few sweeps move the iterate off the kink that stopped the line search; another rho has its kinks elsewhere
            following = into_cone(friction, following)
            gauss_seidel(*shifted_rows, shifted_q, friction, following, 50)
            following, reached, _ = newton(shifted_rows, shifted_q, friction, following, other_rho, 0.0, goal, 30, progress)
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


def solve_scaled(rows, q, friction, impulse, residual, tolerance, effort):
    """The path first, then the proximal loop with one scale rho of the equations after another, until solved or out of ``effort``
    (steps, numbers). Returns the Progress."""
    progress = Progress(residual, impulse, tolerance, *effort)
    follow_path(rows, q, friction, impulse, progress)
    if not progress.over:
        proximal_loop(rows, q, friction, impulse, progress)
    if not progress.over:
        follow_path(rows, q, friction, progress.impulse, progress, rho=1.0, attempt=150)
    for rho in (100.0, 10.0):
        if not progress.over:
            proximal_loop(rows, q, friction, progress.impulse, progress, rho)
    return progress
