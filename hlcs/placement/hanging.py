"""Units of a layer hung over the hollows of the layer below, before they are dropped."""

import numpy as np

from minibullet import rotations
from minibullet.errors import InputError

MOST_LIFTS = 400  # steps by which overlapping units are lifted before the grid is given up


def hang_layer(world, layer, load, centres, lowest, generator, first=0):
    """Units at uniformly random orientations over centres (n, 2), their lowest points at height ``lowest`` (n,) or above [m].

    Returns their handles, and by how much each was lifted (n,) [m]. load: as by `load_of`; first: how many units of the layer
    stand already, which gives the next ones their names.

    On a close grid about half of such units would overlap a neighbour. Drawing again until none does would prefer the
    orientations that fit side by side; so the orientation stays as drawn and the later of the two is lifted, a twentieth of
    its radius at a time, until it is free.
    """
    shape, handles = load["shape"], []
    lifts = np.zeros(len(centres))
    vertices = np.concatenate([piece.vertices for piece in shape.pieces])
    for (x, y), z in zip(centres, lowest, strict=True):
        orientation = rotations.random(generator, 1)[0]
        depth = -rotations.dot(vertices, rotations.matrix(orientation)[2]).min()
        name = f"{layer}.{first + len(handles) + 1}"
        handles.append(world.add(**load, position=(x, y, z + depth), orientation=orientation, name=name))
    rank = {handle: number for number, handle in enumerate(handles)}
    rise = np.array([0.0, 0.0, 0.05 * shape.bounding_radius])
    for _ in range(MOST_LIFTS):
        later = {max(rank.get(a, -1), rank.get(b, -1)) for a, b, _ in world.overlaps()} - {-1}
        if not later:
            return handles, lifts
        for number in sorted(later):
            handles[number].position = handles[number].position + rise
            lifts[number] += rise[2]
    raise InputError(f"placement: the units of layer {layer} overlap however far they are lifted; widen the grid")
