"""What a fluid does to a body, one law a class. Notation: w = velocity relative to the fluid, A = mean projected area,
r = radius of the sphere of equal volume V, rho = density and eta = viscosity of the fluid, m = mass of the body.

The fluid is at rest unless UniformFlow moves it. Coefficients refer to the mean projected area: for a sphere pi r2, for a
tumbling cube of side L 1.5 L2.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from minibullet.bodies import angular_velocity, velocity
from minibullet.effects.body import STANDARD_GRAVITY, ConstantForce, force_only, unit_vector
from minibullet.effects.contract import Effect, Need, parameter
from minibullet.rotations import cross, dot, matrix

AIR_DENSITY = 1.2  # dry air at 20 degrees Celsius and 101 kPa [kg/m3]
AIR_VISCOSITY = 1.8e-5  # the same air [Pa s]
WATER_DENSITY = 1000.0  # fresh water [kg/m3]
WATER_VISCOSITY = 1.0e-3  # fresh water at 20 degrees Celsius [Pa s]


def length_of(vectors) -> np.ndarray:
    """Length of each vector, kept as a column, (n, 3) -> (n, 1)."""
    return np.sqrt(np.einsum("ni,ni->n", vectors, vectors))[:, None]


class FluidForce(Effect):
    """A force that depends on the velocity relative to the fluid, so UniformFlow acts through it."""

    group = "fluid"


class Drag(FluidForce):
    """A force straight against the relative velocity; OrientationDrag
    and WallDrag modify it. Subclass it for a drag of your own.
    """

    dissipative = True


class ViscousDrag(Drag):
    """A drag proportional to the relative velocity, F = -resistance w: a free flight through it has a closed form."""

    form_of = "drag_form"
    needs = (Need.FLUID,)

    def resistance(self, bodies):
        """Force over speed of each body (n,) [kg/s]."""
        raise NotImplementedError

    def forces(self, bodies, time):
        return force_only(-self.resistance(bodies)[:, None] * velocity(bodies))


@dataclass(frozen=True)
class LinearDrag(ViscousDrag):
    """Drag proportional to speed, F = -rate m w.

    Of a sphere in creeping flow the rate is 6 pi eta r/m, and StokesDrag finds the viscosity eta itself.
    """

    # as much as a drag coefficient of 2.5 at the speed of the body
    rate: float = parameter(0.0, unit="1/s", low=0.0, high=2.5, null=0.0, bounds_in="drag at speed")
    plain = "{fluid} resistance in proportion to the speed"

    def resistance(self, bodies):
        return self.rate * bodies.mass


@dataclass(frozen=True)
class StokesDrag(ViscousDrag):
    """Drag of a small or slow body in a viscous fluid, F = -6 pi eta r w.

    Exact for a sphere where inertia of the fluid counts for nothing: the force is 2 % too small at Re = 2 r rho |w|/eta = 0.1 and
    15 % at 1. G. G. Stokes, Trans. Camb. Phil. Soc. 9 (1851); the next term, 1 + 3/16 Re: C. W. Oseen, Ark. Mat. Astron. Fys. 6
    (1910). Of other bodies r is the radius of the sphere of equal volume, which is right to some ten per cent.
    """

    viscosity: float = parameter(0.0, unit="Pa s", low=0.0, high=20.0, null=0.0, source="castor oil 1, glycerine 1.4, honey 10")
    plain = "{fluid} resistance by viscosity"
    needs = (Need.FLUID, Need.MASS_AND_SIZE)
    reynolds = (0.0, 1.0)

    def resistance(self, bodies):
        return 6.0 * pi * self.viscosity * bodies.radius


@dataclass(frozen=True)
class QuadraticDrag(Drag):
    """Drag proportional to speed squared, F = -(rho C A/2 + k m) |w| w.

    Give the drag coefficient C of a body of known size, or for a body without size drag_per_metre k. I. Newton, Principia
    II; C = 0.47 for a smooth sphere, 1.05 for a cube face on: S. F. Hoerner, Fluid-Dynamic Drag (1965), ch. 3.
    """

    drag_coefficient: float = parameter(0.0, unit="-", low=0.0, high=2.5, null=0.0, source="Hoerner (1965)", body_known=True)
    fluid_density: float = parameter(AIR_DENSITY, unit="kg/m3", given=True)
    # light bodies (coffee filters, balloons) reach their final speed within a thirtieth of the height that they fall
    drag_per_metre: float = parameter(0.0, unit="1/m", low=0.0, high=60.0, null=0.0, body_known=False, bounds_in="per extent")
    plain = "{fluid} resistance"
    form_of = "drag_form"

    def forces(self, bodies, time):
        w = velocity(bodies)
        resistance = 0.5 * self.fluid_density * self.drag_coefficient * bodies.area + self.drag_per_metre * bodies.mass
        return force_only(-resistance[:, None] * length_of(w) * w)


@dataclass(frozen=True)
class DragCrisis(Drag):
    """Quadratic drag whose coefficient falls where the boundary layer turns turbulent, F = -rho C(Re) A/2 |w| w.

    C = sup + (sub - sup)/(1 + (Re/Re_c)^4), Re = 2 r rho |w|/eta: a smooth curve through the sphere data of
    E. Achenbach, J. Fluid Mech. 54 (1972) 565-575. A whole drag law, not an addition to QuadraticDrag.
    """

    subcritical: float = parameter(0.47, unit="-", low=0.2, high=1.2, source="Achenbach (1972)")
    supercritical: float = parameter(0.1, unit="-", low=0.0, high=0.5, source="Achenbach (1972)")
    critical_reynolds: float = parameter(2e5, unit="-", low=5e4, high=5e5, source="Achenbach (1972)", starts=(1e5, 2e5, 4e5))
    fluid_density: float = parameter(AIR_DENSITY, unit="kg/m3", given=True)
    fluid_viscosity: float = parameter(AIR_VISCOSITY, unit="Pa s", given=True)
    plain = "{fluid} resistance that drops at high speed"
    form_of = "drag_form"
    contains = (QuadraticDrag,)
    needs = (Need.MASS_AND_SIZE,)
    reynolds = (2.5e4, np.inf)  # half the lowest critical value, where the coefficient begins to fall

    def forces(self, bodies, time):
        w = velocity(bodies)
        speed = length_of(w)
        reynolds = 2.0 * bodies.radius[:, None] * self.fluid_density * speed / self.fluid_viscosity
        # at ten thousand times the critical value the crisis is over to the last bit; the cut keeps the power from overflowing
        ratio = np.minimum(reynolds / self.critical_reynolds, 1e4)
        coefficient = self.supercritical + (self.subcritical - self.supercritical) / (1.0 + ratio**4)
        return force_only(-0.5 * self.fluid_density * coefficient * bodies.area[:, None] * speed * w)


@dataclass(frozen=True)
class Buoyancy(ConstantForce):
    """Lift of a wholly submerged body by the weight of the displaced
    fluid, F = rho V g upwards. Archimedes, On Floating Bodies.
    """

    fluid_density: float = parameter(0.0, unit="kg/m3", low=0.0, high=1100.0, null=0.0, source="air to brine", least=0.0)
    acceleration: float = parameter(STANDARD_GRAVITY, unit="m/s2", given=True)
    direction: tuple = (0.0, 0.0, -1.0)  # of gravity, any length, world frame (3,)
    plain = "the lift of the displaced {fluid}"
    isotropic = False
    group = "fluid"
    alike = "effective_gravity"
    needs = (Need.MASS_AND_SIZE,)

    def forces(self, bodies, time):
        return force_only(-self.fluid_density * bodies.volume[:, None] * (self.acceleration * unit_vector(self.direction)))


@dataclass(frozen=True)
class AddedMass(Effect):
    """Fluid that must be accelerated with the body: linear inertia C rho V more in every direction, no rotational inertia.

    C = 0.5 for a sphere in unbounded fluid: H. Lamb, Hydrodynamics (1932), art. 92; 0.68 for a cube: DNV-RP-C205 (2010), app. D.
    It enters the mass matrix and not the forces, so that light bodies in a heavy fluid stay stable.
    """

    coefficient: float = parameter(
        0.0, unit="-", low=0.0, high=1.5, null=0.0, source="Lamb (1932) art. 92", in_liquid=(0.5, 0.25)
    )  # sphere 1/2, cube 2/3
    fluid_density: float = parameter(WATER_DENSITY, unit="kg/m3", given=True)
    plain = "{fluid} that has to be set in motion with the body"
    group = "fluid"
    needs = (Need.MASS_AND_SIZE,)

    def added_mass(self, bodies):
        matrices = np.zeros((len(bodies.mass), 6, 6))
        matrices[:, [0, 1, 2], [0, 1, 2]] = (self.coefficient * self.fluid_density * bodies.volume)[:, None]
        return matrices


@dataclass(frozen=True)
class Magnus(FluidForce):
    """Side force on a spinning body, F = C pi rho r3 omega x w; it does no work on the translation.

    C = 1 for a sphere in slow flow: S. I. Rubinow and J. B. Keller,
    J. Fluid Mech. 11 (1961) 447-459; negative beyond the drag crisis.
    """

    coefficient: float = parameter(0.0, unit="-", low=-0.5, high=3.0, null=0.0, source="Rubinow and Keller (1961)")
    fluid_density: float = parameter(AIR_DENSITY, unit="kg/m3", given=True)
    plain = "the side force on a spinning body"
    needs = (Need.MASS_AND_SIZE, Need.SPIN)

    def forces(self, bodies, time):
        strength = self.coefficient * pi * self.fluid_density * bodies.radius**3
        return force_only(strength[:, None] * cross(angular_velocity(bodies), velocity(bodies)))


@dataclass(frozen=True)
class SpinDecay(Effect):
    """Moment against the spin, M = -rate I omega, so that a free spin falls as exp(-rate t).

    The linear form of the viscous moment on a sphere, 8 pi eta r3 omega: H. Lamb, Hydrodynamics (1932), art. 334.
    """

    rate: float = parameter(0.0, unit="1/s", low=0.0, high=5.0, null=0.0)
    plain = "the slowing of the spin by the {fluid}"
    dissipative = True
    group = "fluid"
    needs = (Need.ROTATION,)

    def forces(self, bodies, time):
        turn = matrix(bodies.orientation)
        spin = np.einsum("nji,nj->ni", turn, angular_velocity(bodies))
        wrench = np.zeros((len(spin), 6))
        wrench[:, 3:] = -self.rate * np.einsum("nij,nj->ni", turn, bodies.inertia * spin)
        return wrench


@dataclass(frozen=True)
class HistoryForce(FluidForce):
    """Basset's force for a body set free at time `start`, in closed form: F = -multiplier 12 r2 sqrt(pi rho eta/(t - start)) w.

    Basset's force is 6 r2 sqrt(pi rho eta) times the integral of w'(s)/sqrt(t - s) over the whole past, and an effect has
    no memory. The integral has a closed form for w ~ (t - start)^p: p B(p, 1/2) w/sqrt(t - start), where B is the beta
    function. The factor is 2 for steady acceleration (p = 1, taken here as multiplier 1) and 1 for a sudden start (p -> 0:
    multiplier 0.5), pi/2 in between (p = 1/2). So within a factor of two it is right for any flight that only gets faster
    or keeps its speed; it knows nothing of an impact, after which it goes on as if the body had always moved as it moves
    now. Zero up to `start`. A. B. Basset, A Treatise on Hydrodynamics II (1888).
    """

    multiplier: float = parameter(0.0, unit="-", low=0.0, high=1.5, null=0.0, source="1: Basset (1888) at steady acceleration")
    fluid_density: float = parameter(WATER_DENSITY, unit="kg/m3", given=True)
    fluid_viscosity: float = parameter(WATER_VISCOSITY, unit="Pa s", given=True)
    start: float = parameter(0.0, unit="s", given=True)
    plain = "the drag of the {fluid} that earlier motion has stirred"
    dissipative = True
    needs = (Need.MASS_AND_SIZE, Need.RELEASE)

    def forces(self, bodies, time):
        elapsed = time - self.start
        if elapsed <= 0.0:
            return np.zeros((len(bodies.mass), 6))
        resistance = 12.0 * bodies.radius**2 * np.sqrt(pi * self.fluid_density * self.fluid_viscosity / elapsed)
        return force_only(-self.multiplier * resistance[:, None] * velocity(bodies))


@dataclass(frozen=True)
class GroundCushion(FluidForce):
    """Fluid squeezed out under a body that approaches a plane, F = multiplier (3/8) pi rho r2 (r/h)^4 w_n^2 away from the plane.

    h is the distance of the centre from the plane, not less than r; w_n the speed of approach, and without approach there
    is no force: what is squeezed out as a jet does not push back. From the kinetic energy (1/2)(m'/2)(1 + (3/8)(r/h)^3)
    w_n^2 of a sphere near a wall, m' the displaced mass: H. Lamb, Hydrodynamics (1932), art. 98. A flat face has a stronger
    cushion: multiplier above 1.
    """

    multiplier: float = parameter(0.0, unit="-", low=0.0, high=2.0, null=0.0, source="1: Lamb (1932) art. 98")
    fluid_density: float = parameter(AIR_DENSITY, unit="kg/m3", given=True)
    ground_height: float = parameter(0.0, unit="m", given=True)
    ground_normal: tuple = (0.0, 0.0, 1.0)  # out of the ground, where normal . x = ground_height, world frame (3,)
    plain = "the cushion of {fluid} below a body that lands"
    isotropic = False
    dissipative = True
    needs = (Need.MASS_AND_SIZE, Need.FLOOR)

    def forces(self, bodies, time):
        normal = unit_vector(self.ground_normal)
        nearness = bodies.radius / np.maximum(dot(bodies.position, normal) - self.ground_height, bodies.radius)
        approach = np.maximum(-dot(velocity(bodies), normal), 0.0)
        push = self.multiplier * 0.375 * pi * self.fluid_density * bodies.radius**2 * nearness**4 * approach**2
        return force_only(push[:, None] * normal)
