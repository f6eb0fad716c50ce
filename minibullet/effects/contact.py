"""Laws of contact, one a class: each takes the law that holds so far at every contact and returns it changed.

Notation: v_n = speed of approach along the normal, v_t = slip velocity in the tangent plane, both where a new contact touches in
the step, else as it begins; load = normal force of the previous step (0 at a new contact); the lighter body of a pair is the one
with less mass, never a fixed one.
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
    return -(contacts.velocity * contacts.normal).sum(axis=1)


def slip_velocity(contacts) -> np.ndarray:
    """Part of the relative velocity in the tangent plane, world frame [m/s], (m, 3)."""
    return contacts.velocity + approach_speed(contacts)[:, None] * contacts.normal


def slip_squared(contacts) -> np.ndarray:
    """Square of the slip speed [m2/s2], (m,)."""
    slip = slip_velocity(contacts)
    return (slip * slip).sum(axis=1)


def lighter(contacts, bodies) -> np.ndarray:
    """Index of the lighter body of each contact, integer (m,)."""
    return np.where(bodies.mass[contacts.body_a] < bodies.mass[contacts.body_b], contacts.body_a, contacts.body_b)


class ContactEffect(Effect):
    """A law of contact, of friction where it does not say otherwise."""

    group = "contact_tangential"
    needs = (Need.CONTACT,)


@dataclass(frozen=True)
class Friction(ContactEffect):
    """Coulomb friction of one coefficient at every contact. C. A. Coulomb (1785).

    It replaces the coefficients of settings and bodies; to keep those, leave it out.
    """

    coefficient: float = parameter(
        0.5,
        unit="-",
        low=0.0,
        high=1.5,
        symbol="mu",
        about="tangential over normal force",
        typical=(
            (0.04, "PTFE on steel: Marks' Standard Handbook for Mechanical Engineers, section 3.2"),
            (0.6, "concrete on concrete, smooth: EN 1992-1-1:2004, 6.2.5"),
            (0.7, "the same, rough"),
        ),
    )
    plain = "friction"
    formula = "|F_t| <= mu F_n"
    looks_like = (
        "What slides stops too late or too early, by a factor that is the same at all speeds and weights; on a slope it "
        "starts at another angle."
    )
    confused_with = ("bottom_slope", "viscous_friction", "stribeck_friction", "load_dependent_friction")
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

    coefficient: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=1.0,
        most=1.0,
        symbol="e",
        about="normal speed after over before the impact",
        typical=(
            (0.74, "tennis ball on a hard floor: from 2.54 m to 1.35 to 1.47 m, Rules of Tennis"),
            (0.9, "table tennis ball on steel: from 0.305 m to 0.24 to 0.26 m, ITTF"),
        ),
    )
    plain = "restitution"
    formula = "v_after = e v_n"
    symbols = {"v_after": "speed of separation along the normal [m/s]"}
    looks_like = "Every rebound is too high or too low by the same factor e^2, at all speeds of impact."
    confused_with = ("velocity_dependent_restitution", "ground_cushion")
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
    """Faster impacts rebound less, at most as fast as they came; and no rebound below the threshold.

    e_1 is the restitution that holds without this effect. Exponent 1/4 where the impact is plastic: K. L. Johnson, Contact
    Mechanics (1985), ch. 11. Of viscoelastic spheres 1 - e grows as v_n^(1/5), to leading order: R. Ramirez et al., Phys. Rev.
    E 60 (1999) 4465-4472; near v_1 that is the exponent (1 - e_1)/(5 e_1).
    """

    exponent: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=0.3,
        null=0.0,
        source="Johnson (1985): 1/4",
        symbol="k",
        about="how steeply restitution falls with speed",
        typical=((0.25, "plastic impact: Johnson (1985)"), (0.02, "viscoelastic ball, e_1 = 0.9: Ramirez et al. (1999)")),
    )
    threshold: float = parameter(
        0.0, unit="m/s", low=0.0, high=0.5, null=0.0, about="speed of impact below which nothing rebounds"
    )
    reference_speed: float = parameter(1.0, unit="m/s", given=True, symbol="v_1", about="speed of impact at which e_1 holds")
    plain = "a rebound that depends on the speed of the impact"
    formula = "e = e_1 (v_n/v_1)^-k"
    symbols = {"e": "restitution at this speed of impact", "e_1": "restitution without this effect"}
    looks_like = (
        "High drops rebound too little and low ones too much, though one coefficient fits the middle; the last small "
        "bounces are missing."
    )
    confused_with = ("ground_cushion",)
    group = "contact_normal"

    def contact_law(self, contacts, bodies, law):
        speed = approach_speed(contacts)
        hits = speed > 0.0
        factor = np.where(hits, speed / self.reference_speed, 1.0) ** -self.exponent
        changed = np.minimum(law.restitution * factor, 1.0)
        return law._replace(restitution=np.where(hits & (speed < self.threshold), 0.0, changed))


@dataclass(frozen=True)
class Adhesion(ContactEffect):
    """A pair of bodies bears a pull before it parts, shared by its contact points.

    The constant pull-off force of a small contact: B. V. Derjaguin,
    V. M. Muller, Yu. P. Toporov, J. Colloid Interface Sci. 53 (1975).
    """

    pull_off_force: float = parameter(
        0.0, unit="weights", low=0.0, high=1.0, null=0.0, symbol="c", about="largest pull, in weights of the lighter body"
    )
    acceleration: float = parameter(STANDARD_GRAVITY, unit="m/s2", given=True, symbol="g", about="acceleration of gravity")
    plain = "a pull that holds touching bodies together"
    formula = "F_n >= -c m g"
    looks_like = "A body stays where it should have lifted off or rebounded, and all below some speed of impact do so."
    confused_with = ("velocity_dependent_restitution", "restitution")
    group = "contact_normal"

    def contact_law(self, contacts, bodies, law):
        pairs = contacts.body_a.astype(np.int64) * len(bodies.mass) + contacts.body_b
        _, pair_of_contact, points = np.unique(pairs, return_inverse=True, return_counts=True)
        weight = bodies.mass[lighter(contacts, bodies)] * self.acceleration
        return law._replace(adhesion=law.adhesion + self.pull_off_force * weight / points[pair_of_contact])


@dataclass(frozen=True)
class StaticFriction(ContactEffect):
    """A contact at rest holds more than a sliding one. C. A. Coulomb (1785); E. Rabinowicz, Friction and Wear of Materials
    (1965).

    A contact is at rest while v_t^2 <= (rest_speed)^2 (load/m) r, with m and r of the lighter body: v_t below the fraction
    rest_speed of sqrt(g r) under a body's own weight. A new contact bears no load yet, so it slides unless v_t = 0.
    """

    ratio: float = parameter(
        1.0,
        unit="-",
        low=1.0,
        high=2.0,
        null=1.0,
        source="Marks' Standard Handbook for Mechanical Engineers, section 3.2",
        about="friction at rest over friction in motion",
        typical=((1.3, "oak on oak along the grain, 0.62 over 0.48"), (1.9, "hard steel, 0.78 over 0.42")),
    )
    rest_speed: float = parameter(1e-3, unit="-", given=True, about="share of sqrt(g r) below which a contact counts as at rest")
    plain = "more friction at rest than in motion"
    formula = "mu_rest = ratio mu"
    symbols = {"mu_rest": "friction coefficient at rest"}
    looks_like = "On a slope it holds to a steeper angle than the way of sliding foretells, and then goes off with a jerk."
    confused_with = ("stribeck_friction",)

    def contact_law(self, contacts, bodies, law):
        body = lighter(contacts, bodies)
        at_rest = slip_squared(contacts) <= self.rest_speed**2 * contacts.load / bodies.mass[body] * bodies.radius[body]
        return law._replace(friction=law.friction * np.where(at_rest, self.ratio, 1.0))


@dataclass(frozen=True)
class StribeckFriction(ContactEffect):
    """Friction falls with slip speed, from ratio times its value to that value.

    R. Stribeck, Z. VDI 46 (1902); Gaussian form: B. Armstrong-Helouvry,
    P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083-1138.
    """

    ratio: float = parameter(
        1.0,
        unit="-",
        low=1.0,
        high=2.0,
        null=1.0,
        about="friction as slip begins over friction at speed",
        typical=((1.3, "oak on oak along the grain, as for static_friction"),),
    )
    speed: float = parameter(
        0.1, unit="m/s", low=0.001, high=0.5, starts=(0.05, 0.1, 0.2, 0.4), about="slip speed within which friction falls"
    )
    plain = "friction that falls as slip begins"
    formula = "mu_v = mu (1 + (ratio - 1) exp(-(v_t/speed)^2))"
    symbols = {"mu_v": "friction coefficient at this slip speed"}
    looks_like = "The last part of a slide is shorter than one coefficient foretells: it brakes hardest just before it stops."
    confused_with = ("viscous_friction",)

    def contact_law(self, contacts, bodies, law):
        factor = 1.0 + (self.ratio - 1.0) * np.exp(-slip_squared(contacts) / self.speed**2)
        return law._replace(friction=law.friction * factor)


@dataclass(frozen=True)
class ViscousFriction(ContactEffect):
    """Friction changes linearly with slip speed, never below 0. Armstrong-Helouvry et al., Automatica 30 (1994)."""

    slope: float = parameter(0.0, unit="s/m", low=-0.5, high=1.0, null=0.0, about="change of the coefficient with slip speed")
    plain = "friction that changes with the speed of slip"
    formula = "mu_v = mu + slope v_t"
    symbols = {"mu_v": "friction coefficient at this slip speed"}
    looks_like = "Fast slides stop too early and slow ones too late, or the reverse, where one coefficient fits the middle."
    confused_with = ("load_dependent_friction", "linear_drag")

    def contact_law(self, contacts, bodies, law):
        return law._replace(friction=np.maximum(law.friction + self.slope * np.sqrt(slip_squared(contacts)), 0.0))


@dataclass(frozen=True)
class LoadDependentFriction(ContactEffect):
    """Friction coefficient as a power of the normal force at the point; a new contact has mu.

    Exponent -1/3 for one elastic round contact: F. P. Bowden and D. Tabor, The Friction and Lubrication of Solids (1950).
    The load is taken between a millionth and a million of the reference, beyond which no such power was ever
    measured.
    """

    exponent: float = parameter(
        0.0,
        unit="-",
        low=-0.3,
        high=0.3,
        null=0.0,
        source="Bowden and Tabor (1950): -1/3 to 0",
        symbol="k",
        about="power of the normal force",
        typical=((-0.33, "one elastic round contact"),),
    )
    reference_load: float = parameter(1.0, unit="N", given=True, symbol="load_1", about="normal force at which mu holds")
    plain = "friction that depends on the load"
    formula = "mu_load = mu (load/load_1)^k"
    symbols = {"mu_load": "friction coefficient under this load"}
    looks_like = "Heavy bodies slide farther than light ones of the same surface, or less far."
    needs = (Need.CONTACT, Need.UNLIKE_LOADS)
    confused_with = ("mass_offset",)

    def contact_law(self, contacts, bodies, law):
        ratio = np.clip(contacts.load / self.reference_load, 1e-6, 1e6)
        return law._replace(friction=law.friction * np.where(contacts.load > 0.0, ratio, 1.0) ** self.exponent)


@dataclass(frozen=True)
class AnisotropicFriction(ContactEffect):
    """Friction along one horizontal direction is another one than across, the same both ways.

    phi lies between slip and the direction (cos angle, sin angle, 0) laid into the tangent plane; without slip cos^2 phi
    counts as 1/2. An ellipse of friction forces: A. Zmitrowicz (1981); its force is taken straight
    against the slip.
    """

    ratio: float = parameter(
        1.0,
        unit="-",
        low=0.5,
        high=2.0,
        null=1.0,
        source="Marks' Standard Handbook for Mechanical Engineers, section 3.2",
        about="friction along the direction over friction across",
        typical=((1.5, "oak on oak, 0.48 along the grain, 0.32 across"),),
    )
    angle: float = parameter(
        0.0,
        unit="rad",
        low=0.0,
        high=pi,
        period=pi,
        starts=tuple(pi * quarter / 4 for quarter in range(4)),
        about="of the direction from the x axis",
    )
    plain = "friction that depends on the direction"
    formula = "mu_phi = mu sqrt(1 + (ratio^2 - 1) cos^2 phi)"
    symbols = {"mu_phi": "friction coefficient in this direction of slip", "phi": "between slip and the direction at angle"}
    looks_like = "Slides in one heading are longer than in another, the same both ways along it; slides askew bend."
    confused_with = ("bottom_slope",)
    isotropic = False

    def contact_law(self, contacts, bodies, law):
        direction = np.array([cos(self.angle), sin(self.angle), 0.0])
        grain = direction - dot(contacts.normal, direction)[:, None] * contacts.normal
        lengths = slip_squared(contacts) * (grain * grain).sum(axis=1)
        along = (slip_velocity(contacts) * grain).sum(axis=1) ** 2
        share = np.where(lengths > 0.0, np.minimum(along / np.where(lengths > 0.0, lengths, 1.0), 1.0), 0.5)
        return law._replace(friction=law.friction * np.sqrt(1.0 + (self.ratio**2 - 1.0) * share))


@dataclass(frozen=True)
class RollingFriction(ContactEffect):
    """Moment against rolling; a solid sphere that rolls is slowed by (5/7) g arm/r.

    O. Reynolds, Phil. Trans. R. Soc. 166 (1876) 155-174; as a contact law: Contact Mechanics (K. L. Johnson, 1985), ch. 9.
    """

    arm: float = parameter(
        0.0,
        unit="m",
        low=0.0,
        high=0.1,
        null=0.0,
        bounds_in="radius",
        about="lever arm of the normal force",
        typical=((0.0004, "billiard ball on cloth, slowed by 0.01 g: D. Alciatore, billiards.colostate.edu"),),
    )
    plain = "resistance to rolling"
    formula = "|M_roll| <= arm F_n"
    symbols = {"M_roll": "moment about the tangents [N m]"}
    looks_like = "A ball that should roll on slows down evenly and stops; boxes and cubes show nothing of it but in tipping."
    confused_with = ("friction", "bottom_slope", "linear_drag")

    def contact_law(self, contacts, bodies, law):
        return law._replace(rolling_arm=law.rolling_arm + self.arm)


@dataclass(frozen=True)
class SpinningFriction(ContactEffect):
    """Moment about the normal against spinning on the spot.

    For a uniformly loaded round patch of radius a the arm is (2/3) mu a:
    P. Contensou (1963); K. L. Johnson, Contact Mechanics (1985).
    """

    arm: float = parameter(
        0.0,
        unit="m",
        low=0.0,
        high=0.5,
        null=0.0,
        bounds_in="radius",
        about="lever arm of the normal force",
        typical=((0.0003, "billiard ball on cloth, slowed by 10 rad/s2: D. Alciatore, billiards.colostate.edu"),),
    )
    plain = "resistance to spinning on the spot"
    formula = "|M_n| <= arm F_n"
    symbols = {"M_n": "moment about the normal [N m]"}
    looks_like = "A body that spins on the spot slows down evenly and stops; its path hardly changes."
    confused_with = ("spin_decay", "rolling_friction")

    def contact_law(self, contacts, bodies, law):
        return law._replace(spinning_arm=law.spinning_arm + self.arm)
