"""Mass, inertia, areas and shape of the body of a recording, in its principal axes."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from hlcs.data.bodies import SHAPES, Body
from hlcs.placement.units import Cubipod
from minibullet import rotations
from minibullet.shapes.mesh_files import mesh_file
from minibullet.shapes.primitives import Box, ConvexPiece, Cylinder, Sphere

SIDES = 32  # of the base of a cone, as of a cylinder
LIGHT = 10.0  # densities of the fluid, below which a body falls much more slowly than freely from the first: bubbles, balloons


class RigidBody(NamedTuple):
    """What the laws of motion need to know of a body, in its principal axes."""

    mass: float  # [kg]
    inertia: tuple[float, float, float]  # principal moments [kg m2]
    volume: float  # [m3]
    area: float  # that a drag coefficient refers to: the mean projected area, if the file states no other [m2]
    radius: float  # of the sphere of equal volume [m]
    turn: tuple[float, ...]  # quaternion of the principal axes in body axes
    shape: object  # minibullet shape

    @property
    def tensor(self):
        """Inertia about the centre of mass, body axes, (3, 3) [kg m2]."""
        return _tensor(self.inertia, self.turn)


@lru_cache(maxsize=4096)
def _tensor(moments, turn):
    """The tensor of principal moments, read-only: many runs of one body share it."""
    axes = rotations.matrix(np.array(turn))
    tensor = axes @ np.diag(moments) @ axes.T
    tensor.flags.writeable = False
    return tensor


def unstated(body):
    """The keys of size and mass of a body that nobody stated, a tuple."""
    return tuple(key for key in (*SHAPES[body.shape], "mass") if getattr(body, key) is None)


def known_body(body):
    """Are mass and size of a body stated?"""
    return not unstated(body)


def borne(body, around):
    """Does the fluid carry much of the weight of a body of known mass and size?"""
    if not known_body(body):
        return False
    known = rigid_body(body)
    return known.mass < LIGHT * around.fluid_density * known.volume


def fluid_presumed(body, around):
    """Is a body of known mass and size taken to be in air, since its file states no fluid?"""
    return not around.fluid_stated and known_body(body)


def known_to_drag(body):
    """Are mass and area of a body stated, so that a drag coefficient has a meaning?"""
    return known_body(body) or body.mass is not None and body.drag_area is not None


class Altered:
    """A solid that is not quite its `shape`: what its class does not say is the shape's own."""

    def __getattr__(self, name):
        return getattr(object.__getattribute__(self, "shape"), name)  # a copy is asked before it has one


@dataclass(frozen=True)
class WithDragArea(Altered):
    """A solid with another area than the mean projected one of its surface."""

    shape: object
    drag_area: float  # [m2]

    @property
    def surface_area(self):
        """Four times the area: the engine takes a quarter of it for the mean projected one."""
        return 4 * self.drag_area


def cone(radius, height):
    """A ConvexPiece, apex up along z, its centre of mass at zero; its base has the area of a round one [m]."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    ring = radius * np.sqrt(2 * np.pi / SIDES / np.sin(2 * np.pi / SIDES))
    base = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), np.full(SIDES, -height / 4)])
    return ConvexPiece(np.concatenate([base, [[0.0, 0.0, 0.75 * height]]]))


@lru_cache(maxsize=4096)
def rigid_body(body: Body) -> RigidBody:
    """Mass properties of a body; a mass or size nobody stated is taken as 1 kg and 0.05 m (and then never used by a law).

    A mesh keeps its axes; its centre of mass is the body's centre, wherever the file has its origin. Moments that were stated
    belong to the axes in which the shape's own tensor is diagonal: those of the body, else, smallest first, the principal ones.
    """
    if body.shape == "sphere":
        shape = Sphere(body.radius or 0.05)
    elif body.shape == "box":
        shape = Box(*(body.size or (0.1, 0.1, 0.1)))
    elif body.shape == "cubipod":
        shape = Cubipod(body.side or 1.0).pieces
    elif body.shape in ("disc", "cylinder"):
        shape = Cylinder(body.radius or 0.05, body.height or 0.1)
    elif body.shape == "cone":
        shape = cone(body.radius or 0.05, body.height or 0.1)
    else:
        shape = body.form or mesh_file(body.mesh)
    if body.drag_area is not None:
        shape = WithDragArea(shape, body.drag_area)
    mass, stated = body.mass or 1.0, body.inertia
    moments, axes = np.linalg.eigh(shape.inertia)
    if np.allclose(shape.inertia, np.diag(np.diag(shape.inertia)), rtol=0, atol=1e-9 * moments[-1]):
        moments, axes = np.diag(shape.inertia), np.eye(3)
    else:
        axes = axes * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))])
        stated = stated and sorted(stated)
    moments = np.asarray(stated) if stated else moments * mass / shape.volume
    return RigidBody(
        mass,
        tuple(float(m) for m in moments),
        shape.volume,
        shape.surface_area / 4,
        (3 * shape.volume / (4 * np.pi)) ** (1 / 3),
        tuple(rotations.from_matrix(axes)),
        shape,
    )


def support(shape, orientation, normal):
    """Heights of all vertices (less their rounding radius) above the centre of mass along the normal, (V,) [m]."""
    heights = [rotations.rotate(orientation, piece.vertices) @ normal - piece.radius for piece in shape.pieces]
    return np.concatenate(heights)


def lowest_points(shape, orientation, normal, within):
    """Points of a solid no more than so far above its lowest one, from the centre of mass, the lowest first, (k, 3) [m]."""
    points = [rotations.rotate(orientation, piece.vertices) - piece.radius * normal for piece in shape.pieces]
    points = np.concatenate(points)
    heights = points @ normal
    order = np.argsort(heights, kind="stable")
    return points[order[heights[order] <= heights.min() + within]]
