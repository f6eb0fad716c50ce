"""The body is not quite what the file says: mass, size, inertia."""

from dataclasses import dataclass, replace

from hlcs.data.rigid_body import rigid_body
from hlcs.effects.contract import Change, DataNeed
from minibullet.effects.contract import Need, parameter


@dataclass(frozen=True)
class MassOffset(Change):
    """The mass is not the one that was stated; the size is right."""

    relative: float = parameter(
        0.0,
        unit="-",
        low=-0.05,
        high=0.05,
        null=0.0,
        least=-0.9,
        about="true over stated mass, less one",
        typical=((0.01, "balance that shows whole grams, body of 50 g"),),
    )
    plain = "a mass other than stated"
    formula = "m_true = (1 + relative) m"
    symbols = {"m_true": "mass as it is [kg]"}
    looks_like = (
        "Seen only beside forces that do not grow with mass: drag and buoyancy are too weak or too strong by one and the "
        "same factor."
    )
    confused_with = ("quadratic_drag", "buoyancy")
    group = "body"
    needs = (Need.MASS_AND_SIZE,)

    def setup(self, setup):
        body = setup.body
        factor = 1 + self.relative
        inertia = None if body.inertia is None else tuple(factor * moment for moment in body.inertia)
        return replace(setup, body=replace(body, mass=None if body.mass is None else factor * body.mass, inertia=inertia))


@dataclass(frozen=True)
class SizeError(Change):
    """The lengths of the body are not those that were stated; the mass is right."""

    relative: float = parameter(
        0.0,
        unit="-",
        low=-0.02,
        high=0.02,
        null=0.0,
        least=-0.9,
        about="true over stated lengths, less one",
        typical=((0.005, "ruler with millimetres, body of 100 mm"),),
    )
    plain = "a size other than stated"
    formula = "L_true = (1 + relative) L"
    symbols = {"L_true": "length as it is [m]"}
    looks_like = (
        "At rest on the floor the centre is too high or too low, always by the same; drag is wrong by twice the relative error."
    )
    confused_with = ("mass_offset",)
    group = "body"
    alike = "rest_height"
    needs = (Need.SIZE,)

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
    """The centre of mass lies off the centre of the shape."""

    x: float = parameter(0.0, unit="L", low=-0.05, high=0.05, null=0.0, about="along the body's x axis")
    y: float = parameter(0.0, unit="L", low=-0.05, high=0.05, null=0.0, about="along the body's y axis")
    z: float = parameter(0.0, unit="L", low=-0.05, high=0.05, null=0.0, about="along the body's z axis")
    plain = "a centre of mass off the middle of the shape"
    formula = "d = (x, y, z) L"
    symbols = {"d": "from the centre of the shape to the centre of mass, body axes [m]"}
    looks_like = "A tumbling body wobbles: its middle goes round the smooth path once each turn; it tips to one side more easily."
    confused_with = ("inertia_error", "bottom_slope")
    group = "body"
    needs = (DataNeed.LEANING,)

    def setup(self, setup):
        size = rigid_body(setup.body).volume ** (1 / 3)
        moved = tuple(here + size * part for here, part in zip(setup.centre, (self.x, self.y, self.z), strict=True))
        return replace(setup, centre=moved)


@dataclass(frozen=True)
class InertiaError(Change):
    """The principal moments are not those of the shape; what turns freely or tips tells."""

    factor_x: float = parameter(
        1.0,
        unit="-",
        low=0.5,
        high=4.0,
        null=1.0,
        symbol="f_x",
        about="of the moment about the body's x axis",
        typical=((1.67, "hollow in place of solid sphere: thin shell 2/3, solid 2/5"),),
    )
    factor_y: float = parameter(1.0, unit="-", low=0.5, high=4.0, null=1.0, symbol="f_y", about="about its y axis")
    factor_z: float = parameter(1.0, unit="-", low=0.5, high=4.0, null=1.0, symbol="f_z", about="about its z axis")
    plain = "an inertia other than stated"
    formula = "I_true = (f_x I_x, f_y I_y, f_z I_z)"
    symbols = {
        "I_true": "principal moments as they are [kg m2]",
        "I_x": "the model's about x",
        "I_y": "about y",
        "I_z": "about z",
    }
    looks_like = "Free turning wobbles at another rate than foretold, and a hit off the middle turns the body more or less."
    confused_with = ("spin_decay",)
    group = "body"
    needs = (DataNeed.TURNING,)

    def setup(self, setup):
        moments = rigid_body(setup.body).inertia
        factors = (self.factor_x, self.factor_y, self.factor_z)
        wanted = [float(factor * moment) for factor, moment in zip(factors, moments, strict=True)]
        most = max(wanted)  # no solid has a moment above the sum of the other two: the nearest moments that one can have
        beyond = max(2 * most - sum(wanted), 0.0) / 3
        possible = tuple(moment - beyond if moment == most else moment + beyond for moment in wanted)
        return replace(setup, body=replace(setup.body, inertia=possible))
