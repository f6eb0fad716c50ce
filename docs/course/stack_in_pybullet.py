"""Asks pybullet how far a stack of boxes creeps: `python stack_in_pybullet.py` writes stack_in_pybullet.csv.

Ten boxes, 1 m, 1000 kg, friction 0.5, each let go 1 mm above the one below; pybullet's own defaults (50 iterations, step 1/240 s)
but for sleeping, which would hide creep and is off. pybullet is on the package index for Python up to 3.11 on Linux.
"""

import math
from importlib.metadata import version

import pybullet

BOXES, SECONDS, STEPS_A_SECOND, EVERY = 10, 60, 240, 120

pybullet.connect(pybullet.DIRECT)
pybullet.setGravity(0, 0, -9.81)
pybullet.setPhysicsEngineParameter(deterministicOverlappingPairs=1)
surface = {"lateralFriction": math.sqrt(0.5), "linearDamping": 0, "angularDamping": 0}  # two bodies: their product is 0.5
pybullet.changeDynamics(pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE)), -1, **surface)
shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.5, 0.5, 0.5])
boxes = [pybullet.createMultiBody(1000.0, shape, basePosition=[0, 0, 0.501 + 1.001 * k]) for k in range(BOXES)]
for box in boxes:
    pybullet.changeDynamics(box, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING, **surface)

rows = []
for step in range(1, SECONDS * STEPS_A_SECOND + 1):
    pybullet.stepSimulation()
    if step % EVERY == 0:
        x, y, z = pybullet.getBasePositionAndOrientation(boxes[-1])[0]
        rows.append(f"{step / STEPS_A_SECOND:g},{x:.9g},{y:.9g},{z:.9g}")
with open("stack_in_pybullet.csv", "w", encoding="utf-8", newline="\n") as file:
    file.write(f"# pybullet {version('pybullet')}: the highest of {BOXES} boxes; made by stack_in_pybullet.py\n")
    file.write("time_s,x_m,y_m,z_m\n" + "\n".join(rows) + "\n")
