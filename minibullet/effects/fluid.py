"""Drag, and what all forces of a fluid share. The letters of the formulas: `SYMBOLS` in contract.py.

The fluid is at rest unless UniformFlow moves it. Coefficients refer to the mean projected area: for a sphere pi r2, for a
tumbling cube of side L 1.5 L2.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from minibullet.bodies import velocity
from minibullet.effects.body import force_only
from minibullet.effects.contract import Effect, Need, parameter

AIR_DENSITY = 1.2  # dry air at 20 degrees Celsius and 101 kPa [kg/m3]
AIR_VISCOSITY = 1.8e-5  # the same air [Pa s]
WATER_DENSITY = 1000.0  # fresh water [kg/m3]
WATER_VISCOSITY = 1.0e-3  # fresh water at 20 degrees Celsius [Pa s]
SCHILLER_NAUMANN = 800.0  # Reynolds number up to which their curve holds, to 5 %


def excess_over_stokes(reynolds):
    """Part of Stokes's drag by which that of a smooth sphere is larger, at Reynolds numbers up to 800: 0.15 Re^0.687, to 5 % of
    the drag.

    L. Schiller and A. Naumann, Z. VDI 77 (1933) 318; in R. Clift, J. R. Grace and M. E. Weber, Bubbles, Drops, and Particles
    (1978), table 5.1.
    """
    return 0.15 * reynolds**0.687


def drag_coefficient_of_sphere(reynolds):
    """Drag coefficient of a smooth sphere at Reynolds numbers up to 800; 24/Re alone is Stokes's law."""
    return 24.0 / reynolds * (1.0 + excess_over_stokes(reynolds))


def dragged_as_much(reynolds):
    """The Reynolds number of a sphere that a fluid drags as much as Stokes's law foretells at this one.

    Of the same sphere at the same speed: the fluid is thinner by the ratio of the two.
    """
    found = reynolds
    for _ in range(100):  # each step leaves 0.687 of the error at most: the power in the law
        found = reynolds * (1.0 + excess_over_stokes(found))
    return found


def density(default):
    """The density of a fluid, as a number of an effect that the surroundings give."""
    return parameter(default, unit="kg/m3", given=True, symbol="rho", about="density of the fluid")


def viscosity_of(default):
    """The viscosity of a fluid, likewise."""
    return parameter(default, unit="Pa s", given=True, symbol="eta", about="viscosity of the fluid")


def length_of(vectors) -> np.ndarray:
    """Length of each vector, kept as a column, (n, 3) -> (n, 1)."""
    return np.sqrt(np.einsum("ni,ni->n", vectors, vectors))[:, None]


class FluidForce(Effect):
    """A force that depends on the velocity relative to the fluid, so UniformFlow acts through it."""

    group = "fluid"
    needs = (Need.FLUID,)


class Drag(FluidForce):
    """A force straight against the relative velocity; OrientationDrag, WallDrag and TubeDrag modify it. Subclass it for a drag of
    your own.
    """

    dissipative = True
    reynolds_of_spheres = (0.0, np.inf)  # Reynolds numbers between which it has the form of the drag of a smooth sphere


class Viscous(FluidForce):
    """A force with a part in proportion to the relative velocity, -resistance w, for which a free flight has a closed form."""

    def resistance(self, bodies):
        """Force over speed of each body (n,) [kg/s]."""
        raise NotImplementedError

    def inertial(self, bodies):
        """The rest, by the inertia of the fluid: force on each body (n, 3) [N]; 0.0 of a law in proportion to the velocity."""
        return 0.0

    def forces(self, bodies, time):
        return force_only(self.inertial(bodies) - self.resistance(bodies)[:, None] * velocity(bodies))


class ViscousDrag(Viscous, Drag):
    """A drag of that kind, one form of the law of drag."""

    form_of = "drag_form"
    powers = (1,)
    reynolds_of_spheres = (0.0, 1.0)


