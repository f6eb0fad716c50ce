"""How a suspect is measured directly, which needs no model: the cheapest next experiment where one of two suspects can be.

A witness says what it needs of the scene: a camera, a body that hangs free, a gas, a liquid, a height that is seen. What the
user's scene has not is not offered.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hlcs.effects import body, ground, measurement
from minibullet import effects

FRAMES = 10.0  # of a scene at rest, far enough apart to count each
STAFF = 2.0  # the longest ruler that is easily held into a view [m]
STILL = 0.01  # error of a mean reading at rest: the zero drifts by a milligee while it is turned [m/s2]
SWINGS = 1.0  # rate of drag from which a body on a thread of 1 m loses two thirds of its swing in one period, 2 s [1/s]


class Camera(NamedTuple):
    """What a reading by film, or by ruler and clock, depends on, and the scene that it is made in."""

    sigma: float  # noise of positions [m]
    step: float  # between frames [s]
    extent: float  # of the scene [m]
    filmed: bool = True  # is the motion recorded, or one number of it read by ruler and clock?
    upright: bool = True  # is height seen?
    touching: bool = False  # does the body move on a floor?
    level: bool = True  # is that floor stated to be level?
    liquid: bool = False  # is the body in a liquid?

    @property
    def moment(self):
        """Standard deviation of a moment read to the next frame [s]."""
        return self.step / np.sqrt(12)


@dataclass(frozen=True)
class Witness:
    """A direct reading of one effect."""

    text: str
    size: Callable  # (numbers of the effect, Camera) -> how many standard deviations of one reading they are
    frames: float = 1.0  # how many readings there are
    needs: Callable = lambda numbers, camera: True  # (numbers of the effect, Camera) -> can it be done there?


def direct_reading(kind, numbers, camera):
    """(what to do, separation from no effect in units of chi2) of the first reading of an effect that its scene allows, or None.

    kind: class of the effect; numbers: {name: value} of it.
    """
    if camera.sigma <= 0:
        return None
    witness = next((one for one in WITNESSES.get(kind, ()) if one.needs(numbers, camera)), None)
    if witness is None:
        return None
    return witness.text.format(extent=camera.extent, staff=staff(camera)), float(
        witness.frames * witness.size(numbers, camera) ** 2
    )


def filmed(numbers, camera):
    return camera.filmed


def from_aside(numbers, camera):
    """A camera that sees height sees a plumb line."""
    return camera.filmed and camera.upright


def on_level_floor(numbers, camera):
    return camera.touching and camera.level


def level_floor(numbers, camera):
    return camera.level


def in_liquid(numbers, camera):
    return camera.liquid


def hangs_and_swings(numbers, camera):
    """A body in the air, off any floor, whose drag lets it swing."""
    return not camera.touching and not camera.liquid and abs(numbers["rate"]) < SWINGS


def lean(numbers, camera):
    """Two small angles, seen against the whole scene."""
    return np.hypot(numbers["angle_x"], numbers["angle_y"]) * camera.extent / camera.sigma


def levelled(first, second):
    """Two small angles or grades, beside a spirit level (0.2 mm/m)."""
    return lambda numbers, camera: np.hypot(numbers[first], numbers[second]) / 2e-4


def staff(camera):
    """Length of a ruler held into a view [m]."""
    return min(camera.extent, STAFF)


def scale(length):
    """An error of scale, over a length(camera) [m]."""
    return lambda numbers, camera: (numbers["factor"] - 1) * length(camera) / camera.sigma


def swinging(numbers, camera):
    """A loss of amplitude beside that of a good thread and its knot, 0.01 1/s."""
    return numbers["rate"] / 0.01


def flow(numbers, camera):
    """A flow read to 0.05 m/s."""
    return np.linalg.norm(list(numbers.values())) / 0.05


def density(numbers, camera):
    """A density to 1 %, and not better than 0.05 kg/m3."""
    return numbers["fluid_density"] / max(0.01 * numbers["fluid_density"], 0.05)


def narrowness(numbers, camera):
    """One over a radius, to 5 %, and not better than that of a tank of 2 m."""
    return numbers["inverse_radius"] / max(0.05 * numbers["inverse_radius"], 0.5)


def one_in_a_thousand(numbers, camera):
    """A relative error, read to 0.1 %."""
    return numbers["relative"] / 1e-3


PLUMB_LINE = Witness("film a plumb line in the view", lean, FRAMES, from_aside)

# class of the effect -> its readings, the best that a scene may allow first
WITNESSES = {
    measurement.LengthScale: (
        Witness("film a ruler of {staff:.2g} m where the body moves", scale(staff), FRAMES, filmed),
        Witness(
            "measure the lengths of the table again with another ruler, over {extent:.2g} m",
            scale(lambda camera: camera.extent),
            FRAMES,
        ),
    ),
    measurement.TimeScale: (
        Witness("compare the clock with another one for 60 s", lambda v, camera: (v["factor"] - 1) * 60.0 / camera.moment),
    ),
    # a plumb line leans in the view where gravity does too: the camera itself is looked at
    measurement.TiltedFrame: (
        Witness("check the camera with a spirit level (0.2 mm/m)", levelled("angle_x", "angle_y"), needs=filmed),
    ),
    measurement.ClockOffset: (Witness("trigger the clock by the release itself", lambda v, camera: v["offset"] / camera.moment),),
    measurement.AccelerometerOffset: (
        Witness(
            "let the accelerometer lie still on each of its six sides for 10 s: half the sum of what two opposite sides read",
            lambda v, camera: np.linalg.norm(list(v.values())) / STILL,
        ),
    ),
    measurement.CalibrationCurve: (
        Witness(
            "film a ruler at one height after another, over all that was recorded",
            lambda v, camera: np.linalg.norm(list(v.values())) / camera.sigma,
            FRAMES,
            from_aside,
        ),
    ),
    body.MassOffset: (Witness("weigh the body to 0.1 %", one_in_a_thousand),),
    body.SizeError: (Witness("measure the body with a calliper or micrometer to 0.1 %", one_in_a_thousand),),
    ground.BottomSlope: (
        Witness("level the floor with a spirit level (0.2 mm/m)", levelled("grade_x", "grade_y"), needs=level_floor),
        Witness("measure the slope of the floor in both directions to 0.2 mm/m", levelled("grade_x", "grade_y")),
    ),
    effects.TiltedGravity: (
        Witness("level the floor with a spirit level (0.2 mm/m)", levelled("angle_x", "angle_y"), needs=on_level_floor),
        PLUMB_LINE,
    ),
    effects.Buoyancy: (
        Witness("weigh one litre of the liquid: its density to 1 %", density, needs=in_liquid),
        Witness("read thermometer and barometer: the density of the air to 1 %", density),
    ),
    effects.TubeDrag: (
        Witness("measure the inner width of what holds the liquid, and state half of it as surroundings.tube_radius", narrowness),
    ),
    effects.LinearDrag: (
        Witness(
            "let the body swing on a thread of 1 m in the same air, away from any floor, for 60 s",
            swinging,
            1.0,
            hangs_and_swings,
        ),
    ),
    effects.UniformFlow: (
        Witness("measure the flow with dye (0.05 m/s)", flow, needs=in_liquid),
        Witness("measure the flow of the air with an anemometer (0.05 m/s)", flow),
    ),
}

# What a file states that the number of an effect rests on: to be looked up where that number is not plausible.
INPUTS_OF = {
    "added_mass": "mass and size of the body, density of the fluid",
    "buoyancy": "mass and size of the body, scale of length, frames a second",
    "calibration_curve": "scale of length at each height, starts",
    "clock_offset": "moment of the release, start",
    "drag_crisis": "mass and size of the body, density and viscosity of the fluid",
    "friction": "slope of the floor, scale of length",
    "length_scale": "ruler in the picture, and its distance from the motion",
    "linear_drag": "scale of length, frames a second, starts",
    "magnus": "spin, mass and size of the body, density of the fluid",
    "margin_offset": "height of the floor, size of the body",
    "mass_offset": "mass of the body, density of the fluid",
    "quadratic_drag": "mass and size of the body, density of the fluid, scale of length",
    "restitution": "height of the floor, size of the body",
    "rolling_friction": "slope of the floor",
    "size_error": "size of the body and, where it touches, height of the floor",
    "sphere_drag": "mass and size of the body, density of the fluid",
    "stokes_drag": "mass and size of the body, density of the fluid",
    "time_scale": "frames a second",
}

# What to do beside a table of layers, by name of the candidate: most candidates of layers are settings of a placement test.
OF_LAYERS = {
    "convex_hull_shape": "simulate both shapes with the same seeds, and nest two units by hand: hulls cannot",
    "margin_offset": "measure one unit at rest on a flat plate, and run margins of 0, 1/2, 1 and 2 times with the same seeds",
    "friction": "tilt a unit on a plate of the same concrete until it slides",
    "friction_combination": "tilt a unit on a plate of the same concrete until it slides",
    "plate_bias": "lay the same plate on one unit of known height",
    "settlement": "use a rigid bottom, and read the first layer twice",
    "size_error": "measure the units with a calliper",
    "length_scale": "measure a ruler the way the layers are measured",
    "campaign_offset": "repeat one grid in both campaigns",
    "grid_spacing": "survey the centres of the units",
    "placement_scatter": "survey the centres of the units, or place with a jig",
    "placement_offset": "survey the centres layer by layer",
    "orientation_bias": "count the poses of the first layer in photographs",
    "yaw_constraint": "photograph the first layer from above",
    "falling_distance": "place from 0.10, 0.25 and 0.40 Dn",
    "lost_units": "count the units",
    "ground_softness": "read the first layer before and after the others are on it",
    "contact_compliance": "read the first layer before and after the others are on it",
    "bottom_roughness": "place the same grid on a flat plate",
    "sequential_placement": "place one row after another, both ways round",
    "loose_lower_layers": "glue the lower layers, or read them again once the others are on them",
    "vibration": "read the layers before and after shaking",
    "rolling_friction": "tilt a unit until it rolls",
    "static_friction": "tilt a plate with a unit slowly, and let one slide down it",
    "adhesion": "lift a unit off another with a balance, wet and dry",
    "inertia_error": "swing a unit as a pendulum",
    "bottom_slope": "level the bottom, or turn the set-up by 180 degrees",
    "restitution": "film a unit falling from three heights",
    "damping": "run the model without damping",
    "time_step": "halve the time step again",
    "iterations": "double the iterations again",
}
