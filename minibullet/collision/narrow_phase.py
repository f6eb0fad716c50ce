"""Who touches whom: python-fcl decides for each pair of convex pieces, and the feature it leads to is cached while it holds.

FCL finds the direction that separates two pieces (closest points of slightly inset hulls, so that touching pieces are still
apart for FCL); the direction is then made exact: the separation of the face and edge-edge normals around it is measured and
the largest taken (``separation.search``). Overlap cannot send FCL into its penetration algorithms, which are slow and sometimes
wrong. Spheres, capsules and planes have closed forms and never reach FCL.
"""

from math import frexp, sqrt

import fcl
import numpy as np

from minibullet.collision import broad_phase
from minibullet.collision.clipping import polygons
from minibullet.collision.feature_cache import carried_over, relative_poses, revalidate_all, unknown, update
from minibullet.collision.geometry import CAPSULE, FACES, VERTICES, Pair
from minibullet.collision.round_bodies import capsule_direction
from minibullet.collision.separation import workspace

INSET = 0.01  # share of its size by which a hull is shrunk before FCL sees it: [-]
OVERLAP = 0.0, 0.0, 0.0  # in place of a direction


class Collision:
    """The list of close pieces with their separating features, of one World; ``calls`` counts the calls of FCL."""

    def __init__(self, pieces):
        self.pieces = pieces
        self.cache = unknown(np.empty((0, 4), dtype=np.int64))
        self.travel, self.allowance = np.empty(0), np.empty(0)  # motion since the list was made, and its limit [m], (n,)
        self.calls = 0
        self._hulls = {}  # (piece, exponent of scale, role) -> fcl object; keeps FCL's geometry alive
        self._request = fcl.DistanceRequest(enable_nearest_points=True)

    @property
    def pieces(self):
        """The packed geometry of the scene."""
        return self._pieces

    @pieces.setter
    def pieces(self, pieces):
        self._pieces, self._workspace, self.polygons = pieces, workspace(pieces), polygons(pieces)

    def update(self, poses, piece_ranges, moving, group):
        """Bring the list of close pieces and the feature cache to where the bodies are; returns the cache.

        ``feature_cache.update`` measures each cached feature at today's poses and lists the pairs that need a new direction
        (queries); FCL gives it, and ``revalidate_all`` makes it exact.
        """
        self._update_list(poses, piece_ranges, moving, group)
        queries = np.empty(len(self.cache.kind), dtype=np.int64)
        queries = queries[: update(self.pieces, self.cache, poses, self._workspace, queries)]
        if len(queries):
            orientation, place = np.empty((len(queries), 3, 3)), np.empty((len(queries), 3))
            relative_poses(self.cache, poses, queries, orientation, place)
            pieces = self.cache.pieces[queries].tolist()
            directions = np.array([self._query(*pair) for pair in zip(pieces, orientation, place, strict=True)])
            revalidate_all(self.pieces, self.cache, poses, queries, directions, self._workspace)
        return self.cache

    def checkpoint(self):
        """The list, its features and what was moved since it was made, for ``roll_back``; what changes in place is copied."""
        return type(self.cache)(*[array.copy() for array in self.cache]), self.travel.copy(), self.allowance

    def roll_back(self, checkpoint):
        """Be again as at the checkpoint."""
        self.cache, self.travel, self.allowance = checkpoint

    def keep_rows(self, keep, row):
        """Forget the bodies that ``keep`` (n,) does not choose; row: the new row of each that stays, (n,)."""
        pairs = keep[self.cache.bodies].all(axis=1)
        cache = type(self.cache)(*(array[pairs] for array in self.cache))
        self.cache = cache._replace(bodies=row[cache.bodies])
        if len(self.travel) == len(keep):
            self.travel, self.allowance = self.travel[keep], self.allowance[keep]

    def _update_list(self, poses, piece_ranges, moving, group):
        """Make the list anew when some body's motion since, and the motion bound of this step, have used up its allowance."""
        bound = poses.motion_bound
        if len(self.travel) == len(bound):
            self.travel += poses.past_motion
            if not np.count_nonzero(self.travel + 1.01 * bound > self.allowance):
                return
        # bounding radius of the largest piece of each body, 0 for half-spaces
        radius = np.append(np.where(np.isfinite(self.pieces.bounding_radius), self.pieces.bounding_radius, 0.0), 0.0)
        size = np.maximum.reduceat(radius, piece_ranges.reshape(-1))[::2] if len(piece_ranges) else np.empty(0)
        self.travel = np.zeros(len(bound))
        # the allowance is a twentieth of the body's size, so that a resting heap keeps its list for many steps; a fast body gets
        # about eight steps of its motion more, or the list would be made anew at every step
        self.allowance = np.where(moving, 0.05 * size + np.minimum(8.0 * bound, 0.3 * size) + 1.5 * bound, bound)
        skin = self.allowance + 0.005 * size + poses.margin
        lower, upper = broad_phase.bounds(self.pieces, piece_ranges, poses, skin)
        body_pairs = broad_phase.overlapping(lower, upper, moving, group)
        self.cache = carried_over(self.cache, broad_phase.close_pieces(body_pairs, self.pieces, piece_ranges, poses, skin))

    def _hull(self, piece, exponent, role):
        """The FCL object of an inset piece, scaled by a power of two; one for each role, since a query needs two."""
        key = (piece, exponent, role)
        if key not in self._hulls:
            pieces, (first, end) = self.pieces, self.pieces.ranges[piece, VERTICES]
            points = pieces.centres[piece] + (1.0 - INSET) * (pieces.vertices[first:end] - pieces.centres[piece])
            loops = [pieces.loops[slice(*ends)] - first for ends in pieces.loop_ranges[slice(*pieces.ranges[piece, FACES])]]
            faces = np.concatenate([np.append(len(loop), loop) for loop in loops])
            self._hulls[key] = fcl.CollisionObject(fcl.Convex(np.ldexp(points, -exponent), len(loops), faces), fcl.Transform())
        return self._hulls[key]

    def _query(self, both, orientation, place):
        """The direction, in a's axes, from a piece of a to a piece of b, whose orientation and place in these axes are given;
        OVERLAP where the inset hulls overlap.

        FCL's tolerances are absolute lengths, so it sees everything scaled by a power of two to about unit size. It is not
        needed where one piece is a capsule: the segment's point that lies nearest says the direction.
        """
        i, j = both
        if self.pieces.kind[i] <= CAPSULE or self.pieces.kind[j] <= CAPSULE:
            return capsule_direction(self.pieces, Pair(*both, np.eye(3), orientation, tuple(place)))
        exponent = frexp(max(self.pieces.bounding_radius[i], self.pieces.bounding_radius[j]))[1]
        a, b = self._hull(i, exponent, "a"), self._hull(j, exponent, "b")
        b.setTransform(fcl.Transform(orientation, place * 2.0**-exponent))
        result = fcl.DistanceResult()
        self.calls += 1
        if not fcl.distance(a, b, self._request, result) > 0.0:
            return OVERLAP
        (x, y, z), (u, v, w) = (point.tolist() for point in result.nearest_points)  # in FCL's world frame, here the frame of a
        size = sqrt((u - x) ** 2 + (v - y) ** 2 + (w - z) ** 2)
        return ((u - x) / size, (v - y) / size, (w - z) / size) if size > 0.0 else OVERLAP
