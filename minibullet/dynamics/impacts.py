"""Impacts with restitution, each at its own moment inside the step.

Newton's law u_N+ = -e u_N- (Eq. 8 with a finite e) needs the speed at the moment of contact, not at the end of the step, or
every bounce gains or loses energy of the order of the step. The gap of a contact is a parabola in time; the earliest impact is
found, all contacts that touch then and that it can reach from body to body obey Newton's law together with Coulomb friction, and
the search goes on with the new velocities. Contacts whose rebound gravity would undo before the step ends are left to the
resting contact law, and so are those whose rebound is slower than half of the velocity that forces give the two bodies in a
step: units that lie side by side would hand such impacts on without end.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from minibullet.contact.gauss_seidel import solve_contact
from minibullet.contact.problem import DelassusFactors, normal_velocity
from minibullet.kernels import kernel, leaf
from minibullet.vectors import length

MOST = 20  # impacts of an island in one step, and one more for each of its bodies: what goes on is left to the resting law
REBOUND = 0.5  # rebound speed, over acceleration times step, below which a contact rests [-]


class ImpactContacts(NamedTuple):
    """The m contacts of a step as impacts see them."""

    factors: DelassusFactors
    gap: np.ndarray  # when the step begins [m], (m,)
    size: np.ndarray  # radius of the smaller body [m], (m,)
    restitution: np.ndarray  # normal speed after / before the impact [-], (m,)
    friction: np.ndarray  # Coulomb coefficient [-], (m,)
    order: np.ndarray  # contacts sorted by island (m,)
    islands: np.ndarray  # first place of each island in order, and the end (i + 1,)


class Flight(NamedTuple):
    """How n bodies move between impacts: at time t of the step they have moved by twist t + acceleration t^2/2 - correction."""

    twist: np.ndarray  # twist when the step begins plus the velocity jumps so far [m/s, rad/s], (n, 6)
    acceleration: np.ndarray  # constant over the step [m/s2, rad/s2], (n, 6)
    correction: np.ndarray  # impact position correction: sum of impact time times velocity jump [m, rad], (n, 6)
    since: np.ndarray  # time of the step of its last jump [s], (n,)


@leaf
def first_touch(gap, rate, acceleration, now, end):
    """Earliest time in [now, end] at which gap + rate t + acceleration t^2/2 <= 0 while closing; inf if none."""
    here, closing = gap + (rate + 0.5 * acceleration * now) * now, rate + acceleration * now
    if here <= 0.0:
        return now if closing < 0.0 else np.inf
    # the root of here + closing s + acceleration s^2/2, in the form that does not cancel
    discriminant = closing * closing - 2.0 * acceleration * here
    divisor = -closing + sqrt(max(discriminant, 0.0))
    moment = now + 2.0 * here / divisor if discriminant >= 0.0 and divisor > 0.0 else np.inf
    return moment if moment <= end else np.inf


@leaf
def path(c, contacts, flight):
    """Gap, rate and pull of contact c after the jumps so far: at time t it is open by gap + rate t + pull t^2/2."""
    gap = contacts.gap[c] - normal_velocity(c, contacts.factors, flight.correction)
    return gap, normal_velocity(c, contacts.factors, flight.twist), normal_velocity(c, contacts.factors, flight.acceleration)


@leaf
def next_touch(c, contacts, flight, time_step):
    """When contact c touches next in this step, inf if it does not, and whether it rebounds there, or when the next step begins;
    else it is left to the resting contact law."""
    gap, rate, pull = path(c, contacts, flight)
    a, b = contacts.factors.bodies[c, 0], contacts.factors.bodies[c, 1]
    touch = first_touch(gap, rate, pull, max(flight.since[a], flight.since[b]), time_step)
    left = time_step if touch == np.inf else time_step - touch
    undone = max(-pull * left, REBOUND * time_step * max(length(flight.acceleration[a]), length(flight.acceleration[b])))
    return touch, -contacts.restitution[c] * (rate + pull * min(touch, time_step)) > undone


@kernel
def room(contacts, flight, time_step):
    """How far the last velocity of the step may close each contact [m], (m,): by its gap. One that stays open and rebounds in
    the next step may be closed by the mean velocity: it would be caught right above what it is to strike."""
    result = np.empty(len(contacts.gap))
    for c in range(len(result)):
        gap, rate, _ = path(c, contacts, flight)
        touch, rebounds = next_touch(c, contacts, flight, time_step)
        result[c] = 2.0 * gap + time_step * rate if rebounds and touch == np.inf else gap
    return result


@kernel
def struck_together(trigger, linked, contacts, flight, now, moving):
    """Which bodies an impact at contact ``trigger`` reaches, from body to moving body (n,), and the touching contacts on its way,
    in the order of ``linked``, the contacts of its island (k,)."""
    bodies, reached, struck = contacts.factors.bodies, np.zeros(len(moving), np.bool_), np.zeros(len(linked), np.bool_)
    reached[bodies[trigger, 0]], reached[bodies[trigger, 1]] = moving[bodies[trigger, 0]], moving[bodies[trigger, 1]]
    grown = True
    while grown:
        grown = False
        for place, c in enumerate(linked):
            a, b = bodies[c, 0], bodies[c, 1]
            if (reached[a] or reached[b]) and not struck[place]:
                gap, rate, pull = path(c, contacts, flight)
                if c == trigger or gap + now * (rate + 0.5 * now * pull) <= 1e-9 * contacts.size[c]:
                    struck[place] = grown = True
                    reached[a], reached[b] = reached[a] or moving[a], reached[b] or moving[b]
    return reached, linked[struck]


@leaf
def solve_impact(struck, contacts, target, impulse, twist):
    """Coulomb's law with Newton's rebound ``target`` (m,) at the struck contacts together; impulse and twist in place."""
    for _ in range(200):
        change, total = 0.0, 0.0
        for c in struck:
            change += solve_contact(c, contacts.factors, target, contacts.friction, impulse, twist)
            total += impulse[c, 0] ** 2
        if change <= 1e-24 * total:
            return


@kernel
def resolve(contacts, flight, moving, time_step):
    """All impacts of a step, island by island, the Flight brought up to date: sum of the impulses (m, 3) [N s, contact axes]."""
    bodies, count = contacts.factors.bodies, len(contacts.gap)
    total, impulse, target, moments = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count), np.empty(count)
    before, after = np.zeros_like(flight.twist), np.zeros_like(flight.twist)
    for island in range(len(contacts.islands) - 1):
        linked, now, jumped = contacts.order[contacts.islands[island] : contacts.islands[island + 1]], 0.0, moving
        for _ in range(MOST + len(np.unique(bodies[linked]))):
            for c in linked:  # the next rebound of a contact changes where one of its bodies jumps, and nowhere else
                if jumped[bodies[c, 0]] or jumped[bodies[c, 1]]:
                    touch, rebounds = next_touch(c, contacts, flight, time_step)
                    moments[c] = touch if rebounds else np.inf
            ahead = np.where(moments[linked] >= now, moments[linked], np.inf)  # what touched before, and was left, stays so
            now, trigger = ahead.min(), linked[ahead.argmin()]
            if now == np.inf:
                break
            jumped, struck = struck_together(trigger, linked, contacts, flight, now, moving)
            for c in struck:
                for body in bodies[c]:
                    before[body] = after[body] = flight.twist[body] + now * flight.acceleration[body]
                target[c] = max(-contacts.restitution[c] * normal_velocity(c, contacts.factors, before), 0.0)
                impulse[c] = 0.0
            solve_impact(struck, contacts, target, impulse, after)
            for c in struck:
                total[c] += impulse[c]
            for body in np.flatnonzero(jumped):
                flight.since[body] = now
                flight.twist[body] += after[body] - before[body]
                flight.correction[body] += now * (after[body] - before[body])
    return total


def impact_impulses(contacts, moving, twist, free_twist, time_step):
    """The impulses of the impacts of a step (m, 3), the velocity jump that they give each body and their impact position
    correction (n, 6), zeros without restitution, and the ``room`` left.

    A body jumps when it is struck, not when the step begins: at the end it lies behind where the later velocity alone would
    have brought it, by impact time times velocity jump. This is the position correction.
    """
    if not np.count_nonzero(contacts.restitution):
        return 0.0, 0.0, 0.0, contacts.gap
    flight = Flight(twist.copy(), (free_twist - twist) / time_step, np.zeros_like(twist), np.zeros(len(twist)))
    impulse = resolve(contacts, flight, moving, time_step)
    return impulse, flight.twist - twist, flight.correction, room(contacts, flight, time_step)
