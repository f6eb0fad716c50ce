"""Each law of contact against its formula, on contacts made for it. Formulas are met to rounding (1e-13 relative)."""

import numpy as np
import pytest

from minibullet import effects
from minibullet.bodies import Bodies, ContactLaw, Contacts
from minibullet.effects.samples import sample_bodies, sample_contacts, with_fixed_body
from minibullet.errors import InputError

UP = (0.0, 0.0, 1.0)


def two_bodies(masses=(np.inf, 2.0), radius=0.1):
    n = len(masses)
    ones = np.ones(n)
    return Bodies(
        np.zeros((n, 3)),
        np.tile([1.0, 0, 0, 0], (n, 1)),
        np.zeros((n, 6)),
        np.array(masses),
        np.ones((n, 3)),
        ones,
        ones,
        radius * ones,
    )


def touching(velocities, loads=None, pairs=None, normal=UP):
    """Contacts with these relative velocities, of body 1 on body 0 where no pairs are given."""
    m = len(velocities)
    pairs = np.array(pairs if pairs is not None else [(0, 1)] * m)
    loads = np.full(m, 20.0) if loads is None else np.array(loads, float)
    return Contacts(
        pairs[:, 0],
        pairs[:, 1],
        np.zeros((m, 3)),
        np.tile(np.array(normal, float), (m, 1)),
        np.zeros(m),
        np.array(velocities, float),
        loads,
    )


def law_of(effect, contacts, bodies=None, friction=0.5, restitution=0.4):
    m = len(contacts.gap)
    start = ContactLaw(np.full(m, friction), np.full(m, restitution), np.zeros(m), np.zeros(m), np.zeros(m))
    return effects.contact_law([effect], contacts, bodies or two_bodies(), start)


def test_overrides_replace_the_coefficients():
    contacts = touching([(1, 0, 0), (0, 0, -1)])
    assert law_of(effects.Friction(0.7), contacts).friction.tolist() == [0.7, 0.7]
    assert law_of(effects.Restitution(0.9), contacts).restitution.tolist() == [0.9, 0.9]
    for bad in (lambda: effects.Friction(-0.1), lambda: effects.Restitution(1.1), lambda: effects.Friction(np.nan)):
        with pytest.raises(InputError, match="coefficient must"):
            bad()


def test_restitution_falls_with_the_power_of_speed():
    """e = e1 v^-1/4: 16 times the speed, half the restitution; capped at 1; tangential motion and parting do not count."""
    law = effects.VelocityDependentRestitution(exponent=0.25)
    found = law_of(law, touching([(9, 0, -1), (0, 0, -16), (0, 0, -1e-4), (0, 0, 2)])).restitution
    assert np.allclose(found, [0.4, 0.2, 1.0, 0.4], rtol=1e-13)


def test_no_bounce_below_the_threshold():
    found = law_of(effects.VelocityDependentRestitution(threshold=0.1), touching([(0, 0, -0.099), (0, 0, -0.101)])).restitution
    assert found.tolist() == [0.0, 0.4]


def test_adhesion_is_a_share_of_the_lighter_bodys_weight():
    """0.5 weights of 2 kg over four points, of 2 kg under 5 kg at one point."""
    contacts = touching([(0, 0, 0)] * 5, pairs=[(0, 1)] * 4 + [(1, 2)])
    found = law_of(effects.Adhesion(0.5), contacts, two_bodies((np.inf, 2.0, 5.0))).adhesion
    assert np.allclose(found, [0.5 * 2 * 9.81 / 4] * 4 + [0.5 * 2 * 9.81], rtol=1e-14)


def test_static_friction_holds_only_at_rest():
    """At rest up to 1e-3 sqrt(load r/m) = 1e-3 m/s here; a new contact (no load) slides unless it does not move at all."""
    contacts = touching([(0, 0, 0), (0.99e-3, 0, -5), (1.01e-3, 0, 0), (1e-9, 0, 0), (0, 0, 0)], loads=[20, 20, 20, 0, 0])
    found = law_of(effects.StaticFriction(1.5), contacts).friction
    assert np.allclose(found, [0.75, 0.75, 0.5, 0.5, 0.75], rtol=1e-14)


