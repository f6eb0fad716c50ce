"""Which pieces may soon touch: a list that stays valid while bodies move less than its skin (Verlet list).

Bodies are swept along x by their bounding boxes, then pieces are compared by bounding spheres. The list is sorted by body and
piece indices, so its order depends on the scene alone.
"""

import numpy as np

from minibullet.collision.geometry import FACES, VERTICES, turn
from minibullet.kernels import kernel, leaf


@kernel
def bounds(pieces, piece_ranges, position, rotation, skin):
    """Axis-aligned box of each body, world frame, grown by its skin: lower (n, 3), upper (n, 3) [m]. Planes are unbounded."""
    count = len(position)
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for body in range(count):
        for piece in range(piece_ranges[body, 0], piece_ranges[body, 1]):
            first, end = pieces.ranges[piece, VERTICES], pieces.ranges[piece, VERTICES + 1]
            if first == end:
                lower[body], upper[body] = -np.inf, np.inf
                continue
            grow = pieces.sizes[piece, 1] + skin[body]
            for v in range(first, end):
                x, y, z = turn(rotation[body], pieces.vertices[v, 0], pieces.vertices[v, 1], pieces.vertices[v, 2])
                for axis, value in enumerate((x, y, z)):
                    lower[body, axis] = min(lower[body, axis], value - grow + position[body, axis])
                    upper[body, axis] = max(upper[body, axis], value + grow + position[body, axis])
    return lower, upper


@leaf
def body_sizes(pieces, piece_ranges, sizes):
    """Bounding radius of the largest piece of each body [m] into ``sizes`` (n,); 0 for planes."""
    for body in range(len(piece_ranges)):
        sizes[body] = 0.0
        for piece in range(piece_ranges[body, 0], piece_ranges[body, 1]):
            if pieces.sizes[piece, 0] < np.inf:
                sizes[body] = max(sizes[body], pieces.sizes[piece, 0])


def overlapping(lower, upper, moving, group):
    """Index pairs (a < b) of bodies whose boxes overlap, at least one of them moving, groups compatible; sorted, (k, 2)."""
    order, room = np.argsort(lower[:, 0], kind="stable"), 8 * len(lower) + 64
    while True:
        found = np.empty((room, 2), dtype=np.int64)
        count = sweep(lower, upper, moving, group, order, found)
        if count <= room:
            break
        room = count
    found = found[:count]
    return found[np.lexsort((found[:, 1], found[:, 0]))]


@leaf
def sweep(lower, upper, moving, group, order, found):
    """How many pairs ``overlapping`` finds, sweeping along x through the bodies in ``order`` of their lower sides; as many of
    them as there is room for go into ``found``."""
    count = 0
    for place in range(len(order)):
        a = order[place]
        for after in range(place + 1, len(order)):
            b = order[after]
            if lower[b, 0] > upper[a, 0]:
                break
            if not (moving[a] or moving[b]) or (group[a] >= 0 and group[b] >= 0 and group[a] != group[b]):
                continue
            if lower[a, 1] > upper[b, 1] or lower[b, 1] > upper[a, 1] or lower[a, 2] > upper[b, 2] or lower[b, 2] > upper[a, 2]:
                continue
            if count < len(found):
                found[count, 0], found[count, 1] = min(a, b), max(a, b)
            count += 1
    return count


@kernel
def close_pieces(body_pairs, pieces, piece_ranges, position, rotation, skin):
    """Pairs of pieces whose bounding spheres are closer than the skins: rows (body a, body b, piece a, piece b), (k, 4).

    A plane always stands first in its pair and is measured along its normal.
    """
    found = np.empty((256, 4), dtype=np.int64)
    count = 0
    for pair in range(len(body_pairs)):
        a, b = body_pairs[pair]
        if pieces.ranges[piece_ranges[b, 0], VERTICES] == pieces.ranges[piece_ranges[b, 0], VERTICES + 1]:
            a, b = b, a
        x, y, z = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
        grow = skin[a] + skin[b]
        for i in range(piece_ranges[a, 0], piece_ranges[a, 1]):
            plane = pieces.ranges[i, VERTICES] == pieces.ranges[i, VERTICES + 1]
            ax, ay, az = turn(rotation[a], pieces.centres[i, 0], pieces.centres[i, 1], pieces.centres[i, 2])
            for j in range(piece_ranges[b, 0], piece_ranges[b, 1]):
                bx, by, bz = turn(rotation[b], pieces.centres[j, 0], pieces.centres[j, 1], pieces.centres[j, 2])
                dx, dy, dz = x + bx - ax, y + by - ay, z + bz - az
                if plane:
                    face = pieces.ranges[i, FACES]
                    nx, ny, nz = turn(rotation[a], pieces.normals[face, 0], pieces.normals[face, 1], pieces.normals[face, 2])
                    if nx * dx + ny * dy + nz * dz - pieces.offsets[face] > grow + pieces.sizes[j, 0]:
                        continue
                else:
                    reach = grow + pieces.sizes[i, 0] + pieces.sizes[j, 0]
                    if dx * dx + dy * dy + dz * dz > reach * reach:
                        continue
                if count == len(found):
                    grown = np.empty((2 * count, 4), dtype=np.int64)
                    grown[:count] = found
                    found = grown
                found[count, 0], found[count, 1], found[count, 2], found[count, 3] = a, b, i, j
                count += 1
    return found[:count]


@kernel
def carry_over(old, new):
    """For each row of ``new`` the index of the equal row of ``old``, or -1; a hash table of rows, (k,)."""
    size = 16
    while size < 2 * len(old):
        size *= 2
    table = np.full(size, -1, dtype=np.int64)
    for row in range(len(old)):
        slot = ((old[row, 0] * 73856093) ^ (old[row, 1] * 19349663) ^ (old[row, 2] * 83492791) ^ (old[row, 3] * 39916801)) & (
            size - 1
        )
        while table[slot] >= 0:
            slot = (slot + 1) & (size - 1)
        table[slot] = row
    match = np.full(len(new), -1, dtype=np.int64)
    for row in range(len(new)):
        slot = ((new[row, 0] * 73856093) ^ (new[row, 1] * 19349663) ^ (new[row, 2] * 83492791) ^ (new[row, 3] * 39916801)) & (
            size - 1
        )
        while table[slot] >= 0:
            candidate = table[slot]
            if (
                old[candidate, 0] == new[row, 0]
                and old[candidate, 1] == new[row, 1]
                and old[candidate, 2] == new[row, 2]
                and old[candidate, 3] == new[row, 3]
            ):
                match[row] = candidate
                break
            slot = (slot + 1) & (size - 1)
    return match
