"""Coulomb's law at one contact: the projection on the friction cone, and the impulse that satisfies the law exactly.

A contact has the local order normal, first tangent, second tangent. With the velocity u = W r + b (W the 3x3 block of the
contact, b the velocity without its own impulse r) and the modified velocity of De Saxce u~ = u + mu |u_T| n, the law is

    K* contains u~,  u~ . r = 0,  r in K = {|r_T| <= mu r_N}         equivalently   r = P_K(r - rho u~)

K is the friction cone, K* its dual (all u with u . r >= 0 for every r in K), P_K the projection on K, rho any positive number.
In words: no pull, no approach, a normal impulse only where the bodies do not part, and a friction of at most mu r_N, which is
reached, against the velocity, where the contact slides.
Sources: G. De Saxce and Z.-Q. Feng, Math. Comput. Modelling 28 (1998); M. Jean, CMAME 177 (1999), for the block solves.
"""

from math import sqrt

from minibullet.kernels import leaf

NOTHING = 1e-100  # velocity times friction below which a load is resisted by none: the squares of its multiplier overflow [m/s]


@leaf
def project_cone(y, friction):
    """Nearest point of the friction cone K to y (3,), Euclidean norm."""
    y_n, y_1, y_2 = y
    slope = sqrt(y_1 * y_1 + y_2 * y_2)
    if slope <= friction * y_n and y_n >= 0.0:
        return y_n, y_1, y_2
    if friction * slope <= -y_n:
        return 0.0, 0.0, 0.0
    p_n = (y_n + friction * slope) / (1.0 + friction * friction)
    scale = friction * p_n / slope
    return p_n, scale * y_1, scale * y_2


@leaf
def solve_coulomb(W, b, friction, guess=-1.0):
    """Impulse (r_n, r_1, r_2) that satisfies Coulomb's law exactly at one contact: u = W r + b.

    Three states: take-off (r = 0), stick (u = 0 inside the cone), slide (u_N = 0, u_T = -s r_T with |r_T| = mu r_N). ``guess``:
    where to start looking for the multiplier s of sliding, if positive; |u_T|/(mu r_N) of the last sweep needs hardly a step.
    """
    b_n, b_1, b_2 = b
    if b_n >= 0.0:
        return 0.0, 0.0, 0.0
    # eliminate the normal row: r_n = -(b_n + W01 r_1 + W02 r_2)/W00 = -(c_n + e_1 r_1 + e_2 r_2), so that u_T = A r_T + c_T
    share = 1.0 / W[0, 0]
    e_1, e_2, f_1, f_2 = share * W[0, 1], share * W[0, 2], share * W[1, 0], share * W[2, 0]
    if friction * -b_n <= NOTHING:
        return -share * b_n, 0.0, 0.0
    a11, a12 = W[1, 1] - W[1, 0] * e_1, W[1, 2] - W[1, 0] * e_2
    a21, a22 = W[2, 1] - W[2, 0] * e_1, W[2, 2] - W[2, 0] * e_2
    c_1, c_2, c_n = b_1 - f_1 * b_n, b_2 - f_2 * b_n, share * b_n
    determinant = a11 * a22 - a12 * a21
    if determinant > 0.0:  # stick: the impulse that makes u = 0, if the cone holds it
        r_1, r_2 = (a12 * c_2 - a22 * c_1) / determinant, (a21 * c_1 - a11 * c_2) / determinant
        r_n = -(c_n + e_1 * r_1 + e_2 * r_2)
        if r_1 * r_1 + r_2 * r_2 <= friction * friction * r_n * r_n and r_n >= 0.0:
            return r_n, r_1, r_2
    # slide: u_T = A r_T + c_T = -s r_T, that is (A + s I) r_T = -c_T
    s = guess if guess > 0.0 else sqrt(c_1 * c_1 + c_2 * c_2) / (friction * -c_n) - 0.5 * (a11 + a22)
    s = max(s, 1e-12 * (W[0, 0] + W[1, 1] + W[2, 2]))  # a contact that cannot move along a tangent has a singular A
    r_n, r_1, r_2 = sliding_impulse((a11, a12, a21, a22), (c_n, c_1, c_2), (e_1, e_2), friction, s)
    if r_n < 0.0:
        return 0.0, 0.0, 0.0
    # land on the cone to the last bit, so that |r_T| <= mu r_N holds in every published impulse
    size = sqrt(r_1 * r_1 + r_2 * r_2)
    scale = friction * r_n / size if size > friction * r_n else 1.0
    return r_n, scale * r_1, scale * r_2


@leaf
def sliding_impulse(A, c, e, friction, s):
    """Impulse of a sliding contact: r_T = -(A + s I)^-1 c_T and r_N = -(c_N + e . r_T) with |r_T| = mu r_N, from a start of s.

    A scalar equation in the multiplier s >= 0: |r_T(s)| - mu r_N(s) falls from positive at s = 0, where the sticking impulse
    lies outside the cone, to negative as s grows, so a guarded Newton iteration finds it.
    """
    a11, a12, a21, a22 = A
    c_n, c_1, c_2 = c
    e_1, e_2 = e
    low, high = 0.0, 1e300
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
    return r_n, r_1, r_2
