"""check_effect passes everything shipped and names the rule that a wrong effect breaks."""

from dataclasses import dataclass, field, fields, replace

import numpy as np
import pytest

from minibullet import effects
from minibullet.effects import Effect, EffectError, check_effect, parameter, samples
from minibullet.errors import InputError

NAMES = {
    "gravity",
    "linear_drag",
    "stokes_drag",
    "sphere_drag",
    "quadratic_drag",
    "drag_crisis",
    "orientation_drag",
    "buoyancy",
    "added_mass",
    "uniform_flow",
    "magnus",
    "spin_decay",
    "history_force",
    "wall_drag",
    "tube_drag",
    "ground_cushion",
    "tilted_gravity",
    "restitution",
    "velocity_dependent_restitution",
    "adhesion",
    "friction",
    "static_friction",
    "stribeck_friction",
    "viscous_friction",
    "load_dependent_friction",
    "anisotropic_friction",
    "rolling_friction",
    "spinning_friction",
}
MODIFIERS = {"orientation_drag", "uniform_flow", "wall_drag", "tube_drag"}
DRAGS = (effects.QuadraticDrag(0.47, 1000.0), effects.LinearDrag(0.3))


def shipped(name):
    """A value of a shipped effect, modifiers with drags to modify."""
    kind = effects.library()[name]
    return kind(through=DRAGS) if name in MODIFIERS else kind()


def test_library_has_the_agreed_names():
    assert set(effects.library()) == NAMES


@pytest.mark.parametrize("name", sorted(NAMES))
def test_shipped_effects_keep_every_rule_and_draw_no_note(name):
    report = check_effect(shipped(name))
    assert report.effect == name and report.notes == ()
    assert check_effect(effects.library()[name]()).rules == report.rules


@pytest.mark.parametrize("name", sorted(NAMES))
def test_shipped_effects_are_absent_when_made_without_arguments(name):
    """Default = null, but for those that have no null value, and gravity."""
    numbers = effects.parameters(effects.library()[name])
    assert all(number.default == number.null for number in numbers.values() if number.null is not None and name != "gravity")


@pytest.mark.parametrize("name", sorted(NAMES))
def test_change_of_units_by_powers_of_two_changes_no_bit(name):
    """Metre, kilogram, second scaled by powers of two round nothing, so every bit is kept: no hidden SI constant."""
    units = (2.0**6, 2.0**-9, 2.0**4)
    for effect in (shipped(name), active(shipped(name))):
        bodies, (contacts, law) = samples.sample_bodies(), samples.sample_contacts()
        everything = samples.with_fixed_body(bodies)
        other = samples.in_units(units, effect)
        straight = samples.in_units_columns(units, effect.forces(bodies, 1.7), samples.WRENCH_DIMENSIONS)
        assert np.array_equal(other.forces(samples.in_units(units, bodies), 1.7 * units[2]), straight)
        straight = samples.in_units(units, effect.contact_law(contacts, everything, law))
        changed = other.contact_law(*(samples.in_units(units, record) for record in (contacts, everything, law)))
        assert all(np.array_equal(a, b) for a, b in zip(changed, straight, strict=True))


def active(effect):
    """Every searched number three quarters up its bounds."""
    numbers = effects.parameters(effect).items()
    return replace(effect, **{name: known.low + 0.75 * (known.high - known.low) for name, known in numbers if not known.given})


@pytest.mark.parametrize("name", sorted(NAMES))
def test_metadata_is_complete(name):
    for entry in fields(effects.library()[name]):
        if entry.type in (float, "float"):
            known = effects.parameters(effects.library()[name])[entry.name]
            absent = known.given or known.default == known.null  # what is not there may lie outside what is plausible of it
            assert known.unit and (absent or known.low <= known.default <= known.high)


@dataclass(frozen=True)
class MyDrag(Effect):
    rate: float = parameter(0.0, unit="1/s", low=0, high=5, null=0.0)
    dissipative = True

    def forces(self, bodies, time):
        wrench = -self.rate * bodies.mass[:, None] * bodies.twist
        wrench[:, 3:] = 0.0
        return wrench


def test_a_users_own_effect_passes_and_the_report_says_so():
    report = check_effect(MyDrag())
    assert str(report) == (
        "my_drag keeps all rules: declaration, answer, reads only, repeatable, null, rotation, dissipative, independence"
    )


def own(forces=None, name="Mine", **members):
    """A frozen effect with one rate and these members."""
    if forces is not None:
        members["forces"] = forces
    members = {"rate": parameter(0.0, unit="1/s", low=0.0, high=5.0, null=0.0), "__annotations__": {"rate": float}} | members
    return dataclass(frozen=True)(type(name, (Effect,), members))()


def momentum(self, bodies):
    return self.rate * bodies.mass[:, None] * bodies.twist


def wrong_shape(self, bodies, time):
    return momentum(self, bodies)[:, :3]


def not_finite(self, bodies, time):
    speed = np.linalg.norm(bodies.twist[:, :3], axis=1)[:, None]
    return momentum(self, bodies) / speed


def fails(self, bodies, time):
    return bodies.density


def writes(self, bodies, time):
    bodies.twist[:, 3:] = 0.0
    return momentum(self, bodies)


