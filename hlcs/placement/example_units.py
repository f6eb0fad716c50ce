"""Units to try `--armour FILE` with, made from their measures: `hlcs.example_unit("tetrapod").write("tetrapod.obj")`.

A closed solid for each convex piece, so that nothing has to be cut.
"""

from math import cos, pi, sin

import numpy as np
from scipy.spatial import HalfspaceIntersection

from hlcs.placement.mesh_units import MeshUnit
from hlcs.placement.units import Cube, Cubipod
from minibullet.errors import InputError, one_of, shown_value
from minibullet.shapes import polyhedra
from minibullet.shapes.convex import ConvexPiece

# The tetrapod's measures in its height H, from the sheet of units in the Shore Protection Manual (U.S. Army Corps of Engineers,
# 1984, chapter 7): diameter at the tip of a leg, diameter at its base, length between these two. The same sheet gives the
# volume, 0.280 H^3.
TIP, BASE, LEG = 0.302, 0.470, 0.477
SIDES = 18  # of a leg, which then has 98 % of the section of a round one; a multiple of 6, or the legs would not be alike


def example_unit(name, side=1.0):
    """A unit as a MeshUnit.

    name: "cube", "cubipod" or "tetrapod", InputError for any other; side: edge of the cube, of a tetrapod its height H [m].
    """
    makers = {"cube": _of_pieces(Cube), "cubipod": _of_pieces(Cubipod), "tetrapod": _tetrapod}
    if name not in makers:
        raise InputError(f"example unit {shown_value(name)}: unknown; {one_of(name, makers, 'give one of')}")
    hulls = [ConvexPiece(side * _sorted(piece.vertices)) for piece in makers[name]()]
    parts = [(piece.vertices, polyhedra.triangles_of(piece.faces)) for piece in hulls]
    return MeshUnit(f"{name}.obj", tuple(parts), tuple(hulls))


def _sorted(points):
    """Points by x, then y, then z, as they are read from a file again: the unit read is the unit written."""
    return points[np.lexsort(points.T[::-1])]


def _of_pieces(kind):
    return lambda: kind(side=1.0).pieces.pieces


def _tetrapod():
    """The four legs of a tetrapod of height 1, one of them upright.

    A leg is a cone, cut at the planes halfway to the other three: the legs then touch with faces and do not overlap. The height
    is from the top of the upright leg to the lowest points of the others, whose axes fall by a third:
    4/3 l + cos(asin(1/3)) d/2 = 1 gives the distance l of the tips from the middle.
    """
    axes = np.array([(0.0, 0.0, 3.0)] + [(8**0.5 * cos(a), 8**0.5 * sin(a), -1.0) for a in (0.0, 2 * pi / 3, 4 * pi / 3)]) / 3.0
    tip = 0.75 * (1.0 - 0.5 * TIP * 8**0.5 / 3.0)
    return [_leg(axes[k], np.delete(axes, k, axis=0), tip) for k in range(4)]


def _leg(axis, others, tip):
    """One leg along axis, ending at the distance tip, on its own side of the planes halfway to the others. Half-spaces are
    a . x + b <= 0."""
    slope = 0.5 * (BASE - TIP) / LEG  # of the cone's side
    across = others[0] - (others[0] @ axis) * axis
    across = across / np.sqrt(across @ across)
    upright = np.cross(axis, across)
    sides = []
    for angle in (np.arange(SIDES) + 0.5) * 2.0 * pi / SIDES:
        outward = cos(angle) * across + sin(angle) * upright
        # the corners of the section lie on the cone: its sides are nearer to the axis by cos(pi / SIDES)
        inset = cos(pi / SIDES)
        sides.append([*(outward + slope * inset * axis), -inset * (0.5 * TIP + slope * tip)])
    halfway = [[*(other - axis), 0.0] for other in others]
    planes = np.array([*sides, *halfway, [*axis, -tip]])
    corners = HalfspaceIntersection(planes, 0.5 * tip * axis).intersections
    return ConvexPiece(corners)
