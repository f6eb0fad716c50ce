"""What may be missing from a model of layers: each candidate changes the placement test, or how its layers are read.

A candidate has one number with its bounds, its null value in the model under test, and the value that it is simulated at. Groups
and names are those of the effects library. A new candidate is one entry in the function of its family; a family is what a verdict
on layers can tell apart.
"""

import difflib
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hlcs.effects import Free
from hlcs.effects import set_of as library_set
from hlcs.placement.grids import Grid
from hlcs.placement.sea_bottom import Flat, Slope
from minibullet import effects
from minibullet.effects.contract import name_of, parameters
from minibullet.errors import InputError

TIP_OVER_LOW = 1.40428 - 1.29826  # how much higher a unit stands on a tip than in its lowest pose [Dn]

ALIKE = {"plate_bias": "rest_height", "settlement": "rest_height"}  # of what is no class of effects: label of its set


@dataclass(frozen=True)
class LayerCandidate:
    """One thing that may be missing.

    change: (PlacementTest, value) -> PlacementTest; reading: (k (M,), value, LayerSet) -> k as it would be read. One or both.
    A switch is either there (value 1) or not (0).
    """

    name: str
    number: Free  # it has one; `start` is the value at which it is simulated
    change: Callable | None = None
    reading: Callable | None = None
    switch: bool = False
    campaign: str = ""  # name of the campaign it belongs to, where it has one
    removed_at: float | None = None  # bound at which a shortcut of the model is taken back: no sign of a wrong candidate
    family: str = ""  # "physics", "placement", "measurement" or "numerics"

    @property
    def key(self):
        """What tells it from all others."""
        return self.name, self.campaign

    @property
    def simulated(self):
        """Whether its signature needs simulations."""
        return self.change is not None

    @property
    def step(self):
        return self.number.start - self.number.null

    def applied(self, test, value):
        """The test with the candidate at this value."""
        return self.change(test, value) if self.change else test

    def read(self, coefficients, value, measured_set):
        """Layer coefficients as they would be read with the candidate at this value."""
        return self.reading(coefficients, value, measured_set) if self.reading else coefficients


def library(test, sets):
    """(LayerCandidate, ...) of all that fit a model under test (a PlacementTest) and the measured sets, by name."""
    families = {
        "physics": (*_physics(test), *_contact_laws(test)),
        "placement": _placement(test),
        "measurement": _measurement(sets),
        "numerics": _numerics(test),
    }
    candidates = [replace(member, family=family) for family, members in families.items() for member in members if member]
    return tuple(sorted(candidates, key=lambda candidate: candidate.key))


def named(name, test, sets):
    """The candidates of that name; InputError with the nearest known name."""
    known = library(test, sets)
    candidates = tuple(candidate for candidate in known if candidate.name == name)
    if not candidates:
        near = difflib.get_close_matches(name, sorted({candidate.name for candidate in known}), n=1, cutoff=0.0)[0]
        raise InputError(f"effect '{name}' does not fit layer data; the nearest that does is '{near}'")
    return candidates


def set_of(name):
    """Label of the set of look-alikes that a candidate belongs to, or an empty text."""
    return ALIKE.get(name) or library_set(name)


