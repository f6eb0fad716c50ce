"""The laboratory's ruler: square plates of 2 Dn x 2 Dn dropped on a finished layer (Figs. 4, 5 and 8 of the paper)."""

import numpy as np

import minibullet as mb

PLATE_SIDE = 2.0  # [Dn], the paper's
PLATE_THICKNESS = 0.1  # [Dn], not given by the paper; no influence was found
PLATE_DENSITY = 2300.0  # [kg/m3], not given by the paper; no influence was found

MOST_TILT = np.radians(15.0)  # a plate that leans more lies on an edge of the layer, not on the layer
MOST_SLIDE = 0.5  # [Dn]


def plate_centres(centres, nominal_diameter, per_side=3):
    """Where plates are laid on a layer: per_side x per_side places, evenly over the inner part of its units' centres, (k, 2)
    [m].

    The outermost plates reach a quarter of Dn beyond the outermost centres, so that edge units do not tilt them.
    """
    low, high = centres.min(axis=0), centres.max(axis=0)
    inset = np.minimum(0.75 * nominal_diameter, 0.5 * (high - low))
    x, y = (np.linspace(low[k] + inset[k], high[k] - inset[k], per_side) for k in range(2))
    return np.array([(a, b) for b in y for a in x])


def envelope_heights(units, bottom, centres, nominal_diameter, settings, max_time=4.0):
    """Height above the bottom of the lower face's centre of a plate laid at each of ``centres`` (k, 2) on frozen ``units``
    [m], (k,).

    units: handles. The plates fall on the fixed units from just above them and ignore one another. A plate that has not come
    to rest, leans by more than MOST_TILT or slid by more than MOST_SLIDE found no bed there, as over a hole or an edge: it
    reads NaN.
    """
    world = mb.World([mb.Gravity(9.81)], settings)
    bottom.add_to(world)
    for unit in units:
        world.add(unit.shape, position=unit.position, orientation=unit.orientation, fixed=True, margin=unit.margin)
    side, thickness = PLATE_SIDE * nominal_diameter, PLATE_THICKNESS * nominal_diameter
    plate = mb.Box(side, side, thickness)
    tops = np.array([_top(unit) for unit in units])
    places = np.array([unit.position[:2] for unit in units])
    plates = []
    for number, (x, y) in enumerate(centres):
        below = np.abs(places - (x, y)).max(axis=1) < 0.5 * side + nominal_diameter
        start = tops[below].max() if below.any() else float(bottom.height(x, y))
        plates.append(
            world.add(plate, density=PLATE_DENSITY, position=(x, y, start + 0.52 * thickness), group=number, margin=0.0)
        )
    rest = world.settle(max_time)
    heights = np.empty(len(plates))
    for number, handle in enumerate(plates):
        axis = mb.rotations.rotate(handle.orientation, np.array([0.0, 0.0, 1.0]))
        face = handle.position - 0.5 * thickness * axis
        slow = np.linalg.norm(handle.velocity) < 1e-2 * np.sqrt(9.81 * nominal_diameter)
        flat = (
            axis[2] > np.cos(MOST_TILT) and np.hypot(*(handle.position[:2] - centres[number])) < MOST_SLIDE * nominal_diameter
        )
        heights[number] = face[2] - float(bottom.height(face[0], face[1])) if flat and (rest == "at_rest" or slow) else np.nan
    return heights


def _top(unit):
    """Highest point of a unit [m]."""
    rotation = mb.rotations.matrix(unit.orientation)[2]
    highest = max(float(mb.rotations.dot(piece.vertices, rotation).max()) for piece in unit.shape.pieces)
    return unit.position[2] + highest + unit.margin
