"""Physics added from outside: one law, one class, one source. See ``contract`` for how to write your own.

The engine asks through ``compose``, ``wrenches``, ``mean_wrenches``, ``added_mass``, ``changes_contact_law`` and ``contact_law``;
everything else here is a law or looks after laws.
"""

from minibullet.effects.body import Gravity, TiltedGravity
from minibullet.effects.catalogue import library, load_effects
from minibullet.effects.check import Report, check_effect
from minibullet.effects.contact import (
    Adhesion,
    AnisotropicFriction,
    Friction,
    LoadDependentFriction,
    Restitution,
    RollingFriction,
    SpinningFriction,
    StaticFriction,
    StribeckFriction,
    VelocityDependentRestitution,
    ViscousFriction,
)
from minibullet.effects.contract import (
    Effect,
    EffectError,
    Parameter,
    added_mass,
    changes_contact_law,
    contact_law,
    mean_wrenches,
    name_of,
    parameter,
    parameters,
    wrench,
    wrenches,
)
from minibullet.effects.flow import DragModifier, OrientationDrag, TubeDrag, UniformFlow, WallDrag, compose
from minibullet.effects.fluid import Drag, DragCrisis, FluidForce, LinearDrag, QuadraticDrag, SphereDrag, StokesDrag
from minibullet.effects.fluid_forces import AddedMass, Buoyancy, GroundCushion, HistoryForce, Magnus, SpinDecay

# what `minibullet` offers to its users; the rest of the names above is for the engine and for who looks after laws
__all__ = [
    "AddedMass",
    "Adhesion",
    "AnisotropicFriction",
    "Buoyancy",
    "Drag",
    "DragCrisis",
    "DragModifier",
    "Effect",
    "EffectError",
    "FluidForce",
    "Friction",
    "Gravity",
    "GroundCushion",
    "HistoryForce",
    "LinearDrag",
    "LoadDependentFriction",
    "Magnus",
    "OrientationDrag",
    "Parameter",
    "QuadraticDrag",
    "Restitution",
    "RollingFriction",
    "SphereDrag",
    "SpinDecay",
    "SpinningFriction",
    "StaticFriction",
    "StokesDrag",
    "StribeckFriction",
    "TiltedGravity",
    "TubeDrag",
    "UniformFlow",
    "VelocityDependentRestitution",
    "ViscousFriction",
    "WallDrag",
    "check_effect",
    "library",
    "load_effects",
    "parameter",
]
