"""Armour units from mesh files: what they weigh, how they rest and what they touch follows from the mesh itself.

`parse_armour` turns what `--armour` was given into the name of a built-in unit or a `MeshUnit`.
"""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from math import cbrt
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from hlcs.placement.convex_parts import convex_parts
from hlcs.placement.units import CONCRETE, UNITS, Unit
from minibullet import rotations
from minibullet.errors import InputError, if_alike, shown_value
from minibullet.rotations import cross, dot
from minibullet.shapes import mesh_files, polyhedra, surfaces
from minibullet.shapes.convex import ConvexPiece
from minibullet.shapes.decomposed import DecomposedSolid

ENDINGS = (".stl", ".obj", ".ply", ".off")
EQUAL = 1e-6  # heights, widths and directions that differ by less than this part are the same: 32-bit files round to 1e-7 [-]
MOST_ERROR = 0.25  # of the volume of pieces: such pieces belong to another mesh [-]


@dataclass(frozen=True, eq=False)
class MeshUnit(Unit):
    """An armour unit of any form; lengths in metres, body axes those of the mesh, positions those of its centre of mass.

    name: what messages call it; parts: ((vertices (v, 3), triangles (t, 3)), ...), closed surfaces that do not overlap; hulls:
    the convex pieces that touch for it; cut: who made the pieces.

    It rests lowest on the face of its convex hull with the centre of mass above it that is nearest to the centre of mass. Among
    equal faces the one is taken that looks most along z, then x, then y of the mesh. At heading 0 the unit is narrowest along y.
    Two units of the same surface and pieces are equal.
    """

    name: str = Unit.name
    parts: tuple = field(default=(), repr=False)
    hulls: tuple = field(default=(), repr=False)
    cut: str = "its own solids"

    @classmethod
    def read(cls, path):
        """The unit in a mesh file (STL, OBJ, PLY, OFF; lengths in metres).

        Convex pieces are the file's own closed solids, all convex; of a file with one solid that is not, those of a file
        NAME.pieces.obj beside it, or what CoACD (extra `units`) cuts it into.

        Raises InputError that names the file, what is wrong and how to mend it.
        """
        path = Path(path)
        surface, name = mesh_files.read_surface(path)
        parts = surfaces.closed_parts(surface, name)
        beside = path.with_name(f"{path.stem}.pieces.obj")
        if beside.is_file():
            return cls(path.name, tuple(parts), tuple(_pieces_beside(beside)), f"from {beside.name}")._checked(beside.name)
        if len(parts) == 1 and _is_hollowed(*parts[0]):
            return cls(path.name, tuple(parts), tuple(convex_parts(*parts[0], name)), "cut by CoACD")._checked("by CoACD")
        hulls = [surfaces.convex_piece(*part, name, number) for number, part in enumerate(parts, 1)]
        if len(hulls) > 1:
            surfaces.compound(hulls, name)  # refuses solids that overlap: they would be weighed twice
        return cls(path.name, tuple(parts), tuple(hulls))

    def _checked(self, name):
        """The unit itself, if its pieces can be those of its surface."""
        if abs(self.volume_error) > MOST_ERROR:
            raise InputError(
                f"mesh '{self.name}': the convex pieces ({name}) hold {100 * self.volume_error:+.3g} % of its volume more than "
                "it does; give pieces of this mesh, or take the file of pieces away"
            )
        return self

    # ---- what it is

    @cached_property
    def pieces(self):
        """The solid for the engine: the mass of the mesh, the contacts of the pieces."""
        return DecomposedSolid(self.parts, self.hulls)

    @cached_property
    def hull(self):
        """The same with the contacts of its convex hull; it weighs what the unit weighs."""
        return DecomposedSolid(self.parts, (self.pieces.hull,))

    @property
    def volume(self):
        """Volume that the mesh encloses [m3]."""
        return self.pieces.volume

    @property
    def nominal_diameter(self):
        """Edge of the cube of equal volume [m]: Dn = V^(1/3)."""
        return cbrt(self.volume)

    side = nominal_diameter

    @property
    def volume_error(self):
        """By which part of the volume the convex pieces together hold more than the mesh [-]."""
        return self.pieces.volume_error

    def scaled(self, factor):
        """The same unit with all lengths times a factor."""
        return self if factor == 1.0 else _scaled(self, float(factor))

    def facts(self, density=CONCRETE):
        """What the unit is, as plain values: as of any unit, and its convex pieces with their volume error [-]."""
        return super().facts(density) | {"pieces": len(self.hulls), "cut": self.cut, "volume_error": self.volume_error}

    def description(self, density=CONCRETE):
        """Two lines: volume, nominal diameter, mass at a density [kg/m3], rest; convex pieces and their volume error."""
        pieces = "1 convex piece" if len(self.hulls) == 1 else f"{len(self.hulls)} convex pieces"
        return (
            f"unit {self.name}: volume {self.volume:.5g} m3, Dn {self.nominal_diameter:.5g} m, mass {self.mass(density):.5g} kg, "
            f"{self.first_layer_coefficient:.3f} Dn high at its lowest rest\n"
            f"{pieces} ({self.cut}); volume error {100 * self.volume_error:+.2f} %"
        )

    # ---- how it rests

    @cached_property
    def _rests(self):
        """[(height of the centre [m], orientation (4,)), ...] of all stable rests on a plane, the lowest first."""
        centred = self.pieces.hull.moved(-self.pieces.centre_of_mass)
        size = self.pieces.bounding_radius
        found = []
        for normal, offset, loop in zip(centred.normals, centred.offsets, centred.faces, strict=True):
            if _stands(centred.vertices[list(loop)], normal, offset * normal, EQUAL * size):
                ranked = (round(offset / (EQUAL * size)), *(-np.round(normal[[2, 0, 1]], 5)))
                found.append((ranked, offset, _upright(centred.vertices, normal)))
        found.sort(key=lambda rest: rest[0])
        return [(height, orientation) for _, height, orientation in found]

    @property
    def rest_height(self):
        """Height of the centre of mass over the bottom in the low pose [m]."""
        return float(self._rests[0][0])

    @property
    def tip_rest_height(self):
        """Height of the centre of mass over the bottom at the highest rest [m]."""
        return float(self._rests[-1][0])

    @cached_property
    def low_height(self):
        """Height of the top over the bottom in the low pose [m]."""
        vertical = rotations.matrix(self._rests[0][1])[2]
        heights = dot(self.pieces.hull.vertices, vertical)
        return float(heights.max() - heights.min())

    def low_poses(self):
        """The orientations of lowest rest, (k, 4), as many as the hull has such faces."""
        lowest = self.rest_height * (1.0 + EQUAL)
        return np.array([orientation for height, orientation in self._rests if height <= lowest])

    def tip_poses(self):
        """The orientations of highest rest, (k, 4)."""
        highest = self._rests[-1][0] * (1.0 - EQUAL)
        return np.array([orientation for height, orientation in self._rests if height >= highest])

    # ---- as a file, and as a value

    def obj_text(self):
        """The surface as an OBJ file, one object for each closed solid; digits that give the same numbers again."""
        return _obj_text("part", self.parts)

    def pieces_text(self):
        """The convex pieces as an OBJ file, or None where they are the parts themselves."""
        if self.cut == "its own solids":
            return None
        return _obj_text("piece", [(piece.vertices, polyhedra.triangles_of(piece.faces)) for piece in self.hulls])

    def write(self, path):
        """Write NAME.obj, and NAME.pieces.obj beside it where the pieces are not the file's own solids; `read` reads them."""
        from hlcs.files import folders  # here: what only writes is no part of a run, nor of the hash of its code

        path = Path(path)
        if path.suffix.lower() != ".obj":
            raise InputError(f"unit '{self.name}': cannot be written as '{path.name}'; give a name that ends in .obj")
        folders.write_text(path, self.obj_text())
        if (pieces := self.pieces_text()) is not None:
            folders.write_text(path.with_name(f"{path.stem}.pieces.obj"), pieces)

    @cached_property
    def digest(self):
        """Hash of the surface and the pieces, 64 hexadecimal digits."""
        arrays = [array for part in self.parts for array in part] + [piece.vertices for piece in self.hulls]
        text = "\n".join(str(np.asarray(array).tolist()) for array in arrays)
        return hashlib.sha256(text.encode()).hexdigest()

    def __eq__(self, other):
        return isinstance(other, MeshUnit) and self.digest == other.digest

    def __hash__(self):
        return hash(self.digest)


