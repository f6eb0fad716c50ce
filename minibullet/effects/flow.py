"""Effects that act through the drags of a model: the flow, the attitude, the wall.

Each returns only what it changes, so it is added to a model that has the drag already:

    through drag F:   UniformFlow(u) gives F(v - u) - F(v)        and the sum with F(v) is F(v - u).

`through` holds the drags; ``compose`` fills it where it was left empty, from the other effects of the model. A flow with nothing
to act through exerts nothing.
"""

from dataclasses import dataclass, replace

import numpy as np

from minibullet.bodies import Bodies
from minibullet.effects.body import TiltedGravity, force_only, unit_vector
from minibullet.effects.contract import Effect, Need, name_of, parameter, parameters
from minibullet.effects.fluid import Drag, FluidForce, length_of
from minibullet.effects.fluid_forces import Buoyancy
from minibullet.errors import InputError
from minibullet.rotations import conjugate, dot, rotate


class DragModifier(FluidForce):
    """A change of the forces of other effects, which stand in the field `through` (a tuple of effects)."""

    def through_wrench(self, bodies: Bodies, time: float) -> np.ndarray:
        """Wrench of the modified effects together, (n, 6)."""
        return sum((effect.forces(bodies, time) for effect in self.through), np.zeros((len(bodies.mass), 6)))


@dataclass(frozen=True)
class UniformFlow(DragModifier):
    """The fluid moves with velocity u: every force of the fluid takes w = v - u for v, F = F(v - u) - F(v)."""

    velocity_x: float = parameter(0.0, unit="m/s", low=-3.0, high=3.0, null=0.0)
    velocity_y: float = parameter(0.0, unit="m/s", low=-3.0, high=3.0, null=0.0)
    velocity_z: float = parameter(0.0, unit="m/s", low=-3.0, high=3.0, null=0.0)
    through: tuple = ()  # the effects that feel the flow
    plain = "a steady flow of the {fluid}"
    isotropic = False
    alike = "tilt"
    needs = (Need.SIDEWAYS,)

    def forces(self, bodies, time):
        flow = np.array([self.velocity_x, self.velocity_y, self.velocity_z, 0.0, 0.0, 0.0])
        return self.through_wrench(bodies._replace(twist=bodies.twist - flow), time) - self.through_wrench(bodies, time)


@dataclass(frozen=True)
class OrientationDrag(DragModifier):
    """Drag that depends on the attitude of a body with the symmetry of a cube; also a side force where the flow comes askew.

    With c the direction of the drag F in body axes, the drag becomes |F| ((1 - 3/5 b) c + b c^3), c^3 by component: the
    lowest power that tells faces from edges, with the mean over all directions unchanged (the mean of sum c^4 is 3/5).
    Along c it is 1 - 3/5 b + b sum c^4, so that face_edge_ratio = face on/edge on = (1 + 2/5 b)/(1 - 1/10 b). The moment is
    left out. Values for cubes, 1.05 face on and 0.80 edge on: S. F. Hoerner, Fluid-Dynamic Drag (1965), ch. 3.
    """

    face_edge_ratio: float = parameter(1.0, unit="-", low=0.3, high=3.0, null=1.0, source="Hoerner (1965)")
    through: tuple = ()  # the drags that depend on attitude
    plain = "{fluid} resistance that depends on how the body is turned"
    needs = (Need.SPIN,)

    def forces(self, bodies, time):
        drag = self.through_wrench(bodies, time)[:, :3]
        size = length_of(drag)
        direction = rotate(conjugate(bodies.orientation), drag / np.where(size > 0.0, size, 1.0))
        b = (self.face_edge_ratio - 1.0) / (0.4 + 0.1 * self.face_edge_ratio)
        return force_only(size * rotate(bodies.orientation, b * (direction**3 - 0.6 * direction)))


@dataclass(frozen=True)
class WallDrag(DragModifier):
    """Drag grows near a plane wall: by multiplier (9/16) r/h along it and (9/8) r/h towards it, h the distance of the
    centre, at least r.

    Multiplier 1 is the first order for a sphere in creeping flow: H. Faxen (1922) and H. A. Lorentz (1907), in J. Happel
    and H. Brenner, Low Reynolds Number Hydrodynamics (1983), ch. 7.
    """

    multiplier: float = parameter(0.0, unit="-", low=0.0, high=2.0, null=0.0, source="1: Happel and Brenner (1983) ch. 7")
    wall_height: float = parameter(0.0, unit="m", given=True)
    wall_normal: tuple = (0.0, 0.0, 1.0)  # out of the wall, where normal . x = wall_height, world frame (3,)
    through: tuple = ()  # the drags that feel the wall
    plain = "more {fluid} resistance near a wall or a floor"
    isotropic = False
    dissipative = True
    needs = (Need.FLOOR,)

    def forces(self, bodies, time):
        normal = unit_vector(self.wall_normal)
        drag = self.through_wrench(bodies, time)[:, :3]
        nearness = bodies.radius / np.maximum(dot(bodies.position, normal) - self.wall_height, bodies.radius)
        towards = dot(drag, normal)[:, None] * normal
        return force_only(self.multiplier * 0.5625 * nearness[:, None] * (drag + towards))


def compose(effects) -> tuple[Effect, ...]:
    """The effects as they act together: each modifier with an empty `through` is bound to the effects of this list it acts on.

    OrientationDrag and WallDrag act on the plain drags; UniformFlow acts on every force of the fluid, those two included;
    so the order of the list does not matter. What states a coefficient of contact (Friction) acts before what changes one
    (ViscousFriction). Buoyancy is the weight of the displaced fluid: where gravity is tilted, it is too.
    InputError where something is not an effect, or a modifier away from its null
    value finds nothing to act on.
    """
    effects = list(effects)
    for effect in effects:
        if not isinstance(effect, Effect):
            hint = "; write it with parentheses to make a value" if isinstance(effect, type) else ""
            raise InputError(f"effects must be values of Effect, not {effect!r}{hint}")
    effects.sort(key=lambda effect: not effect.replaces)
    tilt = sum((effect.turned_minus_level for effect in effects if isinstance(effect, TiltedGravity)), np.zeros(3))
    if tilt.any():
        level = (0.0, 0.0, -1.0)
        effects = [
            replace(effect, direction=tuple((tilt + level).tolist()))
            if isinstance(effect, Buoyancy) and tuple(effect.direction) == level
            else effect
            for effect in effects
        ]
    drags = tuple(effect for effect in effects if isinstance(effect, Drag))
    for k, effect in enumerate(effects):
        if isinstance(effect, DragModifier) and not isinstance(effect, UniformFlow):
            effects[k] = _bound(effect, drags)
    felt = tuple(effect for effect in effects if isinstance(effect, FluidForce) and not isinstance(effect, UniformFlow))
    for k, effect in enumerate(effects):
        if isinstance(effect, UniformFlow):
            effects[k] = _bound(effect, felt)
            felt += (effects[k],)  # a second flow meets bodies that feel the first one already
    return tuple(effects)


def _bound(modifier, candidates):
    """The modifier acting through the candidates, unless it was told what to act through."""
    if modifier.through:
        return modifier
    absent = all(getattr(modifier, name) == known.null for name, known in parameters(modifier).items() if known.null is not None)
    if not candidates and not absent:
        raise InputError(f"{name_of(modifier)} changes a drag, but the model has none; add quadratic_drag or linear_drag")
    return replace(modifier, through=candidates)
