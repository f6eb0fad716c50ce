"""The library of candidates: what it finds by itself, whom it refuses, and facts that hold for every class in it."""

from dataclasses import dataclass
from enum import Enum

import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.rigid_body import rigid_body
from hlcs.effects import build, build_entry, candidate, class_named, classes, entry_of, own_classes, wanted
from minibullet import effects
from minibullet.effects.contract import Effect, parameter, parameters
from minibullet.errors import InputError

AIR = Surroundings()


@dataclass(frozen=True)
class Breeze(Effect):
    """A law of the user's own that does nothing."""

    rate: float = parameter(0.0, unit="1/s", low=0.0, high=5.0, null=0.0)

    def forces(self, bodies, time):
        return 0.0 * bodies.twist


def test_every_class_with_a_number_to_be_found_is_a_candidate_and_gravity_is_none():
    known = classes()
    assert "gravity" not in known and len(known) == 40
    assert {"quadratic_drag", "mass_offset", "bottom_slope", "clock_offset", "margin_offset"} <= set(known)


@pytest.mark.parametrize("name", sorted(classes()))
def test_facts_of_a_class_are_values_of_their_kind(name):
    kind = classes()[name]
    assert kind.group and kind.plain and all(isinstance(need, Enum) for need in kind.needs)
    assert not (kind.alike and kind.form_of) and all(issubclass(other, Effect) for other in kind.contains)
    for number in parameters(kind).values():
        starts = number.starts or (number.default,)
        absent = starts == (number.null,)  # what is not there may lie outside what is plausible of it
        assert number.given or absent or all(number.low <= value <= number.high for value in starts)


def test_sets_of_look_alikes():
    sets = {}
    for name in sorted(classes()):
        kind = classes()[name]
        sets.setdefault(kind.form_of or kind.alike, []).append(name)
    del sets[""]
    assert sets == {
        "drag_form": ["drag_crisis", "linear_drag", "quadratic_drag", "sphere_drag", "stokes_drag"],
        "effective_gravity": ["buoyancy", "length_scale", "time_scale"],
        "rest_height": ["margin_offset", "size_error"],
        "tilt": ["tilted_frame", "tilted_gravity", "uniform_flow"],
    }


def test_names_are_looked_up_among_shipped_and_own_classes():
    assert class_named("magnus") is effects.Magnus and class_named("breeze", (Breeze,)) is Breeze
    assert list(wanted(["magnus"], (Breeze,))) == [effects.Magnus, Breeze]
    assert {*wanted(None, (Breeze,))} == {*classes().values(), Breeze}
    with pytest.raises(InputError, match="unknown effect 'magnum'; the nearest known effect is 'magnus'"):
        class_named("magnum")


def test_an_entry_of_a_file_becomes_an_effect_with_what_the_surroundings_say():
    water = Surroundings(fluid_density=998.0, gravity=9.8)
    assert build_entry({"name": "buoyancy"}, water) == effects.Buoyancy(998.0, acceleration=9.8)
    assert build_entry({"name": "buoyancy", "fluid_density": 5.0}, water).fluid_density == 5.0
    assert build_entry({"name": "magnus", "coefficient": 1}, AIR).coefficient == 1.0


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"name": "magnus", "strength": 1.0}, "magnus has no parameter 'strength'; it has coefficient, fluid_density"),
        ({"name": "magnus", "coefficient": True}, "must be a finite number"),
        ({"name": "magnus", "coefficient": float("inf")}, "must be a finite number"),
        ({"name": "magnus", "coefficient": 10**400}, "must be a finite number"),
        ({"name": "linear_drag", "rate": -1.0}, "rate = -1 must be at least 0"),
        ({"name": "static_friction", "ratio": 0.9}, "ratio = 0.9 must be at least 1"),
        ({"name": "length_scale", "factor": 0.0}, "factor = 0 must be at least 0.009"),
        ({"name": "restitution", "coefficient": 1.2}, "coefficient = 1.2 must be at most 1"),
        ({"name": "mass_offset", "relative": -0.95}, "relative = -0.95 must be at least -0.9"),
    ],
)
def test_entries_that_mean_nothing_are_refused(entry, message):
    with pytest.raises(InputError, match=message):
        build_entry(entry, AIR)


@pytest.mark.parametrize("name", sorted(name for name, kind in classes().items() if "fluid_density" in parameters(kind)))
def test_a_fluid_that_is_left_out_is_air_for_every_effect(name):
    """Whatever density the class has by itself; a stated fluid is that fluid, a vacuum too, and what an entry says wins."""
    assert build_entry({"name": name}, AIR).fluid_density == AIR.fluid_density == 1.2
    assert build_entry({"name": name}, Surroundings(fluid_density=998.0)).fluid_density == 998.0
    assert build_entry({"name": name}, Surroundings(fluid_density=0.0)).fluid_density == 0.0
    assert build_entry({"name": name, "fluid_density": 5.0}, AIR).fluid_density == 5.0


def test_numbers_that_a_search_may_find_can_be_written_back():
    """Whatever lies between the ends of a law (`Free.least`, `Free.most`), plausible or not."""
    body = rigid_body(Body(radius=0.05, mass=0.5))
    for name, kind in classes().items():
        for free in candidate(kind, AIR, body, body_known=True).free:
            for value in (max(free.least, -1e3), min(free.most, 1e3)):
                assert getattr(build_entry({"name": name, free.name: value}, AIR), free.name) == value


@pytest.mark.parametrize("name", sorted(classes()))
def test_an_effect_is_written_as_the_entry_that_makes_it(name):
    """With all its numbers off their defaults, what the surroundings say filled in."""
    numbers = {key: known.default + 0.01 for key, known in parameters(classes()[name]).items() if not known.given}
    effect = build(classes()[name], numbers, AIR)
    assert entry_of(effect).items() >= {"name": name, **numbers}.items()
    assert build_entry(entry_of(effect), AIR) == effect


def test_own_classes_need_a_number_that_can_be_absent():
    assert own_classes([Breeze(), Breeze]) == (Breeze,)
    with pytest.raises(InputError, match="no number with a null value"):
        own_classes([effects.Gravity])
    with pytest.raises(InputError, match="not an effect"):
        own_classes([float])


def test_no_two_classes_are_called_the_same_in_plain_words():
    """And every name reads on after "the data show": no capital, no full stop, no underscore of a name."""
    words = [kind.plain for kind in classes().values()]
    assert len(set(words)) == len(words)
    assert all(text[0].islower() or text.startswith("{fluid}") for text in words) and not any("_" in text for text in words)


def test_a_law_is_called_by_the_fluid_it_acts_in_and_one_of_the_users_own_by_its_name():
    drag = candidate(class_named("quadratic_drag"), AIR, rigid_body(Body("sphere", radius=0.1, mass=1.0)), True)
    lift = candidate(class_named("buoyancy"), AIR, rigid_body(Body("sphere", radius=0.1, mass=1.0)), True)
    around = (AIR, *(Surroundings(fluid_density=density) for density in (979.0, 980.0, 1040.0, 1041.0, 0.17)))
    assert [drag.called(each.fluid) for each in around] == [
        "air resistance",
        "resistance of the fluid of 979 kg/m3",
        "water resistance",
        "water resistance",
        "resistance of the fluid of 1041 kg/m3",  # milk
        "resistance of the fluid of 0.17 kg/m3",  # helium
    ]
    assert lift.called(Surroundings(fluid_density=860.0).fluid) == "the lift of the displaced fluid of 860 kg/m3"
    assert candidate(Breeze, AIR, rigid_body(Body()), True, own=True).called() == "breeze"
