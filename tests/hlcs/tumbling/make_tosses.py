"""Twenty tosses of one cube by springs: `python tests/hlcs/tumbling/make_tosses.py` writes tosses.csv and tosses_truths.csv
beside itself (NumPy alone, half a minute).

No engine at hand has a restitution that is one number for a cube: pybullet takes a part of a corner's speed away in the step
before it touches, and a part of the restitution with it (0 to 0.36 where 0.3 was typed); MuJoCo's convex cone lifts what slides
(0.41 to 0.57). Here each corner presses a spring of its own that is stiffer on its way back, k1 and k2 = k1/e^2 (O. R. Walton,
R. L. Braun, J. Rheology 30 (1986) 949), so that the work that an impact gives back is e^2 of what it took, whatever mass the
corner feels; and Coulomb friction, its direction that of the slip, all of it from SMOOTH m/s on.

What acted is measured, not believed, as in make_tumbles.py: friction as the horizontal over the vertical force of a corner that
slips, restitution as upward over downward speed of a corner from its first touch to its last, where no other touched meanwhile.
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
SIDE, MASS, GRAVITY = 0.1, 0.37, 9.81
FRICTION, RESTITUTION = 0.35, 0.3
STIFFNESS, STEP = 5e6, 1 / 307200  # N/m, s: an impact lasts 1 ms, goes 0.3 mm deep, and takes 100 steps or more
SMOOTH = 1e-3  # m/s
EVERY, FRAMES, TOSSES, SEED = 2560, 120, 20, 21  # 120 frames a second
SLIPPING, HITTING = 0.05, 0.3  # m/s: what is slower tells neither friction nor restitution
CORNERS = SIDE / 2 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


class Cubes:
    """Tosses beside each other: positions, axes (columns), velocities, spins; all (tosses, ..), world frame, SI."""

    def __init__(self, position, axes, velocity, spin):
        self.position, self.axes, self.velocity, self.spin = position, axes, velocity, spin
        self.deepest = np.zeros((len(position), 8))  # of the touch that lasts [m]

    def corners(self):
        """Arms, heights and velocities of the corners (tosses, 8, ..)."""
        arms = np.einsum("nij,cj->nci", self.axes, CORNERS)
        return arms, self.position[:, None, 2] + arms[..., 2], self.velocity[:, None] + np.cross(self.spin[:, None], arms)

    def step(self):
        """One step (velocities first, then places); what the floor gives each corner (tosses, 8, 3) [N], and `corners` before."""
        arms, heights, speeds = self.corners()
        depth = np.maximum(-heights, 0.0)
        self.deepest = np.where(depth > 0, np.maximum(self.deepest, depth), 0.0)
        normal = STIFFNESS * np.minimum(depth, self.deepest + (depth - self.deepest) / RESTITUTION**2).clip(0.0)
        slip = np.linalg.norm(speeds[..., :2], axis=2)
        force = np.dstack([-FRICTION * (normal / np.maximum(slip, SMOOTH))[..., None] * speeds[..., :2], normal])
        self.velocity = self.velocity + STEP * (force.sum(axis=1) / MASS - [0.0, 0.0, GRAVITY])
        self.spin = self.spin + STEP * np.cross(arms, force).sum(axis=1) / (MASS * SIDE**2 / 6)  # alike about all axes
        self.position = self.position + STEP * self.velocity
        self.axes = turned(STEP * self.spin) @ self.axes
        return force, heights, speeds


def turned(angle):
    """Rotation matrices (n, 3, 3) of rotation vectors (n, 3), by Cayley's formula: exact rotations, angles to third order."""
    half = np.zeros((len(angle), 3, 3))
    half[:, [2, 0, 1], [1, 2, 0]], half[:, [1, 2, 0], [2, 0, 1]] = angle / 2, -angle / 2
    return np.linalg.solve(np.eye(3) - half, np.eye(3) + half)


def quaternion(axes):
    """(w, x, y, z) of rotation matrices (n, 3, 3): the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix."""
    m = axes
    k = np.empty((len(m), 4, 4))
    k[:, 1:, 1:] = m + np.swapaxes(m, 1, 2) - np.einsum("nii->n", m)[:, None, None] * np.eye(3)
    k[:, 0, 0] = np.einsum("nii->n", m)
    k[:, 0, 1:] = k[:, 1:, 0] = np.stack([m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]], axis=1)
    return np.linalg.eigh(k)[1][:, :, -1]


def thrown(generator):
    """The Cubes at their start."""
    heading, speed = generator.uniform(0, 2 * np.pi, TOSSES), generator.uniform(1.0, 2.0, TOSSES)
    height, spin = generator.uniform(0.15, 0.25, TOSSES), generator.uniform(-6, 6, (TOSSES, 3))
    axes = np.linalg.qr(generator.standard_normal((TOSSES, 3, 3)))[0]
    axes *= np.linalg.det(axes)[:, None, None]
    none = np.zeros(TOSSES)
    velocity = np.stack([speed * np.cos(heading), speed * np.sin(heading), none], axis=1)
    return Cubes(np.stack([none, none, height], axis=1), axes, velocity, spin)


def run(cubes):
    """Rows (frames, tosses, 7), readings of friction, readings of restitution."""
    rows, frictions, restitutions = [], [], []
    came, alone = np.zeros((TOSSES, 8)), np.zeros((TOSSES, 8), bool)  # speed at the first touch, and was it the only corner since
    for step in range(EVERY * (FRAMES - 1) + 1):
        if step % EVERY == 0:
            rows.append(np.hstack([cubes.position, quaternion(cubes.axes)]))
        force, heights, speeds = cubes.step()
        touching = heights < 0
        slipping = (force[..., 2] > MASS * GRAVITY) & (np.linalg.norm(speeds[..., :2], axis=2) > SLIPPING)
        if step % 64 == 0 and slipping.any():
            some = force[slipping]
            frictions += (np.linalg.norm(some[:, :2], axis=1) / some[:, 2]).tolist()
        first, left = touching & (came == 0), ~touching & (came > 0)
        restitutions += (speeds[..., 2] / np.maximum(came, HITTING))[left & alone & (came > HITTING)].tolist()
        came = np.where(first, np.maximum(-speeds[..., 2], 1e-9), np.where(left, 0.0, came))
        alone = (alone | first) & touching & (touching.sum(axis=1) == 1)[:, None]
    return np.array(rows), frictions, restitutions


def make():
    """Text of tosses.csv and of tosses_truths.csv."""
    rows, frictions, restitutions = run(thrown(np.random.default_rng(SEED)))
    tosses, truths = ["toss,frame,x_m,y_m,z_m,qw,qx,qy,qz"], ["number,middle,low,high,readings"]
    for toss in range(TOSSES):
        for frame, row in enumerate(rows[:, toss]):
            cells = [f"{value:.5f}" for value in row[:3]] + [f"{value:.4f}" for value in row[3:]]
            tosses.append(f"{toss},{frame}," + ",".join(cells))
    for name, readings in (("friction", frictions), ("restitution", restitutions)):
        low, middle, high = np.quantile(readings, [0.1, 0.5, 0.9])
        truths.append(f"{name},{middle:.4f},{low:.4f},{high:.4f},{len(readings)}")
    return "\n".join(tosses) + "\n", "\n".join(truths) + "\n"


if __name__ == "__main__":
    for name, text in zip(("tosses.csv", "tosses_truths.csv"), make(), strict=True):
        (HERE / name).write_text(text)
