"""Coulomb's law at one contact: projection on the friction cone and the exact local solve.

A contact has the local order normal, first tangent, second tangent. With the velocity u = W r + b (W the 3x3 block of the
contact, b the velocity without its own impulse r) and the modified velocity of De Saxce u~ = u + mu |u_T| n, the law is

    K* contains u~,  u~ . r = 0,  r in K = {|r_T| <= mu r_N}         equivalently   r = P_K(r - rho u~)

Sources: G. De Saxce and Z.-Q. Feng, Math. Comput. Modelling 28 (1998); M. Jean, CMAME 177 (1999), for the block solves.
"""

from math import sqrt

from numba import njit


@njit(cache=True, inline="never")
def project_cone(y_n, y_1, y_2, friction):
    """Nearest point of the friction cone K to (y_n, y_1, y_2), Euclidean norm."""
    slope = sqrt(y_1 * y_1 + y_2 * y_2)
    if slope <= friction * y_n:
        return y_n, y_1, y_2
    if friction * slope <= -y_n:
        return 0.0, 0.0, 0.0
    p_n = (y_n + friction * slope) / (1.0 + friction * friction)
    scale = friction * p_n / slope
    return p_n, scale * y_1, scale * y_2


@njit(cache=True)
def solve_block(w00, w01, w02, w10, w11, w12, w20, w21, w22, b_n, b_1, b_2, friction):
    """Impulse (r_n, r_1, r_2) that satisfies Coulomb's law exactly at one contact: u = W r + b.

    Three states: take-off (r = 0), stick (u = 0 inside the cone), slide (u_N = 0, r_T = -s u_T with |r_T| = mu r_N). Sliding is a
    scalar equation in the multiplier s >= 0: with the normal row eliminated, r_T(s) = -(A + s I)^-1 c, and |r_T(s)| - mu r_N(s)
    falls from positive at s = 0 (the sticking impulse lies outside the cone) to negative as s grows, so a guarded Newton
    iteration finds it.
    """
    if b_n >= 0.0:
        return 0.0, 0.0, 0.0
    # eliminate the normal row: r_n = -(b_n + w01 r_1 + w02 r_2)/w00
    a11, a12 = w11 - w10 * w01 / w00, w12 - w10 * w02 / w00
    a21, a22 = w21 - w20 * w01 / w00, w22 - w20 * w02 / w00
    c_1, c_2 = b_1 - w10 * b_n / w00, b_2 - w20 * b_n / w00
    if friction <= 0.0:
        return -b_n / w00, 0.0, 0.0
    determinant = a11 * a22 - a12 * a21
    if determinant > 0.0:
        r_1, r_2 = (a12 * c_2 - a22 * c_1) / determinant, (a21 * c_1 - a11 * c_2) / determinant
        r_n = -(b_n + w01 * r_1 + w02 * r_2) / w00
        if r_1 * r_1 + r_2 * r_2 <= friction * friction * r_n * r_n and r_n >= 0.0:
            return r_n, r_1, r_2
    low, high = 0.0, 1e300
    s = max(sqrt(c_1 * c_1 + c_2 * c_2) * w00 / (friction * -b_n) - 0.5 * (a11 + a22), 0.0)
    r_n = r_1 = r_2 = 0.0
    for _ in range(60):
        p, q = a11 + s, a22 + s
        determinant = p * q - a12 * a21
        r_1, r_2 = (a12 * c_2 - q * c_1) / determinant, (a21 * c_1 - p * c_2) / determinant
        r_n = -(b_n + w01 * r_1 + w02 * r_2) / w00
        size = sqrt(r_1 * r_1 + r_2 * r_2)
        excess = size - friction * r_n
        if abs(excess) <= 1e-15 * (size + friction * abs(r_n)):
            break
        if excess > 0.0:
            low = s
        else:
            high = s
        # derivative of r_T(s) is -(A + sI)^-1 r_T
        d_1, d_2 = (a12 * r_2 - q * r_1) / determinant, (a21 * r_1 - p * r_2) / determinant
        slope = (r_1 * d_1 + r_2 * d_2) / size + friction * (w01 * d_1 + w02 * d_2) / w00 if size > 0.0 else -1.0
        following = s - excess / slope
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


@njit(cache=True)
def natural_map_error(r_n, r_1, r_2, u_n, u_1, u_2, friction, rho):
    """Squared |r - P_K(r - rho u~)|^2 of one contact, with De Saxce's u~ = u + mu |u_T| n."""
    modified = u_n + friction * sqrt(u_1 * u_1 + u_2 * u_2)
    p_n, p_1, p_2 = project_cone(r_n - rho * modified, r_1 - rho * u_1, r_2 - rho * u_2, friction)
    return (r_n - p_n) ** 2 + (r_1 - p_1) ** 2 + (r_2 - p_2) ** 2
