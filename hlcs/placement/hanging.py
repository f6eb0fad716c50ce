"""Units of a layer hung over the hollows of the layer below, before they are dropped.

Every orientation is drawn uniformly over rotations. On a close grid most neighbours so drawn overlap (RPG: 50 of 84 pairs of
a layer of 49). What is done about it is a setting of the test, `crowding`:

"turn": a unit in overlap is turned about the vertical, as a crane or a hand would; only where it finds no room whatever its
heading is another orientation drawn. "redraw": another orientation is drawn each time. "lift": the orientation stays and the
later of two units is lifted. The first two lift only units over one that sticks up from below, and what finds no room at all.

Turning leaves alone which side of a unit is down, and so how high it stands; drawing again prefers poses that are slim;
lifting lets units fall farther than the falling distance, and one after another.
"""

from typing import NamedTuple

import numpy as np

from minibullet import rotations
from minibullet.errors import InputError

CROWDING = ("turn", "redraw", "lift")
LIFT = 0.05  # step by which a unit is lifted, in its bounding radius [-]
MOST_LIFTS = 400  # steps by which overlapping units are lifted before the grid is given up
IN_VAIN = 150  # rounds of turning that mend nothing, and the search is stuck: what still overlaps is drawn anew
MOST_ROUNDS = 600  # in all, and the rest is lifted; RPG needs about 300 for 49 units
HEADINGS = 40  # tried in vain before a unit is given another orientation; on RPG 6 in 100 are


class Hung(NamedTuple):
    """Units of a layer, free of overlaps, before they fall."""

    handles: list  # of the units
    lifts: np.ndarray  # by how much each hangs above the height asked for [m], (n,)
    redrawn: int  # units that were given another orientation, not only another heading


def hang_layer(world, layer, load, centres, lowest, generator, first=0, crowding="turn"):
    """Units at random orientations over centres (n, 2), their lowest points at height ``lowest`` (n,) or above [m]: a `Hung`.

    load: what `World.add` is told of every unit; first: how many units of the layer stand already, which gives the next ones
    their names; crowding: what is done about overlaps, see above. InputError where the units overlap however far they are
    lifted.
    """
    hangers = []
    for (x, y), z in zip(centres, lowest, strict=True):
        name, orientation = f"{layer}.{first + len(hangers) + 1}", rotations.random(generator, 1)[0]
        place = x, y, z + _depth(load["shape"], orientation)
        hangers.append(_Hanger(world.add(**load, position=place, orientation=orientation, name=name), z))
    if crowding != "lift":
        _turn_free(world, hangers, generator, HEADINGS if crowding == "turn" else 1)
    _lift_free(world, layer, hangers, few=crowding != "lift")
    lifts = np.array([hanger.lift for hanger in hangers])
    return Hung([hanger.handle for hanger in hangers], lifts, sum(hanger.redrawn for hanger in hangers))


class _Hanger:
    """A unit that hangs with its lowest point at height `lowest` + `lift` [m]; tried: orientations tried so far."""

    def __init__(self, handle, lowest):
        self.handle, self.lowest, self.lift, self.tried, self.redrawn = handle, lowest, 0.0, 0, False
        self.step = LIFT * handle.shape.bounding_radius

    def hang(self, orientation, lift):
        x, y, _ = self.handle.position
        self.handle.orientation, self.lift = orientation, lift
        self.handle.position = x, y, self.lowest + lift + _depth(self.handle.shape, orientation)

    def another(self, generator, headings):
        """The orientation to be tried next: another heading, after so many another orientation altogether."""
        self.tried += 1
        if self.tried % headings == 0:
            return rotations.random(generator, 1)[0]
        turn = rotations.exponential([0.0, 0.0, generator.uniform(0.0, 2.0 * np.pi)])
        return rotations.product(turn, self.handle.orientation)


def _depth(shape, orientation):
    """How far the lowest point of a solid lies below its centre [m]."""
    points = np.concatenate([piece.vertices for piece in shape.pieces])
    return -float(rotations.dot(points, rotations.matrix(orientation)[2]).min())


