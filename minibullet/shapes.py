"""Shapes of bodies: what they weigh, how they resist turning, and of which convex pieces they are made.

Every shape is a frozen value with
    volume [m3]; centre_of_mass (3,) [m], in the frame the shape was given in; inertia (3, 3) [m5 = kg m2 per kg/m3],
    about the centre of mass; surface_area [m2]; bounding_radius [m], about the centre of mass;
    pieces: tuple of ConvexPiece, moved so that the centre of mass is the origin (the axes stay the user's).
Shapes compare and hash by content. Input that makes no solid raises InputError.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from minibullet import polyhedra
from minibullet.errors import InputError
from minibullet.rotations import matrix


@dataclass(frozen=True)
class Sphere:
    """A ball of the given radius [m]."""

    radius: float

    def __post_init__(self):
        _positive("sphere", radius=self.radius)

    @cached_property
    def volume(self):
        return 4.0 / 3.0 * pi * self.radius**3

    @property
    def centre_of_mass(self):
        return np.zeros(3)

    @cached_property
    def inertia(self):
        return 0.4 * self.volume * self.radius**2 * np.eye(3)

    @property
    def surface_area(self):
        return 4.0 * pi * self.radius**2

    @property
    def bounding_radius(self):
        return self.radius

    @cached_property
    def pieces(self):
        return (ConvexPiece(np.zeros((1, 3)), self.radius),)


@dataclass(frozen=True)
class Box:
    """A cuboid with full edge lengths x, y, z [m]."""

    x: float
    y: float
    z: float

    def __post_init__(self):
        _positive("box", x=self.x, y=self.y, z=self.z)

    @property
    def volume(self):
        return self.x * self.y * self.z

    @property
    def centre_of_mass(self):
        return np.zeros(3)

    @cached_property
    def inertia(self):
        squares = np.array([self.x, self.y, self.z]) ** 2
        return self.volume / 12.0 * np.diag(squares.sum() - squares)

    @property
    def surface_area(self):
        return 2.0 * (self.x * self.y + self.y * self.z + self.z * self.x)

    @property
    def bounding_radius(self):
        return 0.5 * float(np.sqrt(self.x**2 + self.y**2 + self.z**2))

    @cached_property
    def pieces(self):
        signs = np.array([(i, j, k) for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)])
        return (ConvexPiece(signs * (self.x, self.y, self.z)),)


@dataclass(frozen=True)
class Capsule:
    """A ball of the given radius swept along a segment of the given length on the x axis [m]."""

    radius: float
    length: float

    def __post_init__(self):
        _positive("capsule", radius=self.radius, length=self.length)

    @cached_property
    def volume(self):
        return pi * self.radius**2 * self.length + 4.0 / 3.0 * pi * self.radius**3

    @property
    def centre_of_mass(self):
        return np.zeros(3)

    @cached_property
    def inertia(self):
        return _capsule_inertia(self.radius, self.length)

    @property
    def surface_area(self):
        return 2.0 * pi * self.radius * self.length + 4.0 * pi * self.radius**2

    @property
    def bounding_radius(self):
        return 0.5 * self.length + self.radius

    @cached_property
    def pieces(self):
        return (ConvexPiece(np.array([(-0.5 * self.length, 0, 0), (0.5 * self.length, 0, 0)]), self.radius),)


@dataclass(frozen=True)
class Cylinder:
    """A round cylinder on the z axis [m]. It weighs what a round one weighs; it touches as a prism with so many sides.

    The prism's corners lie on the circle: lying on a side it is lower by radius (1 - cos(pi/sides)), 0.5 % for 32.
    """

    radius: float
    height: float
    sides: int = 32

    def __post_init__(self):
        _positive("cylinder", radius=self.radius, height=self.height)
        if int(self.sides) != self.sides or self.sides < 3:
            raise InputError(f"cylinder: sides = {self.sides}; a prism needs a whole number of sides, 3 or more")

    @property
    def volume(self):
        return pi * self.radius**2 * self.height

    @property
    def centre_of_mass(self):
        return np.zeros(3)

    @cached_property
    def inertia(self):
        across = self.volume * (3.0 * self.radius**2 + self.height**2) / 12.0
        return np.diag([across, across, 0.5 * self.volume * self.radius**2])

    @property
    def surface_area(self):
        return 2.0 * pi * self.radius * (self.radius + self.height)

    @property
    def bounding_radius(self):
        return float(np.sqrt(self.radius**2 + 0.25 * self.height**2))

    @cached_property
    def pieces(self):
        angle = 2.0 * pi * np.arange(int(self.sides)) / int(self.sides)
        ring = self.radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
        half = np.array([0.0, 0.0, 0.5 * self.height])
        return (ConvexPiece(np.concatenate([ring - half, ring + half])),)


@dataclass(frozen=True, eq=False)
class ConvexPiece:
    """The convex hull of points, swept by a ball of `radius`: what collision works with, and a shape of its own.

    vertices: (v, 3) [m]; points inside the hull are left out, the others keep their order.
    radius: 0 for flat-faced solids (4 points or more, not in a plane); a positive radius makes one point a ball and
    two points a capsule.
    """

    vertices: np.ndarray
    radius: float = 0.0

    def __post_init__(self):
        points = _points("hull", self.vertices)
        if self.radius == 0.0:
            corners, faces = polyhedra.convex_hull(points)
            self._set(points[corners], faces)
            return
        _positive("hull", radius=self.radius)
        if len(points) > 2 or (len(points) == 2 and np.array_equal(points[0], points[1])):
            raise InputError(f"hull: radius = {self.radius} with {len(points)} points; only one point (a ball) "
                             "or two different points (a capsule) can be rounded")
        self._set(points, ())

    def _set(self, vertices, faces):
        vertices.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "radius", float(self.radius))
        object.__setattr__(self, "faces", faces)       # tuple of counter-clockwise loops of vertex indices
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            size = np.trace(self.inertia)
        if not (np.isfinite(size) and self.volume > 0 and size > 0):
            raise InputError(f"hull: volume = {self.volume} m3; mass and inertia must be numbers that double precision can hold")

    def moved(self, translation=(0.0, 0.0, 0.0), orientation=None):
        """The same piece turned by the quaternion orientation, then shifted by translation [m]."""
        vertices = self.vertices if orientation is None else self.vertices @ matrix(orientation).T
        piece = object.__new__(ConvexPiece)
        object.__setattr__(piece, "radius", self.radius)
        piece._set(vertices + np.asarray(translation, dtype=float), self.faces)
        return piece

    def __eq__(self, other):
        return isinstance(other, ConvexPiece) and self.radius == other.radius and np.array_equal(self.vertices, other.vertices)

    def __hash__(self):
        # Adding zero makes equal of 0.0 and -0.0, which compare equal too.
        return hash((self.radius, (self.vertices + 0.0).tobytes()))

    def __repr__(self):
        return f"ConvexPiece({len(self.vertices)} vertices, {len(self.faces)} faces, radius={self.radius})"

    @cached_property
    def edges(self):
        """(e, 2) vertex indices, smaller first, sorted."""
        if len(self.vertices) == 2:
            return np.array([[0, 1]])
        return polyhedra.edges_of(self.faces)

    @cached_property
    def _planes(self):
        return polyhedra.planes_of(self.vertices, self.faces) if self.faces else (np.zeros((0, 3)), np.zeros(0))

    @property
    def normals(self):
        """(f, 3) outward unit normals of the faces."""
        return self._planes[0]

    @property
    def offsets(self):
        """(f,) the flat-faced solid is normals . x <= offsets [m]."""
        return self._planes[1]

    @cached_property
    def _mass(self):
        if self.faces:
            return polyhedra.mass_properties(self.vertices, polyhedra.triangles_of(self.faces))
        core = self.vertices[-1] - self.vertices[0]
        length = float(np.sqrt(core @ core))
        volume = pi * self.radius**2 * length + 4.0 / 3.0 * pi * self.radius**3
        along, across = np.diag(_capsule_inertia(self.radius, length))[:2]
        direction = core / length if length else core
        inertia = across * np.eye(3) + (along - across) * np.outer(direction, direction)
        return polyhedra.MassProperties(volume, polyhedra.middle(self.vertices), inertia)

    @property
    def volume(self):
        return self._mass.volume

    @property
    def centre_of_mass(self):
        return self._mass.centre_of_mass

    @property
    def inertia(self):
        return self._mass.inertia

    @cached_property
    def surface_area(self):
        if self.faces:
            return polyhedra.area_of(self.vertices, polyhedra.triangles_of(self.faces))
        length = float(np.linalg.norm(self.vertices[-1] - self.vertices[0]))
        return 2.0 * pi * self.radius * length + 4.0 * pi * self.radius**2

    @cached_property
    def bounding_radius(self):
        return _farthest(self.vertices, self.centre_of_mass) + self.radius

    @cached_property
    def pieces(self):
        return (self.moved(-self.centre_of_mass),)


@dataclass(frozen=True)
class Compound:
    """Several solids that are one rigid body. parts: shapes in one frame, touching but not overlapping.

    Mass properties are the sums over the parts. The surface area is the sum too: where parts touch, the faces inside
    are counted, so it is an upper bound.
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

    @cached_property
    def volume(self):
        return float(sum(part.volume for part in self.parts))

    @cached_property
    def centre_of_mass(self):
        return sum(part.volume * part.centre_of_mass for part in self.parts) / self.volume

    @cached_property
    def inertia(self):
        centre = self.centre_of_mass
        return sum(part.inertia + polyhedra.parallel_axes(part.volume, part.centre_of_mass - centre) for part in self.parts)

    @cached_property
    def surface_area(self):
        return float(sum(part.surface_area for part in self.parts))

    @cached_property
    def bounding_radius(self):
        return max(_farthest(piece.vertices, np.zeros(3)) + piece.radius for piece in self.pieces)

    @cached_property
    def pieces(self):
        return tuple(piece.moved(part.centre_of_mass - self.centre_of_mass) for part in self.parts for piece in part.pieces)


