"""From one normal to a manifold: up to four contact points a pair of pieces, clipped from the faces that meet.

FCL gives one point a pair, and one point cannot hold a stack. The face whose normal is the contact normal clips the face of
the other piece that looks at it most squarely; every corner left within reach is a contact with its own gap. Points are
matched with those of the step before, so that impulses can start where they ended (warm start).
"""

import numpy as np

from minibullet.collision.clipping import clip, drop_doubles, facing, support_edge, thin_out
from minibullet.collision.feature_cache import STILL
from minibullet.collision.geometry import VERTICES, support_vertex, turn, turn_back
from minibullet.collision.separation import EDGE_EDGE, FACE_A, FACE_B, PLANE, ROUND, core, segment_closest
from minibullet.kernels import leaf

MOST = 9  # contact points of a pair of pieces: one of its own, and four over a face of either [-]
NEAR = 0.1  # a point is the same as last step's if it moved by less than this share of the piece: [-]


@leaf
def face_points(pieces, face, own, other, rotation_own, rotation_other, dx, dy, dz, least, reach, points, gaps, work):
    """Contacts of piece ``other`` on ``face`` of piece ``own`` with gaps from ``least`` to ``reach``: points midway between
    the surfaces, axes of own; returns the count."""
    nx, ny, nz = pieces.normals[face, 0], pieces.normals[face, 1], pieces.normals[face, 2]
    wx, wy, wz = turn(rotation_own, nx, ny, nz)
    tx, ty, tz = turn_back(rotation_other, wx, wy, wz)
    sx, sy, sz = turn_back(rotation_own, dx, dy, dz)
    loop_first, loop_end = pieces.face_ranges[face]
    incident = facing(pieces, other, tx, ty, tz) if loop_first < loop_end else -1
    count = 0
    if incident >= 0:
        first, end = pieces.face_ranges[incident]
    else:  # a plane takes every vertex, a capsule offers its two ends
        first, end = pieces.ranges[other, VERTICES], pieces.ranges[other, VERTICES + 1]
    for k in range(first, end):
        v = pieces.loops[k] if incident >= 0 else k
        x, y, z = turn(rotation_other, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
        x, y, z = turn_back(rotation_own, x, y, z)
        points[count, 0], points[count, 1], points[count, 2] = x + sx, y + sy, z + sz
        count += 1
    if loop_first < loop_end:
        count = clip(pieces, face, points, count, work)
    rounding, own_rounding = pieces.sizes[own, 1] + pieces.sizes[other, 1], pieces.sizes[own, 1]
    kept = 0
    for p in range(count):
        height = nx * points[p, 0] + ny * points[p, 1] + nz * points[p, 2] - pieces.offsets[face]
        gap = height - rounding
        if least <= gap <= reach:
            move = own_rounding + 0.5 * gap - height  # midway between the two surfaces
            points[kept, 0], points[kept, 1] = points[p, 0] + move * nx, points[p, 1] + move * ny
            points[kept, 2] = points[p, 2] + move * nz
            gaps[kept] = gap
            kept += 1
    return thin_out(points, gaps, kept)


@leaf
def side_points(
    pieces, face, own, other, rotation_own, rotation_other, dx, dy, dz, side, least, most, points, gaps, normals, work, first
):
    """``face_points`` appended from ``first`` on, turned to world axes about a, with normals from a to b; returns the new
    count.

    side: 1 where the face is a's, -1 where it is b's; (dx, dy, dz) is always b's position minus a's.
    """
    count = face_points(
        pieces,
        face,
        own,
        other,
        rotation_own,
        rotation_other,
        side * dx,
        side * dy,
        side * dz,
        least,
        most,
        points[first:],
        gaps[first:],
        work,
    )
    x, y, z = turn(rotation_own, pieces.normals[face, 0], pieces.normals[face, 1], pieces.normals[face, 2])
    shift = 0.0 if side > 0.0 else 1.0
    for p in range(first, first + count):
        normals[p, 0], normals[p, 1], normals[p, 2] = side * x, side * y, side * z
        u, v, w = turn(rotation_own, points[p, 0], points[p, 1], points[p, 2])
        points[p, 0], points[p, 1], points[p, 2] = u + shift * dx, v + shift * dy, w + shift * dz
    return first + count


@leaf
def single_point(pieces, kind, first, second, i, j, rotation_a, rotation_b, dx, dy, dz, nx, ny, nz, points):
    """The point, world axes about a, midway between two edges, two round bodies or two corners along the normal; returns 1 or
    2.

    Two parallel capsules touch along a line: both of its ends are given.
    """
    ax, ay, az = turn_back(rotation_a, nx, ny, nz)
    bx, by, bz = turn_back(rotation_b, -nx, -ny, -nz)
    radius_a, radius_b = pieces.sizes[i, 1], pieces.sizes[j, 1]
    if kind == EDGE_EDGE:
        e, f = support_edge(pieces, i, first, ax, ay, az), support_edge(pieces, j, second, bx, by, bz)
        v, w = pieces.edges[e, 0], pieces.edges[e, 1]
        px, py, pz = turn(rotation_a, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
        ux, uy, uz = turn(rotation_a, pieces.vertices[w, 0], pieces.vertices[w, 1], pieces.vertices[w, 2])
        v, w = pieces.edges[f, 0], pieces.edges[f, 1]
        qx, qy, qz = turn(rotation_b, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
        vx, vy, vz = turn(rotation_b, pieces.vertices[w, 0], pieces.vertices[w, 1], pieces.vertices[w, 2])
        ux, uy, uz, vx, vy, vz = ux - px, uy - py, uz - pz, vx - qx, vy - qy, vz - qz
    elif (
        kind == ROUND
        and pieces.ranges[i, VERTICES + 1] - pieces.ranges[i, VERTICES] <= 2
        and pieces.ranges[j, VERTICES + 1] - pieces.ranges[j, VERTICES] <= 2
    ):
        px, py, pz, ux, uy, uz = core(pieces, i, rotation_a)
        qx, qy, qz, vx, vy, vz = core(pieces, j, rotation_b)
        uu, vv, uv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz
        if uu > 0.0 and vv > 0.0 and uu * vv - uv * uv < 1e-8 * uu * vv:
            low = min(max((ux * (qx + dx - px) + uy * (qy + dy - py) + uz * (qz + dz - pz)) / uu, 0.0), 1.0)
            high = min(max((ux * (qx + vx + dx - px) + uy * (qy + vy + dy - py) + uz * (qz + vz + dz - pz)) / uu, 0.0), 1.0)
            for p in range(2):
                s = low if p == 0 else high
                points[p, 0], points[p, 1] = px + s * ux + radius_a * nx, py + s * uy + radius_a * ny
                points[p, 2] = pz + s * uz + radius_a * nz
            return 2
    elif kind == ROUND and pieces.ranges[i, VERTICES + 1] - pieces.ranges[i, VERTICES] == 1:
        v = pieces.ranges[i, VERTICES]
        px, py, pz = turn(rotation_a, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
        points[0, 0], points[0, 1], points[0, 2] = px + radius_a * nx, py + radius_a * ny, pz + radius_a * nz
        return 1
    elif kind == ROUND:
        v = pieces.ranges[j, VERTICES]
        px, py, pz = turn(rotation_b, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
        points[0, 0], points[0, 1], points[0, 2] = px + dx - radius_b * nx, py + dy - radius_b * ny, pz + dz - radius_b * nz
        return 1
    else:
        v, w = support_vertex(pieces, i, ax, ay, az), support_vertex(pieces, j, bx, by, bz)
        px, py, pz = turn(rotation_a, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
        qx, qy, qz = turn(rotation_b, pieces.vertices[w, 0], pieces.vertices[w, 1], pieces.vertices[w, 2])
        ux = uy = uz = vx = vy = vz = 0.0
        # at a face, the corner of the other piece says where; any corner of the face only says how high
        height = nx * (qx + dx - px) + ny * (qy + dy - py) + nz * (qz + dz - pz)
        if kind == FACE_A:
            px, py, pz = qx + dx - height * nx, qy + dy - height * ny, qz + dz - height * nz
        elif kind == FACE_B:
            qx, qy, qz = px + height * nx - dx, py + height * ny - dy, pz + height * nz - dz
    s, t = segment_closest(px, py, pz, ux, uy, uz, qx + dx, qy + dy, qz + dz, vx, vy, vz)
    points[0, 0] = 0.5 * (px + s * ux + radius_a * nx + qx + dx + t * vx - radius_b * nx)
    points[0, 1] = 0.5 * (py + s * uy + radius_a * ny + qy + dy + t * vy - radius_b * ny)
    points[0, 2] = 0.5 * (pz + s * uz + radius_a * nz + qz + dz + t * vz - radius_b * nz)
    return 1


def build(
    pieces, rows, answers, numbers, contact_range, scratch, position, rotation, stride, margin, old_point, old_normal, old_impulse
):  # fmt: skip
    """All contacts of the step, in the order of the pair list.

    Last step's contacts: the points on a's and b's surfaces in their body axes (m, 6), normals and impulses [N s] in world
    axes (m, 3). Returns bodies (m, 2), arms from a's centre to a's surface and from b's to b's, and the normal (m, 9), gap
    (m,), last step's impulse where the contact is known from there (m, 3), and the points in body axes (m, 6).
    ``contact_range`` is brought up to date. ``scratch``: of ``clipping.polygons``.
    """
    most = MOST * near(pieces.sizes, rows, numbers, stride) + len(old_point)
    contacts = (
        np.empty((most, 2), dtype=np.int64), np.empty((most, 9)), np.empty(most), np.empty((most, 3)), np.empty((most, 6))
    )  # fmt: skip
    total = fill(
        pieces, rows, answers, numbers, contact_range, position, rotation, stride, margin,
        old_point, old_normal, old_impulse, *contacts, *scratch,
    )  # fmt: skip
    return tuple(array[:total] for array in contacts)


@leaf
def near(sizes, rows, numbers, stride):
    """How many rows may touch in this step; ``sizes`` of the pieces."""
    count = 0
    for k in range(len(rows)):
        size = min(sizes[rows[k, 2], 0], sizes[rows[k, 3], 0])
        count += not numbers[k, 0] > stride[rows[k, 0]] + stride[rows[k, 1]] + 2e-3 * size  # as below, NaN counts
    return count


@leaf
def fill(
    pieces, rows, answers, numbers, contact_range, position, rotation, stride, margin, old_point, old_normal, old_impulse,
    bodies, vectors, gaps, impulse, local, points, point_gaps, normals, work,
):  # fmt: skip
    """The work of ``build``, into arrays that are long enough; returns the number of contacts."""
    total = 0
    for k in range(len(rows)):
        a, b, i, j = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
        old_first, old_end = contact_range[k, 0], contact_range[k, 1]
        contact_range[k, 0] = contact_range[k, 1] = total
        size = min(pieces.sizes[i, 0], pieces.sizes[j, 0])
        reach = stride[a] + stride[b] + 2e-3 * size
        if numbers[k, 0] > reach or (numbers[k, 6] == 0.0 and numbers[k, 7] == 0.0 and numbers[k, 8] == 0.0):
            numbers[k, 10] = np.inf
            continue
        dx, dy, dz = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
        if numbers[k, 10] <= STILL * size:
            # nothing moved far enough to change who touches where: the same points, carried along with their bodies
            for old in range(old_first, old_end):
                px, py, pz = turn(rotation[a], old_point[old, 0], old_point[old, 1], old_point[old, 2])
                qx, qy, qz = turn(rotation[b], old_point[old, 3], old_point[old, 4], old_point[old, 5])
                nx, ny, nz = old_normal[old, 0], old_normal[old, 1], old_normal[old, 2]
                bodies[total, 0], bodies[total, 1] = a, b
                enter(vectors[total], px, py, pz, qx, qy, qz, nx, ny, nz)
                gaps[total] = nx * (qx + dx - px) + ny * (qy + dy - py) + nz * (qz + dz - pz)
                for axis in range(3):
                    impulse[total, axis] = old_impulse[old, axis]
                    local[total, axis], local[total, 3 + axis] = old_point[old, axis], old_point[old, 3 + axis]
                total += 1
            contact_range[k, 1] = total
            continue
        count = pair_points(pieces, k, rows, answers, numbers, rotation[a], rotation[b], dx, dy, dz, reach,
                            margin[a] + margin[b], size, points, point_gaps, normals, work)  # fmt: skip
        numbers[k, 10] = 0.0 if count else np.inf
        for p in range(count):
            bodies[total, 0], bodies[total, 1] = a, b
            x, y, z, u, v, w = points[p, 0], points[p, 1], points[p, 2], normals[p, 0], normals[p, 1], normals[p, 2]
            gap = point_gaps[p] - margin[a] - margin[b]
            half = 0.5 * gap  # from the midpoint to either surface: they meet when the gap has closed
            px, py, pz = x - half * u, y - half * v, z - half * w
            qx, qy, qz = x - dx + half * u, y - dy + half * v, z - dz + half * w
            enter(vectors[total], px, py, pz, qx, qy, qz, u, v, w)
            gaps[total] = gap
            local[total, 0], local[total, 1], local[total, 2] = turn_back(rotation[a], px, py, pz)
            local[total, 3], local[total, 4], local[total, 5] = turn_back(rotation[b], qx, qy, qz)
            # a plane's own axes say nothing: a box that slides takes its contacts along
            side = 3 if answers[k, 0] == PLANE else 0
            nearest, found = (NEAR * size) ** 2, -1
            for old in range(old_first, old_end):
                distance = 0.0
                for axis in range(side, side + 3):
                    distance += (old_point[old, axis] - local[total, axis]) ** 2
                if distance < nearest:
                    nearest, found = distance, old
            for axis in range(3):
                impulse[total, axis] = old_impulse[found, axis] if found >= 0 else 0.0
            if found >= 0:
                old_point[found, side] = np.inf  # taken: no other point may start from it
            total += 1
        contact_range[k, 1] = total
    return total


@leaf
def enter(row, px, py, pz, qx, qy, qz, nx, ny, nz):
    """Write two arms and a normal into a row of nine."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8] = px, py, pz, qx, qy, qz, nx, ny, nz


@leaf
def rise(pieces, face, side, answer, rotation_a, rotation_b):
    """Slope against a face of a (side 0) or b (side 1) of the edge of the other body that makes an edge-edge answer [-]."""
    own, other = (rotation_a, rotation_b) if side == 0 else (rotation_b, rotation_a)
    edge = answer[2] if side == 0 else answer[1]
    x, y, z = turn(own, pieces.normals[face, 0], pieces.normals[face, 1], pieces.normals[face, 2])
    u, v, w = turn(other, pieces.directions[edge, 0], pieces.directions[edge, 1], pieces.directions[edge, 2])
    return abs(x * u + y * v + z * w)


@leaf
def lowest(gaps, count):
    """The smallest of the first ``count`` gaps; infinite if there is none."""
    least = np.inf
    for p in range(count):
        least = min(least, gaps[p])
    return least


@leaf
def pair_points(
    pieces, k, rows, answers, numbers, rotation_a, rotation_b, dx, dy, dz, reach, margin, size, points, gaps, normals, work
):  # fmt: skip
    """Contact points of row k midway between the surfaces, world axes about a, their gaps (margin not taken off) and normals;
    the count."""
    i, j, kind = rows[k, 2], rows[k, 3], answers[k, 0]
    nx, ny, nz, most = numbers[k, 6], numbers[k, 7], numbers[k, 8], reach + margin
    on_face = kind == FACE_A or kind == FACE_B or kind == PLANE
    count = 0
    for side in range(0 if on_face else -1, 2):
        # an answer that is no face begins with its one point (side -1); what else may touch lies over the best faces
        if side >= 0:
            face = answers[k, 1] if on_face else answers[k, 3 + side]
            if face < 0 or kind == ROUND or (on_face and side != (1 if kind == FACE_B else 0)):
                continue
            if kind == EDGE_EDGE and rise(pieces, face, side, answers[k], rotation_a, rotation_b) * NEAR * size > most:
                continue  # the other's edge rises out of reach within the distance at which points count as one
            least = -np.inf if on_face else 0.0
            own, other, turned_own, turned_other, way = i, j, rotation_a, rotation_b, 1.0
            if side == 1:
                own, other, turned_own, turned_other, way = j, i, rotation_b, rotation_a, -1.0
            count = side_points(pieces, face, own, other, turned_own, turned_other, dx, dy, dz, way, least, most,
                                points, gaps, normals, work, count)  # fmt: skip
        # a face that no corner lies over, or only a high one, still has its lowest corner beside the outline
        if side < 0 or (on_face and kind != PLANE and lowest(gaps, count) > numbers[k, 0] + 1e-3 * size):
            first = count
            count += single_point(pieces, kind, answers[k, 1], answers[k, 2], i, j, rotation_a, rotation_b,
                                  dx, dy, dz, nx, ny, nz, points[first:])  # fmt: skip
            for p in range(first, count):
                normals[p, 0], normals[p, 1], normals[p, 2] = nx, ny, nz
                gaps[p] = numbers[k, 0] + margin
    return count if on_face else drop_doubles(points, gaps, normals, count, (NEAR * size) ** 2)