def _turn_free(world, hangers, generator, headings):
    """Turn units round after round until none overlaps, MOST_ROUNDS are over, or IN_VAIN rounds have freed no unit at all.

    In each round some of the units in overlap, no two of them neighbours, try another orientation each, and keep it where they
    overlap no more than before. A unit that after HEADINGS tries still overlaps what does not hang, such as one that sticks up
    from the layer below, is lifted a step with every further try.
    """
    hanging = {hanger.handle for hanger in hangers}
    depths, least, vain = _depths(world), np.inf, 0
    fewest = len(hangers)
    for number in range(MOST_ROUNDS):
        crowded = [hanger for hanger in hangers if _overlap(depths, hanger.handle)]
        fewest = min(fewest, len(crowded))
        if not crowded or (number > IN_VAIN and fewest == len(hangers)):  # free, or too wide for the grid
            return
        left = sum(depths.values())
        least, vain = (left, 0) if left < least else (least, vain + 1)
        if vain > IN_VAIN:
            depths, least, vain = _draw_anew(world, crowded, generator), np.inf, 0
            continue
        chosen = _apart(crowded, generator)
        before = [(hanger.handle.orientation, hanger.lift) for hanger in chosen]
        for hanger in chosen:
            blocked = any(hanger.handle in pair and not hanging.issuperset(pair) for pair in depths)
            step = hanger.step if blocked and hanger.tried >= HEADINGS else 0.0
            hanger.hang(hanger.another(generator, headings), hanger.lift + step)
        found = _depths(world)
        for hanger, state in zip(chosen, before, strict=True):
            handle = hanger.handle
            if _overlap(found, handle) <= _overlap(depths, handle):
                hanger.redrawn = hanger.redrawn or hanger.tried % headings == 0
                depths = {pair: depth for pair, depth in depths.items() if handle not in pair}
                depths |= {pair: depth for pair, depth in found.items() if handle in pair}
            else:
                hanger.hang(*state)


def _draw_anew(world, hangers, generator):
    """Give units other orientations, whatever they overlap then; returns the overlaps."""
    for hanger in hangers:
        hanger.hang(rotations.random(generator, 1)[0], hanger.lift)
        hanger.redrawn = True
    return _depths(world)


def _depths(world):
    """{(handle, handle): depth [m]} of all overlaps."""
    return {(a, b): depth for a, b, depth in world.overlaps()}


def _overlap(depths, handle):
    """How deep a unit lies in all others, together [m]."""
    return sum(depth for pair, depth in depths.items() if handle in pair)


def _apart(hangers, generator):
    """Some of the units, in random order, no two of them so near in plan that they could meet."""
    places = np.array([hanger.handle.position[:2] for hanger in hangers])
    diameters = np.array([2.0 * hanger.handle.shape.bounding_radius for hanger in hangers])
    near = ((places[:, None] - places) ** 2).sum(axis=-1) <= (diameters * diameters)[:, None]  # may each meet another
    chosen = []
    for index in generator.permutation(len(hangers)):
        if not near[index, chosen].any():
            chosen.append(index)
    return [hangers[index] for index in chosen]


def _lift_free(world, layer, hangers, few):
    """Lift one of two overlapping units step by step until none overlaps: the later one, or, so that few are lifted, the one that
    was lifted already. A wall goes on upwards: what overlaps it is moved off it, as far from its aim as it must be."""
    number = {hanger.handle: rank for rank, hanger in enumerate(hangers)}
    for _ in range(MOST_LIFTS):
        overlapping = world.overlaps()
        for *pair, depth in overlapping:
            for wall, handle in (pair, pair[::-1]):
                if wall.is_plane and handle in number:
                    handle.position += depth * rotations.rotate(wall.orientation, np.array([0.0, 0.0, 1.0]))
        pairs = [[number[handle] for handle in pair if handle in number] for *pair, _ in overlapping]
        lifted = {max(pair, key=lambda rank: (few * hangers[rank].lift, rank)) for pair in pairs if pair}
        if not lifted:
            return
        for hanger in (hangers[rank] for rank in sorted(lifted)):
            hanger.hang(hanger.handle.orientation, hanger.lift + hanger.step)
    raise InputError(f"placement: the units of layer {layer} overlap however far they are lifted; widen the grid")
