"""How well impulses satisfy the law: the natural-map residual of the friction problem, which judges every solver.

Coulomb's law with Signorini's condition holds where r = P_K(r - u~), with De Saxce's u~ = u + mu |u_T| n (``coulomb``). What is
left, |r - P_K(r - u~)|, is divided by the largest of |q|, |r|, |u|; impulses are measured in units of the reference mass, so
that the residual does not depend on the unit of mass. Source: V. Acary, M. Bremond, O. Huber (2018).
"""

from math import sqrt
from typing import NamedTuple

from minibullet.contact.coulomb import project_cone
from minibullet.contact.problem import contact_velocity, velocity_beyond_target
from minibullet.contact.rolling import rolling_squares
from minibullet.kernels import leaf
from minibullet.rotations import dot


class Squares(NamedTuple):
    """Sums over contacts that make a residual [m2/s2]."""

    error: float  # of the natural map, |r - P_K(r - u~)|^2
    free: float  # |q|^2, velocity without contact impulses, the target taken off
    impulse: float  # |r|^2, r over the reference mass
    velocity: float  # |u|^2


@leaf
def natural_map_error(r, u, friction, rounding=0.0):
    """|r - P_K(r - u~)|^2 of one contact, impulse r over the reference mass, velocity u; a slip below ``rounding`` is none."""
    r_n, r_1, r_2 = r
    u_n, u_1, u_2 = u
    modified = u_n + friction * max(sqrt(u_1 * u_1 + u_2 * u_2) - rounding, 0.0)
    p_n, p_1, p_2 = project_cone((r_n - modified, r_1 - u_1, r_2 - u_2), friction)
    return (r_n - p_n) ** 2 + (r_1 - p_1) ** 2 + (r_2 - p_2) ** 2


@leaf
def squares_of(problem, iterate, first, end, free):
    """The Squares of the contacts order[first:end]; rolling and spinning count where they are resisted. free: their |q|^2."""
    error = size_r = size_u = 0.0
    for place in range(first, end):
        c = problem.order[place]
        u_n, u_1, u_2 = contact_velocity(c, problem.factors, iterate.twist)
        u_n -= problem.target[c]
        mass, r = problem.reference_mass, iterate.impulse[c]
        p_n, p_1, p_2 = r[0] / mass, r[1] / mass, r[2] / mass
        error += natural_map_error((p_n, p_1, p_2), (u_n, u_1, u_2), problem.friction[c], problem.rounding)
        size_r += p_n * p_n + p_1 * p_1 + p_2 * p_2
        size_u += u_n * u_n + u_1 * u_1 + u_2 * u_2
        if problem.rolling[c, 0] > 0.0 or problem.rolling[c, 1] > 0.0:
            rolling = rolling_squares(c, problem, iterate)
            error, size_r, size_u = error + rolling[0], size_r + rolling[1], size_u + rolling[2]
    return Squares(error, free, size_r, size_u)


@leaf
def relative_residual(squares, rounding, contacts):
    """The relative natural-map residual E / max(|q|, |r|, |u|) of so many contacts; 0 where E is rounding of velocities."""
    if not squares.error > rounding * rounding * contacts:
        return 0.0
    return sqrt(squares.error / max(squares.free, squares.impulse, squares.velocity))


def free_squares(problem):
    """|q|^2 of each contact, q the relative velocity without contact impulses less the target [m2/s2], (m,)."""
    q = velocity_beyond_target(problem, problem.free_twist)
    return dot(q, q)


def residual_of(problem, iterate):
    """The relative residual of the whole problem, measured on the Iterate that is given."""
    contacts = len(problem.target)
    squares = squares_of(problem, iterate, 0, contacts, float(free_squares(problem).sum()))
    return relative_residual(squares, problem.rounding, contacts)
