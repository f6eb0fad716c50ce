"""One layer of units: aimed, oriented, dropped, settled, frozen (section 3.2.3 of the paper).

The first layer is laid at rest: every unit in its lowest pose with an edge on the bottom, heading free on a triangular grid;
on a rectangular one, where free headings collide, with its horizontal tip axis along x. Units of the next layers are oriented
at random, their lowest point a falling distance above the mean height of the layers below, over the hollows, all dropped at
once. Overlaps at the start: headings of the first layer are drawn again, then chosen; what is left (tips longer than the
spacing, margins) is pushed apart; hanging units are turned about the vertical (`hlcs.placement.hanging`).
"""

from dataclasses import dataclass, replace

import numpy as np

from hlcs.placement.first_layer_spacing import first_headings
from hlcs.placement.plate_readings import loads_on
from hlcs.placement.sea_bottom import height_above
from minibullet import rotations
from minibullet.errors import InputError

MOST_DRAWS = 400  # redraws of overlapping orientations before units are pushed apart
SHAKES = 10  # periods of a vibration
MOST_DRAWS_IN_VAIN = 40  # so many in a row that leave no fewer overlaps, and the grid is too narrow for chance
MOST_OVERLAP = 0.05  # [Dn] of units that stand already: a survey measures them to some hundredths
ABOVE = 0.5  # [Dn] by which a unit of a layer stands above the middle of the layer under it, or it lies among that one's
# units: the layers are about 1 Dn apart, and a unit on the same ground as others is about as high as they


@dataclass(frozen=True)
class LayerRecord:
    """How one layer came to rest."""

    layer: int  # from 1
    handles: tuple  # of its units
    reason: str  # "at_rest" or "time_limit"
    unsettled: int  # units of the layer still moving, or carried by nothing, when it was frozen
    penetration: float  # deepest overlap where the layer came to rest [m]
    transient_penetration: float  # deepest overlap in any step on the way [m]
    steps: int  # steps it took
    unsolved_steps: int  # steps whose residual stayed above the tolerance
    lifted: int = 0  # units that started higher than the falling distance, so as not to overlap
    mean_lift: float = 0.0  # of those units [m]
    redrawn: int = 0  # units given another orientation than the one first drawn, so as not to overlap
    pushed: float = 0.0  # how far, at most, a unit of the first layer was pushed aside so as not to overlap [m]
    standing: tuple = ()  # handles of those units that stand in the layer, at rest and carried
    added: int = 0  # of a repair: units that were added to those that stood
    covered: int = 0  # of a repair: empty places under units that stand, which stay empty

    @property
    def stands(self):
        """Which of the units stand in the layer, boolean (n,)."""
        standing = set(self.standing)
        return np.array([handle in standing for handle in self.handles], dtype=bool)

    def after(self, earlier):
        """The same layer come to rest again, after an `earlier` record of it or of its first rows (or None)."""
        if earlier is None:
            return self
        return replace(
            self,
            transient_penetration=max(self.transient_penetration, earlier.transient_penetration),
            steps=self.steps + earlier.steps,
            unsolved_steps=self.unsolved_steps + earlier.unsolved_steps,
            lifted=earlier.lifted,
            mean_lift=earlier.mean_lift,
            redrawn=earlier.redrawn,
            pushed=earlier.pushed,
        )

    def started(self, lifts=(), pushed=0.0, redrawn=0):
        """The same layer, with how its units were freed from overlaps at the start: lifts (n,), pushed [m], redrawn units."""
        lifts = np.asarray(lifts, dtype=float)
        raised = lifts[lifts > 0.0]
        mean = float(raised.mean()) if len(raised) else 0.0
        return replace(self, lifted=len(raised), mean_lift=mean, redrawn=redrawn, pushed=float(pushed))


def load_of(unit, test):
    """What `World.add` is told of every unit: its solid, its density and, where the test states another, its inertia."""
    shape = unit.shape(test.shape)
    load = {"shape": shape, "density": test.density}
    return load if test.inertia_factor == 1.0 else load | {"inertia": test.inertia_factor * test.density * shape.inertia}


def stand(world, load, standing, nominal_diameter):
    """Fix StandingUnits where they stand; load: as by `load_of`. -> {layer: [handles]}, 0 for units that lie about.

    InputError where two of them overlap by more than MOST_OVERLAP, as units of another size or form would.
    """
    layers = {}
    for number, pose in zip(standing.layer.tolist(), standing.poses, strict=True):
        own = layers.setdefault(number, [])
        own.append(world.add(**load, position=pose[:3], orientation=pose[3:], name=f"{number}.{len(own) + 1}"))
    found = world.overlaps(0.0)
    if found and found[0][2] > MOST_OVERLAP * nominal_diameter:
        a, b, depth = found[0]
        raise InputError(
            f"placement: standing = {standing.source}: units {a.name!r} and {b.name!r} (layer.number in the file) overlap by "
            f"{depth / nominal_diameter:.2g} Dn; give the armour, the side and the shape of the units that stand there"
        )
    world.freeze([handle for own in layers.values() for handle in own])
    return layers


