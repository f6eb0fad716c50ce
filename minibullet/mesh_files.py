"""Solids from mesh files: STL and OBJ, read and checked line by line; PLY and OFF through trimesh.

A file is believed only after its sizes, indices and numbers are checked; every refusal is an InputError that names
file, line, value and remedy. Nothing but the given file is opened: material libraries and textures are ignored.
Formats: M. Burns, Automated Fabrication (1993), section 6.5 (STL); Wavefront, Advanced Visualizer Manual, B1 (OBJ).
"""

from array import array
from io import BytesIO
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from minibullet import polyhedra
from minibullet.convex import ConvexPiece
from minibullet.errors import InputError
from minibullet.shapes import Compound

# A rigid body is made of few faces; a file beyond these sizes is a mistake, and would take longer than a user waits.
MOST_BYTES = 64_000_000
MOST_TRIANGLES = 100_000
MOST_PIECES = 64
MOST_LINE = 100_000                         # bytes in one line of text
# A solid whose hull is larger by more than this part of the volume is not convex; 32-bit files round to about 1e-7.
CONVEX = 1e-5

STL_HEADER, STL_TRIANGLE = 84, 50           # bytes; each triangle: 12 32-bit numbers and 2 bytes more


class Surface(NamedTuple):
    """Triangles as they stand in a file."""

    corners: np.ndarray     # (t, 3, 3) m: triangle, corner, coordinate
    group: np.ndarray       # (t,) which named solid of the file a triangle belongs to


def mesh_file(path, scale=1.0):
    """The solid in a mesh file: a ConvexPiece, or a Compound where the file holds several closed convex solids.

    path: .stl, .obj, .ply or .off; scale: metres per unit of the file. Raises InputError for anything but closed,
    outward, convex solids that do not overlap.
    """
    path = Path(path)
    name = f"mesh '{path.name}'"
    readers = {".stl": _read_stl, ".obj": _read_obj, ".ply": _read_ply, ".off": _read_off}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{name}: unknown ending '{path.suffix}'; give one of {', '.join(readers)}")
    if not (isinstance(scale, (int, float)) and isfinite(scale) and scale > 0):
        raise InputError(f"{name}: scale = {scale!r}; must be a finite number > 0, metres per unit of the file")
    surface = reader(_bytes(path, name), name)
    if len(surface.corners) == 0:
        raise InputError(f"{name}: no triangles; the file is empty")
    _refuse_many(len(surface.corners), name)
    # A solid too small or too large to be weighed is refused below; no need to warn of it first.
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return _solid(surface._replace(corners=surface.corners * scale), name)


def _bytes(path, name):
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise InputError(f"{name}: {size / 1e6:.0f} MB, at most {MOST_BYTES / 1e6:.0f} MB are read; simplify the mesh")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{name}: cannot be read ({error.strerror}); looked for {path}") from None


def _refuse_many(count, name):
    if count > MOST_TRIANGLES:
        raise InputError(f"{name}: {count} triangles or more, at most {MOST_TRIANGLES} are read; simplify the mesh")


# --- from bytes to triangles

def _read_stl(data, name):
    announced = int.from_bytes(data[80:84], "little")
    size = STL_HEADER + STL_TRIANGLE * announced
    if len(data) >= STL_HEADER and len(data) == size:
        _refuse_many(announced, name)
        return _read_binary_stl(data, name, announced)
    text = data.lstrip()[:5].lower() == b"solid" and b"\0" not in data
    if text:
        return _read_ascii_stl(data, name)
    if len(data) < STL_HEADER:
        raise InputError(f"{name}: the file has {len(data)} bytes; a binary STL has {STL_HEADER} or more, "
                         "an ASCII STL begins with 'solid'")
    raise InputError(f"{name}: header announces {announced} triangles ({_size(size)}), the file has {len(data)} bytes; "
                     "is it an ASCII STL?")


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
    corners, group, inside, solids = array("d"), array("q"), 0, 0
    for line, words in _lines(data, name):
        key = words[0].lower()
        if key == "vertex":
            corners.extend(_numbers(words[1:], 3, name, line, "vertex"))
            inside += 1
        elif key == "solid":
            solids += 1
        elif key == "endloop":
            if inside != 3:
                raise InputError(f"{name}, line {line}: facet with {inside} vertices; an STL facet has 3")
            group.append(solids)
            inside = 0
            _refuse_many(len(group), name)
        elif key not in ("facet", "outer", "endfacet", "endsolid"):
            raise InputError(f"{name}, line {line}: '{words[0][:40]}' is no word of an ASCII STL; expected facet, vertex, ...")
    if inside:
        raise InputError(f"{name}: the file ends within a facet; it was cut off")
    return Surface(np.array(corners).reshape(-1, 3, 3), np.array(group, dtype=int))