def _positive(name, **lengths):
    """Refuse lengths that are not positive finite numbers."""
    for field, value in lengths.items():
        try:
            fine = np.isfinite(value) and value > 0
        except TypeError:
            fine = False
        if not fine:
            raise InputError(f"{name}: {field} = {value!r}; must be a finite length > 0 in metres")


def _points(name, points):
    """A fresh (n, 3) float array of finite numbers, or InputError."""
    try:
        points = np.array(points, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: vertices are not an array of numbers; give one row x, y, z a point") from None
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise InputError(f"{name}: vertices have the shape {points.shape}; give one row x, y, z a point")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise InputError(f"{name}: vertex {bad[0]} = {points[bad[0]].tolist()} is not finite")
    return points


def _farthest(vertices, centre):
    """Largest distance of the vertices (n, 3) from centre [m]."""
    return float(np.sqrt(np.max(np.sum((vertices - centre) ** 2, axis=1))))


def _capsule_inertia(radius, length):
    """Inertia of a capsule of unit density along x: cylinder plus two half balls."""
    cylinder, ball = pi * radius**2 * length, 4.0 / 3.0 * pi * radius**3
    along = 0.5 * cylinder * radius**2 + 0.4 * ball * radius**2
    # A half ball's centre lies 3/8 r from its flat side; moved out by half the core this gives the second bracket.
    across = (cylinder * (radius**2 / 4.0 + length**2 / 12.0)
              + ball * (0.4 * radius**2 + 0.375 * radius * length + 0.25 * length**2))
    return np.diag([along, across, across])