def parse_armour(armour, folder="."):
    """The name of a built-in unit as it is; a MeshUnit from the name of a mesh file, relative to folder; a MeshUnit as it is."""
    if isinstance(armour, MeshUnit) or (isinstance(armour, str) and armour in UNITS):
        return armour
    if isinstance(armour, str) and armour.strip().lower().endswith(ENDINGS):
        return MeshUnit.read(Path(folder) / armour.strip())
    raise InputError(
        f"placement: armour = {shown_value(armour)}; it must be one of {', '.join(UNITS)}, or a mesh file of the unit that ends "
        f"in {', '.join(ENDINGS)}{if_alike(armour, UNITS)}"
    )


def unit_of(armour, side):
    """The unit of a parsed armour: of this side [m]; one from a file, in metres per unit of length of the file."""
    return armour.scaled(side) if isinstance(armour, MeshUnit) else UNITS[armour](side=side)


@lru_cache(maxsize=16)
def _scaled(unit, factor):
    parts = tuple((factor * vertices, triangles) for vertices, triangles in unit.parts)
    return MeshUnit(unit.name, parts, tuple(ConvexPiece(factor * piece.vertices) for piece in unit.hulls), unit.cut)


def _is_hollowed(vertices, triangles):
    """Whether one closed surface encloses less than its convex hull does."""
    try:
        hull = ConvexPiece(vertices).volume
    except InputError:  # too flat for a hull: `surfaces.convex_piece` tells it by the name of the file
        return False
    return polyhedra.mass_properties(vertices, triangles).volume < (1.0 - surfaces.CONVEX) * hull


