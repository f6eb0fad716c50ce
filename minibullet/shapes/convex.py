"""Convex pieces: what collision works with. A flat-faced hull of points, or a ball or capsule around one or two points."""

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt

import numpy as np

from minibullet.errors import InputError, is_number, shown_value
from minibullet.rotations import dot, matrix
from minibullet.shapes import polyhedra
from minibullet.values import Named

# The least moment of inertia of a hull as part of their sum. Sums of vertices give it to 1e-16 of the sum: here, to four digits.
NEEDLE = 1e-12


@dataclass(frozen=True, eq=False)
class ConvexPiece(Named):
    """The convex hull of points, swept by a ball of `radius`: what collision works with, and a shape of its own.

    vertices: (v, 3) [m]; points inside the hull are left out, the others keep their order.
    radius: 0 for flat-faced solids (4 points or more, not in a plane); a positive radius makes one point a ball and
    two points a capsule.
    """

    vertices: np.ndarray
    radius: float = 0.0

    def __post_init__(self):
        points, faces = _points("hull", self.vertices), ()
        if self.radius == 0.0:
            corners, faces = polyhedra.convex_hull(points)
            points = points[corners]
        else:
            check_lengths("hull", radius=self.radius)
            if len(points) > 2 or (len(points) == 2 and np.array_equal(points[0], points[1])):
                raise InputError(
                    f"hull: radius = {self.radius} with {len(points)} points; only one point (a ball) "
                    "or two different points (a capsule) can be rounded"
                )
        self._set(points, faces)
        self._refuse_unweighable()

    def _set(self, vertices, faces):
        vertices.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "radius", float(self.radius))
        object.__setattr__(self, "faces", faces)  # tuple of counter-clockwise loops of vertex indices

    def _refuse_unweighable(self):
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            size = np.trace(self.inertia)
        if not (np.isfinite(size) and self.volume > 0 and size > 0):
            raise InputError(f"hull: volume = {self.volume} m3; mass and inertia must be numbers that double precision can hold")
        if self.faces and not np.linalg.eigvalsh(self.inertia / size)[0] > NEEDLE:
            raise InputError(
                "hull: the least moment of inertia is lost in the rounding of the largest; a needle must be thicker "
                "than a millionth of its length"
            )

    def moved(self, translation=(0.0, 0.0, 0.0), orientation=None):
        """The same piece turned by the quaternion orientation, then shifted by translation [m]."""
        vertices = self.vertices if orientation is None else dot(self.vertices[:, None], matrix(orientation))
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

    @property
    def _core_length(self):
        """Length of the segment between the two vertices of a capsule; 0 of a ball [m]."""
        core = self.vertices[-1] - self.vertices[0]
        return sqrt(dot(core, core))

    @cached_property
    def _mass(self):
        if self.faces:
            return polyhedra.mass_properties(self.vertices, polyhedra.triangles_of(self.faces))
        length = self._core_length
        volume, (along, across, _) = swept_ball(self.radius, length)
        core = self.vertices[-1] - self.vertices[0]
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
        return swept_ball_area(self.radius, self._core_length)

    @cached_property
    def bounding_radius(self):
        return farthest(self.vertices, self.centre_of_mass) + self.radius

    @cached_property
    def pieces(self):
        return (self.moved(-self.centre_of_mass),)


def check_lengths(name, **lengths):
    """Refuse lengths that are not positive finite numbers."""
    for field, value in lengths.items():
        if not (is_number(value) and value > 0):
            raise InputError(f"{name}: {field} = {shown_value(value)}; must be a finite length > 0 in metres")


def weighs(shape):
    """Whether double precision holds the volume and the inertia of a shape."""
    try:
        with np.errstate(all="ignore"):
            volume, inertia = float(shape.volume), np.asarray(shape.inertia, dtype=float)
    except OverflowError:  # whole numbers of hundreds of digits
        return False
    return bool(0.0 < volume < np.inf and np.isfinite(inertia).all() and inertia.any())


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


def farthest(vertices, centre):
    """Largest distance of the vertices (n, 3) from centre [m]."""
    return sqrt(np.max(np.sum(np.square(vertices - centre), axis=1)))


def swept_ball_area(radius, length):
    """Surface area of a ball swept along a segment: a capsule, or a ball [m2]."""
    return 2.0 * pi * radius * (length + 2.0 * radius)


def swept_ball(radius, length):
    """Volume and moments of inertia (along, across, across) of a ball swept along a segment: a capsule, or a ball.

    Products, not powers: they scale exactly with powers of two.
    """
    square = radius * radius
    cylinder, ball = pi * square * length, 4.0 / 3.0 * pi * square * radius
    along = 0.5 * cylinder * square + 0.4 * ball * square
    # A half ball's centre lies 3/8 r from its flat side; moved out by half the core this gives the second bracket.
    across = cylinder * (square / 4.0 + length * length / 12.0) + ball * (
        0.4 * square + 0.375 * radius * length + 0.25 * length * length
    )
    return cylinder + ball, (along, across, across)
