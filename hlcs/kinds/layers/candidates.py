"""What may be missing from a model of layers: each candidate changes the placement test, or how its layers are read.

A candidate has one number with its bounds, its null value in the model under test, and the value that it is simulated at. Groups
and names are those of the effects library. A new candidate is one entry in the function of its family; a family is what a verdict
on layers can tell apart.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hlcs.effects import Candidate, Free, classes
from hlcs.placement.grids import Grid
from hlcs.placement.sea_bottom import Flat, Slope
from minibullet import effects
from minibullet.effects.contract import Facts, name_of, parameters
from minibullet.errors import InputError, known_one

NEAR = 0.2  # by which a coefficient of contact of a known material is off, as a rule
TIP_OVER_LOW = 1.40428 - 1.29826  # how much higher a unit stands on a tip than in its lowest pose [Dn]


# in plain words, after "the data show": what has no class of its own in the library
WORDS = {
    "bottom_roughness": "a rough bottom",
    "settlement": "a bottom that gives way at once",
    "ground_softness": "a ground that yields under the load",
    "contact_compliance": "contacts that yield under the load",
    "placement_scatter": "units that are placed off their marks at random",
    "placement_offset": "units that are all placed off their marks to one side",
    "yaw_constraint": "units that keep their heading",
    "lost_units": "units that are lost",
    "vibration": "shaking of the structure",
    "falling_distance": "the falling distance",
    "sequential_placement": "units that are placed one after the other",
    "loose_lower_layers": "lower layers that stay loose",
    "grid_spacing": "a grid wider or narrower than stated",
    "orientation_bias": "units of the first layer on an edge, the others on a tip",
    "plate_bias": "plates that read too high or too low",
    "campaign_offset": "campaigns that read differently",
    "time_step": "a time step of the model that is too long",
    "iterations": "a solver that stops too early",
    "convex_hull_shape": "another shape of the units than the model has",
    "damping": "damping of the motion",
    "friction_combination": "friction coefficients that are multiplied in a contact",
    "friction_pyramid": "friction that is limited along two axes, not around",
}
# what it leaves in layer coefficients where the model lacks it, of those whose answer is a formula; all others are simulated
LOOKS_LIKE = {
    "settlement": "The first layer alone is thinner, by the same in all tests.",
    "ground_softness": "All layers are thinner by the same length.",
    "contact_compliance": "Layers are thinner, each by more than the one below.",
    "orientation_bias": "The first layer alone is thicker, since some of its units stand on a tip.",
    "plate_bias": "The first layer alone is too thick or too thin, by the same in all tests.",
    "campaign_offset": "All layers of one campaign are thicker by the same factor than those of another.",
    "time_step": "The misfit goes away when the time step of the model is halved.",
    "iterations": "The misfit goes away when the solver of the model is allowed more iterations.",
}
STATED = {"restitution", "friction", "falling_distance"}  # numbers of the model under test that are called by their own name


class RestHeight(Facts):
    """What raises or lowers the first layer alone, and can be told apart by nothing but another reading."""

    alike = "rest_height"


@dataclass(frozen=True)
class LayerCandidate(Candidate):
    """One thing that may be missing.

    change: (PlacementTest, *its numbers) -> PlacementTest; reading: (k (.., M), LayerSet, *its numbers) -> k as it would be read.
    One or both. What is either there or not (a switch) has no number to be found, but constants that say how it is there.
    """

    change: Callable | None = None
    reading: Callable | None = None
    step: float = 1.0  # from the null value to the first value at which it is simulated; of a switch: it is there

    @property
    def simulated(self):
        """Whether its signature needs simulations."""
        return self.change is not None

    def applied(self, test, *numbers):
        """The test with the candidate at these numbers."""
        return self.change(test, *numbers) if self.change else test

    def read(self, coefficients, measured_set, *numbers):
        """Layer coefficients as they would be read with the candidate at these numbers."""
        return self.reading(coefficients, measured_set, *numbers) if self.reading else coefficients


def library(test, sets):
    """(LayerCandidate, ...) of all that fit a model under test (a PlacementTest) and the measured sets, by name."""
    families = {
        "physics": (*_physics(test), *_contact_laws(test)),
        "placement": _placement(test),
        "measurement": _measurement(sets),
        "numerics": _numerics(test),
    }
    candidates = [
        replace(
            member, family=family, words=WORDS.get(member.name) or classes()[member.name].plain, setting=member.name in STATED
        )
        for family, members in families.items()
        for member in members
        if member
    ]
    return tuple(sorted(candidates, key=lambda candidate: candidate.name))


def named(name, test, sets):
    """The candidate of that name; InputError with the nearest known name."""
    known = {candidate.name: candidate for candidate in library(test, sets)}
    if name not in known:
        raise InputError(f"effect '{name}' does not fit layer data; {known_one(name, sorted(known), 'the nearest that does is')}")
    return known[name]


# ---- the candidates by family: name, number (unit, plausible range, null value), first step, change; None where it does not fit
def _physics(test):
    """Settings of the physics, sizes and slopes that are not what the file says, and what weight does after placing."""
    restitution, friction = test.restitution, test.friction
    weight = 9.81 * test.unit.mass(test.density)
    sinking = weight / test.unit.nominal_diameter  # of a point of unit compliance under one unit's weight [Dn N/m]
    softest = 0.01 * test.unit.side / weight
    level = isinstance(test.bottom, Flat | Slope)  # a survey has the roughness of the bed itself
    bouncier, smoother = 0.3 if restitution <= 0.5 else -0.3, friction * (friction - 1.0) if friction >= 0.3 else 0.2
    return (
        _setting("restitution", _near(test.restitution, most=1.0), bouncier),
        _setting("friction", _near(test.friction), smoother),
        _setting(
            "inertia_error", _number("factor", "1", 0.5, 4.0, test.inertia_factor), 1.06 * test.inertia_factor, "inertia_factor"
        ),
        _setting("bottom_roughness", _number("standard_deviation", "Dn", 0.0, 0.1, test.bottom_roughness), 0.04)
        if level
        else None,
        _simulated("bottom_slope", _number("grade_y", "1", -0.1, 0.1, 0.0), 0.03, _tilt_bottom),
        _simulated(  # in units of their own size, larger units on the same grid have a narrower one
            "size_error",
            _number("relative", "1", -0.02, 0.02, 0.0),
            -0.02,
            change=lambda test, value: _widen_grid(test, 1.0 / (1.0 + value) - 1.0),
            reading=lambda k, _, value: k * (1.0 + value),
        ),
        _read(
            "settlement",
            _number("instant", "Dn", 0.0, 0.1, 0.0),
            reading=lambda k, _, value: _raise_first(k, -value),
            kind=RestHeight,
        ),
        _read(  # every layer loads the ground by as much again
            "ground_softness", _number("compliance", "m/N", 0.0, softest, 0.0), reading=lambda k, _, value: k - value * sinking
        ),
        _read(
            "contact_compliance",
            _number("compliance", "m/N", 0.0, softest, 0.0),
            reading=lambda k, _, value: k - value * sinking / 3.0 * np.arange(1.0, k.shape[-1] + 1.0),
        ),
    )


def _contact_laws(test):
    """Laws of contact from the engine's library, tried at a part of the way from the null value to the upper bound."""
    load = 9.81 * test.unit.mass(test.density) / 3.0  # a unit stands on three points
    return (
        _contact_law(test, effects.StaticFriction, 0.5),
        _contact_law(test, effects.StribeckFriction, 0.5),
        _contact_law(test, effects.ViscousFriction, 0.3),
        _contact_law(test, effects.LoadDependentFriction, 0.5, reference_load=load),
        _contact_law(test, effects.AnisotropicFriction, 0.5),
        _contact_law(test, effects.RollingFriction, 0.5),
        _contact_law(test, effects.SpinningFriction, 0.5),
        _contact_law(test, effects.Adhesion, 0.3),
        _contact_law(test, effects.VelocityDependentRestitution, 0.8) if test.restitution else None,
    )