def missed(test, centres, layer):
    """Where the units of a layer are really aimed, given the centres (n, 2) [m] they were meant for; units left out are gone.

    Chance here has a stream of its own, so that the other draws of a test are the same with and without it.
    """
    if layer == 1 or not (test.placement_scatter or test.placement_offset_x or test.placement_offset_y or test.lost_units):
        return centres
    generator, dn = np.random.default_rng([test.seed, layer]), test.unit.nominal_diameter
    aims = centres + (layer - 1) * dn * np.array([test.placement_offset_x, test.placement_offset_y])
    aims = aims + test.placement_scatter * dn * generator.standard_normal(centres.shape)
    return aims[generator.random(len(aims)) >= test.lost_units]


def rows_of(aims, centres):
    """The aims (n, 2) row by row, from low y to high: [(m, 2), ...]; rows as they stand in the centres meant (k, 2)."""
    rows = np.unique(centres[:, 1].round(9))
    nearest = np.abs(aims[:, 1, None] - rows).argmin(axis=1)
    return [aims[nearest == row] for row in range(len(rows)) if np.any(nearest == row)]


def lay_first_layer(world, unit, load, centres, bottom, test, generator):
    """Lay units at rest on the bottom; load: as by `load_of`; centres (n, 2) [m]. Returns the handles.

    InputError, with the narrowest grid on which they can, where the units cannot stand side by side. Overlaps are redrawn
    where headings are free, then the units take a heading at which they stand side by side, then they are pushed apart.
    """
    check_covered(centres, unit.nominal_diameter, bottom)
    headings = first_headings(test, centres)
    handles, triangular, concentration = [], test.grid.triangular, test.yaw_constraint
    normals, poses = np.asarray(bottom.normal(*centres.T), dtype=float), first_poses(unit, centres, test)

    def draw(number, normal):
        if triangular:
            heading = generator.vonmises(0.0, concentration) if concentration else generator.uniform(0.0, 2.0 * np.pi)
        else:
            heading = headings[generator.integers(2) % len(headings)]
        return _first_pose(poses[number], normal, heading)

    for number, place in enumerate(first_places(unit, centres, bottom, test)):
        handles.append(world.add(**load, position=place, orientation=draw(number, normals[number]), name=f"1.{number + 1}"))

    def redraw(handle):
        handle.orientation = draw(handles.index(handle), np.asarray(bottom.normal(*handle.position[:2]), dtype=float))

    if triangular and not _redrawn(world, handles, redraw):
        for handle, normal, pose in zip(handles, normals, poses, strict=True):
            handle.orientation = _first_pose(pose, normal, headings[0])
    _push_apart(world, handles)
    return handles


def check_covered(centres, nominal_diameter, bottom):
    """InputError, by name, where a survey does not reach half a Dn beyond every centre (n, 2) [m]: units would overhang."""
    for corner in ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)):
        bottom.height(*(centres + np.multiply(corner, nominal_diameter)).T)


def first_places(unit, centres, bottom, test):
    """Where the centres of units at rest on the bottom are, over (n, 2) [m]: (n, 3); with a margin they rest that much higher."""
    foot = np.column_stack([centres, bottom.height(*centres.T)])
    rest = np.where(on_tip(centres, test), unit.tip_rest_height, unit.rest_height) + test.margin * unit.nominal_diameter
    return foot + rest[:, None] * np.asarray(bottom.normal(*centres.T), dtype=float)


def on_tip(centres, test):
    """Which units of the first layer stand on a tip (n,): each with the chance `tip_share`, by a stream of its own."""
    return np.random.default_rng([test.seed, 1]).random(len(centres)) < test.tip_share


def first_poses(unit, centres, test):
    """Orientations of the first layer's units on a level bottom, heading 0: [(4,), ...], their lowest pose or one on a tip."""
    low, tip = unit.first_layer_orientation(0.0), unit.tip_poses()[0]
    return [tip if there else low for there in on_tip(centres, test)]


def _first_pose(pose, normal, heading):
    turned = rotations.product(rotations.exponential([0.0, 0.0, heading]), pose)
    return rotations.product(rotations.between(np.array([0.0, 0.0, 1.0]), normal), turned)


