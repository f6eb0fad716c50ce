"""Solids from mesh files: STL, OBJ and OFF, read and checked line by line; PLY in `ply_files`.

Nothing but the given file is opened: material libraries and textures are ignored.
Formats: M. Burns, Automated Fabrication (1993), section 6.5 (STL); Wavefront, Advanced Visualizer Manual, B1 (OBJ);
Geomview Manual, section 4.2.5 (OFF).
"""

from io import BytesIO

import numpy as np

from minibullet.errors import InputError, is_number, shown
from minibullet.files.reading import path_of, read_bytes
from minibullet.shapes import mesh_text, surfaces
from minibullet.shapes.mesh_text import Indexed, Surface, integer, lines, quoted, refuse_many
from minibullet.shapes.ply_files import read_ply

MOST_BYTES = 64_000_000  # an ASCII STL of the most triangles with all digits of its numbers has 50 MB
STL_HEADER, STL_TRIANGLE = 84, 50  # bytes; each triangle: 12 32-bit numbers and 2 bytes more


def mesh_file(path, scale=1.0):
    """The solid in a mesh file: a ConvexPiece, or a Compound where the file holds several closed convex solids.

    path: .stl, .obj, .ply or .off; scale: metres per unit of the file. Raises InputError for anything but closed,
    outward, convex solids that do not overlap, and beyond 64 MB, 100,000 triangles or 64 solids.
    """
    surface, name = read_surface(path, scale)
    # A solid too small or too large to be weighed is refused below; no need to warn of it first.
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return surfaces.solid(surface, name)


def read_surface(path, scale=1.0):
    """The triangles of a mesh file as they stand in it, in metres, not yet judged: (Surface, what messages call it).

    path, scale and limits: as of `mesh_file`.
    """
    path = path_of(path, "mesh")
    name = f"mesh '{shown(path.name or path, 255)}'"
    readers = {".stl": _read_stl, ".obj": _read_obj, ".ply": read_ply, ".off": _read_off}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        ending = f"unknown ending '{shown(path.suffix)}'" if path.suffix else "no ending, which tells what is in a file"
        raise InputError(f"{name}: {ending}; give one of {', '.join(readers)}")
    if not (is_number(scale) and scale > 0):
        raise InputError(f"{name}: scale = {scale!r}; must be a finite number > 0, metres per unit of the file")
    surface = reader(read_bytes(path, name, MOST_BYTES, "simplify the mesh"), name)
    if len(surface.corners) == 0:
        raise InputError(f"{name}: no triangles; the file is empty")
    with np.errstate(over="ignore", under="ignore"):
        return surface._replace(corners=surface.corners * scale), name


# --- STL


def _read_stl(data, name):
    announced = int.from_bytes(data[80:84], "little")
    size = STL_HEADER + STL_TRIANGLE * announced
    if len(data) >= STL_HEADER and len(data) == size:
        refuse_many(announced, name, mesh_text.MOST_TRIANGLES, "triangles")
        return _read_binary_stl(data, name, announced)
    if data[:STL_HEADER].lstrip()[:5].lower() == b"solid" and b"\0" not in data:
        return _read_ascii_stl(data, name)
    if len(data) < STL_HEADER:
        raise InputError(
            f"{name}: the file has {len(data)} bytes; a binary STL has {STL_HEADER} or more, an ASCII STL begins with 'solid'"
        )
    raise InputError(
        f"{name}: header announces {announced} triangles ({_size(size)}), the file has {len(data)} bytes; is it an ASCII STL?"
    )


def _size(count):
    """A number of bytes, readable."""
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count} bytes"


def _read_binary_stl(data, name, count):
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(data, record, count, STL_HEADER)["corners"].astype(float)
    bad = np.flatnonzero(~np.isfinite(corners).all(axis=(1, 2)))
    if len(bad):
        raise InputError(f"{name}, triangle {bad[0] + 1}: corner {corners[bad[0]].tolist()} is not finite; repair the file")
    return Surface(corners, np.zeros(count, dtype=int))


def _read_ascii_stl(data, name):
    """Lines of: solid, facet normal, outer loop, three times vertex x y z, endloop, endfacet, endsolid."""
    mesh, inside, solids = Indexed(name, first=1), 0, 0
    for line, words in lines(BytesIO(data), name):
        key = words[0].lower()
        if key == "vertex":
            mesh.vertex(words[1:], line)
            inside += 1
        elif key == "endloop":
            if inside != 3:
                raise InputError(f"{name}, line {line}: facet with {inside} vertices; an STL facet has 3")
            mesh.face(range(mesh.defined - 3, mesh.defined), line, solids)
            inside = 0
        elif key == "solid":
            solids += 1
        elif key not in ("facet", "outer", "endfacet", "endsolid"):
            raise InputError(f"{name}, line {line}: {quoted(words[:1])} is no word of an ASCII STL; expected facet, vertex, ...")
    if inside:
        raise InputError(f"{name}: the file ends within a facet; it was cut off")
    return mesh.surface()


# --- OBJ


def _read_obj(data, name):
    """Vertices `v x y z`, faces `f a b c ...` with indices from 1 (or from the end if negative), groups `o` and `g`."""
    mesh, groups = Indexed(name, first=1), 0
    for line, words in lines(BytesIO(data), name):
        if words[0] == "v":
            mesh.vertex(words[1:4], line)
        elif words[0] in ("o", "g"):
            groups += 1
        elif words[0] == "f":
            numbers, defined = mesh.vertex_numbers(words[1:], line), mesh.defined
            mesh.face([k - 1 if k >= 0 else defined + k for k in numbers], line, groups, numbers)
    return mesh.surface()


# --- OFF


def _read_off(data, name):
    """The word OFF, how many vertices and faces, then a line for each: coordinates; how many corners, and their indices."""
    mesh, following = Indexed(name, first=0), lines(BytesIO(data), name)
    line, words = next(following, (1, [""]))
    if words[0] not in ("OFF", "COFF", "NOFF", "CNOFF") or words[1:2] == ["BINARY"]:
        raise InputError(f"{name}: not a readable OFF file; it must begin with the word OFF and be of text")
    counts = words[1:3] or next(following, (line, []))[1][:2]
    if len(counts) < 2 or not all(count.isascii() and count.isdigit() for count in counts):
        raise InputError(
            f"{name}: not a readable OFF file; {quoted(counts)} follows OFF, the numbers of vertices and faces are needed"
        )
    vertices, faces = map(integer, counts)
    refuse_many(vertices, name, mesh_text.MOST_VERTICES, "vertices")
    refuse_many(faces, name, mesh_text.MOST_TRIANGLES, "triangles")
    for number in range(vertices + faces):
        line, words = next(following, (line, None))
        if words is None:
            raise InputError(
                f"{name}, line {line}: the file ends here, its header announces {vertices} vertices and {faces} "
                "faces; it was cut off"
            )
        if number < vertices:
            mesh.vertex(words[:3], line)
            continue
        corners = integer(words[0])
        if corners is None or not 0 <= corners < len(words):
            raise InputError(f"{name}, line {line}: face {quoted(words)}; the number of its corners must stand first, then they")
        mesh.face(mesh.vertex_numbers(words[1 : 1 + corners], line), line)
    return mesh.surface()
