"""The arrays of a world that a step reads."""

from math import isnan, sqrt

import numpy as np

from minibullet.bodies import Bodies
from minibullet.collision import manifolds
from minibullet.collision.geometry import pack
from minibullet.collision.narrow_phase import Collision
from minibullet.kernels import leaf


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
        self.reach = np.empty(0)  # radius about the centre of mass [m], (n,)
        self.margin = np.empty(0)  # layer around the body that contacts keep open [m], (n,)
        self.moved = np.empty(0)  # bound on the motion of any point of the body in the last step [m], (n,)
        self.group = np.empty(0, dtype=np.int64)
        self.piece_ranges = np.empty((0, 2), dtype=np.int64)
        self.frame = np.empty((0, 4))  # principal axes in the user's body axes, (n, 4)
        self.names = []
        self._counted = (None, None, None)
        self.collision = Collision(pack([PlaneShape((0.0, 0.0, 1.0))]))

    @property
    def moving(self):
        """Which bodies can move, boolean (n,)."""
        return self._census()[1]

    @property
    def reference_mass(self):
        """Median mass of the moving bodies [kg]: turns impulses into velocities in residuals."""
        return self._census()[2]

    def _census(self):
        """The masses, who can move, the median mass; counted again only when the masses are others."""
        mass = self.bodies.mass
        if self._counted[0] is not mass:
            moving = np.isfinite(mass)
            finite = np.sort(mass[moving])
            self._counted = mass, moving, float(finite[len(finite) // 2]) if len(finite) else 1.0
        return self._counted

    def touching(self, rotation, stride, kept):
        """The contacts of a step, as ``manifolds.build`` gives them: who touches whom by ``Collision.find``, and where."""
        collision, bodies = self.collision, self.bodies
        rows = collision.find(bodies, rotation, self.piece_ranges, self.group, self.margin, self.moved, stride)
        answers, numbers, ranges = collision.answers, collision.numbers, collision.contact_range
        return manifolds.build(
            collision.pieces, rows, answers, numbers, ranges, collision.polygons,
            bodies.position, rotation, stride, self.margin, *kept,
        )  # fmt: skip

    def contact_size(self, pair):
        """Bounding radius of the smaller body of each pair (m, 2), planes left out [m], (m,)."""
        size = np.empty(len(pair))
        smaller(self.reach, pair, size)
        return size

    def pair_value(self, values, pair, default):
        """Value of each contact: the geometric mean of both bodies' own values, the only one there is, or the default, (m,)."""
        value = np.empty(len(pair))
        combined(values, pair, float(default), value)
        return value


@leaf
def smaller(reach, pair, size):
    """The smaller reach of each pair (m, 2) that is not zero, into ``size`` (m,)."""
    for c in range(len(pair)):
        one, two = reach[pair[c, 0]], reach[pair[c, 1]]
        size[c] = min(one if one > 0.0 else np.inf, two if two > 0.0 else np.inf)


@leaf
def combined(values, pair, default, value):
    """``Scene.pair_value`` into ``value`` (m,)."""
    for c in range(len(pair)):
        one, two = values[pair[c, 0]], values[pair[c, 1]]
        one, two = two if isnan(one) else one, one if isnan(two) else two
        value[c] = default if isnan(one) else sqrt(one * two)