def _placement(test):
    """What hands do: where and how units are placed."""
    lower = -0.2 if test.falling_distance > 0.25 else 0.25
    return (
        _setting("placement_scatter", _number("standard_deviation", "Dn", 0.0, 0.3, test.placement_scatter), 0.15),
        _setting("placement_offset", _number("y", "Dn", -0.3, 0.3, test.placement_offset_y), 0.1, "placement_offset_y"),
        _setting("yaw_constraint", _number("concentration", "1", 0.0, 50.0, test.yaw_constraint), 10.0),
        _setting("lost_units", _number("fraction", "1", 0.0, 0.1, test.lost_units, most=1.0), 0.05),
        _setting("vibration", _number("acceleration", "g", 0.0, 1.0, test.vibration), 0.3),
        _setting("falling_distance", _number("distance", "Dn", 0.0, 0.5, test.falling_distance), lower),
        None if test.sequential_placement else _switch("sequential_placement", sequential_placement=True),
        None if test.loose_lower_layers else _switch("loose_lower_layers", loose_lower_layers=True),
        _simulated("grid_spacing", _number("relative", "1", -0.03, 0.03, 0.0), 0.02, _widen_grid),
        _read(
            "orientation_bias",
            _number("fraction", "1", 0.8, 1.0, 1.0, least=0.0, most=1.0),  # a unit on a tip falls over unless others hold it
            reading=lambda k, _, value: _raise_first(k, (1.0 - value) * TIP_OVER_LOW),
        ),
    )


