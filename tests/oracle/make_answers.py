"""Ask pybullet and freeze its answers: `python tests/oracle/make_answers.py` writes answers/*.csv.

Each function is one experiment; it returns rows of numbers and the settings that made them. The comment lines at the head
of a file name the version of pybullet, the coordinates path and every setting. Common to all: double precision, step
1/240 s, 50 iterations, g = 9.81 m/s2, sleeping off, inertia given by hand, no damping unless named.
Friction and restitution of a contact are products of the two bodies' values in Bullet: here each body has the root.
"""

import csv
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))
import engines
import geometry
import scenes

ANSWERS = Path(__file__).resolve().parent / "answers"
TIME_STEP = 1 / 240
GRAVITY = 9.81


class Bullet:
    """One pybullet world with a floor at z = 0."""

    def __init__(self, maximal, friction=0.0, restitution=0.0, floor=True):
        import pybullet

        self.bullet, self.maximal = pybullet, maximal
        self.surface = {"lateralFriction": np.sqrt(friction), "restitution": np.sqrt(restitution)}
        pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0, 0, -GRAVITY)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP,
            numSolverIterations=50,
            enableConeFriction=1,
            restitutionVelocityThreshold=1e-3,
            deterministicOverlappingPairs=1,
        )
        if floor:
            plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE)
            pybullet.changeDynamics(pybullet.createMultiBody(0, plane, useMaximalCoordinates=maximal), -1, **self.surface)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.bullet.disconnect()

    def add(self, shape, mass, inertia, position, orientation=(1, 0, 0, 0), velocity=(0, 0, 0), damping=0.0, margin=None):
        """shape: keywords of createCollisionShape; inertia (3,) kg m2; orientation w, x, y, z. Returns the body's number."""
        bullet, (w, x, y, z) = self.bullet, orientation
        body = bullet.createMultiBody(
            mass,
            bullet.createCollisionShape(**shape),
            basePosition=list(position),
            baseOrientation=[x, y, z, w],
            useMaximalCoordinates=self.maximal,
        )
        inertia = {"mass": mass, "localInertiaDiagonal": list(inertia)} if mass else {}
        bullet.changeDynamics(
            body,
            -1,
            linearDamping=damping,
            angularDamping=damping,
            rollingFriction=0,
            spinningFriction=0,
            **inertia,
            **self.surface,
        )
        if margin is not None:
            bullet.changeDynamics(body, -1, collisionMargin=margin)
        bullet.resetBaseVelocity(body, list(velocity), [0, 0, 0])
        return body

    def run(self, steps):
        """Yield the time [s] after each step."""
        for step in range(1, steps + 1):
            self.bullet.stepSimulation()
            yield step * TIME_STEP

    def position(self, body):
        return np.array(self.bullet.getBasePositionAndOrientation(body)[0])

    def rotation(self, body):
        return np.array(self.bullet.getMatrixFromQuaternion(self.bullet.getBasePositionAndOrientation(body)[1])).reshape(3, 3)

    def velocity(self, body):
        return np.concatenate(self.bullet.getBaseVelocity(body))


def sphere_shape(radius):
    return {"shapeType": 2, "radius": radius}  # GEOM_SPHERE


def box_shape(*edges):
    return {"shapeType": 3, "halfExtents": [0.5 * edge for edge in edges]}  # GEOM_BOX


def sphere_inertia(mass, radius):
    return (0.4 * mass * radius**2,) * 3


def box_inertia(mass, *edges):
    squares = np.square(edges)
    return tuple(mass / 12 * (squares.sum() - squares))


def drop():
    """Sphere R = 0.1 m, 1 kg, falls freely from z = 10 m."""
    with Bullet(maximal=True, floor=False) as world:
        ball = world.add(sphere_shape(0.1), 1.0, sphere_inertia(1, 0.1), (0, 0, 10.0))
        rows = [(time, world.position(ball)[2], world.velocity(ball)[2]) for time in world.run(240)]
        return ["time_s", "z_m", "vz_m_s"], rows[23::24]


def damping():
    """The same fall for 1 s with linear damping d: Bullet's law of maximal coordinates, v (1 - d)^dt before the force."""
    rows = []
    for coefficient in (0.04, 0.5, 1.0):
        with Bullet(maximal=True, floor=False) as world:
            ball = world.add(sphere_shape(0.1), 1.0, sphere_inertia(1, 0.1), (0, 0, 100.0), damping=coefficient)
            rows += [(coefficient, t, world.velocity(ball)[2]) for t in world.run(240)][59::60]
    return ["damping", "time_s", "vz_m_s"], rows


def slide():
    """Box 1 x 1 x 0.5 m slides to rest from 3 m/s at three headings, friction 0.3 (friction cone on)."""
    rows = []
    for heading in (0.0, 22.5, 45.0):
        direction = np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0])
        with Bullet(maximal=False, friction=0.3) as world:
            box = world.add(box_shape(1, 1, 0.5), 500.0, box_inertia(500, 1, 1, 0.5), (0, 0, 0.25), velocity=3 * direction)
            *_, _end = world.run(360)
            moved = world.position(box)
            rows.append((heading, moved @ direction, moved @ np.array([-direction[1], direction[0], 0])))
    return ["heading_deg", "distance_m", "sideways_m"], rows


