"""Nonlinear Gauss-Seidel on the contact problem: one contact after another is solved exactly, until the residual says so.

Each island of touching bodies stops by itself. Source of the method: J. J. Moreau (1988) and M. Jean (1999), nonsmooth
contact dynamics; of the residual: the natural map of the friction problem (``cone.py``).
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from minibullet.contact.coulomb import natural_map_error, solve_block
from minibullet.contact.exact import STEP_EFFORT, VAIN_EFFORT, solve_rows
from minibullet.contact.problem import ANSWER_A, ANSWER_B, BLOCK, apply_impulses, block_rows, velocity_along
from minibullet.kernels import kernel, leaf

BREATH = 2_000_000  # contacts visited without a look at Ctrl-C: less than a second [-]


class Solution(NamedTuple):
    """Impulses that solve a contact problem, and how well."""

    impulse: np.ndarray  # contact impulses on b, contact axes [N s], (m, 3)
    moment: np.ndarray  # spinning and two rolling impulsive moments on b, contact axes [N m s], (m, 3)
    twist: np.ndarray  # twist of each body at the end of the step [m/s, rad/s], (n, 6)
    residual: float  # relative natural-map residual of the whole problem, impulses over the reference mass [-]
    iterations: int  # most sweeps that any island took
    work: int  # contacts visited: sum over islands of contacts times sweeps
    stalled: np.ndarray  # islands (index) on which Gauss-Seidel ended above the tolerance
    outer: int = 0  # iterations of the exact solver on those islands, added up


@leaf
def visit(c, bodies, rows, target, friction, impulse, twist):
    """Solve contact c exactly with all others held, update its impulse and the twists; returns the squared change of the
    impulse."""
    r, v, w = rows[c], twist[bodies[c, 0]], twist[bodies[c, 1]]
    u_n = velocity_along(r, 0, v, w) - target[c]
    old_n, old_1, old_2 = impulse[c, 0], impulse[c, 1], impulse[c, 2]
    if old_n == 0.0 and u_n >= 0.0:
        return 0.0
    u_1, u_2 = velocity_along(r, 1, v, w), velocity_along(r, 2, v, w)
    limit = friction[c] * old_n
    new_n, new_1, new_2 = solve_block(
        r[63], r[64], r[65], r[66], r[67], r[68], r[69], r[70], r[71],
        u_n - r[63] * old_n - r[64] * old_1 - r[65] * old_2,
        u_1 - r[66] * old_n - r[67] * old_1 - r[68] * old_2,
        u_2 - r[69] * old_n - r[70] * old_1 - r[71] * old_2,
        friction[c],
        sqrt(u_1 * u_1 + u_2 * u_2) / limit if limit > 0.0 else -1.0,
    )  # fmt: skip
    d_n, d_1, d_2 = new_n - old_n, new_1 - old_1, new_2 - old_2
    impulse[c, 0], impulse[c, 1], impulse[c, 2] = new_n, new_1, new_2
    for k in range(6):
        v[k] -= r[ANSWER_A + k] * d_n + r[ANSWER_A + 6 + k] * d_1 + r[ANSWER_A + 12 + k] * d_2
        w[k] += r[ANSWER_B + k] * d_n + r[ANSWER_B + 6 + k] * d_1 + r[ANSWER_B + 12 + k] * d_2
    return d_n * d_n + d_1 * d_1 + d_2 * d_2


@leaf
def turning_answer(mass_a, mass_b, row, i, j):
    """Angular velocity about axis i of a contact that a unit moment about axis j gives b against a [1/(kg m2)]."""
    value = 0.0
    for p in range(3):
        for q in range(3):
            value += row[3 * i + p] * (mass_a[3 + p, 3 + q] + mass_b[3 + p, 3 + q]) * row[3 * j + q]
    return value


@leaf
def within_disc(k11, k12, k22, c_1, c_2, limit):
    """The moment m with |m| <= limit that leaves K m = c, or slides: (K + s I) m = c with s >= 0 and |m| = limit, by
    bisection."""
    determinant = k11 * k22 - k12 * k12
    m_1, m_2 = (k22 * c_1 - k12 * c_2) / determinant, (k11 * c_2 - k12 * c_1) / determinant
    if m_1 * m_1 + m_2 * m_2 <= limit * limit:
        return m_1, m_2
    if limit <= 0.0:
        return 0.0, 0.0
    low, high = 0.0, sqrt(c_1 * c_1 + c_2 * c_2) / limit
    for _ in range(60):
        s = 0.5 * (low + high)
        determinant = (k11 + s) * (k22 + s) - k12 * k12
        m_1, m_2 = ((k22 + s) * c_1 - k12 * c_2) / determinant, ((k11 + s) * c_2 - k12 * c_1) / determinant
        if m_1 * m_1 + m_2 * m_2 > limit * limit:
            low = s
        else:
            high = s
    return m_1, m_2


@leaf
def visit_rolling(c, bodies, rows, rolling, inverse_mass, impulse, moment, twist):
    """Rolling and spinning resistance of contact c: moments on b that oppose the relative rotation, at most arm times the
    normal impulse; the spin about the normal has its own limit, the two rolling moments share a disc."""
    a, b = bodies[c, 0], bodies[c, 1]
    mass_a, mass_b, row, v, w = inverse_mass[a], inverse_mass[b], rows[c], twist[a], twist[b]
    k00 = turning_answer(mass_a, mass_b, row, 0, 0)
    if k00 == 0.0:
        return
    limit = rolling[c, 1] * impulse[c, 0]
    change_0 = min(max(moment[c, 0] - turning_rate(row, 0, v, w) / k00, -limit), limit) - moment[c, 0]
    k11, k12 = turning_answer(mass_a, mass_b, row, 1, 1), turning_answer(mass_a, mass_b, row, 1, 2)
    k10, k20 = turning_answer(mass_a, mass_b, row, 1, 0), turning_answer(mass_a, mass_b, row, 2, 0)
    k22 = turning_answer(mass_a, mass_b, row, 2, 2)
    left_1, left_2 = turning_rate(row, 1, v, w) + k10 * change_0, turning_rate(row, 2, v, w) + k20 * change_0
    m_1, m_2 = within_disc(k11, k12, k22, k11 * moment[c, 1] + k12 * moment[c, 2] - left_1,
                           k12 * moment[c, 1] + k22 * moment[c, 2] - left_2, rolling[c, 0] * impulse[c, 0])  # fmt: skip
    for i in range(3):
        change = change_0 if i == 0 else (m_1 if i == 1 else m_2) - moment[c, i]
        moment[c, i] += change
        for k in range(6):
            for d in range(3):
                v[k] -= change * mass_a[k, 3 + d] * row[3 * i + d]
                w[k] += change * mass_b[k, 3 + d] * row[3 * i + d]


@leaf
def turning_rate(row, i, v, w):
    """Angular velocity of b (twist w) against a (twist v) about axis i of a contact [rad/s]."""
    return row[3 * i] * (w[3] - v[3]) + row[3 * i + 1] * (w[4] - v[4]) + row[3 * i + 2] * (w[5] - v[5])


@leaf
def turning_error(row, rolling_arm, spinning_arm, r_n, moment, v, w, reference_mass):
    """Squares of one contact's rolling and spinning: error of the natural map of their discs, |moment|/(arm m), |arm omega|.

    Moments count as impulses at their arm, rotations as velocities there, so that they can be added to those of the contact.
    """
    error = size_m = size_w = 0.0
    for i in range(3):
        arm = spinning_arm if i == 0 else rolling_arm
        if arm <= 0.0:
            continue
        m_1, w_1 = moment[i] / (arm * reference_mass), arm * turning_rate(row, i, v, w)
        y_1, y_2 = m_1 - w_1, 0.0
        if i > 0:  # the two rolling moments share a disc
            k = 3 - i
            y_2 = moment[k] / (arm * reference_mass) - arm * turning_rate(row, k, v, w)
        slope = sqrt(y_1 * y_1 + y_2 * y_2)
        slope = reference_mass * sqrt(y_1 * y_1 + y_2 * y_2)
        share = r_n / slope if slope > r_n else 1.0
        error += (m_1 - share * y_1) ** 2
        size_m += m_1 * m_1
        size_w += w_1 * w_1
    return error, size_m, size_w


@kernel
def natural_map(first, end, order, bodies, rows, target, friction, rolling, impulse, moment, twist, reference_mass):
    """Squares that make the residual of the contacts order[first:end]: error of the natural map, |r|/m, |u|; rolling and spinning
    count where they are resisted."""
    error = size_r = size_u = 0.0
    for place in range(first, end):
        c = order[place]
        v, w = twist[bodies[c, 0]], twist[bodies[c, 1]]
        u_n = velocity_along(rows[c], 0, v, w) - target[c]
        u_1, u_2 = velocity_along(rows[c], 1, v, w), velocity_along(rows[c], 2, v, w)
        p_n, p_1, p_2 = impulse[c, 0] / reference_mass, impulse[c, 1] / reference_mass, impulse[c, 2] / reference_mass
        error += natural_map_error(p_n, p_1, p_2, u_n, u_1, u_2, friction[c], 1.0)
        size_r += p_n * p_n + p_1 * p_1 + p_2 * p_2
        size_u += u_n * u_n + u_1 * u_1 + u_2 * u_2
        if rolling[c, 0] > 0.0 or rolling[c, 1] > 0.0:
            turning = turning_error(rows[c], rolling[c, 0], rolling[c, 1], impulse[c, 0], moment[c], v, w, reference_mass)
            error, size_r, size_u = error + turning[0], size_r + turning[1], size_u + turning[2]
    return error, size_r, size_u


@leaf
def sweep_islands(
    bodies,
    rows,
    target,
    friction,
    rolling,
    inverse_mass,
    order,
    islands,
    reference_mass,
    rounding,
    free_size,
    impulse,
    moment,
    twist,
    iterations,
    tolerance,
    stop,
    residual,
    progress,
    squares,
):
    """Gauss-Seidel on every island, whose ``residual`` (i,) is filled in; returns whether all is done: else, after
    ``BREATH`` contacts, it is to be called again, so that Ctrl-C is heard.

    progress (4,): island, its sweeps so far, most sweeps, contacts visited; squares (4,) of the whole problem: error, |q|^2,
    |r|^2 / reference_mass^2, |u|^2; all zero at first, in place.
    """
    resists, rest = False, progress[3] + BREATH
    for c in range(len(bodies)):
        if rolling[c, 0] > 0.0 or rolling[c, 1] > 0.0:
            resists = True
    while progress[0] < len(islands) - 1:
        island = progress[0]
        first, end = islands[island], islands[island + 1]
        scale = 0.0  # |q|^2 of the island
        for place in range(first, end):
            scale += free_size[order[place]]
        sweep = progress[1]
        while True:
            if progress[3] >= rest:
                progress[1] = sweep
                return False
            error, size_r, size_u = natural_map(
                first, end, order, bodies, rows, target, friction, rolling, impulse, moment, twist, reference_mass
            )
            largest = max(scale, size_r, size_u)
            residual[island] = sqrt(error / largest) if error > rounding * rounding * (end - first) else 0.0
            # the warm start is swept at least once even if it passes: an error that stays the same at every step adds up
            if sweep >= iterations or (stop and residual[island] <= tolerance and (sweep > 0 or (error == 0.0 and not resists))):
                break
            # as many sweeps as the last ones suggest are needed before the residual is worth its price again
            batch = min(4 if sweep < 12 else 8, iterations - sweep)
            if sweep == 0:
                batch = min(1 if stop and residual[island] <= tolerance else 2, iterations)
            for _ in range(batch):
                for place in range(first, end):
                    c = order[place]
                    visit(c, bodies, rows, target, friction, impulse, twist)
                    if resists and (rolling[c, 0] > 0.0 or rolling[c, 1] > 0.0):
                        visit_rolling(c, bodies, rows, rolling, inverse_mass, impulse, moment, twist)
                sweep += 1
                progress[3] += end - first
        progress[0], progress[1], progress[2] = island + 1, 0, max(progress[2], sweep)
        squares[0], squares[1], squares[2], squares[3] = (
            squares[0] + error, squares[1] + scale, squares[2] + size_r, squares[3] + size_u
        )  # fmt: skip
    return True


def solve(problem, impulse, moment, *, iterations=50, tolerance=1e-6, stop=True):
    """Solve a ContactProblem by Gauss-Seidel from a starting ``impulse`` (m, 3, contact axes).

    Stops each island at relative residual ``tolerance`` (at ``iterations`` sweeps whatever happens); ``stop=False`` always
    makes all sweeps.
    """
    impulse, moment, twist = impulse.copy(), moment.copy(), problem.free_twist.copy()
    size = free_size(problem)
    apply_impulses(problem.bodies, problem.rows, impulse, twist)
    residual, progress, squares = np.zeros(len(problem.islands) - 1), np.zeros(4, dtype=np.int64), np.zeros(4)
    while not sweep_islands(
        problem.bodies,
        problem.rows,
        problem.target,
        problem.friction,
        problem.rolling,
        problem.inverse_mass,
        problem.order,
        problem.islands,
        problem.reference_mass,
        problem.rounding,
        size,
        impulse,
        moment,
        twist,
        iterations,
        tolerance,
        stop,
        residual,
        progress,
        squares,
    ):
        pass  # between two calls Python hears Ctrl-C
    _, _, most, work = progress.tolist()
    (stalled,) = (residual > tolerance).nonzero()
    return Solution(impulse, moment, twist, relative_residual(problem, *squares.tolist()), most, work, stalled)


def free_size(problem):
    """|q|^2 of each contact, q the relative velocity without contact impulses less the target (m,)."""
    return squared_speed(problem.bodies, problem.rows, problem.target, problem.free_twist)


@kernel
def squared_speed(bodies, rows, target, twist):
    """|u - target n|^2 of each contact, u the relative velocity at these twists [m2/s2], (m,)."""
    result = np.empty(len(bodies))
    for c in range(len(bodies)):
        v, w = twist[bodies[c, 0]], twist[bodies[c, 1]]
        u_n = velocity_along(rows[c], 0, v, w) - target[c]
        u_1, u_2 = velocity_along(rows[c], 1, v, w), velocity_along(rows[c], 2, v, w)
        result[c] = u_n * u_n + u_1 * u_1 + u_2 * u_2
    return result


def relative_residual(problem, error, size_q, size_r, size_u):
    """The relative natural-map residual of the whole problem from its squares: E / max(|q|, |r|/m_ref, |u|); 0 where E is
    rounding."""
    if not error > problem.rounding**2 * len(problem.bodies):
        return 0.0
    return sqrt(error / max(size_q, size_r, size_u))


def certify(problem, impulse, moment, twist, size, iterations, work, stalled):
    """The Solution with the residual of the whole problem, measured on what is given; size: |q|^2 of each contact (m,)."""
    error, size_r, size_u = natural_map(
        0,
        len(problem.bodies),
        problem.order,
        problem.bodies,
        problem.rows,
        problem.target,
        problem.friction,
        problem.rolling,
        impulse,
        moment,
        twist,
        problem.reference_mass,
    )
    residual = relative_residual(problem, error, float(size.sum()), size_r, size_u)
    return Solution(impulse, moment, twist, residual, int(iterations), int(work), stalled)


def separate(bodies, rows, gap, tolerance, count, share, sweeps):
    """Displacement of ``count`` bodies (n, 6) that takes away ``share`` of every overlap deeper than its tolerance (m,) without
    giving any velocity.

    A frictionless problem of its own, solved by Gauss-Seidel until a sweep moves nothing by more than a hundredth of the
    tolerance: overlaps open, gaps stay gaps. What the contact problem leaves of overlap comes from its linearisation and its
    tolerance; a velocity that undid it would be energy from nowhere.
    """
    shift = np.zeros((count, 6))
    push_apart(bodies, rows, gap, tolerance, share, sweeps, np.zeros(len(bodies)), shift)
    return shift


@leaf
def push_apart(bodies, rows, gap, tolerance, share, sweeps, push, shift):
    """The sweeps of ``separate``; push (m,), how hard each contact pushes, and shift (n, 6) are brought up to date in place."""
    for _ in range(sweeps):
        still = True
        for c in range(len(bodies)):
            r, v, w = rows[c], shift[bodies[c, 0]], shift[bodies[c, 1]]
            if r[BLOCK] == 0.0:
                continue  # neither of the two may be moved
            wanted = -share * (gap[c] + tolerance[c]) if gap[c] < -tolerance[c] else -max(gap[c], 0.0)
            step = max(push[c] + (wanted - velocity_along(r, 0, v, w)) / r[BLOCK], 0.0) - push[c]
            if step == 0.0:
                continue
            push[c] += step
            for k in range(6):
                v[k] -= step * r[ANSWER_A + k]
                w[k] += step * r[ANSWER_B + k]
            still = still and abs(step) * r[BLOCK] <= 0.01 * tolerance[c]
        if still:
            return


def undo_overlap(problem, gap, size, time_step, share=0.3, sweeps=10):
    """Extra mean twist (n, 6) for this step's move that takes away a share of every overlap beyond 1e-9 of the contact's size
    (m,)."""
    tolerance = 1e-9 * size
    if not np.count_nonzero(gap < -tolerance):
        return 0.0
    return separate(problem.bodies, problem.rows, gap, tolerance, len(problem.free_twist), share, sweeps) / time_step


def escalate(problem, solution, tolerance, most=2000):
    """Solve the stalled islands by the exact solver (``exact.solve_rows``) from where Gauss-Seidel ended, those of at most
    ``most`` contacts."""
    impulse, outer = solution.impulse.copy(), 0
    for island in solution.stalled:
        contacts = problem.order[problem.islands[island] : problem.islands[island + 1]]
        if problem.rolling[contacts].any() or len(contacts) > most:
            continue  # rolling moments are solved by Gauss-Seidel alone
        chosen, law, start = block_rows(problem, contacts), problem.friction[contacts], impulse[contacts].reshape(-1)
        # what a light body does is a small difference of impulses that heavy ones hand it: their rounding over its mass
        light = problem.inverse_mass[np.unique(problem.bodies[contacts]), 0, 0]
        light = light[light > 0.0]
        effort = VAIN_EFFORT if np.finfo(float).eps * light.max() > 0.5 * tolerance * light.min() else STEP_EFFORT
        found, _, used, _ = solve_rows(*chosen, law, start, 0.5 * tolerance, problem.reference_mass, effort, sweeps=0)
        impulse[contacts], outer = found.reshape(-1, 3), outer + used
    twist = solution.twist.copy()
    apply_impulses(problem.bodies, problem.rows, impulse - solution.impulse, twist)
    solved = certify(
        problem, impulse, solution.moment, twist, free_size(problem), solution.iterations, solution.work, solution.stalled
    )
    return solved._replace(outer=outer)