@dataclass(frozen=True)
class LinearDrag(ViscousDrag):
    """Drag proportional to speed.

    Of a sphere in creeping flow the rate is 6 pi eta r/m, and StokesDrag finds the viscosity eta itself.
    """

    # as much as a drag coefficient of 2.5 at the speed of the body
    rate: float = parameter(
        0.0,
        unit="1/s",
        low=0.0,
        high=2.5,
        null=0.0,
        bounds_in="drag at speed",
        about="force over momentum",
        typical=((0.037, "a tennis ball in air at 2 m/s, as much as drag coefficient 0.5 there"),),
    )
    plain = "{fluid} resistance in proportion to the speed"
    formula = "F = -rate m w"
    looks_like = (
        "Too slow from the first moment on: the gap to the model grows with the way that was travelled, in slow throws as "
        "much as in fast ones."
    )

    def resistance(self, bodies):
        return self.rate * bodies.mass


@dataclass(frozen=True)
class StokesDrag(ViscousDrag):
    """Drag of a small or slow body in a viscous fluid.

    Exact for a sphere where inertia of the fluid counts for nothing: the force is 2 % too small at Re = 2 r rho |w|/eta = 0.1 and
    15 % at 1. G. G. Stokes, Trans. Camb. Phil. Soc. 9 (1851); the next term, 1 + 3/16 Re: C. W. Oseen, Ark. Mat. Astron. Fys. 6
    (1910). Of other bodies r is the radius of the sphere of equal volume, which is right to some ten per cent.
    """

    viscosity: float = parameter(
        0.0,
        unit="Pa s",
        low=0.0,
        high=20.0,
        null=0.0,
        symbol="eta",
        about="viscosity of the fluid",
        typical=(
            (0.001, "water at 20 degrees Celsius"),
            (1.0, "castor oil at 20 degrees Celsius"),
            (1.4, "pure glycerine at 20 degrees Celsius"),
            (10.0, "thick honey, about; thin honey has 2 Pa s"),
        ),
    )
    plain = "{fluid} resistance by viscosity"
    formula = "F = -6 pi eta r w"
    looks_like = (
        "Speed comes near to a constant final value soon and exponentially; in a slow fall nearly all of the way is "
        "travelled at it."
    )
    confused_with = ("history_force", "wall_drag")
    needs = (Need.FLUID, Need.MASS_AND_SIZE)
    reynolds = (0.0, 1.0)

    def resistance(self, bodies):
        return 6.0 * pi * self.viscosity * bodies.radius


@dataclass(frozen=True)
class SphereDrag(StokesDrag):
    """Drag of a smooth sphere in a viscous fluid, from creeping flow on to Reynolds numbers of 800.

    Half as much again as by Stokes's law at Re = 6, five times as much at 120; right to 5 %. L. Schiller and A. Naumann, Z. VDI
    77 (1933) 318; in R. Clift, J. R. Grace and M. E. Weber, Bubbles, Drops, and Particles (1978), table 5.1. A whole drag law,
    not an addition to StokesDrag.
    """

    fluid_density: float = density(AIR_DENSITY)
    plain = "{fluid} resistance by viscosity and inertia"
    formula = "F = -6 pi eta r (1 + 0.15 Re^0.687) w, Re = 2 r rho |w|/eta"
    symbols = {"Re": "Reynolds number"}
    looks_like = (
        "As by viscosity alone, but the more so the larger and faster a sphere is: by Stokes's law a large one gives a greater "
        "viscosity than a small one."
    )
    confused_with = ("history_force", "wall_drag")
    powers = (1, 2)
    contains = (StokesDrag,)
    needs = (Need.FLUID, Need.SPHERE, Need.MASS_AND_SIZE)
    reynolds_of_spheres = reynolds = (0.0, SCHILLER_NAUMANN)

    def inertial(self, bodies):
        w = velocity(bodies)
        if not self.viscosity:  # the drag ends at none, its Reynolds number at infinity
            return np.zeros_like(w)
        reynolds = 2.0 * bodies.radius[:, None] * self.fluid_density * length_of(w) / self.viscosity
        return -excess_over_stokes(reynolds) * self.resistance(bodies)[:, None] * w


