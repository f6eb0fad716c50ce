"""Values show what they hold with units, and what they are asked for by a wrong name they refuse with the right one."""

import copy
import pickle
from dataclasses import dataclass

import numpy as np
import pytest

import minibullet as mb


def test_a_value_shows_its_numbers_with_units():
    """SI units as the classes state them; what is as by default is left out, a pure number has no unit."""
    assert repr(mb.Gravity(9.81)) == "Gravity(acceleration=9.81 m/s2)"
    assert repr(mb.Settings(time_step=0.01)) == "Settings(time_step=0.01 s, friction=0.5, restitution=0, solver='exact')"
    shown = repr(mb.Settings(margin=0.002, damping_law="per_step"))
    assert "margin=0.002 m" in shown and "damping_law='per_step'" in shown and "tolerance" not in shown
    drag = repr(mb.QuadraticDrag(drag_coefficient=1.05, fluid_density=1000.0))
    assert "drag_coefficient=1.05," in drag and "fluid_density=1000 kg/m3" in drag


def test_every_shipped_effect_shows_all_its_numbers_in_a_line_and_in_a_table():
    for kind in mb.library().values():
        line, table = repr(kind()), kind()._repr_html_()
        for number in mb.effects.parameters(kind).values():
            assert f"{number.name}=" in line and f"<td>{number.name}</td>" in table, kind
            assert number.unit in ("-", "1") or f" {number.unit}" in line and f"<td>{number.unit}</td>" in table, kind


@dataclass(frozen=True)
class Wind(mb.Effect):
    """A push of the user's own."""

    push: float = mb.parameter(0.0, unit="m/s2", low=0.0, high=1.0, null=0.0)


def test_a_field_that_is_an_array_is_shown_in_one_line():
    """Whatever a user's class holds, its line can be printed: messages quote it."""

    @dataclass(frozen=True, eq=False)
    class Table(mb.Effect):
        forces_at: object = ()

    shown = repr(Table(np.arange(100.0)))
    assert shown.startswith("Table(forces_at=array([ 0.,") and "\n" not in shown and len(shown) < 100


@pytest.mark.parametrize(
    ("make", "wrong", "right"),
    [
        (mb.World, "setings", "settings"),
        (mb.Settings, "frictoin", "friction"),
        (mb.Settings, "timestep", "time_step"),
        (mb.QuadraticDrag, "drag_coeficient", "drag_coefficient"),
        (mb.Gravity, "accelaration", "acceleration"),
        (Wind, "pusch", "push"),
        (mb.Sphere, "raduis", "radius"),
        (mb.ConvexPiece, "vertexes", "vertices"),
    ],
)
def test_an_unknown_argument_is_refused_with_the_nearest(make, wrong, right):
    """One line that names class, argument and remedy, on every version of Python."""
    with pytest.raises(mb.InputError) as refused:
        make(**{wrong: 1.0})
    assert str(refused.value) == f"{make.__name__} has no argument '{wrong}'; did you mean '{right}'?"


@pytest.mark.parametrize(
    ("make", "wrong", "told"),
    [
        (lambda: mb.QuadraticDrag(cd=1.0), "'cd'", "; it takes drag_coefficient, fluid_density, drag_per_metre"),
        (lambda: mb.Settings(solver="foo"), "'foo'", "; it must be one of exact, gauss_seidel, sequential_impulse"),
    ],
)
def test_nothing_is_guessed_of_a_word_that_is_like_none(make, wrong, told):
    """What there is is listed; a guess that is like it by chance would mislead."""
    with pytest.raises(mb.InputError) as refused:
        make()
    assert wrong in str(refused.value) and str(refused.value).endswith(told)


@pytest.mark.parametrize(("field", "wrong", "right"), [("damping_law", "bulet", "bullet"), ("solver", "Exactly", "exact")])
def test_a_word_that_is_none_of_a_few_is_refused_with_the_nearest(field, wrong, right):
    with pytest.raises(mb.InputError, match=f"settings: {field} = '{wrong}'.*; did you mean '{right}'\\?$"):
        mb.Settings(**{field: wrong})


def test_a_value_is_still_a_value():
    """Copies and pickles make no call with arguments of their own; equal values are equal."""
    for value in (mb.Settings(friction=0.3), mb.QuadraticDrag(drag_coefficient=0.47), Wind(0.2)):
        assert pickle.loads(pickle.dumps(value)) == value == copy.deepcopy(value)


def test_a_name_is_found_whatever_its_capitals():
    from minibullet.errors import nearest

    assert nearest("tgp", ("TPG", "RPG")) == "TPG" and nearest("Drag", ("gravity", "drag_coefficient")) == "drag_coefficient"
