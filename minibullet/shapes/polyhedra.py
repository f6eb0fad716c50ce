"""Geometry of flat-faced solids: the faces of a convex hull, and exact volume, centre and inertia.

Every tolerance is relative to the size of the solid, and only dimensionless numbers are compared with it. So a solid
scaled by a power of two has the same faces, and properties that are scaled bit for bit.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from minibullet.errors import InputError
from minibullet.rotations import cross, dot

# A point set flatter than this part of its size has no volume that double precision could measure.
FLAT = 1e-12
# Triangles that leave a common plane by less than this part of the size are one face. Mesh files with 32-bit numbers
# are exact to about 1e-7 of the size, real edges are larger by far. For thin solids it is this part of the thickness.
COPLANAR = 1e-6
COPLANAR_IN_THICKNESS = 1e-3
# ... and their normals agree at least roughly, so that a sharp edge is never one face.
COPLANAR_COSINE = 0.9
# Points up to which qhull merges the triangles of one plane itself. That costs the square of the corners of a face: 0.1 s
# for a prism of so many points, minutes for one of 48,000. Beyond it, the input is joggled, by some 1e-11 of the size: nothing
# is merged, the cost is that of sorting, and the faces are told by the rules above as before.
MOST_MERGED = 2000


class MassProperties(NamedTuple):
    """What a solid of unit density weighs and how it resists turning."""

    volume: float  # m3
    centre_of_mass: np.ndarray  # (3,) m, in the frame of the vertices
    inertia: np.ndarray  # (3, 3) m5 = kg m2 per kg/m3, about the centre of mass, axes of the vertices


def middle(points):
    """Centre of the bounding box of points (n, 3): the reference that keeps sums of products accurate. -> (3,)."""
    return 0.5 * points.min(axis=0) + 0.5 * points.max(axis=0)


def unit_scaled(points):
    """Points moved to their middle and divided by a power of two, so that the largest half extent lies in [1/2, 1)."""
    half_extent = np.max(0.5 * points.max(axis=0) - 0.5 * points.min(axis=0))
    return np.ldexp(points - middle(points), -int(np.frexp(half_extent)[1]))


def convex_hull(points, name="hull"):
    """Corners and faces of the convex hull of points (n, 3).

    -> corners: indices into points, increasing; faces: tuple of tuples of indices into the corners, counter-clockwise
    seen from outside, each starting at its smallest index, sorted. Coplanar triangles are merged into one polygon.
    Raises InputError for fewer than four points, or points that lie in a plane.
    """
    if len(points) < 4:
        plural = "" if len(points) == 1 else "s"
        raise InputError(f"{name}: {len(points)} point{plural}; a hull needs at least 4 points, not in one plane")
    scaled = unit_scaled(points)
    thickness = np.ptp(scaled @ np.linalg.svd(scaled - scaled.mean(axis=0), full_matrices=False)[2][2])
    if thickness <= FLAT:
        raise _flat(name, len(points))
    tolerance = min(COPLANAR, COPLANAR_IN_THICKNESS * thickness)
    corners = np.arange(len(points))
    while True:
        try:
            hull = ConvexHull(scaled[corners], qhull_options="Qt" if len(corners) <= MOST_MERGED else "QJ")
        except QhullError:
            raise _flat(name, len(points)) from None
        normals = hull.equations[:, :3]
        triangles = _outward(hull.simplices, normals, scaled[corners])
        regions = _coplanar_regions(triangles, normals, hull.neighbors, scaled[corners], tolerance)
        # A true corner belongs to three faces at least; other points lie on an edge, within a face or inside.
        face = np.repeat(np.arange(len(regions)), [len(region) for region in regions])
        members = np.unique(face[:, None] * len(corners) + triangles[np.concatenate(regions)]) % len(corners)
        true = np.bincount(members, minlength=len(corners)) >= 3
        if true.all():
            break
        if true.sum() < 4:
            raise _flat(name, len(points))
        corners = corners[true]
    return corners, tuple(sorted(_outline(triangles[region].tolist(), name) for region in regions))


def _flat(name, count):
    return InputError(
        f"{name}: {count} points are coplanar within {FLAT:.0e} of the size; a hull needs volume (give the plate a thickness)"
    )


def _outward(triangles, normals, points):
    """Turn each triangle (t, 3) counter-clockwise about its outward normal (t, 3)."""
    inward = np.einsum("ti,ti->t", _doubled_areas(points, triangles), normals) < 0
    return np.where(inward[:, None], triangles[:, ::-1], triangles)


def _doubled_areas(points, triangles):
    """Vector across each triangle (t, 3), as long as twice its area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _coplanar_regions(triangles, normals, neighbours, points, tolerance):
    """Groups of adjacent triangles in one plane, grown from the largest triangle left: list of index lists.

    The plane is the seed's, not the neighbour's, so that a finely faceted round surface is not swallowed step by step.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(_doubled_areas(points, triangles), axis=1)
    longest = np.max(np.linalg.norm([b - a, c - b, a - c], axis=2), axis=0)
    sliver = (area <= tolerance * longest).tolist()  # rounding turns its normal anywhere
    free = [True] * len(triangles)
    # Lists of plain numbers: most regions are of two triangles, where calls on small arrays cost more than the arithmetic.
    (x, y, z), (u, v, w), (a, b, c) = points.T.tolist(), normals.T.tolist(), triangles.T.tolist()
    beside = neighbours.ravel().tolist()
    regions = []
    for seed in np.argsort(-area, kind="stable").tolist():
        if not free[seed]:
            continue
        nx, ny, nz = u[seed], v[seed], w[seed]
        offset = nx * x[a[seed]] + ny * y[a[seed]] + nz * z[a[seed]]
        free[seed] = False
        region = [seed]
        for member in region:  # it grows while it is walked
            for other in beside[3 * member : 3 * member + 3]:
                if (
                    free[other]
                    and (sliver[other] or nx * u[other] + ny * v[other] + nz * w[other] > COPLANAR_COSINE)
                    and abs(nx * x[a[other]] + ny * y[a[other]] + nz * z[a[other]] - offset) < tolerance
                    and abs(nx * x[b[other]] + ny * y[b[other]] + nz * z[b[other]] - offset) < tolerance
                    and abs(nx * x[c[other]] + ny * y[c[other]] + nz * z[c[other]] - offset) < tolerance
                ):
                    free[other] = False
                    region.append(other)
        regions.append(region)
    return regions


def _outline(triangles, name):
    """The outer loop of a patch of equally turned triangles [t][3], from its smallest index: the edges without opposite."""
    edges = {edge for a, b, c in triangles for edge in ((a, b), (b, c), (c, a))}
    following = {a: b for a, b in edges if (b, a) not in edges}
    loop = [min(following)]
    while (after := following.get(loop[-1])) != loop[0] and after is not None and len(loop) < len(edges):
        loop.append(after)
    if len(loop) != len(following) or len(set(loop)) != len(loop):
        raise InputError(f"{name}: faces cannot be told apart within rounding; give fewer or cleaner points")
    return tuple(loop)


def edges_of(faces):
    """Each edge once, smaller index first, sorted: (e, 2)."""
    edges = {tuple(sorted((loop[k - 1], loop[k]))) for loop in faces for k in range(len(loop))}
    return np.array(sorted(edges), dtype=np.int64).reshape(-1, 2)


def planes_of(vertices, faces):
    """Outward unit normals (f, 3) and offsets (f,) of the faces: inside is normal . x <= offset.

    The normal is the direction of the area vector of the polygon (Newell). The offset is that of the outermost
    vertex of the face: no vertex of the face lies outside.
    """
    flat = np.array([corner for loop in faces for corner in loop])
    ends = np.cumsum([len(loop) for loop in faces])
    starts = ends - [len(loop) for loop in faces]
    points = vertices[flat]
    arms = points - np.repeat(points[starts], ends - starts, axis=0)
    doubled = np.zeros_like(arms)
    doubled[:-1] = np.cross(arms[:-1], arms[1:])
    normals, offsets = [], []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        area = np.sum(doubled[start + 1 : end - 1], axis=0)
        scale = np.max(np.abs(area))
        normal = area / scale
        normal = normal / np.sqrt(dot(normal, normal))
        normals.append(normal + 0.0)  # no negative zeros
        offsets.append(np.max(dot(points[start:end], normal)))
    return np.array(normals), np.array(offsets)


def triangles_of(faces):
    """The faces cut into fans of triangles: (t, 3)."""
    return np.array([(loop[0], loop[k], loop[k + 1]) for loop in faces for k in range(1, len(loop) - 1)], dtype=np.int64)


def area_of(vertices, triangles):
    """Total area of triangles (t, 3) [m2]."""
    return 0.5 * float(np.sum(np.sqrt(np.sum(_doubled_areas(vertices, triangles) ** 2, axis=1))))


def mass_properties(vertices, triangles):
    """Exact volume, centre and inertia of the solid inside a closed surface of outward triangles (t, 3).

    Sum over the signed tetrahedra (o, a, b, c), with d = a . (b x c): volume d/6, first moment d/24 (a+b+c), second
    moment d/120 (s s^T + a a^T + b b^T + c c^T), s = a+b+c. F. Tonon, Explicit exact formulas for the 3-D
    tetrahedron inertia tensor, J. Mathematics and Statistics 1 (2005) 8-11. A volume <= 0 is returned as it is.
    """
    origin = middle(vertices)
    corners = (vertices - origin)[triangles]
    total = corners.sum(axis=1)
    d = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volume = float(np.sum(d)) / 6.0
    first = np.einsum("t,ti->i", d, total) / 24.0
    second = (np.einsum("t,ti,tj->ij", d, total, total) + np.einsum("t,tki,tkj->ij", d, corners, corners)) / 120.0
    arm = first / volume if volume else np.zeros(3)
    second = second - volume * np.outer(arm, arm)
    return MassProperties(volume, origin + arm, inertia_of(second))


def inertia_of(second_moment):
    """Inertia tensor tr(C) 1 - C of a second moment C (3, 3), symmetric to the last bit."""
    c = 0.5 * (second_moment + second_moment.T)
    return np.trace(c) * np.eye(3) - c


def parallel_axes(volume, arm):
    """What moving the reference point by arm (3,) away from the centre of mass adds to the inertia."""
    return volume * (dot(arm, arm) * np.eye(3) - np.outer(arm, arm))


def principal_axes(tensor):
    """Eigenvalues (3,), rising, and eigenvectors, columns of a rotation matrix (3, 3), of a symmetric tensor (3, 3).

    Jacobi's rotations, each of which makes one entry beside the diagonal zero (Golub and Van Loan, Matrix Computations, 8.5):
    arithmetic that rounds alike on every processor, as the linear algebra library's does not.
    """
    a, axes = np.array(tensor, dtype=float), np.eye(3)
    for _ in range(20):  # the entries fall quadratically: some six rounds reach rounding
        if not np.abs(a[[0, 0, 1], [1, 2, 2]]).max() > 1e-17 * np.abs(a).max():
            break
        for p, q in ((0, 1), (0, 2), (1, 2)):
            half = 0.5 * (a[q, q] - a[p, p])
            away = abs(half) + np.sqrt(half * half + a[p, q] * a[p, q])
            tangent = a[p, q] / (away if half >= 0.0 else -away) if away else 0.0
            cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
            sine = tangent * cosine
            for columns in (a, a.T, axes):
                first, second = columns[:, p].copy(), columns[:, q].copy()
                columns[:, p], columns[:, q] = cosine * first - sine * second, sine * first + cosine * second
    order = np.argsort(np.diag(a), kind="stable")
    axes = axes[:, order]
    axes[:, 2] = cross(axes[:, 0], axes[:, 1])
    return np.diag(a)[order], axes


def common_ball(first, second):
    """Radius of the largest ball inside two convex solids at once: their overlap, 0 when they only touch or are apart.

    first, second: (normals, offsets) with inside = normals . x <= offsets. A linear programme: the largest r with
    normals . x + r <= offsets for all planes of both (Boyd and Vandenberghe, Convex Optimization, 8.5.1).
    """
    from scipy.optimize import linprog  # here: it takes as long to load as all other parts of SciPy

    normals = np.concatenate([first[0], second[0]])
    offsets = np.concatenate([first[1], second[1]])
    # Numbers of order one, about a point near both, suit the tolerances of the programme.
    origin = np.linalg.lstsq(normals, offsets, rcond=None)[0]
    offsets = offsets - normals @ origin
    exponent = int(np.frexp(np.max(np.abs(offsets)))[1])
    planes = np.column_stack([normals, np.ones(len(normals))])
    solution = linprog([0, 0, 0, -1], planes, np.ldexp(offsets, -exponent), bounds=[(None, None)] * 3 + [(0, None)])
    return float(np.ldexp(-solution.fun, exponent)) if solution.success else 0.0