def _measurement(sets):
    """How layers are read."""
    campaigns = tuple(dict.fromkeys(measured_set.campaign for measured_set in sets))

    def by_campaign(k, measured_set, *offsets):
        return k * (1.0 + offsets[campaigns.index(measured_set.campaign)])

    offsets = [_number(f"offset {campaign}".strip(), "1", -0.03, 0.03, 0.0) for campaign in campaigns]
    return (
        _read(
            "plate_bias",
            _number("offset", "Dn", -0.05, 0.05, 0.0),
            reading=lambda k, _, value: _raise_first(k, value),
            kind=RestHeight,
        ),
        _read("length_scale", _number("factor", "1", 0.97, 1.03, 1.0), reading=lambda k, _, value: k * value),
        # of one campaign alone it is the length scale
        _read("campaign_offset", *offsets, reading=by_campaign) if len(campaigns) > 1 else None,
    )


def _numerics(test):
    """Shortcuts of the model: what disappears, or would, when they are taken back."""
    margin, finer = test.margin, {"iterations": 2 * test.iterations, "tolerance": test.tolerance / 2}
    thinner = -margin if margin > 0 else 0.008
    return (
        _switch("time_step", "factor", 0.5, time_step=test.time_step / 2),
        _switch("iterations", "factor", 2.0, **finer),
        _switch("convex_hull_shape", shape="pieces" if test.shape == "hull" else "hull"),
        _simulated("margin_offset", _number("offset", "Dn", -margin, 0.02, 0.0, -margin), thinner, _set("margin", plus=margin)),
        _simulated(
            "damping", _number("linear", "1", 0.0, 1.0, test.linear_damping), 0.1, _set("linear_damping", "angular_damping")
        ),
        _switch("friction_combination", friction=test.friction * test.friction) if test.friction > 0 else None,
        _switch("friction_pyramid", solver="sequential_impulse") if test.solver != "sequential_impulse" else None,
    )


# ---- candidates of one sort -----------------------------------------------------------------------------------------------
def _near(stated, most=None):
    """A coefficient of contact, which is near to what was typed."""
    return Free("coefficient", "1", stated - NEAR, stated + NEAR, stated, stated, ends=(0.0, most))


def _number(name, unit, low, high, null, least=None, most=None):
    """A number that is absent at its null value; least, most: where its law ends, if not at a bound of zero."""
    return Free(name, unit, low, high, null, null, ends=(least, most))


def _read(name, *numbers, reading, kind=Facts):
    """A candidate that changes the reading alone."""
    return LayerCandidate(name, kind, numbers, reading=reading)


def _simulated(name, number, step, change, reading=None):
    """A candidate of one number that is first simulated a step from its null value."""
    return LayerCandidate(name, Facts, (number,), change=change, reading=reading, step=step)


def _setting(name, number, step, field=None):
    """A candidate that is one setting of the test, absent at its present value."""
    return _simulated(name, number, step, _set(field or name))


def _switch(name, constant="switch", value=1.0, **settings):
    """A candidate that sets fields of the test to other values."""
    return LayerCandidate(name, Facts, (), change=lambda test: replace(test, **settings), constants=((constant, value),))


def _contact_law(test, law, part, **given):
    """A law of contact at its one number; None where the test has that law. part: of its range, where it is tried."""
    known = next(parameter for parameter in parameters(law).values() if parameter.null is not None)
    radius = (3.0 * test.unit.volume / (4.0 * np.pi)) ** (1.0 / 3.0)
    scale = radius if known.bounds_in == "radius" else 1.0
    low, high = known.low * scale, known.high * scale

    def change(test, value):  # at its null value the law is not even there
        return replace(test, effects=(*test.effects, law(**given, **{known.name: value}))) if value != known.null else test

    if any(isinstance(effect, law) for effect in test.effects):
        return None
    unit, ends = "1" if known.unit == "-" else known.unit, (known.least, known.most)
    number = Free(known.name, unit, low, high, known.null, known.null, ends=ends)
    return LayerCandidate(name_of(law), law, (number,), change=change, step=part * (high - known.null))


# ---- what they change -----------------------------------------------------------------------------------------------------
def _set(*fields, plus=0.0):
    """Set fields of the test to value + plus."""
    return lambda test, value: replace(test, **dict.fromkeys(fields, value + plus))


def _tilt_bottom(test, value):
    """A flat or sloped bottom that rises by `value` more along y."""
    if not isinstance(test.bottom, Flat | Slope):
        return test
    grade = getattr(test.bottom, "grade", 0.0) + value
    return replace(test, bottom=Slope(grade) if grade else Flat())


def _widen_grid(test, value):
    grid, factor = test.grid, 1 + value
    return replace(test, grid=Grid(grid.name, grid.spacing_x * factor, grid.spacing_y * factor, grid.triangular, grid.stacking))


def _raise_first(coefficients, shift):
    """The first layer `shift` thicker."""
    return coefficients + shift * (np.arange(coefficients.shape[-1]) == 0)
