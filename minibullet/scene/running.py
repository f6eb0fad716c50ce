"""Many steps in a row: how many may be asked for, what is left when one of them fails, and when a world has come to rest."""

from math import sqrt

import numpy as np

from minibullet.dynamics.motion_bounds import top_speed
from minibullet.errors import InputError
from minibullet.kernels import leaf
from minibullet.vectors import length

MOST_STEPS = 1_000_000_000  # of one call: a day and more for the smallest world [-]


def whole_steps(asked, steps, time_step):
    """The whole number of steps nearest to this one; InputError where nobody can mean so many."""
    if not steps <= MOST_STEPS:
        raise InputError(
            f"{asked}: more than {MOST_STEPS:,} steps of {time_step:.3g} s in one call, which takes days; "
            "give a longer time_step or ask for less"
        )
    return round(steps)


def checkpoint(world):
    """All that a step changes, for ``roll_back``; what is changed in place is copied."""
    scene, warm_start = world.registry.commit(), world._warm_start
    warm_start = warm_start._replace(on_a=warm_start.on_a.copy(), on_b=warm_start.on_b.copy())
    return (scene.bodies, scene.past_motion, scene.collision.checkpoint(), warm_start, world.time, world.steps,
            world.unsolved_steps, world.worst_residual, world.last_step)  # fmt: skip


def roll_back(world, checkpoint):
    """Make the world again what it was at the checkpoint."""
    scene = world.registry.scene
    (scene.bodies, scene.past_motion, pairs, world._warm_start, world.time, world.steps, world.unsolved_steps,
     world.worst_residual, world.last_step) = checkpoint  # fmt: skip
    scene.collision.roll_back(pairs)


def stopped(world, text):
    """The InputError for a step that failed with this text; the world, rolled back, is saved where its ``rescue`` says."""
    if not text.startswith("step "):
        text = f"step {world.steps + 1}, t = {world.time + world.settings.time_step:.6g} s: {text}"
    if world.rescue is None:
        return InputError(f"{text}; the world stays at step {world.steps}")
    world.save(world.rescue)
    text += f"; run stopped, state of step {world.steps} saved in {str(world.rescue)!r}"
    if world._past:
        from minibullet.scene import saving

        saving.save_past(world._past, f"{world.rescue}.past.npz")
        text += f", the last {len(world._past)} states in {f'{world.rescue}.past.npz'!r}"
    return InputError(text)


def rest_scale(scene, wrenches, select):
    """Whether every moving body that ``select`` chooses is slow now, and how long it must stay so [s]; see ``World.settle``."""
    chosen = scene.moving if select is None else scene.moving & select(scene.bodies)
    pull = sum(wrenches, np.zeros_like(scene.bodies.twist))
    return is_slow(scene.bodies.twist, pull, scene.bodies.mass, scene.bounding_radius, chosen)


@leaf
def is_slow(twist, wrench, mass, radius, chosen):
    """Whether no point of a chosen body (n,) is faster than 2e-3 sqrt(a R), R its radius and a what accelerates it, and the
    longest time that a free fall over the radius takes, sqrt(2 R/a) [s]; 0 where nothing pulls."""
    slow, wait = True, 0.0
    for n in range(len(mass)):
        if not chosen[n]:
            continue
        acceleration = length(wrench[n]) / mass[n]
        slow = slow and top_speed(twist[n], radius[n]) <= 2e-3 * sqrt(acceleration * radius[n])
        if acceleration > 0.0:
            wait = max(wait, sqrt(2.0 * radius[n] / acceleration))
    return slow, wait