def _read_obj(data, name):
    """Vertices `v x y z`, faces `f a b c ...` with indices from 1 (or from the end if negative), groups `o` and `g`."""
    vertices, triangles, group, lines, groups = array("d"), array("q"), array("q"), array("q"), 0
    for line, words in _lines(data, name):
        if words[0] == "v":
            vertices.extend(_numbers(words[1:4], 3, name, line, "vertex"))
        elif words[0] in ("o", "g"):
            groups += 1
        elif words[0] == "f":
            loop = [_obj_index(word, len(vertices) // 3, name, line) for word in words[1:]]
            if len(loop) < 3:
                raise InputError(f"{name}, line {line}: face with {len(loop)} vertices; a face needs 3 or more")
            for k in range(1, len(loop) - 1):
                triangles.extend((loop[0], loop[k], loop[k + 1]))
                group.append(groups)
                lines.append(line)
            _refuse_many(len(group), name)
    vertices, triangles = np.array(vertices).reshape(-1, 3), np.array(triangles).reshape(-1, 3)
    outside = np.flatnonzero((triangles >= len(vertices)).any(axis=1))
    if len(outside):
        raise InputError(f"{name}, line {lines[outside[0]]}: face uses vertex {triangles[outside[0]].max() + 1}, "
                         f"but only {len(vertices)} vertices are defined")
    corners = vertices[triangles] if len(triangles) else np.zeros((0, 3, 3))
    return Surface(corners, np.array(group, dtype=int))


def _obj_index(word, defined, name, line):
    """Index from 0 of a face corner such as 3, 3/1, 3//2 or -1."""
    text = word.split("/", 1)[0]
    try:
        index = int(text)
    except ValueError:
        raise InputError(f"{name}, line {line}: face corner '{word[:40]}' is no vertex number") from None
    if index == 0 or index < -defined or index > 2**62:
        raise InputError(f"{name}, line {line}: face uses vertex {text[:40]}, but only {defined} vertices are defined")
    return index - 1 if index > 0 else defined + index


def _lines(data, name):
    """(line number from 1, words) of every line that says something; a closing backslash joins lines."""
    words, number, text = [], 0, BytesIO(data)
    while line := text.readline(MOST_LINE):
        number += 1
        if len(line) == MOST_LINE or len(words) > MOST_LINE:
            raise InputError(f"{name}, line {number}: longer than {MOST_LINE} bytes; this is no mesh file")
        words += line.decode("latin-1").split("#", 1)[0].split()
        if words and words[-1].endswith("\\"):
            words[-1] = words[-1][:-1]
            words = [word for word in words if word]
        elif words:
            yield number, words
            words = []
    if words:
        yield number, words


def _numbers(words, count, name, line, what):
    """count finite numbers, or InputError."""
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise InputError(f"{name}, line {line}: {what} '{' '.join(words)[:60]}'; {count} numbers are needed")
    if not all(map(isfinite, numbers)):
        raise InputError(f"{name}, line {line}: {what} '{' '.join(words)[:60]}' is not finite")
    return numbers


def _read_ply(data, name):
    header, end, _ = data.partition(b"end_header")
    if not data.startswith(b"ply") or not end:
        raise InputError(f"{name}: no PLY header; the file must begin with 'ply' and have a line 'end_header'")
    for line, words in _lines(header, name):
        if words[0] == "element" and (len(words) != 3 or not words[2].isascii() or not words[2].isdigit()
                                      or int(words[2][:20]) > len(data)):
            raise InputError(f"{name}, line {line}: '{' '.join(words)[:60]}', the file has {len(data)} bytes; it was cut off")
    return _read_with_trimesh(data, name, "ply")


def _read_off(data, name):
    return _read_with_trimesh(data, name, "off")


def _read_with_trimesh(data, name, kind):
    import trimesh

    try:
        mesh = trimesh.load_mesh(BytesIO(data), file_type=kind, process=False)
        vertices, faces = np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64)
    except Exception as error:          # whatever a foreign parser raises on bad input: KeyError, IndexError, ...
        raise InputError(f"{name}: not a readable {kind.upper()} file ({type(error).__name__}: {str(error)[:80]})") from None
    if len(faces) and not (0 <= faces.min() and faces.max() < len(vertices)):
        raise InputError(f"{name}: face uses vertex {faces.max()} (from 0), but only {len(vertices)} vertices are defined")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        raise InputError(f"{name}: vertex {bad[0]} (from 0) = {vertices[bad[0]].tolist()} is not finite")
    return Surface(vertices[faces], np.zeros(len(faces), dtype=int))


# --- from triangles to solids

def _solid(surface, name):
    """Every closed solid of the surface as a convex piece; one piece, or all of them as a Compound."""
    groups = [surface.corners[surface.group == k] for k in np.unique(surface.group)]
    welded = [_welded(group) for group in groups]
    if any(_open_edge(triangles) is not None for _, triangles in welded):
        # The named parts are no solids one by one; perhaps they are one solid together.
        welded = [_welded(surface.corners)]
    pieces = []
    for vertices, triangles in welded:
        open_edge = _open_edge(triangles)
        if open_edge is not None:
            (a, b), why = open_edge
            raise InputError(f"{name}: not a closed surface, {why} at the edge {_text(vertices[a])} - {_text(vertices[b])}; "
                             "repair the mesh (solids that touch: one named solid or object each)")
        for part in _connected(triangles):
            if len(pieces) == MOST_PIECES:
                raise InputError(f"{name}: more than {MOST_PIECES} separate solids; use fewer pieces")
            pieces.append(_convex_piece(vertices, part, name, len(pieces) + 1))
    if not pieces:
        raise InputError(f"{name}: all triangles have zero size; the file is empty")
    if len(pieces) == 1:
        return pieces[0]
    try:
        return Compound(tuple(pieces))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _text(point):
    return f"({point[0]:.6g}, {point[1]:.6g}, {point[2]:.6g})"


def _welded(corners):
    """Corners at the same place become one vertex; triangles with two equal corners vanish. -> (v, 3), (t, 3)."""
    vertices, index = np.unique(corners.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3)
    a, b, c = triangles.T
    return vertices, triangles[(a != b) & (b != c) & (c != a)]


def _directed_edges(triangles):
    """(3 t, 2): the edges of each triangle in its sense of turn."""
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def _open_edge(triangles):
    """((a, b), what is wrong) for the first edge that has not exactly one triangle on each side, or None."""
    edges, inverse, count = np.unique(_directed_edges(triangles), axis=0, return_inverse=True, return_counts=True)
    if np.any(count > 1):
        edge = edges[np.argmax(count > 1)]
        backwards = np.all(edges == edge[::-1], axis=1).any()
        return edge, "more than two triangles meet" if backwards else "neighbouring triangles are turned opposite ways"
    size = 1 + int(triangles.max(initial=0))
    lonely = ~np.isin(edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0])
    return (edges[np.argmax(lonely)], "a triangle is missing") if np.any(lonely) else None


