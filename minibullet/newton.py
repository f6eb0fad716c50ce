"""Semismooth Newton's method for the one-step friction problem, wrapped in a proximal loop.

Used when Gauss-Seidel stalls: on hyperstatic stacks, large mass ratios and redundant contacts, where W is far from diagonal or
singular. Impulses r and velocities u are arrays (3m,), order normal, tangent, tangent at each contact. Every step of the outer
loop adds alpha (r - centre) to the velocity, so that W may be singular; at a fixed point r = centre the term vanishes.

Sources: P. Alart and A. Curnier, CMAME 92 (1991), the equations; R. T. Rockafellar, SIAM J. Control Optim. 14 (1976), the loop.
"""

import numpy as np


def alart_curnier(impulse, velocity, friction):
    """Coulomb's law as equations F(r, u) = 0 and their generalised derivative.

    F_N = r_N - max(y_N, 0), F_T = r_T - (y_T shortened to length mu max(y_N, 0)) with y = r - u. Returns F (m, 3) and the blocks
    A = dF/dr and B = dF/du, both (m, 3, 3); a contact that takes off has B = 0.
    """
    r, u = impulse.reshape(-1, 3), velocity.reshape(-1, 3)
    y = r - u
    pressed = y[:, 0] > 0.0
    limit = friction * np.maximum(y[:, 0], 0.0)
    length = np.hypot(y[:, 1], y[:, 2])
    sliding = length > limit
    safe = np.where(length > 0.0, length, 1.0)
    direction = y[:, 1:] / safe[:, None]
    F = np.empty_like(r)
    F[:, 0] = np.where(pressed, u[:, 0], r[:, 0])
    F[:, 1:] = np.where(sliding[:, None], r[:, 1:] - limit[:, None] * direction, u[:, 1:])
    A, B = np.zeros((len(r), 3, 3)), np.zeros((len(r), 3, 3))
    A[:, 0, 0], B[:, 0, 0] = ~pressed, pressed
    across = np.eye(2) - direction[:, :, None] * direction[:, None, :]
    turning = np.where(sliding[:, None, None], (limit / safe)[:, None, None] * across, np.eye(2))
    A[:, 1:, 1:], B[:, 1:, 1:] = np.eye(2) - turning, turning
    growth = np.where(sliding & pressed, friction, 0.0)[:, None] * direction
    A[:, 1:, 0], B[:, 1:, 0] = -growth, growth
    return F, A, B


def newton_direction(W, alpha, impulse, F, A, B):
    """Solve (A + B (W + alpha I)) d = -F; contacts that take off (B = 0, d = -r) are eliminated first. None if singular."""
    m = len(F)
    held = np.flatnonzero(B.any(axis=(1, 2)))
    rows = (3 * held[:, None] + np.arange(3)).ravel()
    step = -impulse
    if len(held) == 0:
        return step
    free = np.ones(3 * m, dtype=bool)
    free[rows] = False
    blocks, k = B[held], len(held)
    J = np.matmul(blocks, W[np.ix_(rows, rows)].reshape(k, 3, 3 * k)).reshape(3 * k, 3 * k)
    each = np.arange(k)
    J.reshape(k, 3, k, 3)[each, :, each, :] += A[held] + alpha * blocks
    released = W[np.ix_(rows, free)] @ step[free]
    right = -F[held] - np.matmul(blocks, released.reshape(k, 3, 1))[:, :, 0]
    try:
        step[rows] = np.linalg.solve(J, right.ravel())
    except np.linalg.LinAlgError:
        return None
    return step if np.all(np.isfinite(step)) else None


def newton(W, q, friction, impulse, alpha, centre, tolerance, iterations=30):
    """Solve F(r, (W + alpha I) r + q - alpha centre) = 0 from `impulse`; returns (r, reached, iterations).

    The line search halves the step until |F| falls below the largest of the last three values (not monotone: kinks of F would
    otherwise trap the iteration).
    """
    shifted = q - alpha * centre
    recent = []
    for iteration in range(iterations):
        F, A, B = alart_curnier(impulse, W @ impulse + alpha * impulse + shifted, friction)
        error = np.linalg.norm(F)
        if error <= tolerance:
            return impulse, True, iteration
        recent = [*recent[-2:], error]
        step = newton_direction(W, alpha, impulse, F, A, B)
        if step is None:
            return impulse, False, iteration
        fraction = 1.0
        while True:
            following = impulse + fraction * step
            F, _, _ = alart_curnier(following, W @ following + alpha * following + shifted, friction)
            if np.linalg.norm(F) <= (1.0 - 1e-4 * fraction) * max(recent):
                break
            fraction *= 0.5
            if fraction < 1e-4:
                return impulse, False, iteration
        impulse = following
    return impulse, False, iterations


def proximal_newton(W, q, friction, impulse, residual, tolerance, alpha=1e-2, outer=80):
    """Proximal loop: the best impulse by `residual(impulse)`, its residual and the number of Newton steps.

    W, q must be scaled so that the diagonal of W is about 1 and q about 1. alpha falls while Newton's method reaches its goal
    and grows tenfold where it does not.
    """
    centre, here = impulse, residual(impulse)
    best, best_residual, steps, size = centre, here, 0, np.linalg.norm(q)
    for _ in range(outer):
        goal = size * max(1e-14, 1e-2 * min(best_residual, 1e-2))
        following, reached, used = newton(W, q, friction, centre, alpha, centre, goal)
        there = residual(following)
        steps += used + 1
        if there < best_residual:
            best, best_residual = following, there
        if best_residual <= tolerance:
            break
        if reached or there < here:
            centre, here = following, there
        alpha = max(0.2 * alpha, 1e-9) if reached else min(10.0 * alpha, 1e2)
    return best, best_residual, steps
