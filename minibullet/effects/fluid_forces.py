"""What a fluid does to a body besides drag, one law a class."""

from dataclasses import dataclass
from math import pi

import numpy as np

from minibullet.bodies import angular_velocity, velocity
from minibullet.effects.body import STANDARD_GRAVITY, ConstantForce, force_only, unit_vector
from minibullet.effects.contract import Effect, Need, parameter
from minibullet.effects.fluid import AIR_DENSITY, WATER_DENSITY, WATER_VISCOSITY, FluidForce, density, viscosity_of
from minibullet.rotations import cross, dot, matrix


@dataclass(frozen=True)
class Buoyancy(ConstantForce):
    """Lift of a wholly submerged body by the weight of the displaced
    fluid. Archimedes, On Floating Bodies.
    """

    fluid_density: float = parameter(
        0.0,
        unit="kg/m3",
        low=0.0,
        high=1100.0,
        null=0.0,
        least=0.0,
        symbol="rho",
        about="density of the fluid",
        typical=((1.2, "air"), (1000.0, "fresh water"), (1025.0, "sea water")),
    )
    acceleration: float = parameter(STANDARD_GRAVITY, unit="m/s2", given=True, symbol="g", about="acceleration of gravity")
    direction: tuple = (0.0, 0.0, -1.0)  # of gravity, any length, world frame, (3,) [-]
    plain = "the lift of the displaced {fluid}"
    formula = "F = -rho V g d"
    looks_like = (
        "A fall with too small an acceleration, constant from the first moment on; light bodies show it more than heavy "
        "ones of the same size."
    )
    confused_with = ("added_mass", "quadratic_drag")
    isotropic = False
    group = "fluid"
    alike = "effective_gravity"
    needs = (Need.FLUID, Need.MASS_AND_SIZE)

    def forces(self, bodies, time):
        return force_only(-self.fluid_density * bodies.volume[:, None] * (self.acceleration * unit_vector(self.direction)))


@dataclass(frozen=True)
class AddedMass(Effect):
    """Fluid that must be accelerated with the body: more linear inertia in every direction, no rotational inertia.

    C = 0.5 for a sphere in unbounded fluid: H. Lamb, Hydrodynamics (1932), art. 92; 0.68 for a cube: DNV-RP-C205 (2010), app. D.
    A thin disc takes along nearly as much as a ball as wide as it, many times what it displaces (Lamb, art. 108). It enters the
    mass matrix and not the forces, so that light bodies in a heavy fluid stay stable.
    """

    coefficient: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=1.5,
        null=0.0,
        source="Lamb (1932) art. 92",
        bounds_in="ball as wide",
        in_fluid=(0.5, 0.25),
        symbol="C",
        about="added mass over displaced mass",
        typical=((0.5, "sphere: Lamb (1932) art. 92"), (0.68, "cube: DNV-RP-C205 (2010) app. D")),
    )  # sphere 1/2, cube 2/3
    fluid_density: float = density(WATER_DENSITY)
    plain = "{fluid} that has to be set in motion with the body"
    formula = "m_t = m + C rho V"
    symbols = {"m_t": "inertia against acceleration [kg]"}
    looks_like = "Every acceleration is smaller in the same proportion: a slow start in water, and a slow answer to every force."
    confused_with = ("buoyancy", "history_force")
    group = "fluid"
    needs = (Need.FLUID, Need.MASS_AND_SIZE)

    def added_mass(self, bodies):
        matrices = np.zeros((len(bodies.mass), 6, 6))
        matrices[:, [0, 1, 2], [0, 1, 2]] = (self.coefficient * self.fluid_density * bodies.volume)[:, None]
        return matrices


@dataclass(frozen=True)
class Magnus(FluidForce):
    """Side force on a spinning body; it does no work on the translation.

    C = 1 for a sphere in slow flow: S. I. Rubinow and J. B. Keller, J. Fluid Mech. 11 (1961) 447-459. Of smooth spheres it can
    be negative near the drag crisis.
    """

    coefficient: float = parameter(
        0.0,
        unit="-",
        low=-0.5,
        high=3.0,
        null=0.0,
        source="Rubinow and Keller (1961)",
        symbol="C",
        about="of the side force",
        typical=((1.0, "sphere in slow flow"),),
    )
    fluid_density: float = density(AIR_DENSITY)
    plain = "the side force on a spinning body"
    formula = "F = C pi rho r^3 omega x w"
    symbols = {"x": "vector product, no letter"}
    looks_like = (
        "The path of a spinning body curves at right angles to spin and velocity; turn the spin round and it curves to "
        "the other side."
    )
    confused_with = ("uniform_flow",)
    needs = (Need.FLUID, Need.MASS_AND_SIZE, Need.SPIN)

    def forces(self, bodies, time):
        strength = self.coefficient * pi * self.fluid_density * bodies.radius**3
        return force_only(strength[:, None] * cross(angular_velocity(bodies), velocity(bodies)))


