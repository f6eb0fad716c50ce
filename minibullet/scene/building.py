"""The arrays of a world that a step reads."""

from math import isnan, sqrt

import numpy as np

from minibullet.bodies import Bodies
from minibullet.collision import manifolds
from minibullet.collision.broad_phase import Poses
from minibullet.collision.narrow_phase import Collision
from minibullet.collision.packing import pack
from minibullet.kernels import leaf

# arrays of a Scene that have a row for each body, beside those of Bodies
ROWS = ("friction", "restitution", "margin", "frame", "bounding_radius", "past_motion", "group", "piece_ranges")


class PlaneShape:
    """The half-space below a plane through the origin of its body; for collision only."""

    vertices, edges, faces, radius = np.zeros((0, 3)), np.zeros((0, 2), dtype=int), (), 0.0

    def __init__(self, normal):
        self.normals, self.offsets = np.array([normal]), np.zeros(1)


class Scene:
    """The arrays of n bodies that a step reads. Rows never change place."""

    def __init__(self):
        self.bodies = Bodies(*(np.empty((0, *shape)) for shape in ((3,), (4,), (6,), (), (3,), (), (), ())))
        self.friction, self.restitution = np.empty(0), np.empty(0)  # NaN = the world's, (n,)
        self.bounding_radius = np.empty(0)  # about the centre of mass, 0 for a plane [m], (n,)
        self.margin = np.empty(0)  # layer around the body that contacts keep open [m], (n,)
        self.past_motion = np.empty(0)  # bound on the motion of any point of the body since collision looked [m], (n,)
        self.group = np.empty(0, dtype=np.int64)
        self.piece_ranges = np.empty((0, 2), dtype=np.int64)
        self.frame = np.empty((0, 4))  # principal axes in the user's body axes, (n, 4)
        self.names = []
        self._census_of = None, None, None
        self.collision = Collision(pack([PlaneShape((0.0, 0.0, 1.0))]))

    @property
    def moving(self):
        """Which bodies can move, boolean (n,)."""
        return self._census()[1]

    @property
    def reference_mass(self):
        """Median mass of the moving bodies [kg]: turns impulses into velocities in residuals."""
        return self._census()[2]

    def keep_rows(self, keep, row):
        """Leave out the bodies that ``keep`` (n,) does not choose, none of which moves; row: the new row of each, (n,)."""
        self.bodies = Bodies(*(array[keep] for array in self.bodies))
        for name in ROWS:
            setattr(self, name, getattr(self, name)[keep])
        self.names = [name for name, stays in zip(self.names, keep, strict=True) if stays]
        self.collision.keep_rows(keep, row)

    def _census(self):
        """The masses, who can move, the median mass; found again only when the masses are others."""
        mass = self.bodies.mass
        if self._census_of[0] is not mass:
            moving = np.isfinite(mass)
            finite = np.sort(mass[moving])
            self._census_of = mass, moving, float(finite[len(finite) // 2]) if len(finite) else 1.0
        return self._census_of

    def poses(self, rotation, motion_bound):
        """Where the bodies are, as collision sees it; rotation matrices (n, 3, 3), bound on the motion in this step [m], (n,)."""
        return Poses(self.bodies.position, rotation, self.margin, self.past_motion, motion_bound)

    def update_pairs(self, poses):
        """Bring the pairs of close pieces, and the features that separate them, to where the bodies are now."""
        return self.collision.update(poses, self.piece_ranges, self.moving, self.group)

    def contact_points(self, poses, warm_start):
        """The ContactPoints of a step: who touches whom, and where; ``warm_start``, of the step before, is used up."""
        cache = self.update_pairs(poses)
        return manifolds.build(self.collision.pieces, cache, poses, self.collision.polygons, warm_start)

    def contact_size(self, pair):
        """Bounding radius of the smaller body of each pair (m, 2), planes left out [m], (m,)."""
        size = np.empty(len(pair))
        smaller(self.bounding_radius, pair, size)
        return size

    def pair_value(self, values, pair, default):
        """Value of each contact: the geometric mean of both bodies' own values, the only one there is, or the default, (m,)."""
        value = np.empty(len(pair))
        combined(values, pair, float(default), value)
        return value


@leaf
def smaller(radius, pair, size):
    """The smaller radius of each pair (m, 2) that is not zero, into ``size`` (m,)."""
    for c in range(len(pair)):
        a, b = radius[pair[c, 0]], radius[pair[c, 1]]
        size[c] = min(a if a > 0.0 else np.inf, b if b > 0.0 else np.inf)


@leaf
def combined(values, pair, default, value):
    """``Scene.pair_value`` into ``value`` (m,)."""
    for c in range(len(pair)):
        a, b = values[pair[c, 0]], values[pair[c, 1]]
        a, b = b if isnan(a) else a, a if isnan(b) else b
        value[c] = default if isnan(a) else sqrt(a * b)
