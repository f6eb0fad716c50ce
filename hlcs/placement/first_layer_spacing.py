"""Whether units in their first-layer pose can stand side by side on a grid, and the narrowest grid on which they can.

Judged by the solids themselves, without margin: a unit and its neighbours are put on the grid, all with one heading, and
looked at for overlaps. On a triangular grid any heading will do. On a rectangular one the horizontal tip axis lies along x, so
there are two headings; where they fit beside each other in any mix, both may be drawn.
"""

from bisect import bisect_left
from functools import cache

import numpy as np

import minibullet as mb
from minibullet import rotations
from minibullet.errors import InputError

# Spacings are given to a hundredth of Dn, the paper's too: its RPG is the footprint of the unit, 1.404 x 1.298 Dn, printed as
# 1.40 x 1.30. So an overlap of half a hundredth is none [Dn].
ROUNDING = 0.005
FAR = 4.0  # [Dn] spacing at which no two units of any kind can meet
COARSE, FINE = np.radians(np.arange(0.0, 180.0, 5.0)), np.radians(np.arange(-4.0, 5.0))  # headings looked at; half a turn
# maps a grid onto itself
SIDES = {  # neighbours of a unit, in spacings; those on the other side mirror them
    False: ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (-1.0, 1.0)),
    True: ((1.0, 0.0), (0.5, 1.0), (-0.5, 1.0), (1.5, 1.0), (-1.5, 1.0), (0.0, 2.0), (1.0, 2.0), (-1.0, 2.0)),
}


def first_headings(test, centres):
    """Headings [rad] that the units of a PlacementTest's first layer
    can have side by side; centres: (n, 2) where they are aimed [m].

    InputError that names the narrowest spacings where they cannot stand with any heading.
    """
    grid, unit = test.grid, test.unit
    plane = np.column_stack([centres, np.ones(len(centres))])
    grade = np.linalg.lstsq(plane, test.bottom.height(*centres.T), rcond=None)[0][:2].round(6)  # of the bottom, in the mean
    place = unit, test.shape, grid.triangular, (min(test.rows, 3), min(test.columns, 3)), tuple(grade.tolist())
    headings = headings_on(*place, grid.spacing_x, grid.spacing_y)
    if headings:
        return headings
    x, y = narrowest(*place, grid.spacing_x, grid.spacing_y)
    raise InputError(
        f"placement: grid = {grid.name}: units of the first layer ({unit.name}, {test.shape}) overlap at spacing_x = "
        f"{grid.spacing_x:g} Dn, spacing_y = {grid.spacing_y:g} Dn whatever their heading; the smallest feasible spacing_x is "
        f"{x[0]:.2f} (with spacing_y {x[1]:g}), the smallest feasible spacing_y is {y[1]:.2f} (with spacing_x {y[0]:g}); "
        "give a wider grid"
    )


@cache
def headings_on(unit, shape, triangular, size, grade, spacing_x, spacing_y):
    """Headings [rad] at which first-layer units stand on such a grid: () none; one, for all units; or two for any mix.

    size: rows and columns, 3 for more; grade: rise of the bottom along x and y; spacings in Dn.
    """
    patch = _Patch(unit, shape, triangular, size, grade, spacing_x, spacing_y)
    if not triangular:
        mixes = [(0.0, other) for other in (0.0, np.pi)] + [(np.pi, other) for other in (0.0, np.pi)]
        free = [patch.overlap(*mix) <= ROUNDING for mix in mixes]
        return (0.0, np.pi) if all(free) else (0.0,) if free[0] else (np.pi,) if free[3] else ()
    depths = []
    for heading in COARSE:
        depths.append(patch.overlap(heading, heading))
        if depths[-1] <= ROUNDING:
            return (float(heading),)
    if min(depths) > ROUNDING + patch.most_by_turning(0.5 * COARSE[1]):
        return ()
    near = COARSE[np.argsort(depths, kind="stable")[:3]]
    fine = (near[:, None] + FINE).ravel()  # around the least overlaps, degree by degree
    return next(((float(heading),) for heading in fine if patch.overlap(heading, heading) <= ROUNDING), ())


def narrowest(unit, shape, triangular, size, grade, spacing_x, spacing_y):
    """((x, y), (x, y)): the least spacing_x with the spacing_y at hand, and the least spacing_y with the spacing_x at hand, where
    these are wide enough for anything to fit; in hundredths of Dn."""

    def fits(x, y):
        return bool(headings_on(unit, shape, triangular, size, grade, x, y))

    def least(along):
        steps = range(1, round(100 * FAR) + 1)
        return steps[bisect_left(steps, True, key=lambda step: along(step / 100.0))] / 100.0

    wide_x = max(spacing_x, least(lambda x: fits(x, FAR)))
    wide_y = max(spacing_y, least(lambda y: fits(2.0 * FAR, y)))
    return (least(lambda x: fits(x, wide_y)), wide_y), (wide_x, least(lambda y: fits(wide_x, y)))


class _Patch:
    """A unit and its neighbours on a grid."""

    def __init__(self, unit, shape, triangular, size, grade, spacing_x, spacing_y):
        self.unit, self.diameter = unit, unit.nominal_diameter
        normal = np.array([-grade[0], -grade[1], 1.0])
        self.upright = rotations.between(np.array([0.0, 0.0, 1.0]), normal / np.sqrt(rotations.dot(normal, normal)))
        world, solid = mb.World(), unit.shape(shape)
        self.pairs = []
        for column, row in SIDES[triangular]:
            x, y = column * spacing_x * self.diameter, row * spacing_y * self.diameter
            if row >= size[0] or abs(column) >= size[1] or np.hypot(x, y) > 2.0 * solid.bounding_radius:
                continue  # not there, or too far to touch
            place, group = (x, y, grade[0] * x + grade[1] * y), len(self.pairs)
            self.pairs.append([world.add(solid, density=1.0, position=p, group=group) for p in ((0.0, 0.0, 0.0), place)])
        self.world = world

    def most_by_turning(self, angle):
        """By how much an overlap can change when both units turn by an angle [rad]: points move by radius times angle [Dn]."""
        return 2.0 * angle * self.unit.pieces.bounding_radius / self.diameter

    def overlap(self, heading, other):
        """Deepest overlap of a unit with the one heading and neighbours with the other [Dn]."""
        for pair in self.pairs:
            for handle, angle in zip(pair, (heading, other), strict=True):
                handle.orientation = rotations.product(self.upright, self.unit.first_layer_orientation(angle))
        found = self.world.overlaps() if self.pairs else []
        return found[0][2] / self.diameter if found else 0.0