def test_stribeck_friction_falls_from_static_to_sliding():
    found = law_of(effects.StribeckFriction(1.4, speed=0.1), touching([(0, 0, -3), (0.06, 0.08, 0), (9, 0, 0)])).friction
    assert np.allclose(found, 0.5 * (1 + 0.4 * np.array([1, np.exp(-1), 0])), rtol=1e-13)


def test_viscous_friction_is_linear_in_slip_and_never_negative():
    contacts = touching([(0, 0, -3), (0.6, 0.8, 0), (3, 0, 0)])
    assert np.allclose(law_of(effects.ViscousFriction(0.2), contacts).friction, [0.5, 0.7, 1.1], rtol=1e-13)
    assert np.allclose(law_of(effects.ViscousFriction(-0.2), contacts).friction, [0.5, 0.3, 0.0], atol=1e-13)


def test_load_dependent_friction_is_a_power_of_the_load():
    found = law_of(effects.LoadDependentFriction(-0.25), touching([(1, 0, 0)] * 3, loads=[1, 16, 0])).friction
    assert np.allclose(found, [0.5, 0.25, 0.5], rtol=1e-13)


def test_anisotropic_friction_is_the_same_both_ways():
    """Grain along 30 degrees: ratio along it, 1 across it, sqrt((ratio2 + 1)/2) at 45 degrees to it; also on a slope."""
    angle, ratio = np.pi / 6, 1.6
    along, across = np.array([np.cos(angle), np.sin(angle), 0]), np.array([-np.sin(angle), np.cos(angle), 0])
    expected = 0.5 * np.array([ratio, ratio, 1.0, np.sqrt((ratio**2 + 1) / 2)])
    contacts = touching([along, -2 * along, 0.1 * across, along + across])
    found = law_of(effects.AnisotropicFriction(ratio, angle), contacts).friction
    assert np.allclose(found, expected, rtol=1e-13)
    slope = touching([(0.8, 0, -0.6), (0, 1, 0)], normal=(0.6, 0, 0.8))
    assert np.allclose(law_of(effects.AnisotropicFriction(ratio, 0.0), slope).friction, [0.5 * ratio, 0.5], rtol=1e-13)


def test_arms_add_up():
    contacts = touching([(0, 0, 0)])
    start = ContactLaw(*(np.zeros(1) for _ in range(5)))
    model = [effects.RollingFriction(0.002), effects.RollingFriction(0.001), effects.SpinningFriction(0.004)]
    law = effects.contact_law(model, contacts, two_bodies(), start)
    assert law.rolling_arm[0] == pytest.approx(0.003) and law.spinning_arm[0] == 0.004


def test_impossible_laws_are_refused_by_effect_field_and_contact():
    """Shipped laws cannot get there; a user's law can."""

    class Slippery(effects.Effect):
        def contact_law(self, contacts, bodies, law):
            return law._replace(friction=law.friction - 1.0)

    with pytest.raises(InputError, match=r"Slippery: friction of contact 0 \(bodies 0 and 1\) is -0.5; it must be finite"):
        law_of(Slippery(), touching([(0, 0, 0)]))


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0), (2, 0, 3, 1)])
def test_a_stated_coefficient_is_changed_by_the_others_in_any_order(order):
    """mu = 0.4 + 0.1 v and e = 0.6 v^-0.2, at most 1: what states a coefficient does not wipe out what changes one."""
    laws = [
        effects.Friction(0.4),
        effects.ViscousFriction(0.1),
        effects.Restitution(0.6),
        effects.VelocityDependentRestitution(exponent=0.2),
    ]
    contacts, start = sample_contacts()
    law = effects.contact_law(effects.compose([laws[k] for k in order]), contacts, with_fixed_body(sample_bodies()), start)
    speed = -np.sum(contacts.velocity * contacts.normal, axis=1)
    slip = np.linalg.norm(contacts.velocity + speed[:, None] * contacts.normal, axis=1)
    hits = speed > 0
    assert np.allclose(law.friction, 0.4 + 0.1 * slip, rtol=1e-12) and hits.any()
    assert np.allclose(law.restitution[hits], np.minimum(0.6 * speed[hits] ** -0.2, 1.0), rtol=1e-12)
