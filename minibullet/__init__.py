"""minibullet: a small engine for rigid bodies with hard contact, to be read in an evening.

import minibullet as mb

world = mb.World(effects=[mb.Gravity(9.81)], settings=mb.Settings(friction=0.6))
world.add_plane()
unit = world.add(mb.Box(1.0, 1.0, 1.0), density=2300.0, position=(0, 0, 2))
world.settle(max_time=10)
"""

from minibullet import effects, rotations
from minibullet.bodies import Bodies, ContactLaw, Contacts
from minibullet.contact.exact import solve_contacts
from minibullet.effects import *
from minibullet.errors import InputError
from minibullet.report.run_log import Journal
from minibullet.scene.notices import SceneWarning
from minibullet.settings import Settings
from minibullet.shapes.mesh_files import mesh_file
from minibullet.shapes.primitives import Box, Capsule, Compound, ConvexPiece, Cylinder, Sphere
from minibullet.world import World

__all__ = sorted(
    [
        *effects.__all__,
        *("Bodies", "ContactLaw", "Contacts", "InputError", "Journal", "SceneWarning", "Settings", "World"),
        *("Box", "Capsule", "Compound", "ConvexPiece", "Cylinder", "Sphere", "mesh_file"),
        *("effects", "rotations", "solve_contacts"),
    ]
)


def __dir__():
    return __all__