# ---- the candidates by family: name, number (unit, lowest, highest, null, trial value), what they change; None = does not fit
def _physics(test):
    """Settings of the physics, sizes and slopes that are not what the file says, and what weight does after placing."""
    now, friction = test.restitution, test.friction
    weight = 9.81 * test.unit.mass(test.density)
    sinking = weight / test.unit.nominal_diameter  # of a point of unit compliance under one unit's weight [Dn N/m]
    softest = 0.01 * test.unit.side / weight
    level = isinstance(test.bottom, Flat | Slope)  # a survey has the roughness of the bed itself
    rough = test.bottom_roughness
    return (
        _setting(test, "restitution", "coefficient", "1", 0.0, 1.0, now + 0.3 if now <= 0.5 else now - 0.3),
        _setting(test, "friction", "coefficient", "1", 0.0, 1.5, friction * friction if friction >= 0.3 else friction + 0.2),
        _setting(test, "inertia_error", "factor", "1", 0.5, 4.0, 2.06 * test.inertia_factor, "inertia_factor"),
        _setting(test, "bottom_roughness", "standard_deviation", "Dn", 0.0, 0.1, rough + 0.04) if level else None,
        LayerCandidate("bottom_slope", Free("grade_y", "1", -0.1, 0.1, 0.0, 0.03), _tilt_bottom),
        LayerCandidate(  # in units of their own size, larger units on the same grid have a narrower one
            "size_error",
            Free("relative", "1", -0.02, 0.02, 0.0, -0.02),
            change=lambda test, value: _widen_grid(test, 1.0 / (1.0 + value) - 1.0),
            reading=lambda k, value, _: k * (1.0 + value),
        ),
        LayerCandidate(
            "settlement", Free("instant", "Dn", 0.0, 0.1, 0.0, 0.02), reading=lambda k, value, _: _raise_first(k, -value)
        ),
        LayerCandidate(  # every layer loads the ground by as much again
            "ground_softness",
            Free("compliance", "m/N", 0.0, softest, 0.0, 0.5 * softest),
            reading=lambda k, value, _: k - value * sinking,
        ),
        LayerCandidate(
            "contact_compliance",
            Free("compliance", "m/N", 0.0, softest, 0.0, 0.5 * softest),
            reading=lambda k, value, _: k - value * sinking / 3.0 * np.arange(1.0, k.shape[-1] + 1.0),
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
    distance = test.falling_distance
    return (
        _setting(test, "placement_scatter", "standard_deviation", "Dn", 0.0, 0.3, test.placement_scatter + 0.15),
        _setting(test, "placement_offset", "y", "Dn", -0.3, 0.3, test.placement_offset_y + 0.1, "placement_offset_y"),
        _setting(test, "yaw_constraint", "concentration", "1", 0.0, 50.0, test.yaw_constraint + 10.0),
        _setting(test, "lost_units", "fraction", "1", 0.0, 0.1, test.lost_units + 0.05),
        _setting(test, "vibration", "acceleration", "g", 0.0, 1.0, test.vibration + 0.3),
        _setting(test, "falling_distance", "distance", "Dn", 0.0, 0.5, distance + 0.25 if distance <= 0.25 else distance - 0.2),
        None if test.sequential_placement else _switch("sequential_placement", "sequential_placement", True),
        None if test.loose_lower_layers else _switch("loose_lower_layers", "loose_lower_layers", True),
        LayerCandidate("grid_spacing", Free("relative", "1", -0.03, 0.03, 0.0, 0.02), _widen_grid),
        LayerCandidate(
            "orientation_bias",
            Free("fraction", "1", 0.0, 1.0, 1.0, 0.9),
            reading=lambda k, value, _: _raise_first(k, (1.0 - value) * TIP_OVER_LOW),
        ),
    )


def _measurement(sets):
    """How layers are read."""
    campaigns = tuple(dict.fromkeys(measured_set.campaign for measured_set in sets))
    return (
        LayerCandidate(
            "plate_bias", Free("offset", "Dn", -0.05, 0.05, 0.0, 0.02), reading=lambda k, value, _: _raise_first(k, value)
        ),
        LayerCandidate("length_scale", Free("factor", "1", 0.9, 1.1, 1.0, 1.02), reading=lambda k, value, _: k * value),
        *(
            LayerCandidate(
                "campaign_offset",
                Free("offset", "1", -0.03, 0.03, 0.0, 0.02),
                reading=_scale_campaign(campaign),
                campaign=campaign,
            )
            for campaign in (campaigns if len(campaigns) > 1 else ())  # of one campaign alone it is the length scale
        ),
    )


def _numerics(test):
    """Shortcuts of the model: what disappears, or would, when they are taken back."""
    margin, damping = test.margin, test.linear_damping
    return (
        LayerCandidate(
            "time_step", Free("factor", "1", 0.125, 1.0, 1.0, 0.5), _set("time_step", times=test.time_step), switch=True
        ),
        LayerCandidate(
            "iterations",
            Free("factor", "1", 1.0, 16.0, 1.0, 2.0),
            change=lambda now, value: replace(now, iterations=round(value * test.iterations), tolerance=test.tolerance / value),
            switch=True,
        ),
        _switch("convex_hull_shape", "shape", "pieces" if test.shape == "hull" else "hull"),
        LayerCandidate(
            "margin_offset",
            Free("offset", "Dn", -margin, 0.02, 0.0, -margin if margin > 0 else 0.008),
            change=_set("margin", plus=margin),
            removed_at=-margin,
        ),
        LayerCandidate(
            "damping", Free("linear", "1", 0.0, 1.0, damping, damping + 0.1), _set("linear_damping", "angular_damping")
        ),
        _switch("friction_combination", "friction", test.friction * test.friction, "product") if test.friction > 0 else None,
        _switch("friction_pyramid", "solver", "sequential_impulse") if test.solver != "sequential_impulse" else None,
    )


# ---- candidates of one sort -----------------------------------------------------------------------------------------------
def _setting(test, name, number, unit, low, high, trial, field=None):
    """A candidate that is one setting of the test, absent at its present value."""
    return LayerCandidate(name, Free(number, unit, low, high, getattr(test, field or name), trial), _set(field or name))


def _switch(name, field, value, number="switch"):
    """A candidate that sets a field of the test to a value or leaves it alone."""

    def change(test, there):
        return replace(test, **{field: value}) if there else test

    return LayerCandidate(name, Free(number, "1", 0.0, 1.0, 0.0, 1.0), change, switch=True)


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
    unit, trial = "1" if known.unit == "-" else known.unit, known.null + part * (high - known.null)
    return LayerCandidate(name_of(law), Free(known.name, unit, low, high, known.null, trial), change)


# ---- what they change -----------------------------------------------------------------------------------------------------
def _set(*fields, times=1.0, plus=0.0):
    """Set fields of the test to times * value + plus."""
    return lambda test, value: replace(test, **dict.fromkeys(fields, times * value + plus))


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


def _scale_campaign(campaign):
    """What was measured in one campaign is thicker by a factor."""
    return lambda k, value, measured_set: k * (1.0 + value if measured_set.campaign == campaign else 1.0)
