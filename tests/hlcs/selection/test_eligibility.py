"""Which candidates recordings can show: each need met and unmet, and what the model at hand has to offer."""

from types import SimpleNamespace

import numpy as np
import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.rigid_body import rigid_body
from hlcs.effects import candidate, classes
from hlcs.effects.contract import DataNeed
from hlcs.selection.eligibility import NEEDS, candidates_for, known_body, lacks_drag, with_drag_that_fits
from hlcs.simulation.model import Model, Term
from minibullet import effects
from minibullet.effects.contract import Need

BALL = Body(shape="sphere", mass=1.0, radius=0.1)
BOX = Body(shape="box", mass=1.0, size=(0.1, 0.2, 0.3))
TIMES = np.linspace(0.0, 1.0, 12)
OF_FLUID = {name for name, kind in classes().items() if kind.group == "fluid"}


def recordings(columns="xyz", body=BALL, floor=0.0, start=("velocity", "angular_velocity"), effects=(), alike=False, fluid=1.2):
    """What a choice of candidates reads of two recordings and their file."""
    heights = (5 - 4 * TIMES**2, 5 - 4 * TIMES**2 if alike else 1 + 4 * TIMES)
    trials = tuple(
        SimpleNamespace(
            columns=set(columns.split()) if " " in columns else set(columns),
            start=dict.fromkeys(start),
            body=body,
            surroundings=Surroundings(floor_height=floor, fluid_density=fluid),
            session="",
            times=TIMES,
            unplaced=False,
            position=np.stack([0 * TIMES, 0 * TIMES, z], axis=1),
        )
        for z in heights
    )
    return SimpleNamespace(
        trials=trials, file=SimpleNamespace(effects=tuple({"name": name} for name in effects), scale_error=0.0)
    )


def missing(contact=True, **what):
    """{name: why it cannot take part}."""
    return candidates_for(recordings(**what), contact)[1]


def test_where_everything_is_known_everything_takes_part():
    """But for the laws of slow flow, of tubes and of edges: this ball has Reynolds numbers of 1e5."""
    found, absent = candidates_for(recordings(columns="x y z rx ry rz ax"), True)
    assert set(absent) == {"stokes_drag", "sphere_drag", "tube_drag", "orientation_drag"}
    assert [entry.name for entry in found] == sorted({*classes()} - {*absent})


@pytest.mark.parametrize(
    ("what", "names", "why"),
    [
        ({"body": Body(shape="sphere", radius=0.1)}, {"buoyancy", "drag_crisis", "mass_offset"}, "the mass or the size"),
        ({"body": BOX}, {"sphere_drag"}, "the body is no sphere"),
        ({}, {"orientation_drag"}, "a sphere has no edges"),
        ({}, {"tube_drag"}, "there is no liquid, and no tube is stated (surroundings.tube_radius)"),
        ({"fluid": 0.0, "columns": "x y z rx ry rz"}, OF_FLUID, "the file states a vacuum (fluid_density = 0.0)"),
        ({"fluid": 0.0, "body": Body()}, OF_FLUID, "the file states a vacuum (fluid_density = 0.0)"),
        ({}, {"accelerometer_offset"}, "no accelerations are read"),
        ({"floor": None}, {"wall_drag", "ground_cushion", "tracker_smoothing"}, "there is no floor, or not under all recordings"),
        ({"start": ("velocity",)}, {"magnus"}, "the spin is neither measured nor stated"),
        ({"start": ()}, {"clock_offset", "history_force"}, "the moment of release is not known"),
        ({}, {"spin_decay"}, "orientations are not measured"),
        ({"contact": False}, {"friction", "bottom_slope", "margin_offset"}, "nothing touches in these data"),
        ({"columns": "z"}, {"tilted_gravity", "tilted_frame"}, "no horizontal position is measured"),
        ({"columns": "xy"}, {"calibration_curve"}, "no height is measured"),
        ({"alike": True}, {"calibration_curve"}, "all recordings pass the same heights"),
    ],
)
def test_each_need_is_named_where_it_is_not_met(what, names, why):
    absent = missing(**what)
    assert names <= {name for name, text in absent.items() if text.startswith(why)}


def test_a_centre_of_mass_shows_in_a_contact_that_can_lean_and_an_inertia_in_any():
    assert {"centre_of_mass_offset"} == {"centre_of_mass_offset", "inertia_error"} & set(missing())
    assert not {"centre_of_mass_offset", "inertia_error"} & set(missing(body=BOX))
    assert {"centre_of_mass_offset", "inertia_error"} <= set(missing(body=BOX, contact=False))


def test_what_the_model_states_is_tried_by_its_numbers_alone_and_neither_a_law_that_holds_it_nor_one_that_it_holds():
    """They would stand in its place, not beside it; a drag in proportion to speed may act beside one by its square."""
    absent = missing(effects=("quadratic_drag",))
    assert absent["quadratic_drag"].startswith("already in the model") and "linear_drag" not in absent
    assert "the model states quadratic_drag, whose place it would take" in absent["drag_crisis"]
    assert "the model states drag_crisis, whose place it would take" in missing(effects=("drag_crisis",))["quadratic_drag"]


