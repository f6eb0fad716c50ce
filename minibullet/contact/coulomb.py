"""Coulomb's law in kernels: at one contact the projection and the exact local solve, then loops over all contacts.

A contact has the local order normal, first tangent, second tangent. With the velocity u = W r + b (W the 3x3 block of the
contact, b the velocity without its own impulse r) and the modified velocity of De Saxce u~ = u + mu |u_T| n, the law is

    K* contains u~,  u~ . r = 0,  r in K = {|r_T| <= mu r_N}         equivalently   r = P_K(r - rho u~)

The loops take the block rows of W: row i has the blocks block[start[i]:start[i + 1]] (b, 3, 3) in the columns `column` (b,).

Sources: G. De Saxce and Z.-Q. Feng, Math. Comput. Modelling 28 (1998); M. Jean, CMAME 177 (1999), for the block solves;
P. Alart and A. Curnier, CMAME 92 (1991), for the law as equations.
"""

from math import sqrt

import numpy as np

from minibullet.kernels import kernel, leaf

MACHINE_EPSILON = 2.220446049250313e-16


@leaf
def project_cone(y_n, y_1, y_2, friction):
    """Nearest point of the friction cone K to (y_n, y_1, y_2), Euclidean norm."""
    slope = sqrt(y_1 * y_1 + y_2 * y_2)
    if slope <= friction * y_n and y_n >= 0.0:
        return y_n, y_1, y_2
    if friction * slope <= -y_n:
        return 0.0, 0.0, 0.0
    p_n = (y_n + friction * slope) / (1.0 + friction * friction)
    scale = friction * p_n / slope
    return p_n, scale * y_1, scale * y_2


@leaf
def solve_block(w00, w01, w02, w10, w11, w12, w20, w21, w22, b_n, b_1, b_2, friction, guess=-1.0):
    """Impulse (r_n, r_1, r_2) that satisfies Coulomb's law exactly at one contact: u = W r + b.

    Three states: take-off (r = 0), stick (u = 0 inside the cone), slide (u_N = 0, r_T = -s u_T with |r_T| = mu r_N). Sliding is a
    scalar equation in the multiplier s >= 0: with the normal row eliminated, r_T(s) = -(A + s I)^-1 c, and |r_T(s)| - mu r_N(s)
    falls from positive at s = 0 (the sticking impulse lies outside the cone) to negative as s grows, so a guarded Newton
    iteration finds it. ``guess``: where to start it, if positive; |u_T|/(mu r_N) of the last visit needs hardly a step.
    """
    if b_n >= 0.0:
        return 0.0, 0.0, 0.0
    # eliminate the normal row: r_n = -(b_n + w01 r_1 + w02 r_2)/w00
    share = 1.0 / w00
    e_1, e_2, f_1, f_2 = share * w01, share * w02, share * w10, share * w20
    if friction <= 0.0:
        return -share * b_n, 0.0, 0.0
    a11, a12, a21, a22 = w11 - w10 * e_1, w12 - w10 * e_2, w21 - w20 * e_1, w22 - w20 * e_2
    c_1, c_2, c_n = b_1 - f_1 * b_n, b_2 - f_2 * b_n, share * b_n
    determinant = a11 * a22 - a12 * a21
    if determinant > 0.0:
        r_1, r_2 = (a12 * c_2 - a22 * c_1) / determinant, (a21 * c_1 - a11 * c_2) / determinant
        r_n = -(c_n + e_1 * r_1 + e_2 * r_2)
        if r_1 * r_1 + r_2 * r_2 <= friction * friction * r_n * r_n and r_n >= 0.0:
            return r_n, r_1, r_2
    low, high = 0.0, 1e300
    s = guess if guess > 0.0 else sqrt(c_1 * c_1 + c_2 * c_2) / (friction * -c_n) - 0.5 * (a11 + a22)
    s = max(s, 1e-12 * (w00 + w11 + w22))  # a contact that cannot move along a tangent has a singular A
    r_n = r_1 = r_2 = 0.0
    for _ in range(60):
        p, q = a11 + s, a22 + s
        determinant = p * q - a12 * a21
        if determinant <= 0.0:
            break
        inverse = 1.0 / determinant
        r_1, r_2 = (a12 * c_2 - q * c_1) * inverse, (a21 * c_1 - p * c_2) * inverse
        r_n = -(c_n + e_1 * r_1 + e_2 * r_2)
        size = sqrt(r_1 * r_1 + r_2 * r_2)
        excess = size - friction * r_n
        if abs(excess) <= 1e-15 * (size + friction * abs(r_n)):
            break
        if excess > 0.0:
            low = s
        else:
            high = s
        # derivative of r_T(s) is -(A + sI)^-1 r_T
        d_1, d_2 = (a12 * r_2 - q * r_1) * inverse, (a21 * r_1 - p * r_2) * inverse
        slope = (r_1 * d_1 + r_2 * d_2) / size + friction * (e_1 * d_1 + e_2 * d_2) if size > 0.0 else -1.0
        following = s - excess / slope if slope < 0.0 else -1.0
        if not (low < following < high):
            following = 0.5 * (low + high) if high < 1e300 else 2.0 * s + (a11 + a22)
        if following == s:
            break
        s = following
    if r_n < 0.0:
        return 0.0, 0.0, 0.0
    # land on the cone to the last bit, so that |r_T| <= mu r_N holds in every published impulse
    size = sqrt(r_1 * r_1 + r_2 * r_2)
    scale = friction * r_n / size if size > friction * r_n else 1.0
    return r_n, scale * r_1, scale * r_2


