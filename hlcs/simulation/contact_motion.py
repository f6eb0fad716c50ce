"""Motion with contacts: many independent runs of one body on its floor, side by side in one World of the engine."""

import warnings
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from hlcs.data.rigid_body import solid as solid_of
from hlcs.simulation.batch_effects import shared
from hlcs.simulation.free_flight import Track
from minibullet import rotations

BOX = np.repeat(np.eye(3), 2, axis=0) * np.tile([[1.0], [-1.0]], (3, 1))  # outward normals of its faces
SWEEPS = 1000  # a body on an edge needs hundreds; the exact solver costs more than what it adds to them can be measured


@dataclass(frozen=True)
class OffCentre:
    """A solid whose centre of mass was moved by `centre` (body axes) [m]; everything else is the shape's own."""

    shape: object
    centre: tuple

    def __getattr__(self, name):
        return getattr(self.shape, name)

    @cached_property
    def pieces(self):
        """Convex pieces relative to the moved centre of mass."""
        from minibullet.shapes.primitives import ConvexPiece

        return tuple(ConvexPiece(piece.vertices - np.asarray(self.centre), piece.radius) for piece in self.shape.pieces)


@lru_cache(maxsize=256)
def off_centre(shape, centre):
    """The OffCentre of a shape; the same one for every run that has it."""
    return OffCentre(shape, centre)


def support(shape, orientation, normal):
    """Heights of all vertices (less their rounding radius) above the centre of mass along the normal, (V,) [m]."""
    heights = [rotations.rotate(orientation, piece.vertices) @ normal - piece.radius for piece in shape.pieces]
    return np.concatenate(heights)


def gap(shape, position, orientation, surroundings):
    """Gap between a body and its floor [m]; inf without a floor."""
    if surroundings.floor_height is None:
        return np.inf
    normal = np.asarray(surroundings.floor_normal)
    return float(position @ normal - surroundings.floor_height + support(shape, orientation, normal).min())


def seat(shape, start, nominal, actual, margin):
    """A start (13,) that rests on the nominal floor, moved to rest on the actual one; its velocity into the floor taken out.

    A face or a rounded body that lies flat turns with the floor; a body on an edge or corner keeps its attitude.
    """
    start = start.copy()
    old, new = np.asarray(nominal.floor_normal), np.asarray(actual.floor_normal)
    if not np.allclose(old, new):
        heights = support(shape, start[6:10], old)
        if np.sum(heights < heights.min() + 0.01 * np.ptp(heights) + 1e-9) >= 3:
            turn = rotations.between(old, new)
            start[6:10] = rotations.product(turn, start[6:10])
    start[:3] += (margin - gap(shape, start[:3], start[6:10], actual)) * new
    start[3:6] -= (start[3:6] @ new) * new
    return start


@lru_cache(maxsize=256)
def faces(body):
    """Outward normals (F, 3), body axes, of the faces on which a box or the hull of a mesh can lie; none of other shapes."""
    if body.shape == "box":
        return BOX
    if body.shape != "mesh":
        return np.zeros((0, 3))
    from minibullet.shapes.primitives import ConvexPiece

    return ConvexPiece(np.concatenate([piece.vertices for piece in solid_of(body).shape.pieces])).normals


def lies_on_a_face(body, normal, orientations, sigma):
    """Does a box or a mesh lie still on one face over its first dozen measured orientations (n, 4), noise sigma [rad] granted?"""
    there = orientations[np.isfinite(orientations[:, 0])][:12]
    if len(there) < 12 or not len(faces(body)):
        return False
    seen = rotations.rotate(rotations.conjugate(there), np.asarray(normal, dtype=float))  # the normal in body axes
    for half in (seen[:6], seen[6:]):
        mean = half.mean(axis=0)
        if np.arccos(min(np.max(faces(body) @ -mean) / np.linalg.norm(mean), 1.0)) > 0.005 + 4 * sigma / np.sqrt(6):
            return False
    return True


def flattened(orientation, normal, sides=BOX):
    """The nearest orientation (4,) in which one of the sides (outward normals (F, 3), body axes) lies on such a floor."""
    normal = np.asarray(normal, dtype=float)
    seen = rotations.rotate(rotations.conjugate(orientation), normal)
    down = sides[np.argmax(sides @ -seen)]
    return rotations.product(rotations.between(rotations.rotate(orientation, -down), normal), orientation)


def run(solids, shapes, starts, floors, effects, friction, restitution, duration, step):
    """Track of B runs: shapes and starts (B, 13) on floors [(normal, height) or None]; no run touches another.

    effects: tuple of values for each run; friction, restitution [-]: of each run (B,).
    """
    import minibullet as mb

    acting, seats = shared(effects)
    world = mb.World(
        effects=acting,
        settings=mb.Settings(
            time_step=step,
            friction=float(friction[0]),
            restitution=float(restitution[0]),
            margin=0.0,
            solver="gauss_seidel",
            iterations=SWEEPS,
        ),
    )
    unlike = bool(np.ptp(friction) or np.ptp(restitution))
    distinct = {floor for floor in floors if floor is not None}
    for b, (solid, shape, start, floor) in enumerate(zip(solids, shapes, starts, floors, strict=True)):
        if floor is not None and len(distinct) > 1:
            world.add_plane(floor[0], floor[1], name=f"floor {b}", group=b)
        own = {"friction": float(friction[b]), "restitution": float(restitution[b])} if unlike else {}
        world.add(
            shape,
            mass=solid.mass,
            inertia=solid.tensor,
            position=start[:3],
            orientation=start[6:10],
            velocity=start[3:6],
            angular_velocity=start[10:13],
            name=f"run {b}",
            group=b,
            **own,
        )
    if len(distinct) == 1:
        ((normal, height),) = distinct
        world.add_plane(normal, height)
    scene = world.registry.commit()
    place = {name: row for row, name in enumerate(scene.names)}
    order = np.array([place[f"run {b}"] for b in range(len(starts))])
    if seats is not None:
        run_of_row = np.full(len(scene.names), -1)
        run_of_row[order] = np.arange(len(starts))
        seats.take(run_of_row)
    frames = scene.frame[order]
    count = max(int(np.ceil(duration / step - 1e-9)), 1)
    record = [np.empty((count + 1, len(starts), size)) for size in (3, 3, 4, 3)]
    for store, columns in zip(record, (slice(0, 3), slice(3, 6), slice(6, 10), slice(10, 13)), strict=True):
        store[0] = starts[:, columns]
    with warnings.catch_warnings():  # a start read from noisy samples may lie a little in its floor: no scene of the user's
        warnings.simplefilter("ignore", mb.SceneWarning)
        for k in range(1, count + 1):
            world.step()
            after = world.last_step.after
            record[0][k], record[1][k], record[3][k] = after.position[order], after.twist[order, :3], after.twist[order, 3:]
            record[2][k] = after.orientation[order]
    record[2][1:] = rotations.product(record[2][1:], rotations.conjugate(frames))
    return Track(np.arange(count + 1) * step, *record)
