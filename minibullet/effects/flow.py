"""Effects that act through the drags of a model: the flow, the attitude, a wall, a tube.

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
from minibullet.effects.fluid import Drag, FluidForce, Viscous, ViscousDrag, length_of
from minibullet.effects.fluid_forces import Buoyancy
from minibullet.errors import InputError
from minibullet.rotations import conjugate, dot, rotate


class DragModifier(FluidForce):
    """A change of the forces of other effects, which stand in the field `through` (a tuple of effects)."""

    acts_on = Drag  # what it changes, of the effects of a model

    def through_wrench(self, bodies: Bodies, time: float) -> np.ndarray:
        """Wrench of the modified effects together, (n, 6)."""
        return sum((effect.forces(bodies, time) for effect in self.through), np.zeros((len(bodies.mass), 6)))


@dataclass(frozen=True)
class UniformFlow(DragModifier):
    """The fluid moves with velocity u: every force of the fluid takes w = v - u for v."""

    velocity_x: float = parameter(
        0.0,
        unit="m/s",
        low=-3.0,
        high=3.0,
        null=0.0,
        source="scale of winds: World Meteorological Organization",
        symbol="u_x",
        about="of the fluid along x",
        typical=((1.5, "wind of Beaufort 1, at most"), (3.3, "wind of Beaufort 2, at most")),
    )
    velocity_y: float = parameter(0.0, unit="m/s", low=-3.0, high=3.0, null=0.0, symbol="u_y", about="of the fluid along y")
    velocity_z: float = parameter(0.0, unit="m/s", low=-3.0, high=3.0, null=0.0, symbol="u_z", about="of the fluid along z")
    through: tuple = ()  # the effects that feel the flow
    plain = "a steady flow of the {fluid}"
    formula = "F = D(v - u) - D(v), u = (u_x, u_y, u_z)"
    symbols = {"u": "velocity of the fluid [m/s]"}
    looks_like = (
        "A drift to one side that grows with time, larger for light bodies than for heavy ones, and the same way in every "
        "throw of a day."
    )
    confused_with = ("tilted_gravity",)
    isotropic = False
    alike = "tilt"

    def forces(self, bodies, time):
        flow = np.array([self.velocity_x, self.velocity_y, self.velocity_z, 0.0, 0.0, 0.0])
        return self.through_wrench(bodies._replace(twist=bodies.twist - flow), time) - self.through_wrench(bodies, time)


@dataclass(frozen=True)
class OrientationDrag(DragModifier):
    """Drag that depends on the attitude of a body with the symmetry of a cube; also a side force where the flow comes askew.

    c^3, by component, is the lowest power that tells faces from edges; the mean over all directions is unchanged (the mean of sum
    c^4 is 3/5). Along c the drag is 1 - 3/5 b + b sum c^4 times what it was, from which the ratio follows. The moment is
    left out. The ratio is one of forces. S. F. Hoerner, Fluid-Dynamic Drag (1965), ch. 3, has 1.05 for a cube face on and 0.80
    for one that is turned. Such coefficients go with the frontal area of each attitude: their ratio is not this one.
    """

    face_edge_ratio: float = parameter(
        1.0, unit="-", low=0.3, high=3.0, null=1.0, symbol="ratio", about="drag face on over drag edge on"
    )
    through: tuple = ()  # the drags that depend on attitude
    plain = "{fluid} resistance that depends on how the body is turned"
    formula = "F = |D| ((1 - 3/5 b) c + b c^3) - D, ratio = (1 + 2/5 b)/(1 - 1/10 b)"
    symbols = {"c": "direction of the drag in body axes", "b": "number that follows from the ratio"}
    looks_like = "A drag that rises and falls as the body tumbles, and a push to the side while it falls on an edge."
    confused_with = ("magnus", "quadratic_drag")
    needs = (Need.FLUID, Need.EDGES, Need.SPIN)

    def forces(self, bodies, time):
        drag = self.through_wrench(bodies, time)[:, :3]
        size = length_of(drag)
        direction = rotate(conjugate(bodies.orientation), drag / np.where(size > 0.0, size, 1.0))
        b = (self.face_edge_ratio - 1.0) / (0.4 + 0.1 * self.face_edge_ratio)
        return force_only(size * rotate(bodies.orientation, b * (direction**3 - 0.6 * direction)))


@dataclass(frozen=True)
class WallDrag(DragModifier):
    """Drag grows near a plane wall, twice as much towards it as along it.

    Multiplier 1 is the first order for a sphere in creeping flow: H. Faxen (1922) and H. A. Lorentz (1907), in J. Happel
    and H. Brenner, Low Reynolds Number Hydrodynamics (1983), ch. 7.
    """

    multiplier: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=2.0,
        null=0.0,
        source="1: Happel and Brenner (1983) ch. 7",
        about="times the first order of creeping flow",
        typical=((1.0, "sphere in creeping flow"),),
    )
    wall_height: float = parameter(0.0, unit="m", given=True, about="of the wall, along its normal")
    wall_normal: tuple = (0.0, 0.0, 1.0)  # out of the wall, where normal . x = wall_height, world frame, (3,) [-]
    through: tuple = ()  # the drags that feel the wall
    plain = "more {fluid} resistance near a wall or a floor"
    formula = "F = multiplier (9/16) (r/h) (D + D_n)"
    symbols = {"D_n": "part of the drag along the normal of the wall [N]"}
    looks_like = "Slowed more and more over the last radii above the floor, or along a wall; what is far from it moves as before."
    confused_with = ("ground_cushion",)
    isotropic = False
    dissipative = True
    needs = (Need.FLUID, Need.FLOOR, Need.SIZE)

    def forces(self, bodies, time):
        normal = unit_vector(self.wall_normal)
        drag = self.through_wrench(bodies, time)[:, :3]
        nearness = bodies.radius / np.maximum(dot(bodies.position, normal) - self.wall_height, bodies.radius)
        towards = dot(drag, normal)[:, None] * normal
        return force_only(self.multiplier * 0.5625 * nearness[:, None] * (drag + towards))


@dataclass(frozen=True)
class TubeDrag(Viscous, DragModifier):
    """Drag of a sphere grows in a tube: what it displaces must flow back between it and the walls.

    Of the part in proportion to speed, on the axis of the tube: W. L. Haberman and R. M. Sayre, David Taylor Model Basin Report
    1143 (1958), a closed form right to 2 % up to half its radius; in J. Happel and H. Brenner, Low Reynolds Number Hydrodynamics
    (1983), ch. 7. At higher Reynolds numbers the walls count for less beside the inertia of the fluid.
    """

    acts_on = ViscousDrag

    inverse_radius: float = parameter(
        0.0,
        unit="1/m",
        low=0.0,
        high=100.0,
        null=0.0,
        symbol="c",
        about="1 over the inner radius of the tube",
        typical=((27.0, "a fall tube of 75 mm inner diameter"), (67.0, "a measuring cylinder of 30 mm")),
    )
    through: tuple = ()  # the drags that feel the walls
    plain = "more {fluid} resistance between the walls of a tube"
    formula = "F = (K - 1) D_v, K = (1 - 0.759 q^5)/(1 - 2.105 q + 2.087 q^3 - 1.707 q^5 + 0.726 q^6), q = c r"
    symbols = {
        "D_v": "part of the drag in proportion to speed [N]",
        "K": "that part in the tube over that without walls [-]",
        "q": "radius of the body over that of the tube [-]",
    }
    looks_like = "Large spheres sink too slowly beside small ones, by twice the ratio of their radius to that of the tube."
    confused_with = ("sphere_drag",)
    dissipative = True
    needs = (Need.FLUID, Need.TUBE, Need.SPHERE, Need.SIZE)
    reynolds = (0.0, 100.0)

    def resistance(self, bodies):
        viscous = [drag for drag in self.through if isinstance(drag, ViscousDrag)]
        creeping = sum((drag.resistance(bodies) for drag in viscous), np.zeros(len(bodies.mass)))
        return tube_factor(self.inverse_radius * bodies.radius) * creeping


def tube_factor(ratio):
    """Part by which a tube raises the drag of a sphere that creeps along its axis, K - 1 [-]; ratio: of their radii, taken as
    0.8 where it is larger. W. L. Haberman and R. M. Sayre, as in `TubeDrag`."""
    q = np.minimum(ratio, 0.8)
    return (1 - 0.75857 * q**5) / (1 - 2.105 * q + 2.0865 * q**3 - 1.7068 * q**5 + 0.72603 * q**6) - 1


def compose(effects) -> tuple[Effect, ...]:
    """The effects as they act together: each modifier with an empty `through` is bound to the effects of this list it acts on.

    OrientationDrag and WallDrag act on the plain drags, TubeDrag on what they have in proportion to speed; UniformFlow acts on
    every force of the fluid, those three included; so the order of the list does not matter. What states a coefficient of contact
    (Friction) acts before what changes one (ViscousFriction). Buoyancy is the weight of the displaced fluid: where gravity is
    tilted, it is too. InputError where something is not an effect, or a modifier away from its null value has nothing to act on.
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
            effects[k] = _bound(effect, tuple(drag for drag in drags if isinstance(drag, effect.acts_on)))
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
        viscous = issubclass(modifier.acts_on, ViscousDrag)
        kind, which = (" in proportion to speed", "sphere_drag, stokes_drag") if viscous else ("", "quadratic_drag")
        raise InputError(f"{name_of(modifier)} changes a drag{kind}, but the model has none; add {which} or linear_drag")
    return replace(modifier, through=candidates)