def _connected(triangles):
    """The triangles of each connected part of a closed surface, in the order of the file."""
    edges = np.sort(_directed_edges(triangles), axis=1)
    # Sorted by edge, the two triangles of each edge stand side by side.
    first, second = (np.lexsort(edges.T) % max(1, len(triangles))).reshape(-1, 2).T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(triangles), len(triangles)))
    count, label = connected_components(graph, directed=False) if len(triangles) else (0, None)
    return [triangles[label == k] for k in range(count)]


def _convex_piece(vertices, triangles, name, number):
    """The hull of one closed solid, after checking that the hull is the solid."""
    used, index = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], index.reshape(-1, 3)
    volume = polyhedra.mass_properties(vertices, triangles).volume
    if volume < 0:
        raise InputError(f"{name}: solid {number} is inside out, volume = {volume:.6g} m3; turn its faces outward "
                         "(hollow solids cannot be read)")
    try:
        piece = ConvexPiece(vertices)
    except InputError as error:
        raise InputError(f"{name}: solid {number}: {error}") from None
    if not abs(piece.volume - volume) <= CONVEX * piece.volume:
        raise InputError(f"{name}: solid {number} is not convex, it fills {100 * volume / piece.volume:.4g} % of its hull; "
                         "cut it into closed convex pieces, one named solid or object each")
    return piece
