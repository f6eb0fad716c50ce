"""The two engines behind one face: built from a Scene, told to step, asked for poses and velocities.

Each import is made where it is used, so that a run of one engine never loads the other.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull


def outward_triangles(points):
    """Counter-clockwise triangles (t, 3) of the hull of points (V, 3), seen from outside."""
    hull = ConvexHull(points)
    triangles = hull.simplices.copy()
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles


def write_obj(path, pieces):
    """A wavefront file with one object for each convex piece: Bullet makes a compound of hulls of it."""
    lines, first = [], 1
    for number, points in enumerate(pieces):
        lines.append(f"o piece{number}")
        lines += ["v {!r} {!r} {!r}".format(*map(float, point)) for point in points]
        lines += ["f {} {} {}".format(*(corners + first)) for corners in outward_triangles(points)]
        first += len(points)
    Path(path).write_text("\n".join(lines) + "\n")


class Pybullet:
    """Bullet in maximal coordinates (its faster path), friction as rows; inertia given, sleeping off, no damping.

    residual_stop: leave the iteration when Bullet's own residual falls below its default threshold (1e-7), or run all 50.
    maximal=False takes the other path (multibody) with the friction cone on.
    """

    def __init__(self, scene, residual_stop=True, cone=True, maximal=True, iterations=50):
        import pybullet

        self.margin = scene.margin
        self.bullet, self.maximal, self.scene = pybullet, maximal, scene
        self.client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0, 0, -9.81)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=scene.time_step,
            numSolverIterations=iterations,
            numSubSteps=0,
            enableConeFriction=int(cone),
            solverResidualThreshold=1e-7 if residual_stop else 0.0,
            restitutionVelocityThreshold=1e-3,
            deterministicOverlappingPairs=1,
        )
        self.shape = self._shape(scene.form)
        self.ids = []
        for normal, height in scene.planes:
            plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=normal)
            body = pybullet.createMultiBody(
                0, plane, basePosition=list(np.multiply(normal, height)), useMaximalCoordinates=maximal
            )
            pybullet.changeDynamics(body, -1, lateralFriction=np.sqrt(scene.friction), restitution=0)
        self.add(scene.position, scene.orientation, scene.fixed)

    def _shape(self, form):
        bullet = self.bullet
        if form.radius > 0:
            return bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=form.radius)
        if self.scene.name.startswith("box"):
            return bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=list(form.pieces[0].max(axis=0)))
        if len(form.pieces) == 1:
            return bullet.createCollisionShape(bullet.GEOM_MESH, vertices=form.pieces[0].tolist())
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "pieces.obj")
            write_obj(path, form.pieces)
            return bullet.createCollisionShape(bullet.GEOM_MESH, fileName=path)

    def _body(self, position, orientation, fixed):
        bullet, form = self.bullet, self.scene.form
        w, x, y, z = orientation
        body = bullet.createMultiBody(
            0.0 if fixed else form.mass,
            self.shape,
            basePosition=list(position),
            baseOrientation=[x, y, z, w],
            useMaximalCoordinates=self.maximal,
        )
        # without the mass beside it Bullet makes NaN of the inertia
        inertia = {} if fixed else {"mass": form.mass, "localInertiaDiagonal": list(form.inertia)}
        bullet.changeDynamics(
            body,
            -1,
            lateralFriction=np.sqrt(self.scene.friction),
            restitution=0,
            rollingFriction=0,
            spinningFriction=0,
            linearDamping=0,
            angularDamping=0,
            **inertia,
        )
        if self.scene.margin > 0:
            bullet.changeDynamics(body, -1, collisionMargin=self.scene.margin)
        return body

    def add(self, position, orientation, fixed):
        """Add bodies and return their numbers."""
        first = len(self.ids)
        self.ids += [self._body(*values) for values in zip(position, orientation, fixed, strict=True)]
        return np.arange(first, len(self.ids))

    def step(self, count):
        for _ in range(count):
            self.bullet.stepSimulation()

    def freeze(self, numbers):
        """Replace bodies by fixed ones in the same pose."""
        for number in numbers:
            position, (x, y, z, w) = self.bullet.getBasePositionAndOrientation(self.ids[number])
            self.bullet.removeBody(self.ids[number])
            self.ids[number] = self._body(position, (w, x, y, z), True)

    def poses(self):
        """position (n, 3), orientation (n, 4)."""
        both = [self.bullet.getBasePositionAndOrientation(body) for body in self.ids]
        position = np.array([pose[0] for pose in both])
        return position, np.array([pose[1] for pose in both])[:, [3, 0, 1, 2]]

    def heights(self):
        """z of the centres (n,)."""
        return np.array([self.bullet.getBasePositionAndOrientation(body)[0][2] for body in self.ids])

    def velocities(self):
        """(n, 6): linear, angular."""
        return np.array([np.concatenate(self.bullet.getBaseVelocity(body)) for body in self.ids])

    def counts(self):
        """Bullet publishes neither collision calls nor, in this path, its iterations."""
        return {"fcl_calls_per_step": None, "iterations_per_step": None}


class Minibullet:
    """Ours with its default settings but for the cap of 50 iterations; no margin.

    residual_stop=False asks for a residual that is never reached, so that every sweep is made.
    """

    def __init__(self, scene, residual_stop=True, solver="exact", tolerance=None, iterations=50):
        import minibullet

        self.engine, self.scene, self.margin = minibullet, scene, 0.0
        settings = minibullet.Settings(time_step=scene.time_step, friction=scene.friction, solver=solver, iterations=iterations)
        if tolerance is not None or not residual_stop:
            settings = replace(settings, tolerance=tolerance if residual_stop else 1e-300)
        self.world = minibullet.World(effects=[minibullet.Gravity(9.81)], settings=settings)
        self.shape = self._shape(scene.form)
        self.sweeps = self.steps = 0
        for normal, height in scene.planes:
            self.world.add_plane(normal=normal, height=height)
        self.add(scene.position, scene.orientation, scene.fixed)

    def _shape(self, form):
        if form.radius > 0:
            return self.engine.Sphere(form.radius)
        pieces = [self.engine.ConvexPiece(points) for points in form.pieces]
        return pieces[0] if len(pieces) == 1 else self.engine.Compound(tuple(pieces))

    def add(self, position, orientation, fixed):
        """Add bodies and return their numbers."""
        form, first = self.scene.form, len(self.world.bodies)
        for place, turn, held in zip(position, orientation, fixed, strict=True):
            given = {"fixed": True} if held else {"mass": form.mass, "inertia": form.inertia}
            self.world.add(self.shape, position=place, orientation=turn, **given)
        return np.arange(first, len(self.world.bodies))

    def step(self, count):
        for _ in range(count):
            self.world.step()
            self.sweeps += self.world.last_step.iterations
        self.steps += count

    def freeze(self, numbers):
        """Fix bodies where they are."""
        bodies = self.world.bodies
        self.world.freeze([bodies[number] for number in numbers])

    def poses(self):
        """position (n, 3), orientation (n, 4)."""
        bodies = self.world.bodies
        return np.array([body.position for body in bodies]), np.array([body.orientation for body in bodies])

    def heights(self):
        """z of the centres (n,)."""
        return np.array([body.position[2] for body in self.world.bodies])

    def velocities(self):
        """(n, 6): linear, angular."""
        return np.array([np.concatenate([body.velocity, body.angular_velocity]) for body in self.world.bodies])

    def counts(self):
        """Collision calls and sweeps a step, and the worst residual of the run."""
        calls = self.world.last_step.fcl_calls  # counted from the beginning of the world
        return {
            "fcl_calls_per_step": calls / self.steps,
            "iterations_per_step": self.sweeps / self.steps,
            "worst_residual": self.world.worst_residual,
            "unsolved_steps": self.world.unsolved_steps / self.steps,
        }