def bounce():
    """Sphere R = 0.1 m dropped from a gap of 1 m, restitution 1, 0.8, 0.5: height of the first peak."""
    rows = []
    for restitution in (1.0, 0.8, 0.5):
        with Bullet(maximal=False, restitution=restitution) as world:
            ball = world.add(sphere_shape(0.1), 1.0, sphere_inertia(1, 0.1), (0, 0, 1.1))
            peak, bounced = 0.0, False
            for _time in world.run(300):
                bounced = bounced or world.velocity(ball)[2] > 0
                if bounced and world.velocity(ball)[2] < 0:
                    break
                peak = world.position(ball)[2] - 0.1 if bounced else 0.0
            rows.append((restitution, peak))
    return ["restitution", "first_peak_m"], rows


def rolling():
    """Sphere R = 0.5 m thrown at 5 m/s without spin on a floor of friction 0.2: slips, then rolls."""
    with Bullet(maximal=False, friction=0.2) as world:
        ball = world.add(sphere_shape(0.5), 1.0, sphere_inertia(1, 0.5), (0, 0, 0.5), velocity=(5, 0, 0))
        rows = []
        for time in world.run(240):
            twist = world.velocity(ball)
            rows.append((time, world.position(ball)[0], twist[0], twist[4]))
    return ["time_s", "x_m", "vx_m_s", "spin_y_rad_s"], rows[11::12]


def cubipod_shape(folder):
    """Seven convex pieces from a file: a compound of hulls."""
    path = folder / "pieces.obj"
    engines.write_obj(path, scenes.cubipod_pieces())
    return {"shapeType": 5, "fileName": str(path)}  # GEOM_MESH


def cubipod_rest(folder):
    """Cubipod (L = 1 m, seven pieces) let go 10 mm above its low pose; margin 0.001 m on every piece. After 4 s."""
    with Bullet(maximal=False, friction=0.6) as world:
        orientation = scenes.low_pose(0.3)
        unit = world.add(
            cubipod_shape(folder),
            scenes.UNIT_MASS,
            (scenes.UNIT_INERTIA,) * 3,
            (0, 0, scenes.LOW_POSE_HEIGHT + 0.01),
            orientation,
            margin=0.001,
        )
        *_, _end = world.run(960)
        pose = world.bullet.getBasePositionAndOrientation(unit)
        turned = 2 * np.arccos(min(1.0, abs(np.dot(np.array(pose[1])[[3, 0, 1, 2]], orientation))))
        return ["margin_m", "z_m", "turned_rad"], [(0.001, pose[0][2], turned)]


def small_layer():
    """Nine Cubipods dropped on a fixed layer of sixteen, ten seeds: mean height of centres and of highest points, after 4 s."""
    rows = []
    for seed in range(1, 11):
        scene = scenes.one_layer("pieces", 3, 3, seed=seed)
        engine = engines.Pybullet(scene)
        engine.step(960)
        rows.append((seed, *layer_heights(scene, *engine.poses()), float(np.linalg.norm(engine.velocities()[16:], axis=1).max())))
        engine.bullet.disconnect()
    return ["seed", "mean_centre_m", "mean_top_m", "fallen", "fastest_m_s"], rows


def layer_heights(scene, position, orientation):
    """Mean height [m] of centres and of highest points of the units that stayed up, and how many fell to the floor."""
    corners = np.vstack(scene.form.pieces)
    top = (geometry.rotation_matrix(orientation) @ corners.T)[:, 2].max(axis=1) + position[:, 2]
    up = ~scene.fixed & (position[:, 2] > 1.0)
    return position[up, 2].mean(), top[up].mean(), int((~scene.fixed).sum() - up.sum())


PATHS = {
    "drop": "maximal coordinates",
    "damping": "maximal coordinates",
    "slide": "default (multibody)",
    "bounce": "default (multibody)",
    "rolling": "default (multibody)",
    "cubipod_rest": "default (multibody)",
    "small_layer": "maximal coordinates",
}


EXPERIMENTS = {
    "drop": drop,
    "damping": damping,
    "slide": slide,
    "bounce": bounce,
    "rolling": rolling,
    "cubipod_rest": cubipod_rest,
    "small_layer": small_layer,
}


def write(name, function, columns, rows):
    """One CSV whose comment lines say how it was made."""
    heading = [
        f"pybullet {version('pybullet')}, double precision; {PATHS[name]}",
        function.__doc__,
        "step 1/240 s, 50 iterations, g = 9.81 m/s2, sleeping off, restitution threshold 1e-3 m/s, "
        "deterministicOverlappingPairs = 1, localInertiaDiagonal given",
        "made by tests/oracle/make_answers.py",
    ]
    with open(ANSWERS / f"{name}.csv", "w", newline="") as file:
        file.writelines(f"# {line}\n" for line in heading)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([[repr(float(value)) for value in row] for row in rows])


def answers(name):
    """Columns and rows of one experiment, asked now."""
    with tempfile.TemporaryDirectory() as folder:
        return EXPERIMENTS[name](Path(folder)) if name.startswith("cubipod") else EXPERIMENTS[name]()


def main():
    ANSWERS.mkdir(exist_ok=True)
    for name, function in EXPERIMENTS.items():
        write(name, function, *answers(name))


if __name__ == "__main__":
    main()
