"""How far apart two convex pieces are along a direction, and the closed forms of planes, spheres and capsules.

Two convex pieces are apart, touch or overlap by the largest separation over all directions: s(n) = min_b n.x - max_a n.x [m].
"""

import numpy as np

from minibullet.collision.geometry import FACES, VERTICES, edge_vector, length, support, turn, turn_back
from minibullet.kernels import leaf

UNKNOWN, PLANE, FACE_A, FACE_B, EDGE_EDGE, DIRECTION, ROUND = 0, 1, 2, 3, 4, 5, 6  # kinds of answer
PARALLEL = 1e-4  # sine below which two edges span no direction that rounding leaves alone: faces decide there [-]


@leaf
def separation(pieces, i, j, rotation_a, rotation_b, dx, dy, dz, nx, ny, nz):
    """Separation of piece j of b from piece i of a along the world direction n; (dx, dy, dz) is b's position minus a's [m]."""
    ax, ay, az = turn_back(rotation_a, nx, ny, nz)
    bx, by, bz = turn_back(rotation_b, nx, ny, nz)
    apart = nx * dx + ny * dy + nz * dz - support(pieces, i, ax, ay, az) - support(pieces, j, -bx, -by, -bz)
    return apart - pieces.sizes[i, 1] - pieces.sizes[j, 1]


@leaf
def face_separation(pieces, face, other, rotation_own, rotation_other, dx, dy, dz, rounding):
    """Separation of piece ``other`` from the plane of ``face``: (value, world normal); (dx, dy, dz) = other position minus
    own."""
    nx, ny, nz = turn(rotation_own, pieces.normals[face, 0], pieces.normals[face, 1], pieces.normals[face, 2])
    x, y, z = turn_back(rotation_other, nx, ny, nz)
    return nx * dx + ny * dy + nz * dz - pieces.offsets[face] - support(pieces, other, -x, -y, -z) - rounding, nx, ny, nz


@leaf
def edge_normal(pieces, first, second, i, j, rotation_a, rotation_b, dx, dy, dz):
    """Unit normal of two edge directions, from piece i of a towards piece j of b; zero where they are parallel."""
    px, py, pz = turn(rotation_a, pieces.directions[first, 0], pieces.directions[first, 1], pieces.directions[first, 2])
    qx, qy, qz = turn(rotation_b, pieces.directions[second, 0], pieces.directions[second, 1], pieces.directions[second, 2])
    nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    size = length(nx, ny, nz)
    if size < PARALLEL:
        return 0.0, 0.0, 0.0
    ax, ay, az = turn(rotation_a, pieces.centres[i, 0], pieces.centres[i, 1], pieces.centres[i, 2])
    bx, by, bz = turn(rotation_b, pieces.centres[j, 0], pieces.centres[j, 1], pieces.centres[j, 2])
    if nx * (dx + bx - ax) + ny * (dy + by - ay) + nz * (dz + bz - az) < 0.0:
        size = -size
    return nx / size, ny / size, nz / size


@leaf
def segment_closest(p0, p1, p2, u0, u1, u2, q0, q1, q2, v0, v1, v2):
    """Closest points of the segments p + s u and q + t v, 0 <= s, t <= 1: (s, t). Ericson, Real-Time Collision Detection,
    5.1.9."""
    w0, w1, w2 = p0 - q0, p1 - q1, p2 - q2
    a, e = u0 * u0 + u1 * u1 + u2 * u2, v0 * v0 + v1 * v1 + v2 * v2
    b = u0 * v0 + u1 * v1 + u2 * v2
    c, f = u0 * w0 + u1 * w1 + u2 * w2, v0 * w0 + v1 * w1 + v2 * w2
    determinant = a * e - b * b
    s = min(max((b * f - c * e) / determinant, 0.0), 1.0) if determinant > 1e-12 * a * e and determinant > 0.0 else 0.0
    t = (b * s + f) / e if e > 0.0 else 0.0
    if t < 0.0 or t > 1.0 or e == 0.0:
        t = min(max(t, 0.0), 1.0)
        s = min(max((b * t - c) / a, 0.0), 1.0) if a > 0.0 else 0.0
    return s, t


