"""The body is not quite what the file says: mass, size, inertia."""

from dataclasses import dataclass, replace

from hlcs.data.rigid_body import rigid_body
from hlcs.effects.contract import Change, DataNeed
from minibullet.effects.contract import Need, parameter


@dataclass(frozen=True)
class MassOffset(Change):
    """True mass = (1 + relative) stated mass; the size is right."""

    relative: float = parameter(0.0, unit="-", low=-0.05, high=0.05, null=0.0, least=-0.9)
    plain = "a mass other than stated"
    group = "body"
    needs = (Need.MASS_AND_SIZE,)

    def setup(self, setup):
        body = setup.body
        factor = 1 + self.relative
        inertia = None if body.inertia is None else tuple(factor * moment for moment in body.inertia)
        return replace(setup, body=replace(body, mass=None if body.mass is None else factor * body.mass, inertia=inertia))


@dataclass(frozen=True)
class SizeError(Change):
    """True lengths of the body = (1 + relative) stated lengths; the mass is right."""

    relative: float = parameter(0.0, unit="-", low=-0.02, high=0.02, null=0.0, least=-0.9)
    plain = "a size other than stated"
    group = "body"
    alike = "rest_height"
    needs = (Need.MASS_AND_SIZE,)

    def setup(self, setup):
        body, factor = setup.body, 1 + self.relative
        return replace(
            setup,
            body=replace(
                body,
                radius=None if body.radius is None else factor * body.radius,
                height=None if body.height is None else factor * body.height,
                side=None if body.side is None else factor * body.side,
                size=None if body.size is None else tuple(factor * edge for edge in body.size),
            ),
        )


@dataclass(frozen=True)
class CentreOfMassOffset(Change):
    """The centre of mass lies off the centre of the shape, in multiples of its size (side of the cube of equal volume)."""

    x: float = parameter(0.0, unit="L", low=-0.05, high=0.05, null=0.0)
    y: float = parameter(0.0, unit="L", low=-0.05, high=0.05, null=0.0)
    z: float = parameter(0.0, unit="L", low=-0.05, high=0.05, null=0.0)
    plain = "a centre of mass off the middle of the shape"
    group = "body"
    needs = (DataNeed.LEANING,)

    def setup(self, setup):
        size = rigid_body(setup.body).volume ** (1 / 3)
        moved = tuple(here + size * part for here, part in zip(setup.centre, (self.x, self.y, self.z), strict=True))
        return replace(setup, centre=moved)


@dataclass(frozen=True)
class InertiaError(Change):
    """True principal moments = factors times the model's; what turns freely or tips tells."""

    factor_x: float = parameter(1.0, unit="-", low=0.5, high=4.0, null=1.0)
    factor_y: float = parameter(1.0, unit="-", low=0.5, high=4.0, null=1.0)
    factor_z: float = parameter(1.0, unit="-", low=0.5, high=4.0, null=1.0)
    plain = "an inertia other than stated"
    group = "body"
    needs = (DataNeed.TURNING,)

    def setup(self, setup):
        moments = rigid_body(setup.body).inertia
        factors = (self.factor_x, self.factor_y, self.factor_z)
        wanted = [float(factor * moment) for factor, moment in zip(factors, moments, strict=True)]
        total = sum(wanted)  # no solid has a moment above the sum of the other two: the nearest that one can have
        return replace(setup, body=replace(setup.body, inertia=tuple(min(moment, total - moment) for moment in wanted)))
