"""Laws of contact, one a class: each takes the law that holds so far at every contact and returns it changed.

Notation: v_n = speed of approach along the normal, v_t = slip velocity in the tangent plane, both before the step; load =
normal force of the previous step (0 at a new contact); the lighter body of a pair is the one with less mass, never a fixed
one.
"""

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from minibullet.effects.body import STANDARD_GRAVITY
from minibullet.effects.contract import Effect, Need, parameter
from minibullet.errors import InputError
from minibullet.rotations import dot


def approach_speed(contacts) -> np.ndarray:
    """Speed at which the bodies come together along the normal, negative when they part [m/s], (m,)."""
    return -np.sum(contacts.velocity * contacts.normal, axis=1)


def slip_velocity(contacts) -> np.ndarray:
    """Part of the relative velocity in the tangent plane, world frame [m/s], (m, 3)."""
    return contacts.velocity + approach_speed(contacts)[:, None] * contacts.normal


def slip_squared(contacts) -> np.ndarray:
    """Square of the slip speed [m2/s2], (m,)."""
    slip = slip_velocity(contacts)
    return np.sum(slip * slip, axis=1)


def lighter(contacts, bodies) -> np.ndarray:
    """Index of the lighter body of each contact, integer (m,)."""
    return np.where(bodies.mass[contacts.body_a] < bodies.mass[contacts.body_b], contacts.body_a, contacts.body_b)


class ContactEffect(Effect):
    """A law of contact, of friction where it does not say otherwise."""

    group = "contact_tangential"
    needs = (Need.CONTACT,)


@dataclass(frozen=True)
class Friction(ContactEffect):
    """Coulomb friction of one coefficient at every contact, |F_t| <= coefficient F_n. C. A. Coulomb (1785).

    It replaces the coefficients of settings and bodies; to keep those, leave it out.
    """

    coefficient: float = parameter(0.5, unit="-", low=0.0, high=1.5)
    plain = "friction"
    replaces = True

    def __post_init__(self):
        super().__post_init__()
        if self.coefficient < 0.0:
            raise InputError(f"Friction: coefficient must not be negative, not {self.coefficient!r}")

    def contact_law(self, contacts, bodies, law):
        return law._replace(friction=np.full_like(law.friction, self.coefficient))


@dataclass(frozen=True)
class Restitution(ContactEffect):
    """Restitution of one coefficient at every contact: normal speed after/before the impact. I. Newton, Principia, scholium
    to the laws.

    It replaces the coefficients of settings and bodies; to keep those, leave it out.
    """

    coefficient: float = parameter(0.0, unit="-", low=0.0, high=1.0, most=1.0)
    plain = "restitution"
    group = "contact_normal"
    replaces = True

    def __post_init__(self):
        super().__post_init__()
        if not 0.0 <= self.coefficient <= 1.0:
            raise InputError(f"Restitution: coefficient must be between 0 and 1, not {self.coefficient!r}")

    def contact_law(self, contacts, bodies, law):
        return law._replace(restitution=np.full_like(law.restitution, self.coefficient))


@dataclass(frozen=True)
class VelocityDependentRestitution(ContactEffect):
    """Faster impacts rebound less, e = e_1 (v_n/reference_speed)^-exponent, at most 1; and no rebound below the threshold.

    e_1 is the restitution that holds without this effect. Exponent 1/4 where the impact is plastic: K. L. Johnson, Contact
    Mechanics (1985), ch. 11; 1/5 (the leading term) where it is viscous: R. Ramirez et al., Phys. Rev. E 60 (1999)
    4465.
    """

    exponent: float = parameter(0.0, unit="-", low=0.0, high=0.3, null=0.0, source="Johnson (1985): 1/4")
    threshold: float = parameter(0.0, unit="m/s", low=0.0, high=0.5, null=0.0)
    reference_speed: float = parameter(1.0, unit="m/s", given=True)
    plain = "a rebound that depends on the speed of the impact"
    group = "contact_normal"

    def contact_law(self, contacts, bodies, law):
        speed = approach_speed(contacts)
        hits = speed > 0.0
        factor = np.where(hits, speed / self.reference_speed, 1.0) ** -self.exponent
        changed = np.minimum(law.restitution * factor, 1.0)
        return law._replace(restitution=np.where(hits & (speed < self.threshold), 0.0, changed))


@dataclass(frozen=True)
class Adhesion(ContactEffect):
    """A pair of bodies bears a pull of pull_off_force weights of the lighter body before it parts, shared by its contact points.

    The constant pull-off force of a small contact: B. V. Derjaguin,
    V. M. Muller, Yu. P. Toporov, J. Colloid Interface Sci. 53 (1975).
    """

    pull_off_force: float = parameter(0.0, unit="weights", low=0.0, high=1.0, null=0.0)
    acceleration: float = parameter(STANDARD_GRAVITY, unit="m/s2", given=True)
    plain = "a pull that holds touching bodies together"
    group = "contact_normal"

    def contact_law(self, contacts, bodies, law):
        pairs = contacts.body_a.astype(np.int64) * len(bodies.mass) + contacts.body_b
        _, pair_of_contact, points = np.unique(pairs, return_inverse=True, return_counts=True)
        weight = bodies.mass[lighter(contacts, bodies)] * self.acceleration
        return law._replace(adhesion=law.adhesion + self.pull_off_force * weight / points[pair_of_contact])


