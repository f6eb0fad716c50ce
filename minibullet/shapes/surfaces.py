"""From triangles to solids: a closed surface of triangles becomes a convex piece, or a compound of several.

Everything is counted before anything is split or made, and costs no more than sorting the triangles does.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from minibullet.errors import InputError
from minibullet.shapes import polyhedra
from minibullet.shapes.convex import ConvexPiece
from minibullet.shapes.primitives import Compound

# Contact is sought between all pieces of a body and of its neighbours: more would take longer than a user waits.
MOST_PIECES = 64
# A solid whose hull is larger by more than this part of the volume is not convex; 32-bit files round to about 1e-7.
CONVEX = 1e-5


def solid(surface, name):
    """Every closed solid of the surface as a convex piece; one piece, or all of them as a Compound.

    name: what messages call it. Raises InputError for anything but closed, outward, convex solids that do not overlap.
    """
    pieces = [convex_piece(*part, name, number) for number, part in enumerate(closed_parts(surface, name), 1)]
    return pieces[0] if len(pieces) == 1 else compound(pieces, name)


def compound(pieces, name):
    """Convex pieces as one Compound; InputError, with what messages call them, where they overlap."""
    try:
        return Compound(tuple(pieces))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def closed_parts(surface, name):
    """Every closed solid of the surface, whatever its form: [(vertices (v, 3) [m], triangles (t, 3)), ...], counter-clockwise
    seen from outside. Raises InputError where the surface is open, inside out or empty, or has too many solids."""
    vertices, triangles, group = _welded(surface)
    if _open_edge(triangles, group) is not None:
        # The named parts are no solids one by one; perhaps they are one solid together.
        group = np.zeros_like(group)
        open_edge = _open_edge(triangles, group)
        if open_edge is not None:
            (a, b), why = open_edge
            raise InputError(
                f"{name}: not a closed surface, {why} at the edge {_text(vertices[a])} - {_text(vertices[b])}; "
                "repair the mesh (solids that touch: one named solid or object each)"
            )
    count, label = _connected(triangles, group)
    if count == 0:
        raise InputError(f"{name}: all triangles have zero size; the file is empty")
    if count > MOST_PIECES:
        raise InputError(f"{name}: {count} separate solids, at most {MOST_PIECES} are read; use fewer pieces")
    parts = np.split(triangles[np.argsort(label, kind="stable")], np.cumsum(np.bincount(label))[:-1])
    return [_closed_part(vertices, part, name, number) for number, part in enumerate(parts, 1)]


def _closed_part(vertices, triangles, name, number):
    """The vertices that one closed solid uses and its triangles, after checking that its faces look outward."""
    used, index = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], index.reshape(-1, 3)
    volume = polyhedra.mass_properties(vertices, triangles).volume
    if volume < 0:
        raise InputError(
            f"{name}: solid {number} is inside out, volume = {volume:.6g} m3; turn its faces outward "
            "(hollow solids cannot be read)"
        )
    return vertices, triangles


def _text(point):
    return f"({point[0]:.6g}, {point[1]:.6g}, {point[2]:.6g})"


def _welded(surface):
    """Corners at the same place become one vertex; triangles with two equal corners vanish. -> (v, 3), (t, 3), (t,).

    The vertices are sorted by x, then y, then z.
    """
    corners = surface.corners.reshape(-1, 3) + 0.0  # no negative zeros
    order = np.lexsort(corners.T[::-1])
    corners = corners[order]
    first = np.ones(len(corners), dtype=bool)
    first[1:] = np.any(corners[1:] != corners[:-1], axis=1)
    index = np.empty(len(corners), dtype=np.int64)
    index[order] = np.cumsum(first) - 1
    triangles = index.reshape(-1, 3)
    a, b, c = triangles.T
    kept = (a != b) & (b != c) & (c != a)
    return corners[first], triangles[kept], surface.group[kept]


def _directed_edges(triangles, group):
    """Start, end and group of the edges of each triangle in its sense of turn: three times (3 t,)."""
    return triangles.T.ravel(), triangles[:, [1, 2, 0]].T.ravel(), np.tile(group, 3)


def _keys(group, first, second, size):
    """One number for each (group, first, second), equal and sorted where they are: below 2**63 within the limits of files."""
    return (group * size + first) * size + second


def _open_edge(triangles, group):
    """((a, b), what is wrong) for the first edge that has not exactly one triangle of its group on each side, or None."""
    first, second, group = _directed_edges(triangles, group)
    size = 1 + int(triangles.max(initial=0))
    forwards, backwards = np.sort(_keys(group, first, second, size)), np.sort(_keys(group, second, first, size))
    twice = forwards[:-1][forwards[1:] == forwards[:-1]]
    lonely = () if len(twice) or np.array_equal(forwards, backwards) else np.setdiff1d(forwards, backwards, assume_unique=True)
    if len(twice):
        key = twice[0]
        why = "more than two triangles meet" if key in backwards else "neighbouring triangles are turned opposite ways"
    elif len(lonely):
        key, why = lonely[0], "a triangle is missing"
    else:
        return None
    return divmod(int(key) % (size * size), size), why


def _connected(triangles, group):
    """How many connected parts the closed surfaces of the groups have, and the part of each triangle (t,), numbered as met."""
    first, second, group = _directed_edges(triangles, group)
    size = 1 + int(triangles.max(initial=0))
    keys = _keys(group, np.minimum(first, second), np.maximum(first, second), size)
    # Sorted by edge, the two triangles of each edge stand side by side.
    first_side, second_side = (np.argsort(keys, kind="stable") % max(1, len(triangles))).reshape(-1, 2).T
    graph = coo_array((np.ones(len(first_side)), (first_side, second_side)), shape=(len(triangles), len(triangles)))
    return connected_components(graph, directed=False) if len(triangles) else (0, np.zeros(0, dtype=int))


def convex_piece(vertices, triangles, name, number):
    """The hull of one of the `closed_parts`, after checking that the hull is the solid; number: what messages call it."""
    volume = polyhedra.mass_properties(vertices, triangles).volume
    try:
        piece = ConvexPiece(vertices)
    except InputError as error:
        raise InputError(f"{name}: solid {number}: {error}") from None
    if not abs(piece.volume - volume) <= CONVEX * piece.volume:
        share = f"{100 * volume / piece.volume:.6g} % of its hull"
        if volume > piece.volume:
            raise InputError(
                f"{name}: solid {number} holds {share}: the surface overlaps itself, or its faces are too fine "
                "for its thickness; simplify the mesh"
            )
        raise InputError(
            f"{name}: solid {number} is not convex, it fills {share}; "
            "cut it into closed convex pieces, one named solid or object each"
        )
    return piece
