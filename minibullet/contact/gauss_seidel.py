"""Nonlinear Gauss-Seidel on the contact problem: one contact after another is solved exactly, until the residual says so.

Each island of touching bodies stops by itself. Source of the method: J. J. Moreau (1988) and M. Jean (1999), nonsmooth
contact dynamics; of the residual: the natural map of the friction problem (``residual``).
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from minibullet.contact.coulomb import NOTHING, solve_coulomb
from minibullet.contact.problem import Iterate, apply_impulses, velocity_along
from minibullet.contact.residual import Squares, free_squares, relative_residual, squares_of
from minibullet.contact.rolling import solve_rolling
from minibullet.kernels import leaf

UNINTERRUPTED = 2_000_000  # contacts solved without a look at Ctrl-C: less than a second [-]


class Solution(NamedTuple):
    """Impulses that solve a contact problem, and how well."""

    impulse: np.ndarray  # contact impulses on b, contact axes [N s], (m, 3)
    moment: np.ndarray  # spinning and two rolling impulsive moments on b, contact axes [N m s], (m, 3)
    twist: np.ndarray  # twist of each body at the end of the step [m/s, rad/s], (n, 6)
    residual: float  # relative natural-map residual of the whole problem, impulses over the reference mass [-]
    iterations: int  # most sweeps that any island took
    work: int  # contacts solved: sum over islands of contacts times sweeps
    unconverged: np.ndarray  # islands (index) on which Gauss-Seidel ended above the tolerance
    outer: int = 0  # iterations of the exact solver on those islands, added up


class Progress(NamedTuple):
    """Where the sweeps over the islands stand. Flat: Numba hands a record to Python by calling Python for its class, and Ctrl-C
    in the call for one inside another crashes the interpreter."""

    island: int  # the one in work
    sweeps: int  # made on it so far
    most_sweeps: int  # of any island before it
    work: int  # contacts solved so far


@leaf
def solve_contact(c, factors, target, friction, impulse, twist):
    """Solve contact c exactly with all others held, update its impulse and the twists in place; returns the squared change of
    the impulse."""
    v, w, W = twist[factors.bodies[c, 0]], twist[factors.bodies[c, 1]], factors.block[c]
    u_n = velocity_along(c, factors, 0, v, w) - target[c]
    old_n, old_1, old_2 = impulse[c, 0], impulse[c, 1], impulse[c, 2]
    if old_n == 0.0 and u_n >= 0.0:  # open, and stays open
        return 0.0
    u_1, u_2 = velocity_along(c, factors, 1, v, w), velocity_along(c, factors, 2, v, w)
    limit = friction[c] * old_n
    b = (  # the velocity without this contact's own impulse
        u_n - W[0, 0] * old_n - W[0, 1] * old_1 - W[0, 2] * old_2,
        u_1 - W[1, 0] * old_n - W[1, 1] * old_1 - W[1, 2] * old_2,
        u_2 - W[2, 0] * old_n - W[2, 1] * old_1 - W[2, 2] * old_2,
    )
    guess = sqrt(u_1 * u_1 + u_2 * u_2) / limit if limit * W[0, 0] > NOTHING else -1.0
    new_n, new_1, new_2 = solve_coulomb(W, b, friction[c], guess)
    d_n, d_1, d_2 = new_n - old_n, new_1 - old_1, new_2 - old_2
    impulse[c, 0], impulse[c, 1], impulse[c, 2] = new_n, new_1, new_2
    by_a, by_b = factors.inverse_mass_jacobian[c, 0], factors.inverse_mass_jacobian[c, 1]
    for k in range(6):
        v[k] -= by_a[0, k] * d_n + by_a[1, k] * d_1 + by_a[2, k] * d_2
        w[k] += by_b[0, k] * d_n + by_b[1, k] * d_1 + by_b[2, k] * d_2
    return d_n * d_n + d_1 * d_1 + d_2 * d_2


@leaf
def sweep(problem, iterate, first, end):
    """Solve the contacts order[first:end] once each, in order, in place."""
    for place in range(first, end):
        c = problem.order[place]
        solve_contact(c, problem.factors, problem.target, problem.friction, iterate.impulse, iterate.twist)
        if problem.rolling[c, 0] > 0.0 or problem.rolling[c, 1] > 0.0:
            solve_rolling(c, problem, iterate)


@leaf
def sweep_islands(problem, iterate, free, residual, total, progress, iterations, tolerance):
    """Gauss-Seidel on every island, whose ``residual`` (i,) is filled in and whose Squares are added to ``total`` (4,). Returns
    the Progress: where islands are left, after ``UNINTERRUPTED`` contacts, it is to be called again, so that Ctrl-C is heard.
    free: |q|^2 of each contact (m,)."""
    island, sweeps, most_sweeps, work = progress
    pause, resists = work + UNINTERRUPTED, False
    for c in range(len(problem.rolling)):
        if problem.rolling[c, 0] > 0.0 or problem.rolling[c, 1] > 0.0:
            resists = True
    while island < len(residual):
        first, end = problem.islands[island], problem.islands[island + 1]
        scale = 0.0
        for place in range(first, end):
            scale += free[problem.order[place]]
        while True:
            if work >= pause:
                return Progress(island, sweeps, most_sweeps, work)
            squares = squares_of(problem, iterate, first, end, scale)
            residual[island] = relative_residual(squares, problem.rounding, end - first)
            solved = residual[island] <= tolerance
            # the warm start is swept at least once even if it passes: an error that stays the same at every step adds up
            if sweeps >= iterations or (solved and (sweeps > 0 or (squares.error == 0.0 and not resists))):
                break
            # as many sweeps as the last ones suggest are needed before the residual is worth its price again
            batch = (1 if solved else 2) if sweeps == 0 else (4 if sweeps < 12 else 8)
            for _ in range(min(batch, iterations - sweeps)):
                sweep(problem, iterate, first, end)
                sweeps += 1
                work += end - first
        total[0] += squares.error
        total[1] += squares.free
        total[2] += squares.impulse
        total[3] += squares.velocity
        island, sweeps, most_sweeps = island + 1, 0, max(most_sweeps, sweeps)
    return Progress(island, 0, most_sweeps, work)


def solve(problem, impulse, moment, *, iterations=50, tolerance=1e-6):
    """Solve a ContactProblem by Gauss-Seidel from a starting ``impulse`` (m, 3, contact axes).

    Stops each island at relative residual ``tolerance`` (at ``iterations`` sweeps whatever happens).
    """
    iterate = Iterate(impulse.copy(), moment.copy(), problem.free_twist.copy())
    apply_impulses(problem.factors, impulse, iterate.twist)
    residual, total, progress = np.zeros(len(problem.islands) - 1), np.zeros(4), Progress(0, 0, 0, 0)
    free = free_squares(problem)
    while progress.island < len(residual):  # between two calls Python hears Ctrl-C
        progress = sweep_islands(problem, iterate, free, residual, total, progress, iterations, tolerance)
    whole = relative_residual(Squares(*total.tolist()), problem.rounding, len(impulse))
    return Solution(*iterate, whole, progress.most_sweeps, progress.work, (residual > tolerance).nonzero()[0])
