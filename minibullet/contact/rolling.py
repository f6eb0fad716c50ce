"""Rolling and spinning resistance: moments that oppose the relative rotation, at most an arm times the normal impulse.

The spin about the normal has its own limit; the two rolling moments share a disc, as Coulomb's tangential impulses do.
"""

from math import sqrt

from minibullet.contact.coulomb import NOTHING
from minibullet.kernels import leaf


@leaf
def rotation_rate(axis, v, w):
    """Angular velocity of b (twist w) against a (twist v) about an axis [rad/s]."""
    return axis[0] * (w[3] - v[3]) + axis[1] * (w[4] - v[4]) + axis[2] * (w[5] - v[5])


@leaf
def inverse_inertia_along(mass_a, mass_b, axis, other):
    """Angular velocity about ``axis`` that a unit moment about another axis gives b against a, from the inverse masses of the
    two bodies (6, 6): the inverse of the angular effective mass [1/(kg m2)]."""
    value = 0.0
    for p in range(3):
        for q in range(3):
            value += axis[p] * (mass_a[3 + p, 3 + q] + mass_b[3 + p, 3 + q]) * other[q]
    return value


@leaf
def moment_within_disc(k11, k12, k22, c, limit):
    """The moment m with |m| <= limit that leaves K m = c, or slides: (K + s I) m = c with s >= 0 and |m| = limit.

    By Newton's method on 1/|m|, which is nearly straight in s, so that a few steps do and none goes too far (J. J. Moré, D. C.
    Sorensen, SIAM J. Sci. Stat. Comput. 4 (1983) 553).
    """
    if limit <= NOTHING:
        return 0.0, 0.0
    (c_1, c_2), s = c, 0.0
    while True:
        a, b = k11 + s, k22 + s
        determinant = a * b - k12 * k12
        m_1, m_2 = (b * c_1 - k12 * c_2) / determinant, (a * c_2 - k12 * c_1) / determinant
        size = sqrt(m_1 * m_1 + m_2 * m_2)
        if size <= limit:
            return m_1, m_2
        slope = (b * m_1 * m_1 - 2.0 * k12 * m_1 * m_2 + a * m_2 * m_2) / determinant
        former, s = s, s + (size / limit - 1.0) * size * size / slope
        if not s > former:  # the rest is rounding
            return m_1 * limit / size, m_2 * limit / size


@leaf
def solve_rolling(c, problem, iterate):
    """Solve rolling and spinning of contact c with all others held; its moments and the twists are updated in place."""
    a, b = problem.factors.bodies[c, 0], problem.factors.bodies[c, 1]
    v, w = iterate.twist[a], iterate.twist[b]
    mass_a, mass_b = problem.factors.inverse_mass[a], problem.factors.inverse_mass[b]
    axes, moment, normal_impulse = problem.factors.jacobian[c, 0], iterate.moment[c], iterate.impulse[c, 0]
    rolling_arm, spinning_arm = problem.rolling[c, 0], problem.rolling[c, 1]
    normal, first, second = axes[0], axes[1], axes[2]
    k00 = inverse_inertia_along(mass_a, mass_b, normal, normal)
    if k00 == 0.0:
        return
    limit = spinning_arm * normal_impulse
    change_0 = min(max(moment[0] - rotation_rate(normal, v, w) / k00, -limit), limit) - moment[0]
    k11, k12 = inverse_inertia_along(mass_a, mass_b, first, first), inverse_inertia_along(mass_a, mass_b, first, second)
    k10, k20 = inverse_inertia_along(mass_a, mass_b, first, normal), inverse_inertia_along(mass_a, mass_b, second, normal)
    k22 = inverse_inertia_along(mass_a, mass_b, second, second)
    rate_1, rate_2 = rotation_rate(first, v, w) + k10 * change_0, rotation_rate(second, v, w) + k20 * change_0
    still = k11 * moment[1] + k12 * moment[2] - rate_1, k12 * moment[1] + k22 * moment[2] - rate_2
    m_1, m_2 = moment_within_disc(k11, k12, k22, still, rolling_arm * normal_impulse)
    for i in range(3):
        change = change_0 if i == 0 else (m_1 if i == 1 else m_2) - moment[i]
        moment[i] += change
        for k in range(6):
            for d in range(3):
                v[k] -= change * mass_a[k, 3 + d] * axes[i, d]
                w[k] += change * mass_b[k, 3 + d] * axes[i, d]


@leaf
def rolling_squares(c, problem, iterate):
    """Squares of rolling and spinning of contact c: error of the natural map of their discs, |moment|/(arm m), |arm omega|.

    Moments count as impulses at their arm, rotations as velocities there, so that they can be added to those of the contact.
    """
    axes, moment, normal_impulse = problem.factors.jacobian[c, 0], iterate.moment[c], iterate.impulse[c, 0]
    v, w = iterate.twist[problem.factors.bodies[c, 0]], iterate.twist[problem.factors.bodies[c, 1]]
    mass = problem.reference_mass
    error = size_m = size_w = 0.0
    for i in range(3):
        arm = problem.rolling[c, 1] if i == 0 else problem.rolling[c, 0]
        if arm <= 0.0:
            continue
        m_1, w_1 = moment[i] / (arm * mass), arm * rotation_rate(axes[i], v, w)
        y_1, y_2 = m_1 - w_1, 0.0
        if i > 0:  # the two rolling moments share a disc
            k = 3 - i
            y_2 = moment[k] / (arm * mass) - arm * rotation_rate(axes[k], v, w)
        slope = mass * sqrt(y_1 * y_1 + y_2 * y_2)
        share = normal_impulse / slope if slope > normal_impulse else 1.0
        error += (m_1 - share * y_1) ** 2
        size_m += m_1 * m_1
        size_w += w_1 * w_1
    return error, size_m, size_w
