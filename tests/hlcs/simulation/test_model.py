"""The model under test: a value that other models are made from, and what it hands to the engine."""

import tomllib

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.rigid_body import rigid_body
from hlcs.effects import candidate
from hlcs.effects.measurement import ClockOffset, TimeScale
from hlcs.estimation.linearization import free_numbers
from hlcs.simulation.model import Model, Term
from minibullet import effects

SURROUNDINGS = Surroundings(gravity=9.8, fluid_density=2.0)
BALL = rigid_body(Body("sphere", radius=0.1, mass=1.0))
DRAG, CLOCK = (
    Term(candidate(kind, SURROUNDINGS, BALL, True), ((name, value),))
    for kind, name, value in ((effects.QuadraticDrag, "drag_coefficient", 0.4), (ClockOffset, "offset", 0.01))
)
BASE = Model(fixed=({"name": "magnus", "coefficient": 1.0},), time_step=0.005)


def test_models_are_values_with_one_term_more_less_or_changed():
    both = BASE.with_term(DRAG).with_term(CLOCK)
    assert both.names == ("magnus", "quadratic_drag", "clock_offset") and BASE.names == ("magnus",)
    assert both.kinds == (effects.Magnus, effects.QuadraticDrag, ClockOffset)
    assert both.without(0) == BASE.with_term(CLOCK)
    assert both.with_at(0, {"drag_coefficient": 0.5}).terms[0].numbers == {"drag_coefficient": 0.5}


def test_a_model_that_is_held_says_the_same_and_has_nothing_to_fit():
    both = BASE.with_term(DRAG).with_term(CLOCK)
    held = both.held()
    assert held.numbers == both.numbers and held.entries == both.entries
    assert [len(free_numbers(model)) for model in (both, held)] == [2, 0]
    assert repr(held.changes(SURROUNDINGS)) == repr(both.changes(SURROUNDINGS))


def test_a_term_with_the_name_of_a_stated_effect_stands_in_its_place():
    """The other numbers that the file states of it stay: here the density."""
    stated = Model(fixed=({"name": "quadratic_drag", "drag_coefficient": 0.47, "fluid_density": 3.0}, *BASE.fixed))
    entries = ({"name": "quadratic_drag", "drag_coefficient": 0.4, "fluid_density": 3.0}, *BASE.fixed)
    assert stated.with_term(DRAG).entries == entries and stated.with_term(DRAG).names == stated.names
    acting, _, _ = stated.with_term(DRAG).changes(SURROUNDINGS)
    assert acting[1] == effects.QuadraticDrag(0.4, fluid_density=3.0) and len(acting) == 3


def test_effects_go_to_the_engine_with_gravity_first_and_changes_to_their_hooks():
    acting, setups, looks = BASE.with_term(DRAG).with_term(CLOCK).changes(SURROUNDINGS)
    assert acting == (effects.Gravity(9.8), effects.Magnus(1.0, fluid_density=2.0), effects.QuadraticDrag(0.4, fluid_density=2.0))
    assert setups == [] and looks == [ClockOffset(0.01)]


def test_a_model_is_written_as_the_section_it_was_read_from():
    model = tomllib.loads(BASE.with_term(DRAG).to_toml())["model"]
    entries = [{"name": "magnus", "coefficient": 1.0}, {"name": "quadratic_drag", "drag_coefficient": 0.4}]
    assert model == {"effects": entries, "time_step": 0.005}


def test_a_model_is_printed_as_its_equations_with_its_numbers():
    first, magnus, drag, motion, *_ = str(BASE.with_term(DRAG)).splitlines()
    assert first == "Model: gravity, magnus, quadratic_drag" and "m dv/dt = m g + sum of F" in motion
    assert "F = C pi rho r^3 omega x w" in magnus and "; coefficient = 1 (" in magnus
    assert "F = -(rho C A/2 + k m) |w| w" in drag and "; drag_coefficient = 0.4 (of the mean" in drag
    late = Model(fixed=({"name": "clock_offset", "offset": -0.10412, "offset A": 0.2},))
    meaning = "(from the stamp of the release to the release)"
    assert f"; offset = -0.1041 s {meaning}, offset A = 0.2 s {meaning}" in str(late)  # a number has its unit, in each session
    assert str(Model()).startswith("Model: gravity alone\n")


def test_what_a_list_of_effects_says_does_not_depend_on_its_order():
    """A clock that is late and slow: seen(t) = true(factor t - offset), whichever is written first."""
    slow = Term(candidate(TimeScale, SURROUNDINGS, BALL, True), (("factor", 1.05),))
    for model in (BASE.with_term(CLOCK).with_term(slow), BASE.with_term(slow).with_term(CLOCK)):
        assert model.changes(SURROUNDINGS)[2] == [ClockOffset(0.01), TimeScale(1.05)]
