"""Impacts with restitution, each at its own moment inside the step.

Newton's law u_N+ = -e u_N- (Eq. 8 with a finite e) needs the speed at the moment of contact, not at the end of the step, or
every bounce gains or loses energy of the order of the step. With the geometry of the step's beginning, the gap of a contact
is a parabola in time; the earliest impact is found, all contacts that touch at that moment are solved together with Coulomb
friction, and the search goes on with the new velocities. Contacts whose rebound gravity would undo before the step ends are
left to the resting contact law, and so are those whose rebound is slower than half of what pulls the two bodies makes of them
in a step: units that lie side by side would hand such blows on without end. Touching bodies struck together share the blow
as Newton's law with all touching contacts at once has it.
"""

from math import sqrt

import numpy as np

from minibullet.contact.gauss_seidel import visit
from minibullet.contact.problem import normal_velocity
from minibullet.kernels import kernel, leaf
from minibullet.vectors import length

REBOUND = 0.5  # rebound speed, over acceleration times step, below which a contact rests [-]


@leaf
def first_touch(gap, rate, acceleration, now, end):
    """Earliest time in [now, end] at which gap + rate t + acceleration t^2/2 <= 0 while closing; inf if none."""
    here, closing = gap + (rate + 0.5 * acceleration * now) * now, rate + acceleration * now
    if here <= 0.0:
        return now if closing < 0.0 else np.inf
    # the root of here + closing s + acceleration s^2/2, in the form that does not cancel
    discriminant = closing * closing - 2.0 * acceleration * here
    if discriminant < 0.0:
        return np.inf
    divisor = -closing + sqrt(discriminant)
    if divisor <= 0.0:
        return np.inf
    moment = now + 2.0 * here / divisor
    return moment if moment <= end else np.inf


@leaf
def pulled(c, bodies, acceleration):
    """The larger of what pulls at the two bodies of contact c, acceleration of their centres [m/s2]."""
    most = 0.0
    for side in range(2):
        a = acceleration[bodies[c, side]]
        most = max(most, length(a))
    return most


@kernel
def linked(trigger, bodies, touching, moving):
    """The touching contacts that a blow at contact ``trigger`` can reach from body to moving body, in order, (k,)."""
    reached = np.zeros(len(moving), dtype=np.bool_)
    struck = np.zeros(len(bodies), dtype=np.bool_)
    reached[bodies[trigger, 0]], reached[bodies[trigger, 1]] = moving[bodies[trigger, 0]], moving[bodies[trigger, 1]]
    grown = True
    while grown:
        grown = False
        for c in range(len(bodies)):
            a, b = bodies[c, 0], bodies[c, 1]
            if touching[c] and not struck[c] and (reached[a] or reached[b]):
                struck[c] = grown = True
                reached[a], reached[b] = reached[a] or moving[a], reached[b] or moving[b]
    return np.flatnonzero(struck)


@kernel
def resolve(bodies, rows, gap, size, moving, restitution, friction, twist, acceleration, lag, time_step, most):
    """All impacts of a step. ``twist`` (n, 6) at its beginning and ``lag`` (n, 6), the sum of impact time times velocity
    change, are brought up to date in place; returns the impulses (m, 3) [N s, contact axes] and how many impacts there were.

    A body's place at time t is x + twist t + acceleration t^2/2 - lag.
    """
    count = len(bodies)
    impulse = np.zeros((count, 3))
    target, part = np.zeros(count), np.zeros((count, 3))
    now, impacts = 0.0, 0
    while impacts < most:
        moment, trigger = np.inf, -1
        for c in range(count):
            if restitution[c] <= 0.0:
                continue
            pull = normal_velocity(c, bodies, rows, acceleration)
            rate = normal_velocity(c, bodies, rows, twist)
            touch = first_touch(gap[c] - normal_velocity(c, bodies, rows, lag), rate, pull, now, time_step)
            if touch < moment:
                undone = max(-pull * (time_step - touch), REBOUND * time_step * pulled(c, bodies, acceleration))
                if -restitution[c] * (rate + pull * touch) > undone:
                    moment, trigger = touch, c
        if trigger < 0:
            break
        now = moment
        before = twist + now * acceleration
        after = before.copy()
        touching = np.zeros(count, dtype=np.bool_)
        for c in range(count):
            here = (
                gap[c]
                - normal_velocity(c, bodies, rows, lag)
                + now * (normal_velocity(c, bodies, rows, twist) + 0.5 * now * normal_velocity(c, bodies, rows, acceleration))
            )
            touching[c] = c == trigger or here <= 1e-9 * size[c]
        struck = linked(trigger, bodies, touching, moving)
        for c in struck:
            target[c] = max(-restitution[c] * normal_velocity(c, bodies, rows, before), 0.0)
            part[c] = 0.0
        for _ in range(200):
            change, total = 0.0, 0.0
            for c in struck:
                change += visit(c, bodies, rows, target, friction, part, after)
                total += part[c, 0] ** 2
            if change <= 1e-24 * total:
                break
        for c in struck:
            impulse[c] += part[c]
        for n in range(len(twist)):
            for k in range(6):
                step = after[n, k] - before[n, k]
                twist[n, k] += step
                lag[n, k] += now * step
        impacts += 1
    return impulse, impacts
