"""Shapes of bodies: what they weigh, how they resist turning, and of which convex pieces they are made.

Every shape is a frozen value with
    volume [m3]; centre_of_mass (3,) [m], in the frame the shape was given in; inertia (3, 3) [m5 = kg m2 per kg/m3],
    about the centre of mass; surface_area [m2] (a quarter is the mean projected area); bounding_radius [m], about the
    centre of mass;
    pieces: tuple of ConvexPiece, moved so that the centre of mass is the origin (the axes stay the user's).
Shapes compare and hash by content. Input that makes no solid raises InputError.
"""

from dataclasses import dataclass
from functools import cached_property, reduce
from math import pi, sqrt
from numbers import Integral
from operator import add

import numpy as np

from minibullet.errors import InputError, shown, shown_value
from minibullet.rotations import cosine_and_sine
from minibullet.shapes import polyhedra
from minibullet.shapes.convex import ConvexPiece, check_lengths, farthest, swept_ball, swept_ball_area, weighs
from minibullet.values import Named

# Parts of a compound may overlap by this part of their size: rounding in a file is no mistake of the user.
OVERLAP = 1e-5
MOST_SIDES = 1000  # of a prism for a cylinder: it is then 5e-6 of the radius lower than a round one, and a body rests on it [-]


class Centred(Named):
    """A simple shape given about its centre, which is its centre of mass."""

    @property
    def centre_of_mass(self):
        return np.zeros(3)

    def _check(self, **lengths):
        """InputError where these are no lengths, or none of a solid that can be weighed."""
        name = type(self).__name__.lower()
        check_lengths(name, **lengths)
        if not weighs(self):
            told = ", ".join(f"{field} = {shown_value(value)}" for field, value in lengths.items())
            raise InputError(f"{name}: {told}; its volume and inertia are no numbers that double precision holds; give metres")


class SweptBall(Centred):
    """A ball of ``radius`` swept along a segment of the x axis as long as ``core`` [m]."""

    core = 0.0

    @property
    def volume(self):
        return swept_ball(self.radius, self.core)[0]

    @cached_property
    def inertia(self):
        return np.diag(swept_ball(self.radius, self.core)[1])

    @property
    def surface_area(self):
        return swept_ball_area(self.radius, self.core)

    @property
    def bounding_radius(self):
        return 0.5 * self.core + self.radius

    @cached_property
    def pieces(self):
        ends = (-0.5 * self.core, 0.5 * self.core) if self.core else (0.0,)
        return (ConvexPiece(np.array([(x, 0.0, 0.0) for x in ends]), self.radius),)


@dataclass(frozen=True)
class Sphere(SweptBall):
    """A ball of the given radius [m]."""

    radius: float  # of the ball [m]

    def __post_init__(self):
        self._check(radius=self.radius)


@dataclass(frozen=True)
class Box(Centred):
    """A cuboid with full edge lengths x, y, z [m]."""

    x: float  # edge along x [m]
    y: float  # edge along y [m]
    z: float  # edge along z [m]

    def __post_init__(self):
        self._check(x=self.x, y=self.y, z=self.z)

    @property
    def volume(self):
        return self.x * self.y * self.z

    @cached_property
    def inertia(self):
        squares = np.square([self.x, self.y, self.z])
        return self.volume / 12.0 * np.diag(squares.sum() - squares)

    @property
    def surface_area(self):
        return 2.0 * (self.x * self.y + self.y * self.z + self.z * self.x)

    @property
    def bounding_radius(self):
        return 0.5 * sqrt(self.x * self.x + self.y * self.y + self.z * self.z)

    @cached_property
    def pieces(self):
        signs = np.array([(i, j, k) for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)])
        return (ConvexPiece(signs * (self.x, self.y, self.z)),)


@dataclass(frozen=True)
class Capsule(SweptBall):
    """A ball of the given radius swept along a segment of the given length on the x axis [m]."""

    radius: float  # of the ball [m]
    length: float  # of the segment on the x axis [m]

    def __post_init__(self):
        self._check(radius=self.radius, length=self.length)

    @property
    def core(self):
        return self.length