def _pieces_beside(path):
    """The convex pieces in a file beside the mesh; they may overlap a little, as those of a decomposition do."""
    surface, name = mesh_files.read_surface(path)
    return [surfaces.convex_piece(*part, name, number) for number, part in enumerate(surfaces.closed_parts(surface, name), 1)]


def _stands(corners, normal, foot, tolerance):
    """Whether the foot of the centre of mass (3,) lies inside a face: corners (c, 3), counter-clockwise seen from outside."""
    along = np.roll(corners, -1, axis=0) - corners
    inward = cross(normal, along)
    return bool(np.all(dot(inward, foot - corners) > tolerance * np.sqrt(dot(inward, inward))))


def _upright(vertices, normal):
    """The orientation in which a face with this outward normal lies on the bottom, and the unit is narrowest along y. -> (4,)."""
    first = cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first = first / np.sqrt(dot(first, first))
    second = cross(normal, first)
    plan = np.column_stack([dot(vertices, first), dot(vertices, second)])
    outline = plan[ConvexHull(plan).vertices]
    edges = np.roll(outline, -1, axis=0) - outline
    along = edges / np.sqrt(dot(edges, edges))[:, None]
    # of a strip along x as wide as the unit: the narrowest lies along an edge of the outline
    widths = np.ptp(outline @ np.column_stack([-along[:, 1], along[:, 0]]).T, axis=0)
    narrow = along[widths <= widths.min() * (1.0 + EQUAL)]
    candidates = [sign * (x * first + y * second) for x, y in narrow for sign in (1.0, -1.0)]
    # one of several: that in which the largest component along an axis of the mesh is positive and largest
    world_x = max(candidates, key=lambda axis: tuple(np.round([axis.max(), *axis], 5)))
    return rotations.from_matrix(np.array([world_x, cross(-normal, world_x), -normal]))


def _obj_text(word, parts):
    """An OBJ file of closed surfaces [(vertices (v, 3), triangles (t, 3)), ...]."""
    lines, first = [], 1
    for number, (vertices, triangles) in enumerate(parts, 1):
        lines.append(f"o {word}_{number}")
        lines += ["v " + " ".join(map(repr, vertex)) for vertex in np.asarray(vertices, dtype=float).tolist()]
        lines += ["f " + " ".join(map(str, triangle)) for triangle in (np.asarray(triangles) + first).tolist()]
        first += len(vertices)
    return "\n".join(lines) + "\n"