def random(self, bodies, time):
    return momentum(self, bodies) * np.random.default_rng().random()


def not_absent(self, bodies, time):
    return (self.rate - 1e-30) * bodies.mass[:, None] * bodies.twist


def one_axis(self, bodies, time):
    return momentum(self, bodies) * [1, 0, 0, 0, 0, 0]


def wrong_sign(self, bodies, time):
    return momentum(self, bodies)


def to_the_mean(self, bodies, time):
    return momentum(self, bodies) - momentum(self, bodies).mean(axis=0)


def first_row(self, bodies, time):
    return momentum(self, bodies) * np.arange(len(bodies.mass))[:, None]


def negative_mass(self, bodies):
    return -self.rate * np.eye(6) * bodies.mass[:, None, None]


def lopsided_mass(self, bodies):
    return self.rate * np.triu(np.ones((6, 6))) * bodies.mass[:, None, None]


def negative_friction(self, contacts, bodies, law):
    return law._replace(friction=law.friction - self.rate)


def short_law(self, contacts, bodies, law):
    return law._replace(adhesion=law.adhesion[1:])


def no_law(self, contacts, bodies, law):
    return law.friction


def ordered_law(self, contacts, bodies, law):
    return law._replace(friction=law.friction + self.rate * np.arange(len(law.friction)))


def unitless():
    return own(wrong_sign, rate=0.3)


def boundless():
    return own(wrong_sign, rate=parameter(0.3, unit="1/s"))


def wrong_bounds():
    return own(wrong_sign, rate=parameter(0.3, unit="1/s", low=1.0, high=0.0))


def blank_unit():
    return own(wrong_sign, rate=parameter(0.3, unit="", low=0.0, high=1.0))


def changeable():
    return own(wrong_sign, table=field(default_factory=list), __annotations__={"rate": float, "table": list})


def undecorated():
    return type("Mine", (Effect,), {"forces": lambda self, bodies, time: 0.0 * bodies.twist})()


BROKEN = [
    (undecorated, "declaration", "dataclass"),
    (lambda: own(), "declaration", "does nothing"),
    (changeable, "declaration", "can change"),
    (unitless, "declaration", "rate has no unit and bounds; write rate: float = parameter"),
    (boundless, "declaration", "rate needs bounds"),
    (wrong_bounds, "declaration", "low must be below high"),
    (blank_unit, "declaration", "needs a unit"),
    (lambda: own(wrong_shape), "answer", r"answered shape \(7, 3\) for 7 bodies; it must be \(7, 6\)"),
    (lambda: own(not_finite), "answer", "divided by a speed of zero"),
    (lambda: own(fails), "answer", "AttributeError"),
    (lambda: own(contact_law=negative_friction), "answer", "friction of contact"),
    (lambda: own(contact_law=short_law), "answer", "adhesion has shape"),
    (lambda: own(contact_law=no_law), "answer", "must return a ContactLaw"),
    (lambda: own(writes), "reads only", "writes into Bodies.twist"),
    (lambda: own(random), "repeatable", "random"),
    (lambda: own(not_absent), "null", "with rate = 0.0 it must be exactly absent"),
    (lambda: own(one_axis), "rotation", "isotropic = False"),
    (lambda: own(wrong_sign, dissipative=True), "dissipative", "is the sign right"),
    (lambda: own(to_the_mean), "independence", "when the others are not there"),
    (lambda: own(first_row), "independence", "order of the bodies"),
    (lambda: own(contact_law=ordered_law), "independence", "order of the contacts"),
    (lambda: own(added_mass=negative_mass, isotropic=False), "mass matrix", "negative eigenvalue"),
    (lambda: own(added_mass=lopsided_mass, isotropic=False), "mass matrix", "not symmetric"),
]


@pytest.mark.parametrize(("make", "rule", "message"), BROKEN, ids=[f"{rule}-{k}" for k, (_, rule, _) in enumerate(BROKEN)])
def test_every_rule_catches_what_breaks_it(make, rule, message):
    with pytest.raises(EffectError, match=message) as caught:
        check_effect(make())
    assert caught.value.rule == rule and caught.value.effect == "Mine"
    assert "\n" not in str(caught.value)


def test_notes_tell_of_numbers_without_influence_and_of_wrong_dimensions():
    idle = check_effect(own(lambda self, bodies, time: 0.0 * bodies.twist))
    assert idle.notes == ("rate on its own changes nothing on the sample bodies",)
    massless = check_effect(own(lambda self, bodies, time: -self.rate * bodies.twist))
    assert len(massless.notes) == 1 and "is the mass missing" in massless.notes[0]
    strange = check_effect(own(wrong_sign, rate=parameter(0.0, unit="furlong", low=0, high=1, null=0.0)))
    assert "not understood" in strange.notes[0]


def test_what_is_no_effect_is_refused():
    with pytest.raises(InputError, match="make a value with parentheses"):
        check_effect(MyDrag)
    with pytest.raises(InputError, match="wants a value of a subclass of Effect"):
        check_effect("quadratic_drag")
    with pytest.raises(InputError, match="MyDrag: rate must be a finite number, not nan"):
        MyDrag(rate=float("nan"))