@dataclass(frozen=True)
class StaticFriction(ContactEffect):
    """A contact at rest holds more than a sliding one, mu ratio. C. A. Coulomb (1785); E. Rabinowicz, Friction and Wear (1965).

    A contact is at rest while v_t^2 <= (rest_speed)^2 (load/m) r, with m and r of the lighter body: v_t below the fraction
    rest_speed of sqrt(g r) under a body's own weight. A new contact bears no load yet, so it slides unless v_t = 0.
    """

    ratio: float = parameter(1.0, unit="-", low=1.0, high=2.0, null=1.0)
    rest_speed: float = parameter(1e-3, unit="-", given=True)
    plain = "more friction at rest than in motion"

    def contact_law(self, contacts, bodies, law):
        body = lighter(contacts, bodies)
        at_rest = slip_squared(contacts) <= self.rest_speed**2 * contacts.load / bodies.mass[body] * bodies.radius[body]
        return law._replace(friction=law.friction * np.where(at_rest, self.ratio, 1.0))


@dataclass(frozen=True)
class StribeckFriction(ContactEffect):
    """Friction falls with slip speed from mu ratio to mu, mu (1 + (ratio - 1) exp(-(v_t/speed)^2)).

    R. Stribeck, Z. VDI 46 (1902); Gaussian form: B. Armstrong-Helouvry,
    P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083-1138.
    """

    ratio: float = parameter(1.0, unit="-", low=1.0, high=2.0, null=1.0)
    speed: float = parameter(0.1, unit="m/s", low=0.001, high=0.5, starts=(0.05, 0.1, 0.2, 0.4))
    plain = "friction that falls as slip begins"

    def contact_law(self, contacts, bodies, law):
        factor = 1.0 + (self.ratio - 1.0) * np.exp(-slip_squared(contacts) / self.speed**2)
        return law._replace(friction=law.friction * factor)


@dataclass(frozen=True)
class ViscousFriction(ContactEffect):
    """Friction changes linearly with slip speed, mu + slope v_t,
    never below 0. Armstrong-Helouvry et al., Automatica 30 (1994).
    """

    slope: float = parameter(0.0, unit="s/m", low=-0.5, high=1.0, null=0.0)
    plain = "friction that changes with the speed of slip"

    def contact_law(self, contacts, bodies, law):
        return law._replace(friction=np.maximum(law.friction + self.slope * np.sqrt(slip_squared(contacts)), 0.0))


@dataclass(frozen=True)
class LoadDependentFriction(ContactEffect):
    """Friction coefficient as a power of the normal force at the point, mu (load/reference_load)^exponent; a new contact has mu.

    Exponent -1/3 for one elastic round contact: F. P. Bowden and D. Tabor, The Friction and Lubrication of Solids (1950).
    The load is taken between a millionth and a million of the reference, beyond which no such power was ever
    measured.
    """

    exponent: float = parameter(0.0, unit="-", low=-0.3, high=0.3, null=0.0, source="Bowden and Tabor (1950): -1/3 to 0")
    reference_load: float = parameter(1.0, unit="N", given=True)
    plain = "friction that depends on the load"

    def contact_law(self, contacts, bodies, law):
        ratio = np.clip(contacts.load / self.reference_load, 1e-6, 1e6)
        return law._replace(friction=law.friction * np.where(contacts.load > 0.0, ratio, 1.0) ** self.exponent)


@dataclass(frozen=True)
class AnisotropicFriction(ContactEffect):
    """Friction along one horizontal direction is ratio times that
    across, mu sqrt(1 + (ratio^2 - 1) cos^2 phi), the same both ways.

    phi lies between slip and the direction (cos angle, sin angle, 0) laid into the tangent plane; without slip cos^2 phi
    counts as 1/2. An ellipse of friction forces: A. Zmitrowicz (1981); its force is taken straight
    against the slip.
    """

    ratio: float = parameter(1.0, unit="-", low=0.5, high=2.0, null=1.0)
    angle: float = parameter(0.0, unit="rad", low=0.0, high=pi, period=pi, starts=tuple(pi * quarter / 4 for quarter in range(4)))
    plain = "friction that depends on the direction"
    isotropic = False

    def contact_law(self, contacts, bodies, law):
        direction = np.array([cos(self.angle), sin(self.angle), 0.0])
        grain = direction - dot(contacts.normal, direction)[:, None] * contacts.normal
        lengths = slip_squared(contacts) * np.sum(grain * grain, axis=1)
        along = np.sum(slip_velocity(contacts) * grain, axis=1) ** 2
        share = np.where(lengths > 0.0, np.minimum(along / np.where(lengths > 0.0, lengths, 1.0), 1.0), 0.5)
        return law._replace(friction=law.friction * np.sqrt(1.0 + (self.ratio**2 - 1.0) * share))


@dataclass(frozen=True)
class RollingFriction(ContactEffect):
    """Moment against rolling of at most arm times the normal force; a solid sphere rolls down by (5/7) g arm/r a second.

    O. Reynolds, Phil. Trans. R. Soc. 166 (1876) 155-174; as a contact law: Contact Mechanics (K. L. Johnson, 1985), ch. 9.
    """

    arm: float = parameter(0.0, unit="m", low=0.0, high=0.1, null=0.0, bounds_in="radius")
    plain = "resistance to rolling"

    def contact_law(self, contacts, bodies, law):
        return law._replace(rolling_arm=law.rolling_arm + self.arm)


@dataclass(frozen=True)
class SpinningFriction(ContactEffect):
    """Moment about the normal against spinning of at most arm times the normal force.

    For a uniformly loaded round patch of radius a the arm is (2/3) mu a:
    P. Contensou (1963); K. L. Johnson, Contact Mechanics (1985).
    """

    arm: float = parameter(0.0, unit="m", low=0.0, high=0.5, null=0.0, bounds_in="radius")
    plain = "resistance to spinning on the spot"

    def contact_law(self, contacts, bodies, law):
        return law._replace(spinning_arm=law.spinning_arm + self.arm)
