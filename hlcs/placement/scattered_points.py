"""From scattered survey points to a bed on a full grid: linear between neighbours, and nothing where no point is near."""

from typing import NamedTuple

import numpy as np
from scipy import interpolate, spatial

from minibullet.errors import InputError

HOLE = 4.0  # mean distances of points: what is farther from every point is a hole. A mean distance h = sqrt(ab) has a survey in
# lines b apart with points every a along them: they may be 64 times as far apart as their points before the gaps count as holes
MOST_EMPTY = 20.0  # times that the rectangle round the points may be larger than what they cover: beyond, they lie on a line


class GriddedPoints(NamedTuple):
    """A bed interpolated from points."""

    x: np.ndarray  # (c,) of the grid, about the middle of the points [m]
    y: np.ndarray  # (r,)
    z: np.ndarray  # (r, c) heights; of a node that no point is near to, that of the nearest point
    covered: np.ndarray  # (r - 1, c - 1) cells all of whose corners the survey covers


def gridded(points, name):
    """GriddedPoints of scattered points (n, 3) [m]: Delaunay's triangles, linear on each, read at the nodes of a square grid
    whose step is the mean distance of the points, sqrt(area / n).

    A node is covered where it lies within the outline (convex hull) of the points and no farther than HOLE steps from one.
    InputError, beginning with `name`, where the points lie on a line.
    """
    middle = 0.5 * (points[:, :2].min(axis=0) + points[:, :2].max(axis=0))
    plan = points[:, :2] - middle
    try:
        area = spatial.ConvexHull(plan).volume  # in the plane its volume is the area
    except spatial.QhullError:
        area = 0.0
    extent = np.ptp(plan, axis=0)
    if not area * MOST_EMPTY > extent.prod():
        raise InputError(
            f"{name}: the {len(points)} points lie on a line, or nearly so; a bed needs points beside each other, "
            "in x_m and in y_m (turn the axes where they lie in a narrow strip across them)"
        )
    step = float(np.sqrt(area / len(points)))
    x, y = (np.linspace(-0.5 * length, 0.5 * length, int(np.ceil(length / step)) + 1) for length in extent)
    nodes = np.stack(np.meshgrid(x, y), axis=-1)
    z = interpolate.LinearNDInterpolator(plan, points[:, 2])(nodes)
    distance, nearest = spatial.cKDTree(plan).query(nodes)
    known = np.isfinite(z) & (distance <= HOLE * step)
    covered = known[:-1, :-1] & known[:-1, 1:] & known[1:, :-1] & known[1:, 1:]
    return GriddedPoints(x, y, np.where(np.isfinite(z), z, points[nearest, 2]), covered)