@leaf
def core(pieces, piece, rotation):
    """The core segment of a sphere (length zero) or capsule: start and direction, world axes about the centre of mass."""
    v, w = pieces.ranges[piece, VERTICES], pieces.ranges[piece, VERTICES + 1] - 1
    x, y, z = turn(rotation, pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
    e, f, g = turn(rotation, pieces.vertices[w, 0], pieces.vertices[w, 1], pieces.vertices[w, 2])
    return x, y, z, e - x, f - y, g - z


@leaf
def closest_on_piece(pieces, piece, x, y, z):
    """Point of a polytope nearest to (x, y, z), both in its body axes; the point itself where it lies inside."""
    best, bx, by, bz = np.inf, x, y, z
    inside = True
    for face in range(pieces.ranges[piece, FACES], pieces.ranges[piece, FACES + 1]):
        nx, ny, nz = pieces.normals[face, 0], pieces.normals[face, 1], pieces.normals[face, 2]
        height = nx * x + ny * y + nz * z - pieces.offsets[face]
        if height <= 0.0:
            continue
        inside = False
        px, py, pz = x - height * nx, y - height * ny, z - height * nz
        first, end = pieces.face_ranges[face]
        within = True
        for k in range(first, end):
            v, w = pieces.loops[k], pieces.loops[k + 1 if k + 1 < end else first]
            ux, uy, uz = edge_vector(pieces, v, w)
            ex, ey, ez = px - pieces.vertices[v, 0], py - pieces.vertices[v, 1], pz - pieces.vertices[v, 2]
            if (uy * nz - uz * ny) * ex + (uz * nx - ux * nz) * ey + (ux * ny - uy * nx) * ez > 0.0:
                within = False
                t = min(max((ux * ex + uy * ey + uz * ez) / (ux * ux + uy * uy + uz * uz), 0.0), 1.0)
                qx, qy, qz = pieces.vertices[v, 0] + t * ux, pieces.vertices[v, 1] + t * uy, pieces.vertices[v, 2] + t * uz
                distance = (x - qx) ** 2 + (y - qy) ** 2 + (z - qz) ** 2
                if distance < best:
                    best, bx, by, bz = distance, qx, qy, qz
        if within and height * height < best:
            best, bx, by, bz = height * height, px, py, pz
    if inside:
        return x, y, z
    return bx, by, bz


@leaf
def shallowest_face(pieces, piece, x, y, z):
    """The face that the point (x, y, z) inside a polytope is nearest to, both in its body axes: its height over the face, at
    most 0 [m], and the face's outward normal."""
    best, most = pieces.ranges[piece, FACES], -np.inf
    for face in range(pieces.ranges[piece, FACES], pieces.ranges[piece, FACES + 1]):
        height = pieces.normals[face, 0] * x + pieces.normals[face, 1] * y + pieces.normals[face, 2] * z - pieces.offsets[face]
        if height > most:
            best, most = face, height
    return min(most, 0.0), pieces.normals[best, 0], pieces.normals[best, 1], pieces.normals[best, 2]


@leaf
def normal_of_cores(ux, uy, uz, vx, vy, vz):
    """The direction in which two core segments (directions u and v) that cross part soonest: their common normal, any normal of
    the one that has a length, or up where neither has one."""
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size, u, v = length(x, y, z), length(ux, uy, uz), length(vx, vy, vz)
    if size > PARALLEL * u * v:
        return x / size, y / size, z / size
    if v > u:
        ux, uy, uz, u = vx, vy, vz, v
    if u == 0.0:
        return 0.0, 0.0, 1.0
    if abs(uz) < 0.7 * u:  # across it, as far up as can be
        x, y, z = -uz * ux, -uz * uy, u * u - uz * uz
    else:
        x, y, z = u * u - ux * ux, -ux * uy, -ux * uz
    size = length(x, y, z)
    return x / size, y / size, z / size


@leaf
def round_normal(pieces, i, j, rotation_a, rotation_b, dx, dy, dz):
    """Normal a to b and separation of a pair with a sphere, or of two capsules: (separation, nx, ny, nz); separation = inf:
    not round."""
    count_a = pieces.ranges[i, VERTICES + 1] - pieces.ranges[i, VERTICES]
    count_b = pieces.ranges[j, VERTICES + 1] - pieces.ranges[j, VERTICES]
    rounding = pieces.sizes[i, 1] + pieces.sizes[j, 1]
    px, py, pz, ux, uy, uz = core(pieces, i, rotation_a)
    qx, qy, qz, vx, vy, vz = core(pieces, j, rotation_b)
    if count_a <= 2 and count_b <= 2:
        s, t = segment_closest(px, py, pz, ux, uy, uz, qx + dx, qy + dy, qz + dz, vx, vy, vz)
        x, y, z = qx + dx + t * vx - px - s * ux, qy + dy + t * vy - py - s * uy, qz + dz + t * vz - pz - s * uz
        if x == 0.0 and y == 0.0 and z == 0.0:
            x, y, z = normal_of_cores(ux, uy, uz, vx, vy, vz)
            return -rounding, x, y, z
    elif count_a == 1:
        sx, sy, sz = turn_back(rotation_b, px - dx, py - dy, pz - dz)
        ex, ey, ez = closest_on_piece(pieces, j, sx, sy, sz)
        if ex == sx and ey == sy and ez == sz:
            height, x, y, z = shallowest_face(pieces, j, sx, sy, sz)
            x, y, z = turn(rotation_b, x, y, z)
            return height - rounding, -x, -y, -z
        ex, ey, ez = turn(rotation_b, ex, ey, ez)
        x, y, z = ex + dx - px, ey + dy - py, ez + dz - pz
    elif count_b == 1:
        sx, sy, sz = turn_back(rotation_a, qx + dx, qy + dy, qz + dz)
        ex, ey, ez = closest_on_piece(pieces, i, sx, sy, sz)
        if ex == sx and ey == sy and ez == sz:
            height, x, y, z = shallowest_face(pieces, i, sx, sy, sz)
            x, y, z = turn(rotation_a, x, y, z)
            return height - rounding, x, y, z
        ex, ey, ez = turn(rotation_a, ex, ey, ez)
        x, y, z = qx + dx - ex, qy + dy - ey, qz + dz - ez
    else:
        return np.inf, 0.0, 0.0, 0.0
    distance = length(x, y, z)
    return distance - rounding, x / distance, y / distance, z / distance


@leaf
def evaluate(pieces, kind, first, second, direction, i, j, rotation_a, rotation_b, dx, dy, dz):
    """The kept answer at today's poses: separation [m] and world normal a to b; separation -inf where the answer has no
    normal."""
    rounding = pieces.sizes[i, 1] + pieces.sizes[j, 1]
    if kind == FACE_A or kind == PLANE:
        return face_separation(pieces, first, j, rotation_a, rotation_b, dx, dy, dz, rounding)
    if kind == FACE_B:
        apart, nx, ny, nz = face_separation(pieces, first, i, rotation_b, rotation_a, -dx, -dy, -dz, rounding)
        return apart, -nx, -ny, -nz
    if kind == EDGE_EDGE:
        nx, ny, nz = edge_normal(pieces, first, second, i, j, rotation_a, rotation_b, dx, dy, dz)
    elif kind == DIRECTION:
        nx, ny, nz = turn(rotation_a, direction[0], direction[1], direction[2])
    elif kind == ROUND:
        return round_normal(pieces, i, j, rotation_a, rotation_b, dx, dy, dz)
    else:
        return -np.inf, 0.0, 0.0, 0.0
    if nx == 0.0 and ny == 0.0 and nz == 0.0:
        return -np.inf, 0.0, 0.0, 0.0
    return separation(pieces, i, j, rotation_a, rotation_b, dx, dy, dz, nx, ny, nz), nx, ny, nz


@leaf
def capsule_direction(pieces, i, j, rotation_a, rotation_b, dx, dy, dz):
    """Direction a to b between a capsule's core and a polytope, by ternary search for the nearest point of the core; zero if
    inside."""
    flip = pieces.ranges[j, FACES] == pieces.ranges[j, FACES + 1]
    if flip:
        px, py, pz, ux, uy, uz = core(pieces, j, rotation_b)
        px, py, pz = turn_back(rotation_a, px + dx, py + dy, pz + dz)
        ux, uy, uz = turn_back(rotation_a, ux, uy, uz)
        solid = i
    else:
        px, py, pz, ux, uy, uz = core(pieces, i, rotation_a)
        px, py, pz = turn_back(rotation_b, px - dx, py - dy, pz - dz)
        ux, uy, uz = turn_back(rotation_b, ux, uy, uz)
        solid = j
    low, high = 0.0, 1.0
    for _ in range(60):
        s, t = low + (high - low) / 3.0, high - (high - low) / 3.0
        ex, ey, ez = closest_on_piece(pieces, solid, px + s * ux, py + s * uy, pz + s * uz)
        fx, fy, fz = closest_on_piece(pieces, solid, px + t * ux, py + t * uy, pz + t * uz)
        if length(px + s * ux - ex, py + s * uy - ey, pz + s * uz - ez) < length(
            px + t * ux - fx, py + t * uy - fy, pz + t * uz - fz
        ):
            high = t
        else:
            low = s
    x, y, z = px + low * ux, py + low * uy, pz + low * uz
    ex, ey, ez = closest_on_piece(pieces, solid, x, y, z)
    x, y, z = x - ex, y - ey, z - ez
    size = length(x, y, z)
    if size == 0.0:
        return 0.0, 0.0, 0.0
    if flip:
        return turn(rotation_a, x / size, y / size, z / size)
    return turn(rotation_b, -x / size, -y / size, -z / size)
