"""What may be missing from a model of layers: each candidate changes the placement test, or what was read off it.

A candidate has one number with its bounds, its null value in the model at hand, and the value it is tried at. Groups and names
are those of the effects library; a family is what a verdict on layers can tell apart.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hlcs.effects import set_of as library_set
from hlcs.placement.grids import Grid
from hlcs.placement.sea_bottom import Flat, Slope
from minibullet import effects
from minibullet.effects.contract import name_of, parameters
from minibullet.errors import InputError

TIP_OVER_LOW = 1.40428 - 1.29826  # how much higher a unit stands on a tip than in its lowest pose [Dn]


@dataclass(frozen=True)
class LayerCandidate:
    """One thing that may be missing.

    change: (PlacementTest, value) -> PlacementTest; look: (k (M,), value, LayerSet) -> k as it would be read. One or both.
    A switch is either there (value 1) or not (0).
    """

    name: str
    family: str  # "physics", "placement", "measurement" or "numerics"
    number: str  # name of its parameter
    unit: str
    low: float
    high: float
    null: float
    trial: float  # value at which it is simulated
    change: Callable | None = None
    look: Callable | None = None
    switch: bool = False
    needs: str = ""  # name of the campaign it belongs to, where it has one
    gone: float | None = None  # bound at which a shortcut of the model is taken back altogether: no sign of a wrong candidate

    @property
    def simulated(self):
        """Whether its signature needs simulations."""
        return self.change is not None

    @property
    def step(self):
        return self.trial - self.null

    def applied(self, test, value):
        """The test with the candidate at this value."""
        return self.change(test, value) if self.change else test

    def read(self, coefficients, value, one):
        """Layer coefficients as they would be read with the candidate at this value."""
        return self.look(coefficients, value, one) if self.look else coefficients


# Candidates that are one setting of the test: family, number, unit, lowest, highest, field, trial value from the present one.
SETTINGS = {
    "restitution": ("physics", "coefficient", "1", 0.0, 1.0, "restitution", lambda now: now + 0.3 if now <= 0.5 else now - 0.3),
    "friction": ("physics", "coefficient", "1", 0.0, 1.5, "friction", lambda now: now * now if now >= 0.3 else now + 0.2),
    "inertia_error": ("physics", "factor", "1", 0.5, 4.0, "inertia_factor", lambda now: 2.06 * now),
    "bottom_roughness": ("physics", "standard_deviation", "Dn", 0.0, 0.1, "bottom_roughness", lambda now: now + 0.04),
    "placement_scatter": ("placement", "standard_deviation", "Dn", 0.0, 0.3, "placement_scatter", lambda now: now + 0.15),
    "placement_offset": ("placement", "y", "Dn", -0.3, 0.3, "placement_offset_y", lambda now: now + 0.1),
    "yaw_constraint": ("placement", "concentration", "1", 0.0, 50.0, "yaw_constraint", lambda now: now + 10.0),
    "lost_units": ("placement", "fraction", "1", 0.0, 0.1, "lost_units", lambda now: now + 0.05),
    "vibration": ("placement", "acceleration", "g", 0.0, 1.0, "vibration", lambda now: now + 0.3),
    "falling_distance": (
        "placement",
        "distance",
        "Dn",
        0.0,
        0.5,
        "falling_distance",
        lambda now: now + 0.25 if now <= 0.25 else now - 0.2,
    ),
}
SWITCHES = {  # settings that are there or not: family, field, its value when the candidate is in
    "sequential_placement": ("placement", "sequential_placement", True),
    "loose_lower_layers": ("placement", "loose_lower_layers", True),
    "friction_pyramid": ("numerics", "solver", "sequential_impulse"),
}
# Laws of contact from the engine's library, at one number each: where between its null value and its upper bound it is tried.
CONTACT = {
    effects.StaticFriction: 0.5,
    effects.StribeckFriction: 0.5,
    effects.ViscousFriction: 0.3,
    effects.LoadDependentFriction: 0.5,
    effects.AnisotropicFriction: 0.5,
    effects.RollingFriction: 0.5,
    effects.SpinningFriction: 0.5,
    effects.Adhesion: 0.3,
    effects.VelocityDependentRestitution: 0.8,
}
ALIKE = {"plate_bias": "rest_height", "settlement": "rest_height"}  # of what is no class of effects: label of its set


def set_of(name):
    """Label of the set of look-alikes that a candidate belongs to, or an empty text."""
    return ALIKE.get(name) or library_set(name)


def library(test, sets):
    """(LayerCandidate, ...) of all that fit a model under test (a PlacementTest) and the measured sets, by name."""
    rows = [*_settings(test), *_laws(test), *_shortcuts(test), *_sizes(), *_readings(test, sets)]
    return tuple(sorted(rows, key=lambda row: (row.name, row.needs)))


def _settings(test):
    """What is a setting of the test."""
    for name, (family, number, unit, low, high, field, trial) in SETTINGS.items():
        now = getattr(test, field)
        if name == "bottom_roughness" and not isinstance(test.bottom, Flat | Slope):
            continue  # a survey has the bed's own
        yield LayerCandidate(name, family, number, unit, low, high, now, trial(now), _setting(field))
    for name, (family, field, there) in SWITCHES.items():
        if getattr(test, field) != there:
            yield LayerCandidate(name, family, "switch", "1", 0.0, 1.0, 0.0, 1.0, _switch(field, there), switch=True)


def _laws(test):
    """Laws of contact that are not in the test yet."""
    unit = test.unit
    radius = (3.0 * unit.volume / (4.0 * np.pi)) ** (1.0 / 3.0)
    given = {effects.LoadDependentFriction: {"reference_load": 9.81 * unit.mass(test.density) / 3.0}}  # it stands on three points
    for kind, part in CONTACT.items():
        known = next(one for one in parameters(kind).values() if one.null is not None)
        scale = radius if known.bounds_in == "radius" else 1.0
        low, high = known.low * scale, known.high * scale
        without = kind is effects.VelocityDependentRestitution and test.restitution == 0.0  # then it has nothing to act on
        if not without and not any(isinstance(effect, kind) for effect in test.effects):
            unit_name = "1" if known.unit == "-" else known.unit
            trial = known.null + part * (high - known.null)
            yield LayerCandidate(
                name_of(kind),
                "physics",
                known.name,
                unit_name,
                low,
                high,
                known.null,
                trial,
                _law(kind, known.name, known.null, given.get(kind, {})),
            )


def _shortcuts(test):
    """Shortcuts of the model: what disappears, or would, when they are taken back."""
    margin, product = test.margin, test.friction * test.friction
    damping = test.linear_damping
    yield LayerCandidate(
        "time_step", "numerics", "factor", "1", 0.125, 1.0, 1.0, 0.5, _setting("time_step", times=test.time_step), switch=True
    )
    yield LayerCandidate("iterations", "numerics", "factor", "1", 1.0, 16.0, 1.0, 2.0, _more_iterations(test), switch=True)
    yield LayerCandidate("convex_hull_shape", "numerics", "switch", "1", 0.0, 1.0, 0.0, 1.0, _other_shape(test), switch=True)
    yield LayerCandidate(
        "margin_offset",
        "numerics",
        "offset",
        "Dn",
        -margin,
        0.02,
        0.0,
        -margin if margin > 0 else 0.008,
        _setting("margin", plus=margin),
        gone=-margin,
    )
    yield LayerCandidate(
        "damping",
        "numerics",
        "linear",
        "1",
        0.0,
        1.0,
        damping,
        damping + 0.1,
        lambda test, value: replace(test, linear_damping=value, angular_damping=value),
    )
    if test.friction > 0:
        yield LayerCandidate(
            "friction_combination",
            "numerics",
            "product",
            "1",
            0.0,
            1.0,
            0.0,
            1.0,
            lambda test, value: replace(test, friction=product if value else test.friction),
            switch=True,
        )


def _sizes():
    """Lengths and slopes that are not what the file says."""
    yield LayerCandidate("bottom_slope", "physics", "grade_y", "1", -0.1, 0.1, 0.0, 0.03, _tilt_bottom)
    yield LayerCandidate(
        "size_error", "physics", "relative", "1", -0.02, 0.02, 0.0, -0.02, _bigger_units, lambda k, value, one: k * (1.0 + value)
    )
    yield LayerCandidate("grid_spacing", "placement", "relative", "1", -0.03, 0.03, 0.0, 0.02, _wider_grid)


def _readings(test, sets):
    """What changes layer coefficients by arithmetic alone, without another simulation."""
    unit = test.unit
    weight = 9.81 * unit.mass(test.density)
    sinking = weight / unit.nominal_diameter  # of a point of unit compliance under one unit's weight [Dn N/m]
    softest = 0.01 * unit.side / weight
    yield LayerCandidate("settlement", "physics", "instant", "Dn", 0.0, 0.1, 0.0, 0.02, look=_first_layer(-1.0))
    yield LayerCandidate(
        "ground_softness",
        "physics",
        "compliance",
        "m/N",
        0.0,
        softest,
        0.0,
        0.5 * softest,
        look=lambda k, value, one: k - value * sinking,
    )  # every layer loads the ground by as much again
    yield LayerCandidate(
        "contact_compliance",
        "physics",
        "compliance",
        "m/N",
        0.0,
        softest,
        0.0,
        0.5 * softest,
        look=lambda k, value, one: k - value * sinking / 3.0 * np.arange(1.0, k.shape[-1] + 1.0),
    )
    yield LayerCandidate(
        "orientation_bias",
        "placement",
        "fraction",
        "1",
        0.0,
        1.0,
        1.0,
        0.9,
        look=lambda k, value, one: _on_first(k, (1.0 - value) * TIP_OVER_LOW),
    )
    yield LayerCandidate("plate_bias", "measurement", "offset", "Dn", -0.05, 0.05, 0.0, 0.02, look=_first_layer(1.0))
    yield LayerCandidate("length_scale", "measurement", "factor", "1", 0.9, 1.1, 1.0, 1.02, look=lambda k, value, one: k * value)
    campaigns = tuple(dict.fromkeys(one.campaign for one in sets))
    for campaign in campaigns if len(campaigns) > 1 else ():  # of one campaign alone it is the length scale
        yield LayerCandidate(
            "campaign_offset", "measurement", "offset", "1", -0.03, 0.03, 0.0, 0.02, look=_of_campaign(campaign), needs=campaign
        )


def named(name, test, sets):
    """The candidates of that name; InputError with the nearest known name."""
    import difflib

    known = library(test, sets)
    found = tuple(row for row in known if row.name == name)
    if not found:
        near = difflib.get_close_matches(name, sorted({row.name for row in known}), n=1, cutoff=0.0)[0]
        raise InputError(f"effect '{name}' does not fit layer data; the nearest that does is '{near}'")
    return found


# ------------------------------------------------------------------------------------------------------ what they change
def _setting(name, times=1.0, plus=0.0):
    """Set a field of the test to times * value + plus."""
    return lambda test, value: replace(test, **{name: times * value + plus})


def _switch(name, there):
    """Set a field of the test to the value `there`, or leave it alone."""
    return lambda test, value: replace(test, **{name: there}) if value else test


def _law(kind, number, null, given):
    """Add a law of the engine to the test, at its null value not even that."""
    return lambda test, value: replace(test, effects=(*test.effects, kind(**given, **{number: value}))) if value != null else test


def _more_iterations(base):
    def change(test, value):
        return replace(test, iterations=round(value * base.iterations), tolerance=base.tolerance / value)

    return change


def _other_shape(base):
    other = "pieces" if base.shape == "hull" else "hull"
    return lambda test, value: replace(test, shape=other if value else base.shape)


def _tilt_bottom(test, value):
    """A flat or sloped bottom that rises by `value` more along y."""
    if not isinstance(test.bottom, Flat | Slope):
        return test
    grade = getattr(test.bottom, "grade", 0.0) + value
    return replace(test, bottom=Slope(grade) if grade else Flat())


def _wider_grid(test, value):
    grid = test.grid
    return replace(
        test, grid=Grid(grid.name, grid.spacing_x * (1 + value), grid.spacing_y * (1 + value), grid.triangular, grid.stacking)
    )


def _bigger_units(test, value):
    """Units larger than their nominal size on the same grid: in units of their own size the grid is narrower."""
    return _wider_grid(test, 1.0 / (1.0 + value) - 1.0)


def _on_first(coefficients, shift):
    return coefficients + shift * (np.arange(coefficients.shape[-1]) == 0)


def _first_layer(sign):
    return lambda coefficients, value, one: _on_first(coefficients, sign * value)


def _of_campaign(campaign):
    return lambda coefficients, value, one: coefficients * (1.0 + value if one.campaign == campaign else 1.0)
