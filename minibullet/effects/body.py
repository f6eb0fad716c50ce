"""Forces on the mass of a body."""

from dataclasses import dataclass
from functools import cached_property
from math import cos, hypot, inf, pi, sin

import numpy as np

from minibullet.effects.contract import Effect, Need, parameter
from minibullet.errors import InputError

STANDARD_GRAVITY = 9.81  # the value used throughout this project; measured on Earth 9.78 to 9.83 [m/s2]


def unit_vector(vector) -> np.ndarray:
    """A direction given by any three numbers, at length 1, (3,); InputError where it has none."""
    try:
        x, y, z = map(float, vector)
        length = hypot(x, y, z)
    except (TypeError, ValueError):
        length = 0.0
    if not 0.0 < length < inf:
        raise InputError(f"a direction must be three finite numbers, not all zero; got {vector!r}")
    return np.array([x / length, y / length, z / length])


def force_only(force) -> np.ndarray:
    """The wrench of forces (n, 3) through the centres of mass, (n, 6)."""
    wrench = np.zeros((len(force), 6))
    wrench[:, :3] = force
    return wrench


class ConstantForce(Effect):
    """What effects share whose force depends on nothing that moves: its potential energy is -F . x."""

    def potential(self, bodies):
        return -float((self.forces(bodies, 0.0)[:, :3] * bodies.position).sum())


@dataclass(frozen=True)
class Gravity(ConstantForce):
    """Uniform gravity. Newton's law of gravitation near the ground."""

    acceleration: float = parameter(
        STANDARD_GRAVITY,
        unit="m/s2",
        low=9.78,
        high=9.83,
        null=0.0,
        given=True,
        source="9.78 (equator) to 9.83 (pole): WGS 84",
        symbol="g",
        about="acceleration of gravity",
        typical=((9.81, "middle latitudes, at sea level"),),
    )
    direction: tuple = (0.0, 0.0, -1.0)  # where things fall to, any length, world frame, (3,) [-]
    formula = "F = m g d"
    isotropic = False

    @cached_property
    def field(self):
        """The field strength of gravity, world frame (3,) [m/s2]."""
        return self.acceleration * unit_vector(self.direction)

    def forces(self, bodies, time):
        return force_only(bodies.mass[:, None] * self.field)


# of an axis that somebody levelled: there is nothing beyond half a turn
LEVELLED = {
    "unit": "rad",
    "low": -0.05,
    "high": 0.05,
    "least": -pi,
    "most": pi,
    "null": 0.0,
    "source": "levelling by eye: within 3 degrees",
}
HARDLY_SEEN = ((0.0087, "half a degree, hardly seen by eye"),)


@dataclass(frozen=True)
class TiltedGravity(ConstantForce):
    """The world is level but the world's z axis is not: what is to be added to Gravity downwards.

    Gravity is turned about the x axis, then about the y axis.
    For small angles the acceleration is g (-angle_y, angle_x, 0), the same for all bodies.
    """

    angle_x: float = parameter(0.0, **LEVELLED, about="of the world about its x axis", typical=HARDLY_SEEN)
    angle_y: float = parameter(0.0, **LEVELLED, about="of the world about its y axis, after the first")
    acceleration: float = parameter(STANDARD_GRAVITY, unit="m/s2", given=True, symbol="g", about="acceleration of gravity")
    plain = "a z axis that is not vertical"
    formula = "F = m g (R_y(angle_y) R_x(angle_x) e - e), e = (0, 0, -1)"
    symbols = {"R_x": "turn about the x axis", "R_y": "turn about the y axis", "e": "direction of gravity in a level world"}
    looks_like = "A body drifts sideways in free flight, as 1/2 g angle t^2, the same way for all bodies and in all throws."
    confused_with = ("bottom_slope",)
    isotropic = False
    group = "measurement"
    alike = "tilt"
    needs = (Need.SIDEWAYS,)

    @property
    def turned_minus_level(self):
        """Direction of gravity less (0, 0, -1), (3,)."""
        a, b = self.angle_x, self.angle_y
        return np.array([-sin(b) * cos(a), sin(a), 1.0 - cos(a) * cos(b)])

    @cached_property
    def field(self):
        """What is to be added to the field strength of Gravity, world frame (3,) [m/s2]."""
        return self.acceleration * self.turned_minus_level

    def forces(self, bodies, time):
        return force_only(bodies.mass[:, None] * self.field)
