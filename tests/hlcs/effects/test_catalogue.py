"""The catalogue of effects: every letter, number and name in it is explained, and its formulas are what the classes compute."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import minibullet as mb
from hlcs.effects import classes
from hlcs.effects.catalogue import FAMILIES, catalogue, facts_of
from hlcs.effects.library import class_named
from minibullet.bodies import Bodies
from minibullet.effects import samples
from minibullet.effects.contract import LETTERS, contact_law, parameters, symbols_of, wrench

SHIPPED = {**classes(), "gravity": mb.Gravity}
MATHEMATICS = {"sqrt", "exp", "cos", "pi", "integral"}


@pytest.mark.parametrize("name", sorted(SHIPPED))
def test_every_letter_of_a_formula_is_explained(name):
    kind = SHIPPED[name]
    numbers = {known.symbol or key for key, known in parameters(kind).items()}
    unknown = set(LETTERS.findall(kind.formula)) - {*symbols_of(kind)} - numbers - MATHEMATICS
    assert kind.formula and not unknown
    assert not set(kind.symbols) - set(LETTERS.findall(kind.formula))  # none that the formula does not have


@pytest.mark.parametrize("facts", catalogue(), ids=lambda facts: facts.name)
def test_every_effect_says_what_it_looks_like_and_what_its_numbers_are(facts):
    assert facts.looks_like.endswith(".") and facts.group in FAMILIES
    for known in facts.numbers:
        assert known.about and known.unit and (known.given or known.range)
        least = class_named(facts.name) and parameters(class_named(facts.name))[known.name].least
        assert all(least is None or value >= least for value, _ in known.typical)


def test_what_is_confused_with_another_is_confused_both_ways():
    names = {facts.name: facts.confused_with for facts in catalogue()}
    assert all(name in names[other] for name, others in names.items() for other in others)
    assert set(names["quadratic_drag"]) >= {"linear_drag", "buoyancy"}  # its set of forms, and one that it names itself


def as_python(formula):
    """The right side of a formula as Python: blanks between two factors multiply, ^ is a power, bars are a modulus."""
    right = re.sub(r"\|(\w+)\|", r"abs(\1)", formula.split(" = ", 1)[1])
    return re.sub(r"(?<=[\w)]) (?=[\w(])", "*", right).replace("^", "**")


def value_of(effect, **letters):
    """The right side of the formula of an effect, from its own numbers and these letters."""
    numbers = {known.symbol or name: getattr(effect, name) for name, known in parameters(effect).items()}
    functions = {"sqrt": math.sqrt, "exp": math.exp, "pi": math.pi, "abs": abs}
    return eval(as_python(effect.formula), {"__builtins__": {}}, {**functions, **letters, **numbers})


BALL = {"m": 0.3, "V": 0.004, "A": 0.03, "r": 0.1}


def falling(speed):
    """One ball that moves along z, 0.25 m above the ground, its numbers those of BALL."""
    twist = np.array([[0.0, 0.0, speed, 0.0, 0.0, 0.0]])
    quaternion, inertia = np.array([[1.0, 0.0, 0.0, 0.0]]), np.full((1, 3), 0.001)
    rest = (np.array([BALL[letter]]) for letter in "VAr")
    return Bodies(np.array([[0.0, 0.0, 0.25]]), quaternion, twist, np.array([BALL["m"]]), inertia, *rest)


@pytest.mark.parametrize(
    "effect",
    [
        mb.Gravity(9.8),
        mb.LinearDrag(0.7),
        mb.StokesDrag(1.4),
        mb.QuadraticDrag(drag_coefficient=0.4, drag_per_metre=0.2),
        mb.Buoyancy(900.0),
        mb.HistoryForce(0.8, start=0.5),
        mb.GroundCushion(1.3),
    ],
    ids=lambda effect: type(effect).__name__,
)
def test_a_formula_is_the_force_that_the_class_computes(effect):
    """Along z, of a ball that falls with 3 m/s at 2 s; equal but for the order of products, a few roundings."""
    found = wrench(effect, falling(-3.0), 2.0)[0, 2]
    told = value_of(effect, **BALL, w=-3.0, w_n=3.0, h=0.25, t=2.0, d=-1.0)
    assert found == pytest.approx(told, rel=1e-12) and found != 0.0


@pytest.mark.parametrize(
    "effect",
    [mb.StribeckFriction(1.4, speed=0.2), mb.ViscousFriction(0.3), mb.LoadDependentFriction(-0.2, reference_load=3.0)],
    ids=lambda effect: type(effect).__name__,
)
def test_a_formula_is_the_friction_that_the_class_computes(effect):
    """At contacts with slip and load of every size; a contact without load is new, and keeps its coefficient."""
    contacts, law = samples.sample_contacts()
    bodies = samples.with_fixed_body(samples.sample_bodies())
    found = contact_law([effect], contacts, bodies, law).friction
    along = np.sum(contacts.velocity * contacts.normal, axis=1)
    slip = np.sqrt(np.maximum(np.sum(contacts.velocity**2, axis=1) - along**2, 0.0))
    seen = np.flatnonzero(contacts.load > 0.0)
    told = [value_of(effect, mu=law.friction[k], v_t=slip[k], load=contacts.load[k]) for k in seen]
    assert found[seen] == pytest.approx(told, rel=1e-9)  # the slip is a difference of larger squares


def test_a_users_own_effect_is_listed_with_what_it_says():
    class Breeze(mb.LinearDrag):
        """Wind. A second sentence."""

    facts = facts_of(Breeze, (Breeze,))
    assert facts.name == "breeze" and facts.law == "Wind. A second sentence."
    assert "quadratic_drag" in facts.confused_with and replace(facts, name="x").name == "x"


def test_a_source_is_that_of_each_value_beside_it():
    """It is told behind every typical value: what it says of one of them is false of the others."""
    for facts in catalogue():
        for known in facts.numbers:
            assert not any(known.source.startswith(what) for _, what in known.typical), (facts.name, known.source)
    viscosity = next(known for facts in catalogue() if facts.name == "stokes_drag" for known in facts.numbers)
    assert not viscosity.source and all("the same" not in what for _, what in viscosity.typical)