@dataclass(frozen=True)
class QuadraticDrag(Drag):
    """Drag proportional to speed squared.

    Give the drag coefficient C of a body of known size, or for a body without size drag_per_metre k. I. Newton, Principia
    II; C = 0.47 for a smooth sphere, 1.05 for a cube face on: S. F. Hoerner, Fluid-Dynamic Drag (1965), ch. 3.
    """

    drag_coefficient: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=2.5,
        null=0.0,
        source="Hoerner (1965)",
        body_known=True,
        symbol="C",
        about="of the mean projected area",
        typical=((0.47, "smooth sphere"), (1.05, "cube, face on")),
    )
    fluid_density: float = density(AIR_DENSITY)
    # light bodies (coffee filters, balloons) reach their final speed within a thirtieth of the height that they fall
    drag_per_metre: float = parameter(
        0.0,
        unit="1/m",
        low=0.0,
        high=60.0,
        null=0.0,
        body_known=False,
        bounds_in="per extent",
        symbol="k",
        about="deceleration over speed squared, for a body whose size is not known",
    )
    plain = "{fluid} resistance"
    formula = "F = -(rho C A/2 + k m) |w| w"
    looks_like = (
        "Falls too slowly, and the more so the faster it is: nothing at first, then a gap that grows as the fourth power of time."
    )
    confused_with = ("buoyancy", "length_scale", "time_scale", "mass_offset", "history_force")
    form_of = "drag_form"
    powers = (2,)
    reynolds_of_spheres = (1e3, 2e5)  # coefficient constant to some 10 %: Clift, Grace and Weber (1978), ch. 5

    def forces(self, bodies, time):
        w = velocity(bodies)
        resistance = 0.5 * self.fluid_density * self.drag_coefficient * bodies.area + self.drag_per_metre * bodies.mass
        return force_only(-resistance[:, None] * length_of(w) * w)


@dataclass(frozen=True)
class DragCrisis(Drag):
    """Quadratic drag whose coefficient falls where the boundary layer turns turbulent.

    A smooth curve in the manner of the data for smooth spheres of E. Achenbach, J. Fluid Mech. 54 (1972) 565-575; roughness
    brings the fall to a lower Reynolds number: J. Fluid Mech. 65 (1974) 113-125. A whole drag law, not an addition to
    QuadraticDrag.
    """

    subcritical: float = parameter(
        0.0,
        unit="-",
        low=0.2,
        high=1.2,
        null=0.0,
        source="Achenbach (1972)",
        symbol="sub",
        about="drag coefficient well below the critical Reynolds number",
        typical=((0.5, "smooth sphere, about"),),
    )
    supercritical: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=0.5,
        null=0.0,
        source="Achenbach (1972)",
        symbol="sup",
        about="the same well above it",
        typical=((0.1, "smooth sphere, about"),),
    )
    critical_reynolds: float = parameter(
        2e5,
        unit="-",
        low=5e4,
        high=5e5,
        source="Achenbach (1972)",
        starts=(1e5, 2e5, 4e5),
        symbol="Re_c",
        about="Reynolds number in the middle of the fall",
        typical=((3e5, "smooth sphere, about; a rough one less"),),
    )
    fluid_density: float = density(AIR_DENSITY)
    fluid_viscosity: float = viscosity_of(AIR_VISCOSITY)
    plain = "{fluid} resistance that drops at high speed"
    formula = "F = -rho C(Re) A/2 |w| w, C(Re) = sup + (sub - sup)/(1 + (Re/Re_c)^4), Re = 2 r rho |w|/eta"
    symbols = {"C": "drag coefficient at this Reynolds number", "Re": "Reynolds number"}
    looks_like = (
        "Fast bodies are slowed less than slow ones foretell: a drag coefficient that was found at low speed is too large "
        "at high speed."
    )
    form_of = "drag_form"
    powers = (2,)
    contains = (QuadraticDrag,)
    needs = (Need.FLUID, Need.MASS_AND_SIZE)
    reynolds_of_spheres = (1e3, np.inf)
    reynolds = (2.5e4, np.inf)  # half the lowest critical value, where the coefficient begins to fall

    def forces(self, bodies, time):
        w = velocity(bodies)
        speed = length_of(w)
        reynolds = 2.0 * bodies.radius[:, None] * self.fluid_density * speed / self.fluid_viscosity
        # at ten thousand times the critical value the crisis is over to the last bit; the cut keeps the power from overflowing
        ratio = np.minimum(reynolds / self.critical_reynolds, 1e4)
        coefficient = self.supercritical + (self.subcritical - self.supercritical) / (1.0 + ratio**4)
        return force_only(-0.5 * self.fluid_density * coefficient * bodies.area[:, None] * speed * w)
