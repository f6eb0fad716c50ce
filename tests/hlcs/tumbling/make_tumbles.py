"""Twenty experiments of tossed cubes from pybullet: `python tests/hlcs/tumbling/make_tumbles.py` writes tumbles.csv and
truths.csv beside itself (Linux, Python 3.11: where pybullet has wheels).

Step 1/3840 s (64 a frame), 200 iterations; sleeping, damping, rolling and spinning friction and friction anchors off;
restitution 0; the margin of the box is inside it. Bullet multiplies the friction of the two bodies: both carry the root of
what is wanted. The default path with its cone, not `useMaximalCoordinates=1`: there friction is two rows, along the slip and
across it, each limited by itself; a turning cube saturates both, so what acts is no Coulomb law (0.3 wanted: ratios of 0.29
to 0.42, 45 degrees off the slip, at the same tosses). A cube's inertia is the same about all axes, so the default path's known
error in free rotation is nil here.

What acted is measured, not believed: over every step the momentum that the floor gave is m dv + m g dt; its horizontal over
its vertical part is the friction where one corner touches that slips before and after by more than SLIPPING. The median over
such steps of all tosses of an experiment is the true friction, half the distance of its 10 % and 90 % quantiles the spread.
The restitution likewise: upward speed of the corner SETTLED steps after its first touch over downward speed before it.
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
SIDE, MASS, GRAVITY = 0.1, 0.37, 9.81
FRAMES, RATE, SUBSTEPS = 90, 60, 64
TOSSES, SEED = 3, 20
SLIPPING = 0.05  # m/s
SETTLED = 4  # steps: Bullet stops a corner in two, the first still above the floor
CORNERS = SIDE / 2 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
FRICTIONS = np.linspace(0.2, 0.5, 20)


class Toss:
    """One cube over a floor at z = 0 in a world of its own."""

    def __init__(self, bullet, friction, position, turn, velocity, spin):
        self.bullet, self.step = bullet, 1 / (RATE * SUBSTEPS)
        bullet.resetSimulation()
        bullet.setGravity(0, 0, -GRAVITY)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.step,
            numSolverIterations=200,
            deterministicOverlappingPairs=1,
            enableConeFriction=1,
            restitutionVelocityThreshold=1e-3,
        )
        plane = bullet.createMultiBody(0, bullet.createCollisionShape(bullet.GEOM_PLANE), useMaximalCoordinates=0)
        box = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=[SIDE / 2] * 3)
        x, y, z, w = turn
        self.cube = bullet.createMultiBody(
            MASS, box, basePosition=list(position), baseOrientation=[x, y, z, w], useMaximalCoordinates=0
        )
        surface = {"lateralFriction": np.sqrt(friction), "restitution": 0.0, "rollingFriction": 0.0, "spinningFriction": 0.0}
        bullet.changeDynamics(plane, -1, **surface, frictionAnchor=0)
        inertia = {"mass": MASS, "localInertiaDiagonal": [MASS * SIDE**2 / 6] * 3}
        still = {"linearDamping": 0.0, "angularDamping": 0.0, "activationState": bullet.ACTIVATION_STATE_DISABLE_SLEEPING}
        bullet.changeDynamics(self.cube, -1, **surface, frictionAnchor=0, **inertia, **still)
        bullet.resetBaseVelocity(self.cube, list(velocity), list(spin))

    def state(self):
        """(position, quaternion w x y z, velocity, velocities of the corners (8, 3), heights of the corners)."""
        position, turn = self.bullet.getBasePositionAndOrientation(self.cube)
        velocity, spin = (np.array(part) for part in self.bullet.getBaseVelocity(self.cube))
        arms = CORNERS @ np.array(self.bullet.getMatrixFromQuaternion(turn)).reshape(3, 3).T
        return np.array(position), np.roll(turn, 1), velocity, velocity + np.cross(spin, arms), position[2] + arms[:, 2]

    def run(self):
        """Rows (frames, 7) of the recording, friction readings, and what the first impact leaves of the corner's speed."""
        rows, readings, touched, left = [], [], None, None
        count = 0
        for frame in range(FRAMES):
            before = self.state()
            rows.append(np.r_[before[0], before[1]])
            for _ in range(SUBSTEPS if frame < FRAMES - 1 else 0):
                self.bullet.stepSimulation()
                after = self.state()
                given = MASS * (after[2] - before[2] + [0, 0, GRAVITY * self.step])
                corner = np.argmin(before[4])
                slips = [np.linalg.norm(one[3][corner, :2]) for one in (before, after)]
                alone = np.sort(after[4])[1] > 0.002  # m: the next corner is well above the floor
                if given[2] > 0.2 * MASS * GRAVITY * self.step and alone and min(slips) > SLIPPING:
                    readings.append(np.linalg.norm(given[:2]) / given[2])
                count += 1
                if touched is None and given[2] > 0.1 * MASS:
                    touched = count, corner, -before[3][corner, 2]
                if touched and count == touched[0] + SETTLED:
                    left = after[3][touched[1], 2] / touched[2]
                before = after
        return np.array(rows), readings, left


def make():
    """Text of tumbles.csv and of truths.csv."""
    import pybullet

    generator = np.random.default_rng(SEED)
    pybullet.connect(pybullet.DIRECT)
    tumbles, truths = ["case,toss,frame,x_m,y_m,z_m,qw,qx,qy,qz"], ["case,friction_set,friction,spread,readings,restitution"]
    for case, friction in enumerate(FRICTIONS):
        readings, left = [], []
        for toss in range(TOSSES):
            heading, speed = generator.uniform(0, 2 * np.pi), generator.uniform(1.0, 2.0)
            turn = generator.standard_normal(4)
            velocity = [speed * np.cos(heading), speed * np.sin(heading), 0.0]
            spin = generator.uniform(-6, 6, 3)
            world = Toss(pybullet, friction, (0, 0, generator.uniform(0.15, 0.25)), turn / np.linalg.norm(turn), velocity, spin)
            rows, some, kept = world.run()
            readings, left = readings + some, [*left, kept]
            for frame, (*place, qw, qx, qy, qz) in enumerate(rows):
                cells = [f"{value:.5f}" for value in place] + [f"{value:.4f}" for value in (qw, qx, qy, qz)]
                tumbles.append(f"{case},{toss},{frame}," + ",".join(cells))
        low, middle, high = np.quantile(readings, [0.1, 0.5, 0.9])
        truths.append(f"{case},{friction:.4f},{middle:.4f},{(high - low) / 2:.4f},{len(readings)},{np.median(left):.4f}")
    pybullet.disconnect()
    return "\n".join(tumbles) + "\n", "\n".join(truths) + "\n"


if __name__ == "__main__":
    for name, text in zip(("tumbles.csv", "truths.csv"), make(), strict=True):
        (HERE / name).write_text(text)