@leaf
def natural_map_error(r_n, r_1, r_2, u_n, u_1, u_2, friction, rho):
    """Squared |r - P_K(r - rho u~)|^2 of one contact, with De Saxce's u~ = u + mu |u_T| n."""
    modified = u_n + friction * sqrt(u_1 * u_1 + u_2 * u_2)
    p_n, p_1, p_2 = project_cone(r_n - rho * modified, r_1 - rho * u_1, r_2 - rho * u_2, friction)
    return (r_n - p_n) ** 2 + (r_1 - p_1) ** 2 + (r_2 - p_2) ** 2


@kernel
def velocity(start, column, block, q, impulse):
    """u = W r + q, all (3m,)."""
    u = q.copy()
    for i in range(len(start) - 1):
        for k in range(start[i], start[i + 1]):
            j = 3 * column[k]
            for a in range(3):
                u[3 * i + a] += block[k, a, 0] * impulse[j] + block[k, a, 1] * impulse[j + 1] + block[k, a, 2] * impulse[j + 2]
    return u


@kernel
def natural_map_residual(start, column, block, q, friction, impulse, reference_mass):
    """E / max(|q|, |r|, |u|) with E = |r - P_K(r - u~)| and r in units of the reference mass; E itself if all of them vanish."""
    u = velocity(start, column, block, q, impulse)
    r = impulse / reference_mass
    error = 0.0
    for i in range(0, len(q), 3):
        error += natural_map_error(r[i], r[i + 1], r[i + 2], u[i], u[i + 1], u[i + 2], friction[i // 3], 1.0)
    size = sqrt(max((q * q).sum(), (r * r).sum(), (u * u).sum()))
    return sqrt(error) / size if size > MACHINE_EPSILON else sqrt(error)


@kernel
def into_cone(friction, impulse):
    """A copy of impulse (3m,) with every contact projected on its friction cone."""
    inside = np.empty_like(impulse)
    for i in range(0, len(impulse), 3):
        inside[i], inside[i + 1], inside[i + 2] = project_cone(impulse[i], impulse[i + 1], impulse[i + 2], friction[i // 3])
    return inside


@kernel
def gauss_seidel(start, column, block, q, friction, impulse, sweeps):
    """Solve every contact exactly with the others held, in order, `sweeps` times; changes impulse (3m,) in place."""
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
def newton_system(start, column, block, impulse, F, A, B):
    """(A + B W) d = -F without the contacts that take off (B = 0, where d = -r).

    Returns number (m,), the place of each contact in the system or -1, the matrix as compressed rows (pointer, index, value), and
    the right side.
    """
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
