"""Motion with contacts: many independent runs of a body on its floor, beside each other in one World of the engine."""

import warnings
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

import minibullet as mb
from hlcs.data.rigid_body import Altered, RigidBody, rigid_body, support
from hlcs.simulation.batch_effects import shared_effects
from hlcs.simulation.track import JUMP, Track
from minibullet import rotations
from minibullet.shapes.primitives import ConvexPiece

BOX = np.repeat(np.eye(3), 2, axis=0) * np.tile([[1.0], [-1.0]], (3, 1))  # outward normals of its faces
ENDS = {shape: ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0)) for shape in ("disc", "cylinder")} | {"cone": ((0.0, 0.0, -1.0),)}  # likewise
SWEEPS = 1000  # a body on an edge needs hundreds; the exact solver costs more than what it adds to them can be measured


@dataclass(frozen=True)
class OffCentre(Altered):
    """A solid whose centre of mass was moved by `centre` (body axes) [m]."""

    shape: object
    centre: tuple

    @cached_property
    def pieces(self):
        """Convex pieces relative to the moved centre of mass."""
        return tuple(ConvexPiece(piece.vertices - np.asarray(self.centre), piece.radius) for piece in self.shape.pieces)


@lru_cache(maxsize=256)
def off_centre(shape, centre):
    """The OffCentre of a shape; the same one for every run that has it."""
    return OffCentre(shape, centre)


def gap(shape, position, orientation, surroundings):
    """Gap between a body and its floor [m]; inf without a floor."""
    if surroundings.floor_height is None:
        return np.inf
    return float(surroundings.above_floor(position) + support(shape, orientation, surroundings.normal).min())


def seat(shape, initial_state, nominal, actual, margin):
    """An initial state (13,) at rest on the nominal floor, moved to rest on the actual one without its velocity into the floor.

    A face or a rounded body that lies flat turns with the floor; a body on an edge or corner keeps its attitude.
    """
    state = initial_state.copy()
    old, new = nominal.normal, actual.normal
    if (np.abs(old - new) > 1e-8 + 1e-5 * np.abs(new)).any():
        heights = support(shape, state[6:10], old)
        if np.sum(heights < heights.min() + 0.01 * np.ptp(heights) + 1e-9) >= 3:
            turn = rotations.between(old, new)
            state[6:10] = rotations.product(turn, state[6:10])
    state[:3] += (margin - gap(shape, state[:3], state[6:10], actual)) * new
    state[3:6] -= (state[3:6] @ new) * new
    return state


@lru_cache(maxsize=256)
def faces(body):
    """Outward normals (F, 3), body axes, of the faces on which a box, a disc, a cylinder, a cone or the hull of a mesh can lie;
    none of other shapes."""
    if body.shape == "box":
        return BOX
    if body.shape in ENDS:
        return np.array(ENDS[body.shape])
    if body.shape != "mesh":
        return np.zeros((0, 3))
    return ConvexPiece(np.concatenate([piece.vertices for piece in rigid_body(body).shape.pieces])).normals


def lies_on_a_face(body, normal, orientations, sigma):
    """Does a body lie still on one of its faces over its first dozen measured orientations (n, 4), noise sigma [rad] granted?"""
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


class Run(NamedTuple):
    """One run: a body, where it starts, its floor, and the laws that hold for it and for no other run of its World."""

    body: RigidBody
    shape: object  # a minibullet shape about the centre of mass
    initial_state: np.ndarray  # of the centre of mass (13,)
    floor: tuple | None  # (unit normal, height along it [m]), None = none
    effects: tuple
    friction: float  # [-]
    restitution: float  # [-]


def run_of(body, setup, initial_state, effects, moved_centre):
    """The Run of a rigid body in its Setup; moved_centre: whether centres of mass are off the centres of their shapes.

    A gap that contacts keep open lifts the floor: the body touches, rolls and turns with its own surface.
    """
    around, floor = setup.surroundings, None
    if around.floor_height is not None:
        floor = around.floor_normal, around.floor_height + setup.margin
    shape = off_centre(body.shape, setup.centre) if moved_centre else body.shape
    return Run(body, shape, initial_state, floor, effects, around.friction, around.restitution)


