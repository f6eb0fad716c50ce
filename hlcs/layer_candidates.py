"""What may be missing from a model of layers: each candidate changes the placement test, or what was read off it.

A candidate has one number with its bounds, its null value in the model at hand, and the value it is tried at. Groups and names
are those of the effects library; a family is what a verdict on layers can tell apart.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hlcs.bottoms import Flat, Slope
from hlcs.grids import Grid
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


def library(test, sets):
    """{name: LayerCandidate} of all that fit a model under test (a PlacementTest) and the measured sets."""
    friction, fall = test.friction, test.falling_distance
    product = friction * friction
    rows = [
        LayerCandidate(
            "time_step", "numerics", "factor", "1", 0.125, 1.0, 1.0, 0.5, _setting("time_step", times=test.time_step), switch=True
        ),
        LayerCandidate("iterations", "numerics", "factor", "1", 1.0, 16.0, 1.0, 2.0, _more_iterations(test), switch=True),
        LayerCandidate("convex_hull_shape", "numerics", "switch", "1", 0.0, 1.0, 0.0, 1.0, _other_shape(test), switch=True),
        LayerCandidate(
            "margin_offset",
            "numerics",
            "offset",
            "Dn",
            -test.margin,
            0.02,
            0.0,
            -test.margin if test.margin > 0 else 0.008,
            _setting("margin", plus=test.margin),
            gone=-test.margin,
        ),
        LayerCandidate(
            "friction",
            "physics",
            "coefficient",
            "1",
            0.0,
            1.5,
            friction,
            product if friction >= 0.3 else friction + 0.2,
            _setting("friction"),
        ),
        LayerCandidate(
            "restitution",
            "physics",
            "coefficient",
            "1",
            0.0,
            1.0,
            test.restitution,
            test.restitution + (0.3 if test.restitution <= 0.5 else -0.3),
            _setting("restitution"),
        ),
        LayerCandidate("bottom_slope", "physics", "grade_y", "1", -0.1, 0.1, 0.0, 0.03, _tilt_bottom),
        LayerCandidate("settlement", "physics", "instant", "Dn", 0.0, 0.1, 0.0, 0.02, look=_first_layer(-1.0)),
        LayerCandidate(
            "size_error",
            "physics",
            "relative",
            "1",
            -0.02,
            0.02,
            0.0,
            -0.02,
            _bigger_units,
            lambda k, value, one: k * (1.0 + value),
        ),
        LayerCandidate(
            "damping",
            "numerics",
            "linear",
            "1",
            0.0,
            1.0,
            test.linear_damping,
            test.linear_damping + 0.1,
            lambda test, value: replace(test, linear_damping=value, angular_damping=value),
        ),
        LayerCandidate(
            "falling_distance",
            "placement",
            "distance",
            "Dn",
            0.0,
            0.5,
            fall,
            fall + 0.25 if fall <= 0.25 else fall - 0.2,
            lambda test, value: replace(test, falling_distance=max(value, 0.01)),
        ),
        LayerCandidate("grid_spacing", "placement", "relative", "1", -0.03, 0.03, 0.0, 0.02, _wider_grid),
        LayerCandidate(
            "placement_scatter",
            "placement",
            "standard_deviation",
            "Dn",
            0.0,
            0.3,
            test.placement_scatter,
            test.placement_scatter + 0.15,
            _setting("placement_scatter"),
        ),
        LayerCandidate(
            "placement_offset",
            "placement",
            "y",
            "Dn",
            -0.3,
            0.3,
            test.placement_offset_y,
            test.placement_offset_y + 0.1,
            _setting("placement_offset_y"),
        ),
        LayerCandidate(
            "yaw_constraint",
            "placement",
            "concentration",
            "1",
            0.0,
            50.0,
            test.yaw_constraint,
            test.yaw_constraint + 10.0,
            _setting("yaw_constraint"),
        ),
        LayerCandidate(
            "lost_units", "placement", "fraction", "1", 0.0, 0.1, test.lost_units, test.lost_units + 0.05, _setting("lost_units")
        ),
        LayerCandidate(
            "orientation_bias",
            "placement",
            "fraction",
            "1",
            0.0,
            1.0,
            1.0,
            0.9,
            look=lambda k, value, one: _on_first(k, (1.0 - value) * TIP_OVER_LOW),
        ),
        LayerCandidate("plate_bias", "measurement", "offset", "Dn", -0.05, 0.05, 0.0, 0.02, look=_first_layer(1.0)),
        LayerCandidate("length_scale", "measurement", "factor", "1", 0.9, 1.1, 1.0, 1.02, look=lambda k, value, one: k * value),
    ]
    if test.friction > 0:
        rows.append(
            LayerCandidate(
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
        )
    campaigns = tuple(dict.fromkeys(one.campaign for one in sets))
    if len(campaigns) > 1:  # of one campaign alone it is the length scale
        rows += [
            LayerCandidate(
                "campaign_offset",
                "measurement",
                "offset",
                "1",
                -0.03,
                0.03,
                0.0,
                0.02,
                look=_of_campaign(campaign),
                needs=campaign,
            )
            for campaign in campaigns
        ]
    return tuple(sorted(rows, key=lambda row: (row.name, row.needs)))


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
