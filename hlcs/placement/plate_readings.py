"""The laboratory's ruler: square plates of 2 Dn x 2 Dn dropped on a finished layer (Figs. 4, 5 and 8 of the paper).

What a plate reads is statics. At rest its weight and the loads from below are in equilibrium, so the height of its middle is
the mean of the heights of its points of contact, each weighted by the load it bears. A plate that something deeper helps to
carry reads in part how deep that is. A reading is therefore one of the layer only where units that stand in that layer carry
the plate alone; every other one is told by what carries it, and left out.
"""

import warnings
from typing import NamedTuple

import numpy as np

import minibullet as mb
from hlcs.placement.sea_bottom import height_above

PLATE_SIDE = 2.0  # [Dn], the paper's
PLATE_THICKNESS = 0.1  # [Dn], not given by the paper; no influence was found
PLATE_DENSITY = 2300.0  # [kg/m3], not given by the paper; no influence was found

MOST_TILT = np.radians(15.0)  # a plate that leans more lies on an edge of the layer, not on the layer
MOST_SLIDE = 0.5  # [Dn]
NO_LOAD = 0.01  # share of a plate's load that is none: it moves the reading by a hundredth of the difference in depth at most


class Readings(NamedTuple):
    """What the plates on one layer read."""

    heights: np.ndarray  # (k,) above the bottom [m], NaN where the layer alone does not carry the plate at rest
    carried_by: tuple  # (k,) words: what carries each plate, such as "layer 5", and why it is left out if it is
    faces: np.ndarray  # (k, 3) where the middle of each plate's lower face came to rest, world frame [m]
    poses: np.ndarray  # (k, 7) positions [m] and orientations where the plates came to rest


def plate_of(nominal_diameter):
    """The solid of a plate for units of this nominal diameter [m]."""
    side = PLATE_SIDE * nominal_diameter
    return mb.Box(side, side, PLATE_THICKNESS * nominal_diameter)


def plate_centres(centres, nominal_diameter, per_row=3, rows=None):
    """Where plates are laid on a layer: rows (along x) of per_row places each, as many rows as plates in one where left out,
    evenly over the inner part of its units' centres, (k, 2) [m]. A single one lies in the middle.

    The outermost plates reach a quarter of Dn beyond the outermost centres, so that edge units do not tilt them.
    """
    low, high = centres.min(axis=0), centres.max(axis=0)
    inset = np.minimum(0.75 * nominal_diameter, 0.5 * (high - low))
    counts = per_row, per_row if rows is None else rows
    alone = 0.5 * (low + high)
    x, y = (np.linspace(low[k] + inset[k], high[k] - inset[k], n) if n > 1 else alone[k : k + 1] for k, n in enumerate(counts))
    return np.array([(a, b) for b in y for a in x])


def read_plates(layers, standing, bottom, centres, nominal_diameter, settings, margin=0.0, max_time=4.0):
    """Readings of plates laid at ``centres`` (k, 2) [m] on the last of ``layers``: heights of the lower face's centre.

    layers: handles of the units of every layer so far, lowest first; standing: those of the last layer's units that stand in
    it; margin: shell around the plates that their contacts keep open [m]. The plates fall on the units, fixed as they are, from
    just above them and ignore one another. Left out (NaN) are a
    plate that the standing units of the layer do not carry alone, and one that has not come to rest, leans by more than
    MOST_TILT or slid by more than MOST_SLIDE, as over a hole or an edge.
    """
    world = mb.World([mb.Gravity(9.81)], settings)
    bottom.add_to(world)
    units = [unit for layer in layers for unit in layer]
    for unit in units:
        world.add(
            unit.shape, position=unit.position, orientation=unit.orientation, fixed=True, margin=unit.margin, name=unit.name
        )
    side, thickness = PLATE_SIDE * nominal_diameter, PLATE_THICKNESS * nominal_diameter
    plate = plate_of(nominal_diameter)
    tops = np.array([top(unit) for unit in units])
    places = np.array([unit.position[:2] for unit in units])
    plates = []
    for number, (x, y) in enumerate(centres):
        below = np.abs(places - (x, y)).max(axis=1) < 0.5 * side + nominal_diameter
        start = tops[below].max() if below.any() else -float(height_above(bottom, (x, y, 0.0)))
        plates.append(
            world.add(
                plate,
                density=PLATE_DENSITY,
                position=(x, y, start + margin + 0.52 * thickness),
                group=number,
                margin=margin,
                name=f"plate {number}",
            )
        )
    with warnings.catch_warnings():  # a plate that strikes hard past its layer is no unit of the user's: it is told as left out
        warnings.simplefilter("ignore", mb.SceneWarning)
        rest = world.settle(max_time)
    own, loads = f"layer {len(layers)}", loads_on(world.last_step)
    kind = {unit.name: f"layer {number}" for number, layer in enumerate(layers, start=1) for unit in layer}
    # units that fell, move or hang in the air
    kind |= {unit.name: f"units out of {own}" for unit in set(layers[-1]) - set(standing)}
    heights, words, faces = np.full(len(plates), np.nan), [], np.empty((len(plates), 3))
    for number, handle in enumerate(plates):
        axis = mb.rotations.rotate(handle.orientation, np.array([0.0, 0.0, 1.0]))
        faces[number] = face = handle.position - 0.5 * thickness * axis
        carriers = _carriers(loads.get(handle.name, {}), kind)
        faults = []
        if rest != "at_rest" and np.linalg.norm(handle.velocity) >= 1e-2 * np.sqrt(9.81 * nominal_diameter):
            faults.append("moves")
        if axis[2] <= np.cos(MOST_TILT):
            faults.append("leans")
        if np.hypot(*(handle.position[:2] - centres[number])) >= MOST_SLIDE * nominal_diameter:
            faults.append("slid")
        if carriers == [own] and not faults:
            heights[number] = height_above(bottom, face)
        words.append(", ".join([" and ".join(carriers) or "nothing", *faults]))
    poses = np.reshape([[*handle.position, *handle.orientation] for handle in plates], (-1, 7))
    return Readings(heights, tuple(words), faces, poses)


def loads_on(step):
    """{body: {body under or over it: vertical impulse [N s], upwards}} of a step, by name: who carries whom."""
    contacts, up, loads = step.contacts, step.impulse[:, 2], {}
    for a, b, impulse in zip(contacts.body_a, contacts.body_b, up, strict=True):
        for one, other, sign in ((step.names[a], step.names[b], -1.0), (step.names[b], step.names[a], 1.0)):
            share = loads.setdefault(one, {})
            share[other] = share.get(other, 0.0) + sign * float(impulse)
    return loads


def top(unit):
    """Highest point of a unit [m]."""
    rotation = mb.rotations.matrix(unit.orientation)[2]
    highest = max(float(mb.rotations.dot(piece.vertices, rotation).max()) for piece in unit.shape.pieces)
    return unit.position[2] + highest + unit.margin


def _carriers(load, kind):
    """What bears more than NO_LOAD of a plate, sorted; load: {name: impulse};
    kind: {name: word}, "the bed" where there is none."""
    shares = {}
    for name, impulse in load.items():
        word = kind.get(name, "the bed")
        shares[word] = shares.get(word, 0.0) + impulse
    whole = sum(abs(share) for share in shares.values())
    return sorted(word for word, share in shares.items() if abs(share) > NO_LOAD * whole)
