"""Armour units: their solids, their nominal diameter, and how they rest on a flat bottom.

A unit has one face for all the laboratory: side, volume, nominal_diameter, mass(density), shape("pieces" | "hull"),
low_poses(), tip_poses(), rest_height, first_layer_coefficient, first_layer_orientation(heading, roll_choice).
Lengths in metres, orientations as quaternions (w, x, y, z), body axes along the edges of the cube.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import permutations, product
from math import atan2, cbrt, hypot, isfinite, pi

import numpy as np

from minibullet import rotations
from minibullet.errors import InputError, if_alike
from minibullet.shapes.primitives import Box, Compound, ConvexPiece
from minibullet.values import Named

CONCRETE = 2300.0  # kg/m3, the density used by the paper


class Unit(Named):
    """What every armour unit does; a unit defines its side, relative volume, pieces, hull and the poses on its faces."""

    name = "unit"
    relative_volume = 1.0  # V / L^3

    @property
    def volume(self):
        """Volume of the true unit [m3]."""
        return self.relative_volume * self.side * self.side * self.side

    @property
    def nominal_diameter(self):
        """Edge of the cube of equal volume [m]: Dn = V^(1/3)."""
        # The root of the relative volume: a side scaled by a power of two scales Dn exactly.
        return cbrt(self.relative_volume) * self.side

    def mass(self, density=CONCRETE):
        """Mass of the unit [kg] at a density [kg/m3]."""
        return density * self.volume

    def facts(self, density=CONCRETE):
        """What the unit is, as plain values: its name, volume [m3], and mass at a density [kg/m3]."""
        return {"name": self.name, "volume_m3": self.volume, "mass_kg": self.mass(density)}

    def shape(self, which="pieces"):
        """The solid for the engine: "pieces", the true unit, or "hull", its convex hull."""
        if which == "pieces":
            return self.pieces
        if which == "hull":
            return self.hull
        told = "give 'pieces' (the true unit) or 'hull' (its convex hull)"
        raise InputError(f"{self.name}: shape = {which!r}; {told}{if_alike(which, ('pieces', 'hull'))}")

    @property
    def first_layer_coefficient(self):
        """Theoretical k of a first layer on a flat bottom: height of the unit in its low pose over Dn [-]."""
        return self.low_height / self.nominal_diameter

    def first_layer_orientation(self, heading, roll_choice=0):
        """Low pose number roll_choice (0 to 23), turned about the vertical by heading [rad]. -> (4,)."""
        poses = self.low_poses()
        if roll_choice not in range(len(poses)):
            raise InputError(f"{self.name}: roll_choice = {roll_choice!r}; the low poses are numbered 0 to {len(poses) - 1}")
        return rotations.product(rotations.exponential([0.0, 0.0, heading]), poses[int(roll_choice)])

    def low_poses(self):
        """The 24 orientations of lowest rest, (24, 4): the pose below after each of the cube's own 24 turns.

        A unit with the symmetry of the cube looks the same in all of them; only a heading makes a difference.
        """
        return _after_every_symmetry(self._low_pose())

    def tip_poses(self):
        """The 6 orientations that stand on the middle of a cube face, (6, 4): the cube's axis -z, +z, -y, ... down."""
        down = np.array([(0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0)], dtype=float)
        return rotations.between(down, np.array([0.0, 0.0, -1.0]))