def _redrawn(world, handles, redraw):
    """Redraw units of this layer until none overlaps; whether that was reached."""
    own, fewest, stalled = set(handles), len(handles) + 1, 0
    for _ in range(MOST_DRAWS):
        bad = sorted({handles.index(b if b in own else a) for a, b, _ in world.overlaps() if a in own or b in own})
        if not bad:
            return True
        stalled = 0 if len(bad) < fewest else stalled + 1
        fewest = min(fewest, len(bad))
        if stalled > MOST_DRAWS_IN_VAIN:
            return False
        for index in bad:
            redraw(handles[index])
    return False


def _push_apart(world, handles):
    """Push overlapping units of this layer apart sideways."""
    world.separate(handles)
    # what the library measures on touching edges is good to some 1e-5 of a unit; less than 1e-4 does no harm
    own = set(handles)
    left = [(a, b, d) for a, b, d in world.overlaps(1e-4) if a in own or b in own]
    if left:
        a, b, depth = left[0]
        raise InputError(
            f"placement: units {a.name!r} and {b.name!r} overlap by {depth:.3g} m and cannot be freed; widen the grid, or "
            "make the margin smaller"
        )


def settle_layer(world, layer, handles, bottom, level, nominal_diameter, max_time, watchers=()):
    """Run until the layer is at rest or the time is up, and say how it went.

    level: `level_of` the layer below [m]. Units that have sunk below it are lost: they may roll on without the layer waiting
    for them. Of the units that are still in the layer, unsettled are those that move and those that no contact carries: a
    damping that stops all motion leaves units in the air. Each watcher(layer, world) is called after every step.
    """
    first, unsolved, deepest = world.steps, world.unsolved_steps, [0.0]

    def look(world):
        deepest[0] = max(deepest[0], world.last_step.penetration)
        for watcher in watchers:
            watcher(layer, world)

    def in_layer(bodies):
        return height_above(bottom, bodies.position) > level

    reason = world.settle(max_time, watch=look, select=in_layer)
    rest, loads, standing, unsettled = world.last_step.penetration, loads_on(world.last_step), [], 0
    heights = height_above(bottom, np.reshape([handle.position for handle in handles], (-1, 3)))
    inside = in_place(heights, level, nominal_diameter)
    for handle in (handle for handle, there in zip(handles, inside, strict=True) if there):
        radius = handle.shape.bounding_radius
        speed = np.linalg.norm(handle.velocity) + np.linalg.norm(handle.angular_velocity) * radius
        moves = reason != "at_rest" and speed > 5e-3 * np.sqrt(9.81 * radius)
        if moves or sum(loads.get(handle.name, {}).values()) <= 0.0:
            unsettled += 1
        else:
            standing.append(handle)
    return LayerRecord(
        layer,
        tuple(handles),
        str(reason),
        unsettled,
        rest,
        deepest[0],
        world.steps - first,
        world.unsolved_steps - unsolved,
        standing=tuple(standing),
    )


def in_place(heights, level, nominal_diameter):
    """Which units are in their layer, by the heights of their centres above the bottom (n,) and the `level_of` the layer below
    [m]: the others fell out of it."""
    return np.asarray(heights) > level + ABOVE * nominal_diameter


def level_of(heights, level, nominal_diameter):
    """Median height of the centres of a layer's units [m]. It does not mind a few that fell out of the layer; where most did, it
    is that of the units that are in it, and where none is, the `level` of the layer below."""
    inside = in_place(heights, level, nominal_diameter)
    if 2 * inside.sum() < len(inside):
        heights = heights[inside]
    return float(np.median(heights)) if inside.any() else level


def shake(world, handles, acceleration, nominal_diameter):
    """Shake the bottom to and fro along x: what the units feel on it, as velocity jumps, one every half period of the sine.

    acceleration: peak [g]; two periods pass while a stone falls from rest over Dn / 2. A sine of peak a and frequency f gives
    a speed of a / (pi f) in half a period; the first and the last jump are half of that, so that no speed stays.
    """
    frequency = 2.0 * np.sqrt(9.81 / nominal_diameter)
    jump = np.array([9.81 * acceleration / (np.pi * frequency), 0.0, 0.0])
    for half in range(2 * SHAKES + 1):
        size = 0.5 if half in (0, 2 * SHAKES) else 1.0
        for handle in handles:
            handle.velocity = handle.velocity + size * (-1.0) ** half * jump
        world.run(0.5 / frequency)


def reference_shift(record, aims):
    """How far the unit nearest the middle of a layer came to rest from its aim, in plan [m]: what "layer reference" passes on.

    Only a unit that stands in its layer can be referred to; where none does, nothing is passed on.
    """
    stands = record.stands
    if not stands.any():
        return np.zeros(2)
    distance = ((aims - aims.mean(axis=0)) ** 2).sum(axis=1)
    middle = int(np.argmin(np.where(stands, distance, np.inf)))
    return record.handles[middle].position[:2] - aims[middle]
