"""The ground is not as level as the file says."""

from dataclasses import dataclass, replace

import numpy as np

from hlcs.effects.contract import Change
from minibullet.effects.contract import Need, parameter


@dataclass(frozen=True)
class BottomSlope(Change):
    """The floor rises beside its stated slope; gravity stays vertical."""

    grade_x: float = parameter(
        0.0,
        unit="-",
        low=-0.1,
        high=0.1,
        null=0.0,
        about="rise over run along x",
        typical=((0.004, "finished floor, 4 mm out of flat over 1 m: DIN 18202, table 3"),),
    )
    grade_y: float = parameter(0.0, unit="-", low=-0.1, high=0.1, null=0.0, about="rise over run along y")
    plain = "a floor that slopes more than stated"
    formula = "z_floor = grade_x x + grade_y y"
    symbols = {"z_floor": "height of the floor above the stated one [m]"}
    looks_like = (
        "What slides or rolls drifts downhill, in every run the same way, and rests lower the farther it went; flights "
        "show nothing."
    )
    confused_with = ("rolling_friction",)
    group = "ground"
    needs = (Need.CONTACT,)

    def setup(self, setup):
        surroundings = setup.surroundings
        if surroundings.floor_height is None:
            return setup
        stated = surroundings.normal
        normal = stated - stated[2] * np.array([self.grade_x, self.grade_y, 0.0])
        normal = normal / np.linalg.norm(normal)
        height = surroundings.floor_height * float(normal[2] / stated[2])  # below the origin the floor stays where it was
        normal = tuple(float(part) for part in normal)
        return replace(setup, surroundings=replace(surroundings, floor_normal=normal, floor_height=height))
