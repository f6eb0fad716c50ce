"""A solid of any form: its closed surface says what it weighs, convex pieces in its place say what it touches."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from minibullet.errors import InputError
from minibullet.shapes import polyhedra
from minibullet.shapes.convex import ConvexPiece, farthest


@dataclass(frozen=True, eq=False)
class DecomposedSolid:
    """A shape with the mass of its surface and the contacts of its pieces.

    parts: ((vertices (v, 3) [m], triangles (t, 3)), ...), closed surfaces, counter-clockwise seen from outside, that do not
    overlap; hulls: the convex pieces that stand for them in contact, in the same frame. Where the parts are convex the pieces are
    the solid; where they are not, the pieces miss it by `volume_error`.

    The surface area is that of the convex hull where this is smaller: what a current sees from outside, as in `Compound`.
    Raises InputError where the parts enclose nothing, or there is no piece.
    """

    parts: tuple = field(repr=False)
    hulls: tuple = field(repr=False)

    def __post_init__(self):
        object.__setattr__(self, "parts", tuple(self.parts))
        object.__setattr__(self, "hulls", tuple(self.hulls))
        if not self.hulls or not self.parts:
            raise InputError("solid: no parts or no pieces; give a closed surface and the convex pieces that stand for it")
        if not self.volume > 0.0:
            raise InputError(f"solid: volume = {self.volume:.6g} m3; give closed surfaces whose faces look outward")

    @cached_property
    def _masses(self):
        return [polyhedra.mass_properties(*part) for part in self.parts]

    @cached_property
    def volume(self):
        """What the surface encloses [m3]."""
        return float(sum(mass.volume for mass in self._masses))

    @cached_property
    def centre_of_mass(self):
        """In the frame of the surface (3,) [m]."""
        return sum(mass.volume * mass.centre_of_mass for mass in self._masses) / self.volume

    @cached_property
    def inertia(self):
        """About the centre of mass, axes of the surface, for unit density (3, 3) [m5]."""
        return sum(
            mass.inertia + polyhedra.parallel_axes(mass.volume, mass.centre_of_mass - self.centre_of_mass)
            for mass in self._masses
        )

    @cached_property
    def hull(self):
        """Convex hull of the pieces, in their frame."""
        return ConvexPiece(np.concatenate([piece.vertices for piece in self.hulls]))

    @cached_property
    def surface_area(self):
        """Of the surface, or of the convex hull where that is smaller [m2]."""
        return min(float(sum(polyhedra.area_of(*part) for part in self.parts)), self.hull.surface_area)

    @cached_property
    def pieces(self):
        """The convex pieces about the centre of mass."""
        return tuple(piece.moved(-self.centre_of_mass) for piece in self.hulls)

    @cached_property
    def bounding_radius(self):
        """About the centre of mass [m]."""
        return max(farthest(piece.vertices, np.zeros(3)) for piece in self.pieces)

    @cached_property
    def volume_error(self):
        """By which part of the volume the pieces together hold more than the surface encloses [-]."""
        return sum(piece.volume for piece in self.hulls) / self.volume - 1.0
