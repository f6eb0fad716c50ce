"""Direct readings: how many standard deviations of one reading a suspect's numbers are."""

import numpy as np
import pytest

from hlcs.effects import classes
from hlcs.effects.ground import BottomSlope
from hlcs.effects.measurement import CalibrationCurve, ClockOffset, LengthScale, TiltedFrame
from hlcs.effects.witnesses import INPUTS_OF, OF_LAYERS, WITNESSES, Camera, direct_reading
from minibullet.effects import Buoyancy, LinearDrag, TiltedGravity, UniformFlow

CAMERA = Camera(sigma=0.002, step=0.01, extent=1.5)


PUCK = CAMERA._replace(upright=False, touching=True)
TANK = CAMERA._replace(liquid=True)
BOARD = CAMERA._replace(touching=True, level=False)
TABLE = CAMERA._replace(filmed=False, upright=False)
LEAN = {"angle_x": 0.03, "angle_y": 0.04}
FLOW = {"velocity_x": 0.3, "velocity_y": 0.4}
GRADE = {"grade_x": 0.003, "grade_y": 0.004}


@pytest.mark.parametrize(
    ("kind", "numbers", "camera", "size"),
    [
        (LengthScale, {"factor": 1.02}, CAMERA, np.sqrt(10) * 0.02 * 1.5 / 0.002),
        (ClockOffset, {"offset": 0.05}, CAMERA, 0.05 * np.sqrt(12) / 0.01),
        (TiltedGravity, LEAN, CAMERA, np.sqrt(10) * 0.05 * 1.5 / 0.002),
        (TiltedGravity, LEAN, PUCK, 0.05 / 2e-4),
        (BottomSlope, GRADE, BOARD, 0.005 / 2e-4),
        (Buoyancy, {"fluid_density": 1000.0}, TANK, 100.0),
        (Buoyancy, {"fluid_density": 1.0}, CAMERA, 20.0),
        (LinearDrag, {"rate": 0.2}, CAMERA, 20.0),
        (UniformFlow, FLOW, CAMERA, 10.0),
    ],
)
def test_a_reading_is_as_sharp_as_its_instrument(kind, numbers, camera, size):
    """Its separation is the square of so many standard deviations, times the readings that there are (10 frames of a film)."""
    assert direct_reading(kind, numbers, camera)[1] == pytest.approx(size**2, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "numbers", "camera", "text"),
    [
        (LengthScale, {"factor": 1.02}, CAMERA, "film a ruler of 1.5 m where the body moves"),
        (LengthScale, {"factor": 1.02}, CAMERA._replace(extent=8.0), "film a ruler of 2 m where the body moves"),
        (LengthScale, {"factor": 1.02}, TABLE, "measure the lengths of the table again with another ruler, over 1.5 m"),
        (TiltedGravity, LEAN, CAMERA, "film a plumb line in the view"),
        (TiltedFrame, LEAN, PUCK, "check the camera with a spirit level (0.2 mm/m)"),  # from above a plumb line is a point
        (TiltedGravity, LEAN, PUCK, "level the floor with a spirit level (0.2 mm/m)"),
        (BottomSlope, GRADE, CAMERA, "level the floor with a spirit level (0.2 mm/m)"),
        (BottomSlope, GRADE, BOARD, "measure the slope of the floor in both directions to 0.2 mm/m"),  # it slopes on purpose
        (Buoyancy, {"fluid_density": 998.0}, TANK, "weigh one litre of the liquid: its density to 1 %"),
        (Buoyancy, {"fluid_density": 1.2}, CAMERA, "read thermometer and barometer: the density of the air to 1 %"),
        (UniformFlow, FLOW, TANK, "measure the flow with dye (0.05 m/s)"),
        (UniformFlow, FLOW, CAMERA, "measure the flow of the air with an anemometer (0.05 m/s)"),
    ],
)
def test_what_is_asked_for_can_be_done_in_that_scene(kind, numbers, camera, text):
    assert direct_reading(kind, numbers, camera)[0] == text


@pytest.mark.parametrize(
    ("kind", "numbers", "camera"),
    [
        (LinearDrag, {"rate": 0.2}, PUCK),  # no thread for what lies on a floor
        (LinearDrag, {"rate": 0.2}, TANK),  # no tank is a room to swing in
        (LinearDrag, {"rate": 4.0}, CAMERA),  # exp(-4 * 2 / 2) = 2 % of the swing is left after one period of 2 s
        (CalibrationCurve, {"c_1": 0.01}, PUCK),
        (TiltedGravity, LEAN, PUCK._replace(level=False)),
        (TiltedFrame, LEAN, TABLE),
        (LengthScale, {"factor": 1.02}, CAMERA._replace(sigma=0.0)),
    ],
)
def test_what_a_scene_has_not_is_not_asked_for(kind, numbers, camera):
    assert direct_reading(kind, numbers, camera) is None


def test_witnesses_are_of_shipped_classes_and_say_what_to_do():
    assert set(WITNESSES) <= set(classes().values())
    assert all(text and text == text.strip() for text in OF_LAYERS.values())


def test_what_numbers_rest_on_is_told_of_effects_that_there_are():
    assert INPUTS_OF.keys() <= classes().keys()
