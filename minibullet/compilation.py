"""The engine compiled ahead of its first step, in parts that several processes can compile at once.

The compiler takes half a minute for the kernels of a step, once: the code is kept (`kernels`). Each part below is a call that
needs half of them. What a part leaves out, a first step compiles.
"""

from minibullet.effects import Gravity
from minibullet.settings import Settings
from minibullet.shapes.primitives import Box
from minibullet.world import World


def find_pairs():
    """Compile what looks for pairs of bodies and for the features that separate them."""
    world = _world()
    world.add(Box(1.0, 1.0, 1.0), density=2300.0, position=(0.2, 0.0, 1.5))
    world.overlaps()


def answer_contacts():
    """Compile the rest of a step: contact points, constraints, impulses, the move; of a body with nobody near."""
    world = _world()
    scene = world.registry.commit()
    nobody = scene.collision.cache
    scene.collision.update = lambda *given: nobody  # else the pairs would be looked for here too
    world.step()


def _world():
    world = World([Gravity(9.81)], Settings(solver="gauss_seidel"))
    world.add_plane()
    world.add(Box(1.0, 1.0, 1.0), density=2300.0, position=(0.0, 0.0, 0.5))
    return world


PARTS = (find_pairs, answer_contacts)