def simulate(runs, duration, step):
    """Track of many runs for a duration [s] in steps [s], beside each other in one World; no run touches another."""
    effects, assignment = shared_effects([run.effects for run in runs])
    settings = mb.Settings(
        time_step=step,
        friction=float(runs[0].friction),
        restitution=float(runs[0].restitution),
        margin=0.0,
        solver="gauss_seidel",
        iterations=SWEEPS,
    )
    world = mb.World(effects=effects, settings=settings)
    _add(world, runs)
    scene = world.registry.commit()
    row_of = {name: row for row, name in enumerate(scene.names)}
    order = np.array([row_of[f"run {b}"] for b in range(len(runs))])
    if assignment is not None:
        run_of_row = np.full(len(scene.names), -1)
        run_of_row[order] = np.arange(len(runs))
        assignment.take(run_of_row)
    frames = scene.frame[order]
    count = max(int(np.ceil(duration / step - 1e-9)), 1)
    record = [np.empty((count + 1, len(runs), size)) for size in (3, 3, 4, 3)]
    pushed, struck = np.zeros((2, count, len(scene.names)), bool)
    initial_states = np.array([run.initial_state for run in runs])
    for store, columns in zip(record, (slice(0, 3), slice(3, 6), slice(6, 10), slice(10, 13)), strict=True):
        store[0] = initial_states[:, columns]
    with warnings.catch_warnings():  # a start read from noisy samples may lie a little in its floor: no scene of the user's
        warnings.simplefilter("ignore", mb.SceneWarning)
        for k in range(1, count + 1):
            world.step()
            last, after, twist = world.last_step, world.last_step.after, world.last_step.after.twist[order]
            impact = last.impact_impulse + 0 * last.solution.impulse  # a mere 0.0 where nothing rebounds
            pushed[k - 1, last.points.bodies[(last.solution.impulse + impact)[:, 0] > 0]] = True
            struck[k - 1, last.points.bodies[impact[:, 0] > 0]] = True
            record[0][k], record[1][k] = after.position[order], twist[:, :3]
            record[2][k], record[3][k] = after.orientation[order], twist[:, 3:]
    record[2][1:] = rotations.product(record[2][1:], rotations.conjugate(frames))
    _leave_impacts(record, pushed[:, order] & ~struck[:, order], step)
    return Track(np.arange(count + 1) * step, *record, pushed[:, order])


def _leave_impacts(record, held, step):
    """Set what T nodes of a track hold as the velocity after an impact without rebound to the one that the body goes on with.

    A step that ends in touch ends with the velocity that carries the body just to the surface; the next one has that after the
    impact. record: positions, velocities, orientations and spins (T, B, ..); held: by such contacts alone (T - 1, B).
    """
    _, velocity, _, spin = record
    jump = np.linalg.norm(velocity[2:] - velocity[:-2], axis=-1)
    who = held[:-1] & held[1:] & (jump > JUMP * step)
    for part in (velocity, spin):
        part[1:-1][who] = part[2:][who]


def _add(world, runs):
    """Put runs into a World: one floor for all where they have the same, else one each."""
    unlike, like = len({(run.friction, run.restitution) for run in runs}) > 1, None
    floors = {run.floor for run in runs if run.floor is not None}
    for b, run in enumerate(runs):
        if run.floor is not None and len(floors) > 1:
            world.add_plane(*run.floor, name=f"floor {b}", group=b)
        own = {
            "friction": float(run.friction) if unlike else None,
            "restitution": float(run.restitution) if unlike else None,
            "position": run.initial_state[:3],
            "orientation": run.initial_state[6:10],
            "velocity": run.initial_state[3:6],
            "angular_velocity": run.initial_state[10:13],
            "name": f"run {b}",
            "group": b,
        }
        if like is not None and runs[b - 1].body is run.body and runs[b - 1].shape is run.shape:  # to check a body takes its time
            world.registry.add_alike(like, **own)
        else:
            like = world.add(run.shape, mass=run.body.mass, inertia=run.body.tensor, **own)
    if len(floors) == 1:
        world.add_plane(*floors.pop())
