"""A model is refused that states an effect of a body, or of a fluid, that the file does not describe: no body is invented."""

import numpy as np
import pytest

import hlcs
from hlcs.effects import classes
from minibullet.effects.contract import Need, parameters
from minibullet.errors import InputError

HEIGHTS = np.repeat([0.5, 1.0, 2.0], 3)
TIMES = np.sqrt(2 * HEIGHTS / 9.81) + 0.002 * np.tile([-1.0, 0.0, 1.0], 3)
T = np.arange(0.0, 0.5, 0.02)
RADIUS, MASS, AREA = {"radius": 0.03}, {"mass": 0.05}, {"drag_area": 0.003}
DRAG, PER_METRE, RATE = (
    {"name": "quadratic_drag", "drag_coefficient": 0.47},
    {"name": "quadratic_drag", "drag_per_metre": 0.1},
    {"name": "linear_drag", "rate": 0.1},
)


def falls(body, *effects, fluid=1.2, **columns):
    """An Experiment of falls of a body, under a model with these effects; more columns of its table."""
    columns = {"height_m": HEIGHTS, **columns, "fall_time_s": TIMES}
    around, model = {"gravity": 9.81, "fluid_density": fluid}, {"effects": list(effects)}
    return hlcs.Experiment.from_frames(
        columns, kind="outcomes", body={"shape": "sphere", **body}, surroundings=around, model=model
    )


def flights(body, *effects, trials=({}, {})):
    """The same of two recordings; trials: what stands beside each."""
    frames = [{"t_s": T, "z_m": speed * T - 4.905 * T**2} for speed in (1.0, 2.0)]
    model, noise = {"effects": list(effects)}, {"position": 0.001}
    return hlcs.Experiment.from_frames(frames, body={"shape": "sphere", **body}, model=model, noise=noise, trials=list(trials))


def numbers(name):
    """An entry of an effect with all its numbers off their null values."""
    known = parameters(classes()[name])
    return {"name": name} | {key: number.default + 0.01 for key, number in known.items() if not number.given}


OF_BODY = sorted(name for name, kind in classes().items() if Need.MASS_AND_SIZE in kind.needs)


@pytest.mark.parametrize("name", OF_BODY)
@pytest.mark.parametrize(
    ("body", "missing"), [(MASS, "body.radius is not"), (RADIUS, "body.mass is not"), ({}, "body.radius and body.mass are not")]
)
def test_what_acts_through_mass_and_size_is_refused_without_them(name, body, missing):
    for experiment in (falls(body, numbers(name)), flights(body, numbers(name))):
        with pytest.raises(
            InputError, match=f"model.effects: {name} needs the mass and the size of the body, and {missing} stated"
        ):
            hlcs.compare(experiment)


def test_what_acts_through_the_size_alone_needs_no_mass():
    with pytest.raises(
        InputError, match=r"size_error needs the size of the body, and body.radius is not stated; state body.radius"
    ):
        hlcs.compare(falls(MASS, {"name": "size_error", "relative": 0.01}))
    rest = {"kind": "outcomes", "noise": {"outcome": 1e-4}, "model": {"effects": [{"name": "size_error", "relative": 0.01}]}}
    heights = 0.0303 + 1e-4 * np.array([-1.0, 0.0, 1.0])
    assert hlcs.compare(
        hlcs.Experiment.from_frames({"rest_height_m": heights}, body=RADIUS | {"shape": "sphere"}, **rest)
    ).adequate


@pytest.mark.parametrize("body", [{}, RADIUS, MASS, AREA])
def test_a_drag_coefficient_is_refused_without_the_body_and_the_remedy_is_named(body):
    for experiment in (falls(body, DRAG), flights(body, DRAG)):
        with pytest.raises(
            InputError, match="for its drag_coefficient, and body.* stated; .*, or give drag_per_metre in its place"
        ):
            hlcs.compare(experiment)


@pytest.mark.parametrize(
    ("body", "entry"),
    [
        ({}, PER_METRE),
        ({}, RATE),
        (MASS, RATE),
        (RADIUS | MASS, DRAG),
        (RADIUS | MASS, PER_METRE),
        (AREA | MASS, DRAG),
        ({}, {"name": "buoyancy", "fluid_density": 0.0}),  # absent
        ({}, {"name": "clock_offset", "offset": 0.01}),
    ],
)
def test_what_needs_nothing_that_is_not_stated_is_computed(body, entry):
    hlcs.compare(falls(body, entry))
    if entry["name"] != "clock_offset":  # of a recording it needs the moment of the release
        hlcs.compare(flights(body, entry))


def test_a_column_or_a_trial_states_the_body_as_well():
    mass, radius = np.full(len(HEIGHTS), 0.05), np.full(len(HEIGHTS), 0.03)
    assert hlcs.compare(falls(RADIUS, DRAG, mass_kg=mass)).error == hlcs.compare(falls(RADIUS | MASS, DRAG)).error
    hlcs.compare(falls({}, DRAG, mass_kg=mass, radius_m=radius))
    hlcs.predict(falls(RADIUS, DRAG, mass_kg=mass), {"height_m": 1.0, "mass_kg": 0.05})
    with pytest.raises(InputError, match="body.mass is not stated"):
        hlcs.predict(falls(RADIUS, DRAG, mass_kg=mass), {"height_m": 1.0})
    hlcs.compare(flights(RADIUS, DRAG, trials=(MASS, MASS)))
    with pytest.raises(InputError, match="body.mass is not stated"):
        hlcs.compare(flights(RADIUS, DRAG, trials=(MASS, {})))


def test_the_fluid_of_an_entry_is_that_of_the_surroundings_and_in_a_vacuum_there_is_none():
    """What needs no density of the file says what it says; a table with rows in air is in no vacuum."""
    body = RADIUS | MASS
    for entry in (DRAG, {"name": "added_mass", "coefficient": 0.5}):
        with pytest.raises(InputError, match=r"model.effects: \w+ acts through the fluid, and the file states a vacuum"):
            hlcs.compare(falls(body, entry, fluid=0.0))
    for entry in (DRAG | {"fluid_density": 1.2}, PER_METRE, RATE):
        assert hlcs.compare(falls(body, entry, fluid=0.0)).error == hlcs.compare(falls(body, entry)).error
    tubes = falls(body, DRAG, fluid_density_kg_m3=np.tile([0.0, 1.2, 1.2], 3))
    empty, full = hlcs.predict(tubes, {"height_m": [2.0, 2.0], "fluid_density_kg_m3": [0.0, 1.2]})["fall_time_s"]
    assert empty == pytest.approx(np.sqrt(4 / 9.81), rel=1e-6) and full > empty + 1e-3