@dataclass(frozen=True)
class Cylinder(Centred):
    """A round cylinder on the z axis [m]. It weighs what a round one weighs; it touches as a prism with so many sides.

    The prism's corners lie on the circle: lying on a side it is lower by radius (1 - cos(pi/sides)), 0.5 % for 32.
    """

    radius: float  # of the round faces [m]
    height: float  # along z [m]
    sides: int = 32  # of the prism that it touches as [-]

    def __post_init__(self):
        self._check(radius=self.radius, height=self.height)
        if not isinstance(self.sides, Integral) or not 3 <= self.sides <= MOST_SIDES:
            raise InputError(f"cylinder: sides = {shown(self.sides)}; a prism needs a whole number of sides, 3 to {MOST_SIDES}")

    @property
    def volume(self):
        return pi * self.radius * self.radius * self.height

    @cached_property
    def inertia(self):
        across = self.volume * (3.0 * self.radius * self.radius + self.height * self.height) / 12.0
        return np.diag([across, across, 0.5 * self.volume * self.radius * self.radius])

    @property
    def surface_area(self):
        return 2.0 * pi * self.radius * (self.radius + self.height)

    @property
    def bounding_radius(self):
        return sqrt(self.radius * self.radius + 0.25 * self.height * self.height)

    @cached_property
    def pieces(self):
        angle = 2.0 * pi * np.arange(self.sides) / self.sides
        ring = self.radius * np.column_stack([*cosine_and_sine(angle), np.zeros_like(angle)])
        half = np.array([0.0, 0.0, 0.5 * self.height])
        return (ConvexPiece(np.concatenate([ring - half, ring + half])),)


@dataclass(frozen=True)
class Compound(Named):
    """Several solids that are one rigid body. parts: shapes in one frame, touching but not overlapping.

    Mass properties are the sums over the parts. The surface area is that of the convex hull of flat-faced parts, what a
    current sees from outside: its quarter exceeds the mean silhouette of a Cubipod by 7 %, with the sum it would be 57 %.
    """

    parts: tuple

    def __post_init__(self):
        parts = tuple(self.parts)
        if not parts:
            raise InputError("compound: no parts; a compound needs at least one solid")
        for number, part in enumerate(parts):
            if not hasattr(part, "pieces"):
                raise InputError(f"compound: part {number} is {part!r}; parts are shapes such as Box or ConvexPiece")
        object.__setattr__(self, "parts", parts)
        self._refuse_overlap()

    def _refuse_overlap(self):
        """Overlapping parts would be weighed twice. Round parts are not checked."""
        flat = [(number, piece) for number, part in enumerate(self.parts) for piece in _in_frame(part) if piece.faces]
        low = np.array([piece.vertices.min(axis=0) for _, piece in flat]).reshape(-1, 3)
        high = np.array([piece.vertices.max(axis=0) for _, piece in flat]).reshape(-1, 3)
        for i, (number, piece) in enumerate(flat):
            common = np.minimum(high[i], high[i + 1 :]) - np.maximum(low[i], low[i + 1 :])
            allowed = OVERLAP * np.minimum(np.max(high[i] - low[i]), np.max(high[i + 1 :] - low[i + 1 :], axis=1))
            for j in i + 1 + np.flatnonzero(np.min(common, axis=1) > 2.0 * allowed):
                other, second = flat[j]
                if number == other or _parted(piece, second, allowed[j - i - 1]) or _parted(second, piece, allowed[j - i - 1]):
                    continue
                ball = polyhedra.common_ball((piece.normals, piece.offsets), (second.normals, second.offsets))
                if ball > allowed[j - i - 1]:
                    raise InputError(
                        f"compound: parts {number} and {other} overlap (a ball of radius {ball:.3g} m fits "
                        "into both); cut them so that they only touch"
                    )

    @cached_property
    def volume(self):
        return _total(part.volume for part in self.parts)

    @cached_property
    def centre_of_mass(self):
        return sum(part.volume * part.centre_of_mass for part in self.parts) / self.volume

    @cached_property
    def inertia(self):
        centre = self.centre_of_mass
        return sum(part.inertia + polyhedra.parallel_axes(part.volume, part.centre_of_mass - centre) for part in self.parts)

    @cached_property
    def surface_area(self):
        total = _total(part.surface_area for part in self.parts)
        if any(piece.radius for piece in self.pieces):
            return total
        return min(total, ConvexPiece(np.concatenate([piece.vertices for piece in self.pieces])).surface_area)

    @cached_property
    def bounding_radius(self):
        return max(farthest(piece.vertices, np.zeros(3)) + piece.radius for piece in self.pieces)

    @cached_property
    def pieces(self):
        return tuple(piece.moved(-self.centre_of_mass) for part in self.parts for piece in _in_frame(part))


def _parted(piece, other, allowed):
    """Does the face of a piece that the other lies farthest beyond part them, so that no ball larger than allowed fits into both?

    Most neighbours touch with a face: this spares them the linear programme.
    """
    beyond = piece.normals @ polyhedra.middle(other.vertices) - piece.offsets
    face = np.argmax(beyond)
    return np.min(other.vertices @ piece.normals[face]) - piece.offsets[face] >= -2.0 * allowed


def _total(numbers):
    """Their sum, one after another: Python's own `sum` of numbers rounds in another way from version 3.12 on."""
    return float(reduce(add, numbers))


def _in_frame(part):
    """The convex pieces of a part in the frame the part was given in."""
    return (part,) if isinstance(part, ConvexPiece) else tuple(piece.moved(part.centre_of_mass) for piece in part.pieces)