@dataclass(frozen=True)
class SpinDecay(Effect):
    """Moment against the spin, so that a free spin falls as exp(-rate t).

    The linear form of the viscous moment on a sphere, 8 pi eta r3 omega: H. Lamb, Hydrodynamics (1932), art. 334.
    """

    rate: float = parameter(0.0, unit="1/s", low=0.0, high=5.0, null=0.0, about="share of the spin that is lost in a second")
    plain = "the slowing of the spin by the {fluid}"
    formula = "M = -rate I omega"
    looks_like = "A body in flight turns slower and slower: the gap in its orientation grows as the square of time at first."
    confused_with = ("inertia_error",)
    dissipative = True
    group = "fluid"
    needs = (Need.FLUID, Need.ROTATION)

    def forces(self, bodies, time):
        turn = matrix(bodies.orientation)
        spin = np.einsum("nji,nj->ni", turn, angular_velocity(bodies))
        wrench = np.zeros((len(spin), 6))
        wrench[:, 3:] = -self.rate * np.einsum("nij,nj->ni", turn, bodies.inertia * spin)
        return wrench


@dataclass(frozen=True)
class HistoryForce(FluidForce):
    """Basset's force for a body set free at time `start`, in closed form.

    Basset's force is 6 r2 sqrt(pi rho eta) times the integral of w'(s)/sqrt(t - s) over the whole past, and an effect has
    no memory. The integral has a closed form for w ~ (t - start)^p: p B(p, 1/2) w/sqrt(t - start), where B is the beta
    function. The factor is 2 for steady acceleration (p = 1, taken here as multiplier 1) and 1 for a sudden start (p -> 0:
    multiplier 0.5), pi/2 in between (p = 1/2). So within a factor of two it is right for any flight that only gets faster
    or keeps its speed; it knows nothing of an impact, after which it goes on as if the body had always moved as it moves
    now. Zero up to `start`. A. B. Basset, A Treatise on Hydrodynamics II (1888).
    """

    multiplier: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=1.5,
        null=0.0,
        source="1: Basset (1888) at steady acceleration",
        about="times Basset's force",
        typical=((1.0, "steady acceleration"), (0.5, "sudden start")),
    )
    fluid_density: float = density(WATER_DENSITY)
    fluid_viscosity: float = viscosity_of(WATER_VISCOSITY)
    start: float = parameter(0.0, unit="s", given=True, about="when the body was set free")
    plain = "the drag of the {fluid} that earlier motion has stirred"
    formula = "F = -multiplier 12 r^2 sqrt(pi rho eta/(t - start)) w"
    looks_like = (
        "More resistance soon after the release, which then dies away slowly: final speed is reached later than drag "
        "alone foretells."
    )
    confused_with = ("added_mass",)
    dissipative = True
    needs = (Need.FLUID, Need.MASS_AND_SIZE, Need.RELEASE)

    def forces(self, bodies, time):
        elapsed = time - self.start
        if elapsed <= 0.0:
            return np.zeros((len(bodies.mass), 6))
        resistance = 12.0 * bodies.radius**2 * np.sqrt(pi * self.fluid_density * self.fluid_viscosity / elapsed)
        return force_only(-self.multiplier * resistance[:, None] * velocity(bodies))


@dataclass(frozen=True)
class GroundCushion(FluidForce):
    """Fluid squeezed out under a body that approaches a plane; it pushes away from the plane.

    Without approach there is no force: what is squeezed out as a jet does not push back. From the kinetic energy
    (1/2)(m'/2)(1 + (3/8)(r/h)^3) w_n^2 of a sphere near a wall, m' the displaced mass: H. Lamb, Hydrodynamics (1932), art.
    98. A flat face has a stronger cushion: multiplier above 1.
    """

    multiplier: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=2.0,
        null=0.0,
        source="1: Lamb (1932) art. 98",
        about="times the force on a sphere",
        typical=((1.0, "sphere"),),
    )
    fluid_density: float = density(AIR_DENSITY)
    ground_height: float = parameter(0.0, unit="m", given=True, about="of the plane, along its normal")
    ground_normal: tuple = (0.0, 0.0, 1.0)  # out of the ground, where normal . x = ground_height, world frame, (3,) [-]
    plain = "the cushion of {fluid} below a body that lands"
    formula = "F = multiplier (3/8) pi rho r^2 (r/h)^4 w_n^2"
    looks_like = (
        "Within one radius above the floor the body is slowed, and lands a little late and softly; nothing is seen higher up."
    )
    confused_with = ("wall_drag", "restitution")
    isotropic = False
    dissipative = True
    needs = (Need.FLUID, Need.MASS_AND_SIZE, Need.FLOOR)

    def forces(self, bodies, time):
        normal = unit_vector(self.ground_normal)
        nearness = bodies.radius / np.maximum(dot(bodies.position, normal) - self.ground_height, bodies.radius)
        approach = np.maximum(-dot(velocity(bodies), normal), 0.0)
        push = self.multiplier * 0.375 * pi * self.fluid_density * bodies.radius**2 * nearness**4 * approach**2
        return force_only(push[:, None] * normal)
