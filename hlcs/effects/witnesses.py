"""How a suspect is measured directly, which needs no model: the cheapest next experiment where one of two suspects can be."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hlcs.effects import body, ground, measurement
from minibullet import effects

FRAMES = 10.0  # of a scene at rest, far enough apart to count each


class Camera(NamedTuple):
    """What a reading by film, or by ruler and clock, depends on."""

    sigma: float  # noise of positions [m]
    step: float  # between frames [s]
    extent: float  # of the scene [m]

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


def lean(numbers, camera):
    """Two small angles, seen against the whole scene."""
    return np.hypot(numbers["angle_x"], numbers["angle_y"]) * camera.extent / camera.sigma


def swinging(numbers, camera):
    """A loss of amplitude beside that of a good thread and its knot, 0.01 1/s."""
    return numbers["rate"] / 0.01


def one_in_a_thousand(numbers, camera):
    """A relative error, read to 0.1 %."""
    return numbers["relative"] / 1e-3


WITNESSES = {
    measurement.LengthScale: Witness(
        "hold a ruler of {extent:.2g} m beside what is measured",
        lambda v, camera: (v["factor"] - 1) * camera.extent / camera.sigma,
        FRAMES,
    ),
    measurement.TimeScale: Witness(
        "compare the clock with another one for 60 s", lambda v, camera: (v["factor"] - 1) * 60.0 / camera.moment
    ),
    measurement.TiltedFrame: Witness("film a plumb line in the view", lean, FRAMES),
    measurement.ClockOffset: Witness("trigger the clock by the release itself", lambda v, camera: v["offset"] / camera.moment),
    measurement.CalibrationCurve: Witness(
        "film a ruler over the whole height", lambda v, camera: np.linalg.norm(list(v.values())) / camera.sigma, FRAMES
    ),
    body.MassOffset: Witness("weigh the body to 0.1 %", one_in_a_thousand),
    body.SizeError: Witness("measure the body with a calliper to 0.1 %", one_in_a_thousand),
    ground.BottomSlope: Witness(
        "level the floor with a spirit level (0.2 mm/m)", lambda v, camera: np.hypot(v["grade_x"], v["grade_y"]) / 2e-4
    ),
    effects.TiltedGravity: Witness("film a plumb line in the view", lean, FRAMES),
    effects.Buoyancy: Witness(
        "weigh the fluid: its density to 1 %", lambda v, camera: v["fluid_density"] / max(0.01 * v["fluid_density"], 0.05)
    ),
    effects.LinearDrag: Witness(
        "let the body swing on a thread of 1 m in the same fluid, away from any floor, for 60 s", swinging
    ),
    effects.UniformFlow: Witness(
        "measure the flow with dye (0.05 m/s)", lambda v, camera: np.linalg.norm(list(v.values())) / 0.05
    ),
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