@dataclass(frozen=True, init=False)
class Cubipod(Unit):
    """Cube with a truncated square pyramid on each face: reconstructed, to be confirmed against the Cubipod Manual.

    side: L of the cube, 1 m where nothing is given [m]; nominal_diameter: Dn, in place of the side [m]; protrusion_height,
    protrusion_base, protrusion_top: of the pyramids [L]. The defaults are the only simple fractions which fit Dn = 1.07 m for L
    = 1 m and the first layer coefficient 1.298 of the paper (section 4): volume 39/32 L^3, Dn = 1.0682 L.
    """

    side: float
    protrusion_height: float = 0.25
    protrusion_base: float = 0.50
    protrusion_top: float = 0.25

    name = "cubipod"

    def __init__(self, side=None, nominal_diameter=None, protrusion_height=0.25, protrusion_base=0.50, protrusion_top=0.25):
        fractions = {"protrusion_height": protrusion_height, "protrusion_base": protrusion_base, "protrusion_top": protrusion_top}
        for field, value in fractions.items():
            _check_positive(self.name, field, value, "a finite number > 0, in units of the side")
            object.__setattr__(self, field, float(value))
        if not protrusion_top <= protrusion_base <= 1.0:
            raise InputError(
                f"cubipod: protrusion_base = {protrusion_base}, protrusion_top = {protrusion_top}; "
                "a protrusion narrows outwards on a face of side 1: top <= base <= 1"
            )
        object.__setattr__(self, "side", _side(self.name, side, nominal_diameter, cbrt(self.relative_volume)))

    @property
    def relative_volume(self):
        """Cube and six frusta over the cube: 1 + 6 h/3 (b^2 + b t + t^2) [-]."""
        h, b, t = self.protrusion_height, self.protrusion_base, self.protrusion_top
        return 1.0 + 2.0 * h * (b * b + b * t + t * t)

    @cached_property
    def pieces(self):
        """The exact solid: a Compound of the cube and six frusta."""
        return Compound((ConvexPiece(_cube_corners(self.side)), *(ConvexPiece(corners) for corners in self._frusta())))

    @cached_property
    def hull(self):
        """Convex hull of the unit: 36 % more volume, the hollows between the protrusions filled."""
        return ConvexPiece(np.concatenate([_cube_corners(self.side), *(corners[4:] for corners in self._frusta())]))

    def _frusta(self):
        """Corners (8, 3) of each protrusion: four at the base, four at the top."""
        squares = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
        base = np.column_stack([np.full(4, 0.5), self.protrusion_base * squares])
        top = np.column_stack([np.full(4, 0.5 + self.protrusion_height), self.protrusion_top * squares])
        frustum = self.side * np.concatenate([base, top])
        return [sign * np.roll(frustum, axis, axis=1) for axis in range(3) for sign in (1.0, -1.0)]

    @property
    def _low_normal(self):
        """(x, z) of the outward normal of the hull face between the cube edge and the tip edge that face +x, +z."""
        rise, run = self.protrusion_height, 0.5 * (1.0 - self.protrusion_top)
        return rise / hypot(rise, run), run / hypot(rise, run)

    @property
    def rest_height(self):
        """Height of the centre over the bottom in the low pose [m]."""
        return 0.5 * sum(self._low_normal) * self.side

    @property
    def low_height(self):
        """Height of the top over the bottom in the low pose [m]; the top is the same face as the bottom."""
        return 2.0 * self.rest_height

    @property
    def tip_rest_height(self):
        """Height of the centre over the bottom when standing on a protrusion [m]."""
        return (0.5 + self.protrusion_height) * self.side

    @property
    def low_tipping_angle(self):
        """Tilt that turns the low pose over its cube edge into its twin [rad]."""
        x, z = self._low_normal
        return atan2(0.5 * (z - x), 0.5 * (z + x))

    @property
    def tip_tipping_angle(self):
        """Tilt that turns the unit off its protrusion [rad]."""
        return atan2(0.5 * self.protrusion_top * self.side, self.tip_rest_height)

    def _low_pose(self):
        """Bottom on the trapezoid between a cube edge and the parallel tip edge; the horizontal tip axis lies along x."""
        x, z = self._low_normal
        world_x, world_z = np.array([0.0, 1.0, 0.0]), -np.array([x, 0.0, z])  # in body axes
        return rotations.from_matrix(np.array([world_x, np.cross(world_z, world_x), world_z]))


@dataclass(frozen=True, init=False)
class Cube(Unit):
    """A plain cube. side: 1 m where nothing is given [m]; nominal_diameter: the same, in its place [m]."""

    side: float

    name = "cube"

    def __init__(self, side=None, nominal_diameter=None):
        object.__setattr__(self, "side", _side(self.name, side, nominal_diameter, 1.0))

    @cached_property
    def pieces(self):
        return Box(self.side, self.side, self.side)

    @property
    def hull(self):
        return self.pieces

    @property
    def rest_height(self):
        return 0.5 * self.side

    @property
    def low_height(self):
        return self.side

    tip_rest_height = rest_height

    @property
    def low_tipping_angle(self):
        return 0.25 * pi

    tip_tipping_angle = low_tipping_angle

    def _low_pose(self):
        return rotations.IDENTITY


UNITS = {kind.name: kind for kind in (Cubipod, Cube)}  # by the names of [placement] armour


def _side(name, side, nominal_diameter, diameter_of_unit_side):
    """The side [m] from the one of the two lengths that was given."""
    if side is not None and nominal_diameter is not None:
        raise InputError(f"{name}: side = {side} and nominal_diameter = {nominal_diameter}; give one of the two")
    if nominal_diameter is not None:
        _check_positive(name, "nominal_diameter", nominal_diameter, "a finite length > 0 in metres")
        return nominal_diameter / diameter_of_unit_side
    side = 1.0 if side is None else side
    _check_positive(name, "side", side, "a finite length > 0 in metres")
    return float(side)


def _check_positive(name, field, value, rule):
    if isinstance(value, str | bool) or not (isfinite(value) and value > 0):
        raise InputError(f"{name}: {field} = {value!r}; must be {rule}")


def _cube_corners(side):
    """(8, 3) corners of a cube about the origin."""
    return side * np.array(list(product((-0.5, 0.5), repeat=3)))


def _after_every_symmetry(pose):
    """The pose after each of the 24 turns that map a cube onto itself, the identity first. (4,) -> (24, 4)."""
    signs = list(product((1.0, -1.0), repeat=3))
    turns = [np.diag(sign) @ np.eye(3)[list(order)] for order in permutations(range(3)) for sign in signs]
    turns = np.array([turn for turn in turns if np.linalg.det(turn) > 0])
    return rotations.product(pose, rotations.from_matrix(turns))