def test_numbers_that_the_model_states_are_expected_where_they_are_stated_and_may_be_wrong():
    shown = recordings()
    shown.file.effects = ({"name": "quadratic_drag", "drag_coefficient": 0.47}, {"name": "static_friction", "ratio": 1.3})
    found = {entry.name: entry for entry in candidates_for(shown, True)[0]}
    (drag,), (ratio,) = found["quadratic_drag"].free, found["static_friction"].free
    assert found["quadratic_drag"].setting and (drag.null, drag.start, drag.expected) == (0.47, 0.47, 0.47)
    assert (drag.least, ratio.null, ratio.least) == (0.0, 1.3, 1.0)  # a law ends where it ends, whatever is stated


def test_every_need_of_a_class_has_its_test():
    assert set(NEEDS) == {*Need, *DataNeed}


def test_a_body_is_known_by_mass_and_any_size():
    assert known_body(BALL) and known_body(BOX)
    assert not known_body(Body(shape="sphere", mass=1.0)) and not known_body(Body(shape="sphere", radius=0.1))


def test_a_law_of_the_load_needs_two_loads_where_nothing_strikes():
    """What slides on one floor presses on it with its weight: then any law of the load is a friction. An impact has its own."""
    slides, why = recordings(), "load_dependent_friction"
    assert candidates_for(slides, True, seated=(True, True))[1][why] == "the load does not vary"
    assert why not in candidates_for(slides, True, seated=(True, False))[1]
    slides.trials[0].body = Body("sphere", radius=0.2, mass=2 * BALL.mass)
    assert why not in candidates_for(slides, True, seated=(True, True))[1]


def test_what_acts_through_a_drag_needs_one():
    drag, wall, lift = (
        candidate(kind, Surroundings(), rigid_body(BALL), True) for kind in (effects.LinearDrag, effects.WallDrag, effects.Magnus)
    )
    alone, both = Model((Term(wall, ()),)), Model((Term(drag, ()), Term(wall, ())))
    assert lacks_drag(wall, alone.kinds) and not lacks_drag(wall, both.kinds)
    assert not lacks_drag(lift, alone.kinds) and not lacks_drag(wall, Model(fixed=({"name": "drag_crisis"},)).kinds)


def test_a_tube_needs_a_drag_in_proportion_to_speed():
    tube = candidate(effects.TubeDrag, Surroundings(fluid_density=1260.0), rigid_body(BALL), True)
    assert lacks_drag(tube, [effects.QuadraticDrag]) and not lacks_drag(tube, [effects.SphereDrag])


def test_what_a_fluid_does_needs_one():
    """Every class of that group says so, the drags with a number that no density enters (a rate, per metre) as well."""
    assert {"quadratic_drag", "linear_drag", "uniform_flow", "magnus", "buoyancy"} <= OF_FLUID
    assert all(Need.FLUID in classes()[name].needs for name in OF_FLUID)
    other = {"stokes_drag", "sphere_drag", "tube_drag", "orientation_drag"}  # of slow flow, of a tube, of edges
    assert not OF_FLUID & set(missing(fluid=1.2, columns="x y z rx ry rz")) - other


def test_recordings_of_which_one_is_in_a_fluid_are_in_no_vacuum():
    """The fluid is that of the one, whatever their order and speeds."""
    shown = recordings(columns="z")
    vacuum, air = (
        SimpleNamespace(
            **vars(shown.trials[0])
            | {"surroundings": Surroundings(fluid_density=density), "position": 0 * TIMES[:, None] + np.ones(3)}
        )
        for density in (0.0, 1.2)
    )
    for order in ((vacuum, air), (air, vacuum)):
        shown.trials = order
        (lift,) = (entry for entry in candidates_for(shown, False)[0] if entry.name == "buoyancy")
        assert lift.expected == {"fluid_density": 1.2}


def test_in_a_vacuum_nothing_creeps():
    why = with_drag_that_fits({effects.StokesDrag: None, effects.LinearDrag: None}, BALL, Surroundings(fluid_density=0.0), 1.0)
    assert why[effects.LinearDrag] is None and "no fluid" in why[effects.StokesDrag]


def test_reynolds_numbers_are_those_of_each_recording_whatever_their_order():
    """Spheres of 2 and 20 mm in oil of 1 Pa s, at 0.4 and 0.04 m/s: 0.7 both, and 7 for the large one at 0.4 m/s."""
    around = Surroundings(fluid_density=900.0, fluid_viscosity=1.0, fluid_stated=True, floor_height=0.0)
    shown = recordings(columns="z")
    small, large = (
        SimpleNamespace(**vars(trial) | {"body": Body(shape="sphere", mass=m, radius=r), "surroundings": around, "position": way})
        for trial, m, r, way in zip(
            shown.trials,
            (1e-5, 1e-2),
            (0.001, 0.01),
            (np.outer(TIMES, [0, 0, -0.4]), np.outer(TIMES, [0, 0, -0.04])),
            strict=True,
        )
    )
    for order in ((small, large), (large, small)):
        shown.trials = order
        found, absent = candidates_for(shown, False)
        assert "stokes_drag" not in absent and "stokes_drag" in {entry.name for entry in found}
