"""What a World tells its user once, because no number of a step would: bodies put into each other, steps too long for a body or
for a force."""

import warnings
from math import sqrt

import numpy as np

from minibullet.effects import contract
from minibullet.kernels import leaf

DEEP = 0.01  # overlap, in radii of the smaller body, that is told: rounding and the noise of measured poses stay below it [-]
MOST = 8  # pairs that one line names [-]
AGAIN = 2.0  # times as many pairs as the last line on overlaps counted, or times its depth: only then comes another [-]
TINY = 1e-300  # square of a velocity that is counted as one, so that nothing is divided by zero [m2/s2, 1/s2]
OWN_FRAMES = 6  # calls between the user's line and the warning: step, _advance, _step, look, _overlaps or another, _tell [-]


class SceneWarning(UserWarning):
    """A scene is simulated, but not as its user may think; the message says what, where, and the remedy."""


@leaf
def count_notable(gap, size, motion_bound, bounding_radius):
    """How many contacts (m,) overlap deeply, and how many bodies (n,) may go farther than their radius in this step."""
    deep = hasty = 0
    for c in range(len(gap)):
        deep += gap[c] < -DEEP * size[c]
    for n in range(len(bounding_radius)):
        hasty += motion_bound[n] > 2.0 * bounding_radius[n]  # twice the way: see ``motion_bounds.motion_bound``
    return deep, hasty


@leaf
def taken_away(wrench, inverse, twist, time_step):
    """Change of a velocity, and of an angular velocity, by wrenches (n, 6) alone in a step, over that itself: the largest of all
    bodies, and its row."""
    most, row = 0.0, 0
    for n in range(len(twist)):
        for half in (0, 3):
            change = size = 0.0
            for k in range(half, half + 3):
                value = 0.0
                for i in range(6):
                    value += time_step * inverse[n, k, i] * wrench[n, i]
                change += value * value
                size += twist[n, k] * twist[n, k]
            if change > most * most * max(size, TINY):
                most, row = sqrt(change / max(size, TINY)), n
    return most, row


def step_of(world):
    """The step that a world is in, by its number and its end, the beginning of a message."""
    return f"step {world.steps + 1}, t = {world.time + world.settings.time_step:.6g} s"


class Notices:
    """What was told in a run. texts: one line each, in order, every one also a SceneWarning."""

    def __init__(self):
        self.texts, self._pairs, self._hasty, self._stiff = [], set(), False, False
        self._counted, self._deepest = 0, 0.0  # pairs in overlap so far and the deepest overlap [m], as the last line had them

    def look(self, world, pair, gap, size, motion_bound, acting, inverse):
        """Tell what the contacts (m,) with which a step begins, the bound on every body's way in it (n,), and each effect with
        its wrench (n, 6) on bodies with these inverse masses (n, 6, 6), show for the first time."""
        scene = world.registry.scene
        deep, hasty = count_notable(gap, size, motion_bound, scene.bounding_radius)
        if deep:
            self._overlaps(step_of(world), scene, pair, gap, gap < -DEEP * size)
        if hasty and not self._hasty:
            self._haste(step_of(world), scene, pair, motion_bound, world.settings.time_step)
        if not self._stiff:
            self._stiffness(world, acting, inverse)

    def _overlaps(self, when, scene, pair, gap, deep):
        depth = {}
        for a, b, value in zip(*pair[deep].T.tolist(), gap[deep].tolist(), strict=True):
            if (scene.moving[a] or scene.moving[b]) and (a, b) not in self._pairs:
                depth[a, b] = max(depth.get((a, b), 0.0), -value)
        self._pairs.update(depth)
        deepest = max(depth.values(), default=0.0)
        if not depth or (len(self._pairs) < AGAIN * self._counted and deepest < AGAIN * self._deepest):
            return
        before, self._counted, self._deepest = self._counted, len(self._pairs), max(deepest, self._deepest)
        worst = sorted(depth, key=lambda pair: -depth[pair])
        listed = ", ".join(f"{scene.names[a]!r} and {scene.names[b]!r} by {depth[a, b]:.3g} m" for a, b in worst[:MOST])
        more = f" and {len(worst) - MOST} more pairs, see World.overlaps()" if len(worst) > MOST else ""
        so_far = f" ({len(self._pairs)} pairs so far)" if before else ""
        self._tell(
            f"{when}: bodies overlap: {listed}{more}{so_far}; they are moved apart little by little, without a blow; "
            "where they were put so, put them apart or call World.separate(), else give a shorter time_step or more iterations"
        )

    def _haste(self, when, scene, pair, motion_bound, time_step):
        others = pair[(scene.bounding_radius[pair] > 0.0).all(axis=1)]  # a half-space cannot be passed
        share = np.divide(
            motion_bound, 2.0 * scene.bounding_radius, out=np.zeros(len(motion_bound)), where=scene.bounding_radius > 0.0
        )
        if not len(others) or share[others].max() <= 1.0:
            return
        self._hasty = True
        contact, side = np.unravel_index(share[others].argmax(), others.shape)
        body, other = others[contact, side], others[contact, 1 - side]
        self._tell(
            f"{when}: body {scene.names[body]!r} may move by {0.5 * motion_bound[body]:.3g} m in one step, its radius is "
            f"{scene.bounding_radius[body]:.3g} m, and {scene.names[other]!r} is in its way: they may pass or miss each other "
            f"wrongly; a time_step of {time_step / share[body]:.2g} s would do"
        )

    def _stiffness(self, world, acting, inverse):
        """Tell of an effect that only brakes, yet by its wrench alone turns a body round within the step and then pushes it
        harder than before: the motion would grow from step to step."""
        bodies, dt = world.registry.scene.bodies, world.settings.time_step
        for effect, wrench in acting:
            share, row = taken_away(wrench, inverse, bodies.twist, dt) if effect.dissipative else (0.0, 0)
            if share <= 1.0:
                continue
            change = dt * np.einsum("nij,nj->ni", inverse, wrench)
            later = contract.wrench(effect, bodies._replace(twist=bodies.twist + change), world.time)
            if taken_away(later, inverse, change, dt)[0] > 1.0:
                self._stiff, body = True, world.registry.scene.names[row]
                self._tell(
                    f"{step_of(world)}: {contract.name_of(effect)} turns body {body!r} round in one step and then pushes it "
                    f"harder than before: its motion grows from step to step; a time_step of {dt / share:.2g} s would do"
                )
                break

    def _tell(self, text):
        if text not in self.texts:
            self.texts.append(text)
        warnings.warn(text, SceneWarning, stacklevel=OWN_FRAMES + 1)
