"""Who touches whom: python-fcl decides for each pair of convex pieces, and its answer is kept while it holds.

FCL finds the direction that separates two pieces (closest points of slightly inset hulls, so that touching pieces are still
apart for FCL); the direction is then made exact: the separation of the face and edge-edge normals around it is measured and
the largest taken (``answers``). Overlap cannot send FCL into its penetration algorithms, which are slow and sometimes wrong.
Spheres, capsules and planes have closed forms and never reach FCL.
"""

from math import frexp, sqrt

import fcl
import numpy as np

from minibullet.collision import broad_phase as pairs_module
from minibullet.collision.clipping import polygons
from minibullet.collision.feature_cache import adopt_all, refresh, relative_poses, workspace
from minibullet.collision.geometry import FACES, VERTICES
from minibullet.collision.separation import capsule_direction

INSET = 0.01  # share of its size by which a hull is shrunk before FCL sees it: [-]


class Collision:
    """The list of close pieces with FCL's kept answers. One object belongs to one World; ``calls`` counts the calls of FCL."""

    def __init__(self, pieces):
        self.pieces = pieces
        self.rows = np.empty((0, 4), dtype=np.int64)  # body a, body b, piece a, piece b
        self.answers = np.empty((0, 5), dtype=np.int64)
        self.numbers = np.empty((0, 11))
        self.contact_range = np.empty((0, 2), dtype=np.int64)  # this pair's contacts of the previous step
        self.travel, self.allowance = np.empty(0), np.empty(0)  # motion since the list was made, and its limit [m], (n,)
        self.calls = 0
        self._hulls = {}  # (piece, exponent of scale, role) -> fcl object; keeps FCL's geometry alive
        self._request = fcl.DistanceRequest(enable_nearest_points=True)

    def find(self, bodies, rotation, piece_ranges, group, margin, moved, stride):
        """Refresh the list and the answers; per body: margin [m], motion in the last step and bound on it in this one [m]."""
        self._update_list(bodies, rotation, piece_ranges, group, margin, moved, stride)
        work, place = self._workspace, bodies.position
        ask = np.empty(len(self.rows), dtype=np.int64)
        ask = ask[: refresh(self.pieces, *self._kept, place, rotation, moved, stride, margin, work, ask)]
        if len(ask):
            poses, directions = np.empty((len(ask), 12)), np.empty((len(ask), 3))
            relative_poses(self.rows, ask, place, rotation, poses)
            for row, pose, direction in zip(self.rows[ask], poses, directions, strict=True):
                direction[:] = self._ask(row[2], row[3], pose[:9].reshape(3, 3), pose[9:])
            adopt_all(self.pieces, *self._kept, ask, place, rotation, margin, directions, work)
        return self.rows

    def hold(self):
        """The list, its answers and what was moved since it was made, for ``take_back``; what changes in place is copied."""
        return (self.rows, self.answers.copy(), self.numbers.copy(), self.contact_range.copy(), self.travel.copy(),
                self.allowance)  # fmt: skip

    def take_back(self, held):
        """Be again what ``hold`` saw."""
        self.rows, self.answers, self.numbers, self.contact_range, self.travel, self.allowance = held

    @property
    def pieces(self):
        """The packed geometry of the scene."""
        return self._pieces

    @pieces.setter
    def pieces(self, pieces):
        self._pieces, self._workspace, self.polygons = pieces, workspace(pieces), polygons(pieces)

    @property
    def _kept(self):
        return self.rows, self.answers, self.numbers

    def _update_list(self, bodies, rotation, piece_ranges, group, margin, moved, stride):
        """Make the list anew when some body's motion since, and the reach of this step, have used up its allowance."""
        if len(self.travel) == len(moved):
            self.travel += moved
            if not np.count_nonzero(self.travel + 1.01 * stride > self.allowance):
                return
        moving = np.isfinite(bodies.mass)
        size = np.empty(len(moved))
        pairs_module.body_sizes(self.pieces, piece_ranges, size)
        self.travel = np.zeros(len(moved))
        # a fast body gets a thicker skin: about eight steps of its motion, or its list would be made anew at every step
        self.allowance = np.where(moving, 0.05 * size + np.minimum(8.0 * stride, 0.3 * size) + 1.5 * stride, stride)
        grown = self.allowance + 0.005 * size + margin
        lower, upper = pairs_module.bounds(self.pieces, piece_ranges, bodies.position, rotation, grown)
        body_pairs = pairs_module.overlapping(lower, upper, moving, group)
        rows = pairs_module.close_pieces(body_pairs, self.pieces, piece_ranges, bodies.position, rotation, grown)
        match = pairs_module.carry_over(self.rows, rows)
        kept = match >= 0
        answers, numbers = np.zeros((len(rows), 5), dtype=np.int64), np.zeros((len(rows), 11))
        numbers[:, 10] = np.inf
        contact_range = np.zeros((len(rows), 2), dtype=np.int64)
        answers[kept], numbers[kept], contact_range[kept] = (
            self.answers[match[kept]],
            self.numbers[match[kept]],
            self.contact_range[match[kept]],
        )
        self.rows, self.answers, self.numbers, self.contact_range = rows, answers, numbers, contact_range

    def _hull(self, piece, exponent, role):
        key = (piece, exponent, role)
        if key not in self._hulls:
            pieces = self.pieces
            first, end = pieces.ranges[piece, VERTICES], pieces.ranges[piece, VERTICES + 1]
            points = np.ldexp(
                pieces.centres[piece] + (1.0 - INSET) * (pieces.vertices[first:end] - pieces.centres[piece]), -exponent
            )
            faces = []
            for loop_first, loop_end in pieces.face_ranges[pieces.ranges[piece, FACES] : pieces.ranges[piece, FACES + 1]]:
                loop = pieces.loops[loop_first:loop_end] - first
                faces.extend((len(loop), *loop))
            self._hulls[key] = fcl.CollisionObject(
                fcl.Convex(
                    points,
                    len(pieces.face_ranges[pieces.ranges[piece, FACES] : pieces.ranges[piece, FACES + 1]]),
                    np.array(faces, dtype=np.int64),
                ),
                fcl.Transform(),
            )
        return self._hulls[key]

    def _ask(self, i, j, orientation, place):
        """The direction, in a's axes, from piece i of a to piece j of b, whose orientation and place in these axes are given;
        zero where the inset hulls overlap.

        FCL's tolerances are absolute lengths, so it sees everything scaled by a power of two to about unit size. It is not
        needed where one piece is a capsule: the segment's point that lies nearest says the direction.
        """
        pieces = self.pieces
        if pieces.ranges[i, FACES] == pieces.ranges[i, FACES + 1] or pieces.ranges[j, FACES] == pieces.ranges[j, FACES + 1]:
            return capsule_direction(pieces, i, j, np.eye(3), orientation, *place)
        exponent = frexp(max(pieces.sizes[i, 0], pieces.sizes[j, 0]))[1]
        one, two = self._hull(i, exponent, "a"), self._hull(j, exponent, "b")
        two.setTransform(fcl.Transform(orientation, place * 2.0**-exponent))
        result = fcl.DistanceResult()
        self.calls += 1
        if not fcl.distance(one, two, self._request, result) > 0.0:
            return 0.0, 0.0, 0.0
        (x, y, z), (u, v, w) = (point.tolist() for point in result.nearest_points)
        size = sqrt((u - x) ** 2 + (v - y) ** 2 + (w - z) ** 2)
        if not size > 0.0:
            return 0.0, 0.0, 0.0
        # FCL answers in the frame of its world, here the frame of a
        return (u - x) / size, (v - y) / size, (w - z) / size
